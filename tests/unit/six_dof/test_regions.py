"""What is reported as undecided may hold a pose: some taut cable can pull against the load there."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from cdpr_interval.robots.formats.reader import load_robot
from cdpr_interval.robots.numbers import exact_point
from solvers import forward_kinematics
from solvers.answers.data import Answer, Outcome, Undecided
from solvers.six_dof import clusters

Point = tuple[str, str, str]
Ranges = list[tuple[str, str]]


def platform(gravity: Point, exits: Sequence[Point], anchors: Sequence[Point]) -> Robot:
    """Return a robot of 10 kg."""
    cables = tuple(
        Cable(f"c{i}", point(a), point(b)) for i, (a, b) in enumerate(zip(exits, anchors, strict=True))
    )
    return Robot("six", Platform(Fraction(10)), cables, point(gravity))


def point(p: Point) -> tuple[Fraction, Fraction, Fraction]:
    return Fraction(p[0]), Fraction(p[1]), Fraction(p[2])


def around(lengths: Sequence[str], by: str) -> Ranges:
    """Return the ranges of lengths +- by, as exact decimals."""
    return [(str(float(Fraction(x) - Fraction(by))), str(float(Fraction(x) + Fraction(by)))) for x in lengths]


EXITS: list[Point] = [(x, y, "3") for x, y in (("2", "0"), ("-1", "1.73"), ("-1", "-1.73")) for _ in (0, 1)]
ANCHORS: list[Point] = [
    (x, y, "-0.2") for x, y in (("0.5", "0"), ("-0.25", "0.43"), ("-0.25", "0.43"), ("-0.25", "-0.43"))
]
ANCHORS += [("-0.25", "-0.43", "-0.2"), ("0.5", "0", "-0.2")]
SIX = platform(("0", "0", "-9.81"), EXITS, ANCHORS)
"""Six cables in pairs from three points above: their wrenches are nearly dependent at a level platform."""
LENGTHS = around(["1.71", "2.37", "1.94", "2.53", "2.19", "2.9"], "0.05")


def may_hold(robot: Robot, region: Undecided) -> bool:
    """Return True where the box of the region does not show that every taut cable pulls along gravity (z)."""
    up = -1.0 if exact_point(robot.gravity)[2] > 0 else 1.0
    lowest = min(up * z for z in region.position[2])
    for i in region.taut:
        cable = robot.cables[i]
        anchor, exit_point = exact_point(cable.platform_anchor), exact_point(cable.frame_anchor)
        row = zip(region.rotation[2], anchor, strict=True)
        ends = [min(up * x * float(b) for x in bounds) for bounds, b in row]
        if lowest + sum(ends) <= up * float(exit_point[2]):
            return True
    return False


def asked(robot: Robot, lengths: Ranges) -> Answer:
    return forward_kinematics(robot, lengths, taut=range(len(robot.cables)))


def test_regions_in_which_every_cable_pulls_down_are_dropped(monkeypatch: pytest.MonkeyPatch):
    # Lengths alone leave nothing of it, either.
    monkeypatch.setattr(
        clusters, "drawn_in", lambda _, __, poses: (poses, np.ones(len(poses), dtype=np.bool_))
    )
    with monkeypatch.context() as patch:
        patch.setattr(clusters, "may_lift", lambda _, charts, __: np.ones(len(charts), dtype=np.bool_))
        before = asked(SIX, LENGTHS)
    after = asked(SIX, LENGTHS)
    assert [may_hold(SIX, region) for region in before.undecided].count(False) == 1
    assert all(may_hold(SIX, region) for region in after.undecided)
    assert len(after.undecided) == len(before.undecided) - 1
    assert after.outcome is Outcome.INCOMPLETE
    kept = {region.cells for region in after.undecided}
    assert kept <= {region.cells for region in before.undecided}


def test_down_is_where_the_load_pulls():
    """The same robot upside down in a field that pulls upwards: regions are where cables pull downwards."""
    exits = [(x, f"{-float(y)}", f"{-float(z)}") for x, y, z in EXITS]
    anchors = [(x, f"{-float(y)}", f"{-float(z)}") for x, y, z in ANCHORS]
    robot = platform(("0", "0", "9.81"), exits, anchors)
    found = asked(robot, LENGTHS)
    assert found.undecided
    assert all(may_hold(robot, region) for region in found.undecided)


CORNERS = [("0", "0"), ("4.2", "0"), ("4.2", "3.1"), ("0", "3.1")]
RECTANGLE = platform(
    ("0", "0", "-9.81"),
    [(x, y, "3.5") for x, y in CORNERS],
    [(x, y, "0.15") for x, y in (("-0.25", "-0.2"), ("0.25", "-0.2"), ("0.25", "0.2"), ("-0.25", "0.2"))],
)
"""Four cables between similar rectangles."""
HANGING = ["2.8566669819330306", "2.9866155595477886", "3.032774169914622", "2.905162377810758"]


@pytest.mark.parametrize(
    ("robot", "lengths", "by"),
    [(load_robot("uc4"), ["7.5", "8", "7", "9"], "0.02"), (RECTANGLE, HANGING, "0.001")],
    ids=["uc4", "rectangle"],
)
def test_platforms_above_their_exit_points_are_no_regions(robot: Robot, lengths: list[str], by: str):
    found = asked(robot, around(lengths, by))
    assert found.undecided
    assert all(may_hold(robot, region) for region in found.undecided)
