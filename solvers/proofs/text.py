"""Robots and solutions as the text of a certificate: exact numbers, every double in hexadecimal."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np

from cdpr_interval.exact.decimals import exact_text
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import exact, exact_point
from cdpr_interval.robots.pulley import Pulley
from solvers.answers.data import Family, Solution
from solvers.proofs.listed import certified, written_states

Json = dict[str, Any]


def robot_document(robot: Robot) -> Json:
    """Return the robot in exact numbers."""
    cables = []
    for cable in robot.cables:
        document: Json = {
            "name": cable.name,
            "frame_anchor_m": vector(exact_point(cable.frame_anchor)),
            "platform_anchor_m": vector(exact_point(cable.platform_anchor)),
        }
        if cable.elasticity is not None:
            for key, value in (
                ("stiffness_N_per_m", cable.elasticity.stiffness),
                ("axial_stiffness_N", cable.elasticity.axial_stiffness),
            ):
                if value is not None:
                    document[key] = exact_text(exact(value))
        if cable.pulley is not None and not cable.pulley.is_plain:
            document["pulley"] = pulley_document(cable.pulley, robot)
        cables.append(document)
    return {
        "name": robot.name,
        "sha256": robot.sha256,
        "gravity_m_s2": vector(exact_point(robot.gravity)),
        "mass_kg": exact_text(exact(robot.platform.mass)),
        "centre_of_mass_m": vector(exact_point(robot.platform.centre_of_mass)),
        "cables": cables,
    }


def pulley_document(pulley: Pulley, robot: Robot) -> Json:
    """Return a pulley in exact numbers; its axis is against gravity where none is given."""
    up = [-x for x in exact_point(robot.gravity)]
    return {
        "radius_m": exact_text(exact(pulley.radius)),
        "axis": vector(up if pulley.axis is None else exact_point(pulley.axis)),
        "lead_in_m": exact_text(exact(pulley.lead_in)),
    }


def solution_document(solution: Solution) -> Json:
    """Return a solution with its bounds as exact doubles."""
    solution = certified(solution)
    return {
        "taut": list(solution.taut),
        "states": list(written_states(solution)),
        "position_m": doubles(solution.position),
        "rotation": doubles(solution.rotation),
        "height_m": doubles(solution.height),
        "tensions_N": doubles(solution.tensions),
        "distances_m": doubles(solution.distances),
        "slack_respected": solution.slack_respected,
        "stability": str(solution.stability),
        "family": None if solution.family is None else family_document(solution.family),
    }


def family_document(family: Family) -> Json:
    """Return a family with its bounds as exact doubles."""
    return {
        "kind": family.kind,
        "axis_point_m": None if family.axis_point is None else doubles(family.axis_point),
        "axis_direction": None if family.axis_direction is None else doubles(family.axis_direction),
        "angle_ranges_rad": doubles(family.angle_ranges),
    }


def doubles(bounds: Bounds) -> Any:
    """Return nested lists of hexadecimal numbers."""
    return hexadecimal(np.asarray(bounds, dtype=np.float64).tolist())


def hexadecimal(value: Any) -> Any:
    """Return floats in nested lists as text."""
    return [hexadecimal(v) for v in value] if isinstance(value, list) else value.hex()


def vector(values: Iterable[Fraction]) -> list[str]:
    """Return exact numbers as text."""
    return [exact_text(x) for x in values]
