"""The reader of ``delta-robot/1``: a checked document becomes a `DeltaRobot`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from cdpr_interval.files.document import Document
from cdpr_interval.files.fields import SHAPES
from cdpr_interval.files.validation import Models
from cdpr_interval.robots.delta import LIMITS, REGULAR, DeltaRobot, complaints
from cdpr_interval.robots.formats import delta_schema
from cdpr_interval.robots.formats.robot_reader import notes_of, point_of, scalar_of

KEYS = {
    "base_radius": "base_radius_m",
    "platform_radius": "platform_radius_m",
    "arm": "arm_m",
    "bar": "bar_m",
    "bar_spacing": "bar_spacing_m",
    "arm_angles": "arm_angles_rad",
    **{name: f"{name}_rad" for name in LIMITS},
}
"""Keys of fields that are called otherwise."""


def delta(document: Document) -> DeltaRobot:
    """Check the tree against the schema and build the robot, or raise with every error."""
    models = Models(delta_schema.DeltaBlock, delta_schema.BLOCKS, SHAPES, word=delta_schema.DELTA_FORMAT)
    given = _fields(models.validated(document), notes_of(document))
    for key, rule in complaints(SimpleNamespace(**given)):
        name, _, rest = key.partition("[")
        path = KEYS.get(name, name)
        node = document.root.mapping.get(path, document.root)
        document.report(node, path + (f"[{rest}" if rest else ""), rule)
    document.require_valid()
    found = DeltaRobot(**given)
    return found.read_from(document.data) if document.data else found


def _fields(block: delta_schema.DeltaBlock, notes: str | None) -> dict[str, Any]:
    """Return the fields of the robot; absent keys take the model's defaults."""
    rails = block.rail_directions
    found: dict[str, Any] = {
        "name": block.name,
        "source": block.source,
        "notes": notes,
        "drives": block.drives,
        "arm_angles": REGULAR if block.arm_angles_rad is None else block.arm_angles_rad,
        "rail_directions": None if rails is None else tuple(map(point_of, rails)),
    }
    for name in ("base_radius", "platform_radius", "arm", "bar", "bar_spacing"):
        value = getattr(block, KEYS[name])
        found[name] = None if value is None else scalar_of(value)
    if block.tool_offset_m is not None:
        found["tool_offset"] = point_of(block.tool_offset_m)
    return found | {name: getattr(block, f"{name}_rad") for name in LIMITS}
