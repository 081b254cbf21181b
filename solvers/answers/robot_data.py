"""The data of a robot in exact numbers as a document, and back: what was really solved.

The layout is that of ``cdpr-robot/1`` without winches and notes, every number a text: a decimal or p/q. The
digest is that of the data, whatever file they came from.
"""

from __future__ import annotations

import hashlib
import json
from fractions import Fraction
from typing import Any

from cdpr_interval.exact.decimal_text import exact_text
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Point, Robot, Scalar
from solvers.answers.json_text import Json

DIGEST = "data_sha256"
"""Key of the digest of all other keys."""


def robot_to_dict(robot: Robot) -> Json:
    """Return the data of a robot, with their digest first."""
    data: Json = {
        "name": robot.name,
        "source": robot.source,
        "sha256": robot.sha256,
        "gravity_m_s2": _point(robot.gravity),
        "platform": {
            "mass_kg": _scalar(robot.platform.mass),
            "centre_of_mass_m": _point(robot.platform.centre_of_mass),
        },
        "cables": [_cable(cable) for cable in robot.cables],
    }
    return {DIGEST: digest(data), **data}


def digest_of(robot: Robot) -> str:
    """Return the digest of a robot's data in hexadecimal, whatever file they came from."""
    found: str = robot_to_dict(robot)[DIGEST]
    return found


def digest(data: Json) -> str:
    """Return the digest of a robot's data in hexadecimal: of their JSON without spaces, keys in order."""
    numbers = {key: data[key] for key in ("gravity_m_s2", "platform", "cables")}
    text = json.dumps(numbers, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def robot_from_dict(data: Any) -> Robot:
    """Return the robot of its data.

    Raises
    ------
    ValueError
        They are no data of a robot, or the digest is that of others.
    """
    try:
        robot = Robot(
            data["name"],
            Platform(_number(data["platform"]["mass_kg"]), _vector(data["platform"]["centre_of_mass_m"])),
            tuple(_read_cable(cable) for cable in data["cables"]),
            gravity=_vector(data["gravity_m_s2"]),
            source=data["source"],
            sha256=data["sha256"],
        )
        if data[DIGEST] != digest(data):
            raise ValueError("the digest is not that of the data")
    except (KeyError, TypeError, IndexError, ZeroDivisionError) as error:
        raise ValueError(f"must be the data of a robot ({type(error).__name__}: {error})") from None
    return robot


def _cable(cable: Cable) -> Json:
    found: Json = {
        "name": cable.name,
        "frame_anchor_m": _point(cable.frame_anchor),
        "platform_anchor_m": _point(cable.platform_anchor),
    }
    spring = cable.elasticity
    if spring is not None and spring.stiffness is not None:
        found["elasticity"] = {"stiffness_N_per_m": _scalar(spring.stiffness)}
    if spring is not None and spring.axial_stiffness is not None:
        found["elasticity"] = {"axial_stiffness_N": _scalar(spring.axial_stiffness)}
    if cable.tension_limits is not None:
        found["tension_limits_N"] = [exact_text(limit) for limit in cable.tension_limits]
    return found


def _read_cable(data: Json) -> Cable:
    spring, limits = data.get("elasticity"), data.get("tension_limits_N")
    return Cable(
        data["name"],
        _vector(data["frame_anchor_m"]),
        _vector(data["platform_anchor_m"]),
        None
        if spring is None
        else Elasticity(_optional(spring, "stiffness_N_per_m"), _optional(spring, "axial_stiffness_N")),
        None if limits is None else (Fraction(limits[0]), Fraction(limits[1])),
    )


def _optional(spring: Json, key: str) -> Scalar | None:
    return _number(spring[key]) if key in spring else None


def _point(point: Point) -> list[Any]:
    return [_scalar(value) for value in point]


def _vector(values: Any) -> Point:
    x, y, z = map(_number, values)
    return x, y, z


def _scalar(value: Scalar) -> Any:
    return [exact_text(value.lo), exact_text(value.hi)] if isinstance(value, Range) else exact_text(value)


def _number(value: Any) -> Scalar:
    if isinstance(value, list):
        lo, hi = value
        return Range(Fraction(lo), Fraction(hi))
    if not isinstance(value, str):
        raise TypeError("numbers are texts")
    return Fraction(value)
