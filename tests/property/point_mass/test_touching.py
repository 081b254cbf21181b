"""Balls that only touch, subsets with dependent directions, and tensions that nothing bounds: exact cases."""

from __future__ import annotations

import json
import math
import random
import re
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval.exact.enclosure import length_bounds
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers import PointMass, Result, forward_kinematics
from solvers.answers.data import CableState, Outcome
from solvers.point_mass.arrays import robot_arrays
from solvers.point_mass.controller import PoseStatus
from solvers.point_mass.convex import find_pose
from solvers.point_mass.entry import Fields
from solvers.point_mass.rationals.tension_polytope import tensions_at
from solvers.point_mass.reach import reachable
from solvers.questions.problem import Problem

METHODS = ["convex", "search"]
ZERO = (Fraction(0), Fraction(0), Fraction(0))
TWO_UP_TWO_DOWN = [(0, 3, 4), (0, -3, 4), (3, 0, -4), (-3, 0, -4)]
LINE = [(0, 0, 0), (2, 0, 0), (4, 0, 0)]


def robot(anchors, gravity=(0, 0, -1)) -> Robot:
    cables = tuple(
        Cable(f"c{i}", tuple(Fraction(str(x)) for x in a), ZERO, None) for i, a in enumerate(anchors)
    )
    x, y, z = (Fraction(str(g)) for g in gravity)
    return Robot("test", Platform(Fraction(1)), cables, (x, y, z))


def contains(bounds, value) -> bool:
    return Fraction(float(bounds[0])) <= value and (
        math.isinf(bounds[1]) or value <= Fraction(float(bounds[1]))
    )


def unit(rng: random.Random, plane: bool = False) -> tuple[Fraction, ...]:
    """Return a rational unit vector, in the plane y = 0 if asked."""
    x = Fraction(rng.randint(-40, 40), 17)
    y = Fraction(0) if plane else Fraction(rng.randint(-40, 40), 19)
    size = x * x + y * y + 1
    return 2 * x / size, 2 * y / size, (x * x + y * y - 1) / size


def pulling_against_each_other(rng: random.Random, count: int, plane: bool) -> list[tuple[Fraction, ...]]:
    """Return unit vectors with 0 strictly in their hull."""
    while True:
        directions = [unit(rng, plane) for _ in range(count)]
        columns = np.array(directions, dtype=float).T[[0, 2] if plane else [0, 1, 2]]
        _, _, v = np.linalg.svd(columns)
        kernel = v[-1]
        if (kernel > 0.05).all() or (kernel < -0.05).all():
            return directions


def touching(rng: random.Random, count: int, plane: bool):
    """Return exit points and lengths whose balls have one common point, and that point."""
    point = tuple(Fraction(rng.randint(-30, 30), 7) for _ in range(3))
    lengths = [Fraction(rng.randint(5, 40), 11) for _ in range(count)]
    if count == 2:
        (first,) = (unit(rng),)
        directions = [first, tuple(-x for x in first)]
    else:
        directions = pulling_against_each_other(rng, count, plane)
    anchors = [
        tuple(p - s * u for p, u in zip(point, d, strict=True))
        for d, s in zip(directions, lengths, strict=True)
    ]
    return anchors, lengths, point


@pytest.mark.parametrize("method", METHODS)
def test_two_up_two_down(method) -> None:
    model = robot(TWO_UP_TWO_DOWN)
    result = forward_kinematics(model, [5] * 4, method=method)
    (pose,) = result.solutions
    assert result.outcome is Outcome.INCOMPLETE and not result.undecided
    assert np.abs(pose.position).max() < 1e-15 and pose.is_proved
    assert pose.cable_states == (CableState.TAUT,) * 2 + (CableState.UNDECIDED,) * 2
    # Without the lower cables each upper one carries 5/8 N; the lower ones add what they pull.
    assert all(contains(pose.tensions[i], Fraction(5, 8)) for i in (0, 1)) and pose.tensions[0, 0] > 0.624
    assert np.isinf(pose.tensions[:, 1]).all() and "prestress" in pose.note
    assert result.verify(model) == []
    text = result.to_json()
    assert json.loads(text)["solutions"][0]["tensions_N"][2] == [0.0, None]
    assert Result.from_json(text).to_json() == text


