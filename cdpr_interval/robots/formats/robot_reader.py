"""The reader of ``cdpr-robot/1``: a checked document becomes a `Robot`."""

from __future__ import annotations

from typing import Any

from cdpr_interval.exact.range import Range
from cdpr_interval.files.document import Document, Node, child
from cdpr_interval.files.fields import SHAPES, bounds
from cdpr_interval.files.validation import Models
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from cdpr_interval.robots.formats import schema
from cdpr_interval.robots.numbers import Point, Scalar
from cdpr_interval.robots.pulley import Pulley
from cdpr_interval.robots.winch import Winch
from cdpr_interval.text.literal import quote

LAZY = {"": ("winches",), "cables": ("winch",)}
"""Keys of blocks that are only known to the models of winches, for suggestions."""
NOT_OF_LEGS = ("elasticity", "tension_limits_N", "winch", "pulley")
"""Keys of a cable that a leg cannot have."""


def robot(document: Document) -> Robot:
    """Check the tree against the schema and build the robot, or raise with every error."""
    _check_names(document)
    _check_winches(document)
    _check_legs(document)
    found = _robot(_models(document).validated(document), notes_of(document))
    return found.read_from(document.data) if document.data else found


def notes_of(document: Document) -> str | None:
    """Return what the file says in ``notes``: a text, or a list of texts as its lines."""
    node = document.root.mapping.get("notes")
    if node is None:
        return None
    lines = [entry.literal for entry in node.items] if node.is_list else [node.literal]
    return "\n".join(line.strip() for line in lines if line) or None


def _models(document: Document) -> Models[schema.RobotBlock]:
    """Return the models that a file needs: those of winches take time to build, and most files have none."""
    root = document.root.mapping
    cables = root["cables"].items if "cables" in root else []
    if "winches" in root or any("winch" in cable.mapping for cable in cables):
        from cdpr_interval.robots.formats import winch_schema

        return Models(
            winch_schema.RobotWithWinches, winch_schema.BLOCKS, winch_schema.TAGS, word=schema.ROBOT_FORMAT
        )
    return Models(schema.RobotBlock, schema.BLOCKS, SHAPES, LAZY, schema.ROBOT_FORMAT)


def _check_names(document: Document) -> None:
    """Report two cables of one name."""
    cables = document.root.mapping.get("cables")
    first: dict[object, int] = {}
    for index, cable in enumerate(cables.items if cables else []):
        name = cable.mapping.get("name")
        if name is None or not isinstance(name.value, str):
            continue
        other = first.setdefault(name.value, index)
        if other != index:
            path = f"cables[{index}].name"
            document.report(name, path, f"{quote(name.value)} is the name of cables[{other}] already")


def _check_winches(document: Document) -> None:
    """Report cables without a winch beside cables with one, and two winches of one node."""
    cables = document.root.mapping.get("cables")
    entries = cables.items if cables else []
    first: dict[object, int] = {}
    for index, cable in enumerate(entries):
        given = cable.mapping.get("winch")
        path = child(child("cables", index), "winch")
        if given is None:
            if cable.is_mapping and any("winch" in other.mapping for other in entries):
                document.report(cable, path, "missing: either every cable has a winch or none has")
            continue
        node = given.mapping.get("node")
        if node is None or isinstance(node.value, dict | list | None):
            continue
        other = first.setdefault(node.value, index)
        if other != index:
            document.report(node, f"{path}.node", f"{node.literal} is the node of cables[{other}] already")


def _check_legs(document: Document) -> None:
    """Report cables beside legs, what a leg cannot have, and limits of a length without a leg."""
    cables = document.root.mapping.get("cables")
    entries = cables.items if cables else []
    legs = [_is_leg(cable) for cable in entries]
    for index, cable in enumerate(entries):
        path = child("cables", index)
        keys = cable.mapping
        if legs[index]:
            for key in NOT_OF_LEGS:
                if key in keys:
                    document.report(keys[key], child(path, key), "a leg has none")
            continue
        given = keys.get("leg")
        if given is not None and given.value is not False:
            continue  # no bool, which the schema says
        if cable.is_mapping and any(legs):
            rule = f"{'missing' if given is None else 'must be true'}: either every cable is a leg or none is"
            document.report(given or cable, child(path, "leg"), rule)
        elif "length_limits_m" in keys:
            place = child(path, "length_limits_m")
            document.report(keys["length_limits_m"], place, "only of a leg, with leg: true")


def _is_leg(cable: Node) -> bool:
    leg = cable.mapping.get("leg")
    return leg is not None and leg.value is True


def _robot(block: schema.RobotBlock, notes: str | None) -> Robot:
    """Return the robot of validated blocks; absent keys take the model's defaults."""
    given: dict[str, Any] = {}
    if block.gravity_m_s2 is not None:
        given["gravity"] = point_of(block.gravity_m_s2)
    if getattr(block, "winches", None) is not None:
        from cdpr_interval.robots.formats.winch_reader import settings

        given["winches"] = settings(block.winches)  # type: ignore[attr-defined]
    cables = tuple(_cable(cable) for cable in block.cables)
    return Robot(block.name, _platform(block.platform), cables, source=block.source, notes=notes, **given)


def _platform(block: schema.PlatformBlock) -> Platform:
    mass = scalar_of(block.mass_kg)
    return (
        Platform(mass) if block.centre_of_mass_m is None else Platform(mass, point_of(block.centre_of_mass_m))
    )


def _cable(block: schema.CableBlock) -> Cable:
    return Cable(
        block.name,
        point_of(block.frame_anchor_m),
        point_of(block.platform_anchor_m),
        None if block.elasticity is None else _elasticity(block.elasticity),
        block.tension_limits_N,
        _winch(block),
        None if block.pulley is None else _pulley(block.pulley),
        block.leg,
        block.length_limits_m,
    )


def _winch(block: schema.CableBlock) -> Winch | None:
    if getattr(block, "winch", None) is None:
        return None
    from cdpr_interval.robots.formats.winch_reader import winch

    return winch(block.winch)  # type: ignore[attr-defined]


def _pulley(block: schema.PulleyBlock) -> Pulley:
    given: dict[str, Any] = {
        "radius": scalar_of(block.radius_m),
        "joints": block.joints,
        "balance": block.balance,
    }
    if block.arm_m is not None:
        given["arm"] = scalar_of(block.arm_m)
    if block.axis is not None:
        given["axis"] = point_of(block.axis)
    if block.lead_in_m is not None:
        given["lead_in"] = scalar_of(block.lead_in_m)
    return Pulley(**given)


def _elasticity(block: schema.ElasticityBlock) -> Elasticity:
    if block.stiffness_N_per_m is not None:
        return Elasticity(stiffness=scalar_of(block.stiffness_N_per_m))
    assert block.axial_stiffness_N is not None
    return Elasticity(axial_stiffness=scalar_of(block.axial_stiffness_N))


def point_of(quantities: tuple[Any, Any, Any]) -> Point:
    """Return a vector of numbers or ranges."""
    x, y, z = map(scalar_of, quantities)
    return x, y, z


def scalar_of(quantity: Any) -> Scalar:
    """Return the number, or the range where the bounds differ."""
    lo, hi = bounds(quantity)
    return lo if lo == hi else Range(lo, hi)
