"""Deltas against numbers computed independently from EPFL, "Les robots paralleles" (R. Clavel), 1.3."""

from __future__ import annotations

import math

import pytest

from scripts.reproduce_clavel import ROUNDING, THRESHOLD, Prism, robots, table
from solvers import delta_drives, delta_poses

DRIVES = [
    ((0, 0, -0.4), (0.7417282496961637,) * 3, (3.0056341406435725,) * 3),
    (
        (0, 0.15, -0.45),
        (1.0880927210767548, 0.6033574749177155, 1.4689512556529072),
        (2.5953936331898797, 2.5164413277012883, 2.703415785431697),
    ),
    (
        (0.2, -0.1, -0.43),
        (0.4103469229603287, 1.7644960722441918, 1.2855712219564608),
        (2.385882747393454, 2.631263333462765, 2.4787900886436485),
    ),
    (
        (-0.24, 0, -0.42),
        (1.8887803665751866, 0.7676264701670719, 0.7676264701670719),
        (2.6837098437279394, 2.397774582539341, 2.397774582539341),
    ),
]
"""DELTA 580: position in m, angles in rad of the useful and of the other branch."""
POSES = [
    ((0, 0, 0), (0, 0, -196.91368667515218), (0, 0, 196.91368667515218)),
    (
        (10, 20, 30),
        (33.95548473940672, 20.772377700637826, -281.75395488425335),
        (-11.18028587168923, -5.510542632884716, 147.98913939282295),
    ),
    (
        (60, 5, -10),
        (-147.34235917804088, -22.68616198434922, -245.63784693456907),
        (43.80053643564336, 15.55267312468756, 160.44873499031155),
    ),
]
"""DELTA 580: angles in deg, lower and upper pose in mm."""


@pytest.mark.parametrize(("position", "useful", "other"), DRIVES)
def test_drives_are_those_computed_elsewhere(position, useful, other):
    found = delta_drives("delta_580", [str(x) for x in position])
    assert found.reachable and found.outcome == "complete"
    for rows, wanted in ((found.angles, useful), (found.other_branch, other)):
        assert rows.mean(axis=1) == pytest.approx(wanted, abs=1e-12)
        assert (rows[:, 1] - rows[:, 0] < 1e-14).all()


@pytest.mark.parametrize(("angles", "lower", "upper"), POSES)
def test_poses_are_those_computed_elsewhere(angles, lower, upper):
    found = delta_poses("delta_580", [f"{a}deg" for a in angles])
    assert found.outcome == "complete" and [p.lower for p in found.solutions] == [True, False]
    for pose, wanted in zip(found.solutions, (lower, upper), strict=True):
        assert 1000 * pose.position.mean(axis=1) == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize(
    ("position", "degrees"),
    [((-0.3, 0, -0.2), (103.013, -4.477, -4.477)), ((-0.3, 0, -0.3), (107.801, 21.734, 21.734))],
)
def test_the_smaller_principal_value_is_not_the_useful_branch(position, degrees):
    """The text takes the smaller angle: true before angles are brought into half a turn of 0 only."""
    found = delta_drives("delta_580", position)
    assert [math.degrees(a) for a in found.angles.mean(axis=1)] == pytest.approx(degrees, abs=1e-3)
    assert found.other_branch[0].mean() < found.angles[0].mean()


def test_the_tables_of_the_chapter():
    verdicts = [verdict for _, verdict in table()]
    assert len(verdicts) == 144 and "not reproduced" not in verdicts
    assert [verdicts.count(v) for v in ("reproduced", ROUNDING, "contradicts the text")] == [89, 43, 12]
    assert [verdict for _, verdict in robots()].count("not reproduced") == 0
    exact = Prism(0.625, 2).exact()
    assert exact[0] == pytest.approx(-1.2393136749274758) and exact[1] == pytest.approx(0.8919216274758887)
    assert math.sqrt(3) * math.tan(math.radians(20)) == pytest.approx(0.630414938192) and THRESHOLD == 0.63