@pytest.mark.parametrize(("count", "plane"), [(2, False), (3, True), (4, False)])
def test_planted_balls_that_touch(count, plane) -> None:
    rng = random.Random(count)
    held = 0
    for _ in range(12):
        anchors, lengths, point = touching(rng, count, plane)
        arms = {
            i: tuple(p - a for p, a in zip(point, anchor, strict=True)) for i, anchor in enumerate(anchors)
        }
        pulls = [Fraction(rng.randint(0, 9), 4) for _ in anchors]
        pulls[rng.randrange(count)] += 1
        load = [sum(t * arms[i][j] for i, t in enumerate(pulls)) for j in range(3)]
        inside = any(load)
        if not inside:
            load = [Fraction(0), Fraction(0), Fraction(-1)]
        model = robot(anchors, load)
        result = forward_kinematics(model, lengths)
        if not inside:
            continue
        held += 1
        (pose,) = result.solutions
        assert pose.is_proved and result.outcome is Outcome.INCOMPLETE and result.verify(model) == []
        assert all(contains(box, x) for box, x in zip(pose.position, point, strict=True))
        assert (pose.position[:, 1] - pose.position[:, 0]).max() < 1e-14
        assert np.isinf(pose.tensions[:, 1]).all()
        assert all(
            contains(pose.tensions[i], t * s) for i, (t, s) in enumerate(zip(pulls, lengths, strict=True))
        )
        # Shorter by next to nothing: apart, which is proved; longer: one pose, and it is near.
        little = Fraction(1, 10**25)
        shorter = forward_kinematics(model, [lengths[0] - little, *lengths[1:]])
        assert shorter.outcome is Outcome.COMPLETE and "cannot reach" in shorter.message
        assert re.search(r"lengths, by some \de-\d\d m$", shorter.message)
        longer = forward_kinematics(model, [lengths[0] + little, *lengths[1:]])
        (near,) = longer.solutions
        assert near.is_proved and longer.verify(model) == []
        assert np.abs(near.position.mean(axis=1) - pose.position.mean(axis=1)).max() < 1e-9
        if count < 4:
            across = [0, 1, 0] if plane else [arms[0][1], -arms[0][0], Fraction(0)]
            if any(across):
                side = robot(anchors, [Fraction(x) for x in across])
                nothing = forward_kinematics(side, lengths)
                assert nothing.outcome is Outcome.COMPLETE and not nothing.solutions
                assert nothing.message.endswith(
                    "only just reach each other: no finite tensions hold the load"
                )
    assert held > 8


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("anchors", "lengths", "listed"),
    [
        ([(0, 0, 0), (4, 0, 0)], ["2", "2"], "c0 and c1"),
        ([(0, 0, 0), ("0.3", 0, 0)], ["0.1", "0.2"], "c0 and c1"),
        ([(0, 0, 0), ("0.3", 0, 0), (0, 0, 1)], ["0.1", "0.2", "5"], "c0 and c1"),
        ([(5, 0, 0), (-3, 4, 0), (-3, -4, 0)], ["5", "5", "5"], "c0, c1 and c2"),
    ],
)
def test_balls_that_touch_where_nothing_holds_the_load(anchors, lengths, listed, method) -> None:
    result = forward_kinematics(robot(anchors), lengths, method=method)
    assert result.outcome is Outcome.COMPLETE and not result.solutions
    assert result.message == f"cables {listed} only just reach each other: no finite tensions hold the load"
    assert all(row.outcome is Outcome.COMPLETE and row.solutions == 0 for row in result.subsets)


def test_floats_are_exact_for_the_prepared_solver() -> None:
    model = robot(TWO_UP_TWO_DOWN)
    pose = PointMass(model).solve([5.0] * 4)
    (listed,) = forward_kinematics(model, [5.0] * 4).solutions
    assert pose.status is PoseStatus.PROVED and not pose.complete and pose.note == listed.note
    assert np.array_equal(pose.tensions, listed.tensions)
    decimals = robot([(0, 0, 0), (0, 0, "-0.3")])
    text = PointMass(decimals).solve("0.1,0.2")
    (same,) = forward_kinematics(decimals, "0.1,0.2").solutions
    assert text.proved and np.array_equal(text.tensions, same.tensions) and np.isinf(text.tensions[1, 1])
    # Doubles near 0.1, 0.2 and the decimal 0.3 touch neither: 0.1 + 0.2 as doubles is more than 0.3.
    overlapping = PointMass(robot([(0, 0, 0), ("0.3", 0, 0)])).solve([0.1, 0.2])
    assert overlapping.proved and np.abs(overlapping.position.mean(axis=1) - [0.1, 0, 0]).max() < 1e-8


