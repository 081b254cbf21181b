"""Honest certificates of every class, small enough to be checked hundreds of times, and what is true."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import Any

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from cdpr_interval.robots.cable_robot import Robot
from certificates.tree import Node
from solvers.answers.result import Result
from solvers.forward import answer_question, pose_problem
from solvers.proofs.document import certificate_document
from solvers.proofs.entries import subset_entries
from solvers.questions.problem import Options
from solvers.six_dof.record import Record
from tests.support import hanging_mass
from tests.support.point_certificates import robot, vector

Document = dict[str, Any]


@dataclass(frozen=True)
class Honest:
    """A certificate as the writer makes it, and what the solver found."""

    document: Document
    truth: Result


def honest(made: Robot, lengths: Any, taut: Any = None, **asked: Any) -> Honest:
    """Ask, and write the certificate."""
    options = Options(record=Record(), **asked)
    problem = pose_problem(made, lengths, taut, None, options)
    result = answer_question(problem, options)
    return Honest(
        certificate_document(problem, options, result, subset_entries(problem, options, result)), result
    )


SWING = robot([(0, 0, 0), (4, 0, 0)], [(0, 0, 1), (1, 0, 0.5)], mass=1)
"""The platform hangs on one cable and turns until the other one is tight."""
TURNED = replace(
    robot([(0, 0, 0), (1.44, 3.712, -0.384)], [(0.864, 0.352, 0.36), (0.28, 1.04, -0.3)], mass=1),
    gravity=vector(-0.48, 0.096, -0.872),
)
"""Such a platform in a frame that is turned; with a length near 6.1033 the second cable hardly carries."""
CORNERS = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)]
BESIDE = [(0, 0, 3), (2.5, 0.5, 3), (-2, 1.5, 3.5)]
FREE = [(0, 0, 0), (0.5, 0.2, 0.1), (0.2, 0.9, 0)]


CLASSES: dict[str, Callable[[], Honest]] = {
    "point": lambda: honest(hanging_mass.robot(), ["2", "5"]),
    "point, each subset": lambda: honest(hanging_mass.robot(), ["2", "3"], ignore_slack=True),
    "point, none": lambda: honest(hanging_mass.robot(), ["1", "1"]),
    "point, ranges": lambda: honest(hanging_mass.robot(), ["1.9..2.1", "3"]),
    "point, four corners": lambda: honest(robot(CORNERS), ["4", "4", "4.5", "4.2"], ignore_slack=True),
    "elastic": lambda: honest(load_robot("merlet_4_1_k100"), "2.9,2.9,4.1,4.1"),
    "elastic, parts": lambda: honest(load_robot("merlet_4_1_k100"), "2.9+-0.03,2.9,4.1,4.1"),
    "swing": lambda: honest(SWING, ["3", "5"]),
    "swing, each subset": lambda: honest(SWING, ["3", "5"], ignore_slack=True),
    "swing, asked": lambda: honest(SWING, ["3", "5"], "c0", ignore_slack=True),
    "swing, ranges": lambda: honest(TURNED, ["3", "6.1..6.1028"]),
    "all rotations": lambda: honest(robot(BESIDE, FREE), ["3", "6", "6"], "c0"),
    "slings": lambda: honest(robot([(0, 0, 3)] * 2, [(-1, 0, 0.5), (1, 0, 0.5)]), ["1.5", "1.6"]),
    "rod": lambda: honest(robot([(0, 0, 3), (2, 0.5, 3)], [(-1, 0, 0), (1, 0, 0)]), ["1.5", "1.7"]),
    "plane": lambda: honest(load_robot("uc2"), "7.5,8"),
    "plane, ranges": lambda: honest(load_robot("uc2"), "7.5+-0.0001,8", "c1,c2"),
    "three cables": lambda: three_cables("7.5,8,7"),
    "three cables, ranges": lambda: three_cables("7.5+-0.000001,8+-0.000001,7"),
}


@cache
def made(name: str) -> Honest:
    """Return the certificate of a class; not to be changed."""
    return CLASSES[name]()


def three_cables(lengths: str) -> Honest:
    """Return uc3's 14 poses of three taut cables, of whose trees only the way to each root is looked at."""
    options = Options(record=Record())
    problem = pose_problem(load_robot("uc3"), lengths, "c1,c2,c3", None, options)
    result = answer_question(problem, options)
    assert options.record is not None
    options.record.budget = Budget(cell_limit=0)
    document = certificate_document(problem, options, result, subset_entries(problem, options, result))
    search = document["subsets"][0]["searches"][0]
    first = next(root for root in search["roots"] if root["chart"] == 0)
    longest = Fraction(document["lengths_m"][search["order"][0]][1])
    reach = (
        float(longest) if Fraction(float(longest)) >= longest else math.nextafter(float(longest), math.inf)
    )
    search["trees"][0] = base64.b64encode(way_to(first, reach)).decode()
    return Honest(document, result)


def way_to(root: Document, reach: float) -> bytes:
    """Return a tree that ends in one cell inside a root's box; beside it nothing is looked at.

    ``reach`` : no entry of x is larger.
    """
    box = [tuple(map(float.fromhex, b)) for key in ("u", "x") for b in root[key]]
    middle = [(lo + hi) / 2 for lo, hi in box]
    cell = [(-1.0, 1.0)] * 3 + [(-reach, reach)] * 3
    content = bytes([Node.HAND_ON])
    closing = b""
    while any(not (b[0] <= c[0] and c[1] <= b[1]) for b, c in zip(box, cell, strict=True)):
        k = max(range(6), key=lambda i: (cell[i][1] - cell[i][0]) / (box[i][1] - box[i][0]))
        lo, hi = cell[k]
        half = 0.5 * (lo + hi)
        content += bytes([k])
        if middle[k] < half:
            cell[k], closing = (lo, half), bytes([Node.PENDING]) + closing
        else:
            cell[k], content = (half, hi), content + bytes([Node.PENDING])
    return content + bytes([Node.ROOT]) + closing