def test_bounds_of_tensions_hold_for_all_that_balance() -> None:
    rng = random.Random(3)
    unbounded = 0
    for _ in range(60):
        count = rng.randint(1, 6)
        anchors = {i: tuple(Fraction(rng.randint(-4, 4)) for _ in range(3)) for i in range(count)}
        anchors = {i: a for i, a in anchors.items() if any(a)}
        t = {i: Fraction(rng.randint(0, 6), 3) for i in anchors}
        load = tuple(-sum((t[i] * a[j] for i, a in anchors.items()), Fraction(0)) for j in range(3))
        if not any(load):
            continue
        tensions = tensions_at(ZERO, anchors, load)
        for corner in tensions.corners:
            total = [-sum((x * anchors[i][j] for i, x in corner.items()), Fraction(0)) for j in range(3)]
            assert total == list(load)
        for ray in tensions.rays:
            assert min(ray.values()) > 0
            assert not any(sum((x * anchors[i][j] for i, x in ray.items()), Fraction(0)) for j in range(3))
        for i in anchors:
            most = tensions.most(i)
            unbounded += most is None
            assert tensions.least(i) <= t[i] and (most is None or t[i] <= most)
    assert unbounded > 20
    assert (
        tensions_at(ZERO, {0: (Fraction(0), Fraction(0), Fraction(1))}, (*ZERO[:2], Fraction(1))).corners
        == ()
    )


def test_more_tight_cables_than_are_listed_stay_open() -> None:
    anchors = [(0, 0, 2)] * 7 + [(0, 0, -2)] * 7
    result = forward_kinematics(robot(anchors), [2] * 14)
    assert result.outcome is Outcome.INCOMPLETE and not result.solutions
    (region,) = result.undecided
    assert np.abs(region.position).max() < 1e-4


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("anchors", "lengths", "point", "tensions"),
    [
        (LINE, ["2.5", "1.5", "2.5"], (2, 0, -1.5), (0.25, 0.7, 0.25)),
        ([(0, 0, 0), (0, 0, 1)], ["1", "2"], (0, 0, -1), (0.4, 0.6)),
        ([(0, 0, 0), (0, 0, 0)], ["2", "2"], (0, 0, -2), (0.4, 0.6)),
        ([(0, 0, 0), (0, 0, -3)], ["1", "2"], (0, 0, -1), (3.0, 2.0)),
        ([(-3, 0, 4), (0, 0, 5), (3, 0, 4)], ["5", "5", "5"], (0, 0, 0), (0.25, 0.6, 0.25)),
    ],
)
def test_a_subset_with_dependent_directions(anchors, lengths, point, tensions, method) -> None:
    asked = tuple(range(len(anchors)))
    more = [*anchors, (100, 0, 0)]
    for exits, sizes in ((anchors, lengths), (more, [*lengths, "500"]), (more, [*lengths, "5"])):
        model = robot(exits)
        result = forward_kinematics(model, sizes, taut=asked, ignore_slack=True, method=method)
        (pose,) = result.solutions
        assert result.outcome is Outcome.INCOMPLETE and not result.undecided and result.verify(model) == []
        assert np.abs(pose.position.mean(axis=1) - point).max() < 1e-12
        assert all(lo <= t <= hi for t, (lo, hi) in zip(tensions, pose.tensions.tolist(), strict=False))
        assert all(pose.cable_states[i] is not CableState.SLACK for i in asked)
        assert pose.slack_respected is (sizes[-1] != "5" or len(sizes) == len(lengths))
        assert [row.outcome for row in result.subsets] == [Outcome.INCOMPLETE]
    alone = forward_kinematics(robot(anchors), lengths, taut=asked, method=method)
    assert len(alone.solutions) == 1 and alone.outcome is Outcome.INCOMPLETE


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("middle", ["1.6", "1.4"])
def test_a_dependent_subset_that_does_not_carry_together(middle, method) -> None:
    result = forward_kinematics(
        robot(LINE), ["2.5", middle, "2.5"], taut=(0, 1, 2), ignore_slack=True, method=method
    )
    assert result.outcome is Outcome.COMPLETE and not result.solutions


def test_a_dependent_subset_over_ranges_stays_open() -> None:
    result = forward_kinematics(robot(LINE), [(2.4, 2.6), 1.5, 2.5], taut=(0, 1, 2), ignore_slack=True)
    assert result.outcome is Outcome.INCOMPLETE and "not unique" in result.undecided[0].reason


def test_unique_tensions_are_not_said_to_be_others() -> None:
    """Three cables with independent wrenches, one just taut: its tension is zero, nothing else."""
    result = forward_kinematics(robot([(-3, 0, 0), (3, 0, 0), (0, 3, 0)]), ["5", "5", "5"])
    (pose,) = result.solutions
    assert pose.cable_states == (CableState.TAUT, CableState.TAUT, CableState.SWITCHING)
    assert pose.note == "c2 just taut or just slack" and result.outcome is Outcome.COMPLETE
    four = forward_kinematics(robot([(-3, 0, 0), (3, 0, 0), (0, 3, 0), (0, -3, 0)]), ["5"] * 4)
    assert four.solutions[0].note == "cables {c0, c1, c2, c3} tight, tensions not unique"


def test_one_cable_with_a_range_does_not_make_the_others_unique() -> None:
    square = [(0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0)]
    fixed = forward_kinematics(robot([*square, (2, 2, 20)]), [3, 3, 3, 3, (20.5, 21.5)])
    assert fixed.outcome is Outcome.INCOMPLETE
    assert CableState.UNDECIDED in fixed.solutions[0].cable_states
    ranges = forward_kinematics(robot(square), [(2.99, 3.01)] * 4)
    assert ranges.outcome is Outcome.COMPLETE and ranges.verify(robot(square)) == []
    assert ranges.solutions[0].cable_states == (CableState.SWITCHING,) * 4
    assert ranges.message == "1 static pose, proved to be all"


def test_an_open_region_holds_every_pose_for_lengths_in_their_ranges() -> None:
    rng = random.Random(11)
    found = 0
    for _ in range(8):
        anchors, lengths, _ = touching(rng, 4, False)
        model = robot(anchors)
        ranges = [(s - Fraction(1, 500), s + Fraction(1, 500)) for s in lengths]
        problem = Problem(model, tuple(ranges))
        arrays = robot_arrays(problem.loaded)
        box = reachable(arrays, length_bounds(ranges))
        for _ in range(60):
            chosen = [float(lo + (hi - lo) * Fraction(rng.random())) for lo, hi in ranges]
            finding = find_pose(arrays, np.column_stack([chosen, chosen]))
            if isinstance(finding, Fields):
                found += 1
                middle = finding.position.mean(axis=1)
                assert (box[:, 0] <= middle).all() and (middle <= box[:, 1]).all()
    assert found > 40


def test_a_plane_of_exits_and_load_holds_the_region() -> None:
    upright = [(0, "1.76", 0), ("2.055", "1.76", 0), (0, 0, 0), ("2.055", 0, 0)]
    middles = ("1.3189", "1.3616", "1.3454", "1.3859")
    ranges = [(Fraction(x) - Fraction(1, 500), Fraction(x) + Fraction(1, 500)) for x in middles]
    result = forward_kinematics(robot(upright, (0, "-9.81", 0)), ranges)
    (region,) = result.undecided
    low, high = region.position.T
    # Of the intersection of the largest balls: x 0.9976..1.0027, y 0.8965..0.9025, to four digits.
    assert np.allclose(low, [0.9976, 0.8965, 0], atol=6e-5) and np.allclose(
        high, [1.0027, 0.9025, 0], atol=6e-5
    )
    assert low[2] < 0 < high[2]


def test_the_box_in_reach_ends_where_the_common_points_do() -> None:
    rng = random.Random(20261129)
    for _ in range(20):
        anchors = [[Fraction(rng.randint(-40, 40), 10) for _ in range(3)] for _ in range(5)]
        model = robot(anchors)
        inside = np.array([rng.uniform(-1, 1) for _ in range(3)])
        exits = np.array(anchors, dtype=float)
        longest = np.linalg.norm(exits - inside, axis=1) + 0.1
        arrays = robot_arrays(Problem(model, ()).loaded)
        box = reachable(arrays, np.stack([longest - 0.01, longest], axis=1))
        points = inside + np.array([[rng.uniform(-0.3, 0.3) for _ in range(3)] for _ in range(4000)])
        common = points[(np.linalg.norm(points[:, None] - exits, axis=2) <= longest).all(axis=1)]
        assert len(common) > 3
        assert (box[:, 0] <= common.min(axis=0)).all() and (common.max(axis=0) <= box[:, 1]).all()
        for j in range(3):
            for k, sign in enumerate((-1.0, 1.0)):
                # There are common points as near to the end as a hundredth of the extent.
                short = 0.01 * (box[j, 1] - box[j, 0])
                end = projected(exits, longest, inside, sign * np.eye(3)[j], sign * box[j, k] - short)
                assert (np.linalg.norm(end - exits, axis=1) <= longest + 1e-6).all()


def projected(
    exits: np.ndarray, longest: np.ndarray, start: np.ndarray, direction: np.ndarray, least: float
) -> np.ndarray:
    """Return a point with direction . p >= least in all balls, if there are any: by projections in turn."""
    p = start.copy()
    for _ in range(20000):
        for a, size in zip(exits, longest, strict=True):
            away = np.linalg.norm(p - a)
            if away > size:
                p = a + (p - a) * size / away
        p += max(least - direction @ p, 0.0) * direction
        if (np.linalg.norm(p - exits, axis=1) <= longest + 1e-7).all():
            break
    return p
