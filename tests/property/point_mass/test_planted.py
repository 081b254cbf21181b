"""Planted poses are never lost, both methods agree, and open cases are reported as what they are."""

from __future__ import annotations

import importlib.util
import math
import random
import sys
from fractions import Fraction
from itertools import combinations
from pathlib import Path

import mpmath
import numpy as np
import pytest

from cdpr_interval.errors import InputError
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from solvers.answers.data import Answer, CableState, Outcome, StopReason
from solvers.point_mass.forward import solve
from solvers.point_mass.rationals.surd import ExactPose, exact_pose
from solvers.questions.problem import Method, Options, Problem

SCRIPT = Path(__file__).parents[3] / "scripts" / "planted_point_mass.py"
spec = importlib.util.spec_from_file_location("planted_point_mass", SCRIPT)
assert spec is not None and spec.loader is not None
planted = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = planted
spec.loader.exec_module(planted)

METHODS = [Method.CONVEX, Method.SEARCH]
ORIGIN = (Fraction(0), Fraction(0), Fraction(0))
SQUARE = ((0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0))


def robot(anchors, elasticity: Elasticity | None = None, mass: object = 80, gravity=(0, 0, "-9.81")) -> Robot:
    cables = tuple(
        Cable(f"c{i + 1}", tuple(Fraction(str(x)) for x in a), ORIGIN, elasticity)
        for i, a in enumerate(anchors)
    )
    return Robot("test", Platform(Fraction(str(mass))), cables, tuple(Fraction(str(g)) for g in gravity))


def ask(model: Robot, lengths, method: Method = Method.CONVEX, **options) -> Answer:
    taut = options.pop("taut", None)
    ranges = tuple((Fraction(x), Fraction(x)) if not isinstance(x, tuple) else x for x in lengths)
    return solve(Problem(model, ranges, taut=taut), Options(method=method, **options))


def distances(point, anchors) -> list[float]:
    return [math.dist(point, a) for a in anchors]


def test_planted_poses_are_found() -> None:
    lines, failed = planted.run(120, 20240229)
    assert failed == 0, "\n".join(lines)


def test_the_planted_check_can_fail() -> None:
    one = planted.plant(random.Random(5), elastic=False)
    answer = solve(one.problem, Options())
    assert planted.complaints(one, answer, 1e-8) == []
    moved = planted.Planted(
        one.problem, one.taut, tuple(x + Fraction(1, 10**9) for x in one.position), one.tensions
    )
    assert planted.complaints(moved, answer, 1e-8)
    assert planted.complaints(one, Answer(()), 1e-8)


@pytest.mark.parametrize("elastic", [False, True])
def test_methods_agree_on_random_lengths(elastic: bool) -> None:
    rng = random.Random(11 + elastic)
    none = 0
    for _ in range(60):
        anchors = [[rng.uniform(-3, 3) for _ in range(3)] for _ in range(rng.randint(1, 5))]
        stretch = Elasticity(stiffness=Fraction(10 ** rng.randint(2, 6))) if elastic else None
        model = robot(anchors, stretch, gravity=[rng.uniform(-9, 9) for _ in range(3)])
        lengths = [rng.uniform(0.5, 5) for _ in anchors]
        a, b = (ask(model, lengths, method) for method in METHODS)
        assert a.outcome is b.outcome is Outcome.COMPLETE
        assert len(a.solutions) == len(b.solutions) <= 1
        assert elastic <= len(a.solutions)
        none += not a.solutions
        for s, t in zip(a.solutions, b.solutions, strict=True):
            assert s.taut == t.taut
            assert (s.position[:, 0] <= t.position[:, 1]).all() and (
                t.position[:, 0] <= s.position[:, 1]
            ).all()
            assert (s.position[:, 1] - s.position[:, 0]).max() < 1e-9
    assert elastic or 0 < none < 60


def test_the_energy_of_an_elastic_pose_is_lowest() -> None:
    rng = random.Random(3)
    mpmath.mp.dps = 40
    for _ in range(10):
        anchors = [[rng.uniform(-3, 3) for _ in range(3)] for _ in range(5)]
        model = robot(anchors, Elasticity(axial_stiffness=Fraction(5000)))
        lengths = [rng.uniform(1, 4) for _ in anchors]
        (solution,) = ask(model, lengths).solutions

        def force(
            x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf, points=tuple(model.cables), sizes=tuple(lengths)
        ) -> list[mpmath.mpf]:
            total = [mpmath.mpf(0), mpmath.mpf(0), -mpmath.mpf("784.8")]
            for cable, size in zip(points, sizes, strict=True):
                e = [
                    mpmath.mpf(a.numerator) / a.denominator - c
                    for a, c in zip(cable.frame_anchor, (x, y, z), strict=True)
                ]
                rho = mpmath.sqrt(sum(c * c for c in e))
                if rho > size:
                    total = [f + 5000 * (rho / size - 1) * c / rho for f, c in zip(total, e, strict=True)]
            return total

        root = mpmath.findroot(force, list(solution.nominal.position))
        for (lo, hi), x in zip(solution.position, root, strict=True):
            assert mpmath.mpf(float(lo)) <= x <= mpmath.mpf(float(hi))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("elastic", [False, True])
def test_length_ranges_enclose_the_pose_of_every_choice(elastic: bool, method: Method) -> None:
    rng = random.Random(17)
    point = (1.1, 1.4, -2.0)
    stretch = Elasticity(stiffness=Fraction(20000)) if elastic else None
    model = robot(SQUARE, stretch)
    middle = [Fraction(round(d, 4)) for d in distances(point, SQUARE)]
    tolerance = Fraction(1, 100)
    ranges = [(x - tolerance, x + tolerance) for x in middle]
    answer = ask(model, ranges, method)
    (whole,) = answer.solutions
    assert not answer.undecided
    assert (whole.position[:, 1] - whole.position[:, 0]).max() < 0.15
    seen: list[set[CableState]] = [set() for _ in SQUARE]
    for _ in range(40):
        chosen = [lo + (hi - lo) * Fraction(rng.choice((0.0, 1.0, rng.random()))) for lo, hi in ranges]
        (one,) = ask(model, chosen).solutions
        for whole_box, box in (
            (whole.position, one.position),
            (whole.tensions, one.tensions),
            (whole.distances, one.distances),
        ):
            assert (whole_box[:, 0] <= box[:, 1]).all() and (box[:, 0] <= whole_box[:, 1]).all()
        for state, own, found in zip(whole.cable_states, one.cable_states, seen, strict=True):
            assert state in (CableState.SWITCHING, CableState.UNDECIDED, own)
            found.add(own)
    # For springs the bounds do not tell of every cable whether it is taut for all lengths.
    assert elastic or answer.outcome is Outcome.COMPLETE
    for state, found in zip(whole.cable_states, seen, strict=True):
        # What is said to change does.
        assert state is not CableState.SWITCHING or found == {CableState.TAUT, CableState.SLACK}


def test_partly_empty_ranges_are_undecided_and_empty_ones_are_proved() -> None:
    model = robot(SQUARE[:2])
    partly = ask(model, [(Fraction("1.9"), Fraction("2.1"))] * 2)
    assert partly.outcome is Outcome.INCOMPLETE and partly.solutions == () and len(partly.undecided) == 1
    empty = ask(model, [(Fraction("1.8"), Fraction("1.9"))] * 2)
    assert empty.outcome is Outcome.COMPLETE and empty.message.startswith("cables c1 and c2 cannot reach")


@pytest.mark.parametrize("method", METHODS)
def test_four_spheres_through_one_point_up_to_rounding(method: Method) -> None:
    point = (1.0, 1.5, -2.0)
    answer = ask(robot(SQUARE), distances(point, SQUARE), method)
    (solution,) = answer.solutions
    assert answer.outcome is Outcome.INCOMPLETE and answer.undecided == ()
    assert CableState.UNDECIDED in solution.cable_states and solution.slack_respected is None
    assert abs(solution.position.mean(axis=1) - point).max() < 1e-12
    assert (solution.position[:, 1] - solution.position[:, 0]).max() < 1e-12
    assert solution.note == "cables {c1, c2, c3, c4} tight up to rounding, tensions may not be unique"
    # Every subset's tensions lie in the hull.
    for taut in ((0, 1, 2), (0, 2, 3)):
        for own in ask(
            robot([SQUARE[i] for i in taut]), [distances(point, SQUARE)[i] for i in taut]
        ).solutions:
            for i, (lo, hi) in zip(taut, own.tensions, strict=True):
                assert solution.tensions[i, 0] <= hi and lo <= solution.tensions[i, 1]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ignore_slack", [False, True])
def test_a_symmetric_pose_is_one_entry(method: Method, ignore_slack: bool) -> None:
    answer = ask(robot(SQUARE), [3] * 4, method, ignore_slack=ignore_slack)
    there = [s for s in answer.solutions if abs(s.position.mean(axis=1) - (2, 2, -1)).max() < 1e-9]
    assert len(there) == 1 and there[0].note == "cables {c1, c2, c3, c4} tight, tensions not unique"
    assert len(answer.solutions) == (9 if ignore_slack else 1)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("anchors", "lengths", "pose"),
    [
        ([(0, 0, 0)] * 3, [2, 2, 3], (0, 0, -2)),
        ([(0, 0, 0), (0, 0, 1), (0, 0, 2)], [2, 3, 4], (0, 0, -2)),
        ([(0, 0, 0), (0, 0, 1), (0, 0, 2)], [2, 4, 4], (0, 0, -2)),
        (
            [(0, 0, 0), (1, 0, 0), (2, 0, 0)],
            distances((0.75, 0, -2), [(0, 0, 0), (1, 0, 0), (2, 0, 0)]),
            (0.75, 0, -2),
        ),
    ],
)
def test_degenerate_anchors_keep_their_pose(anchors, lengths, pose, method: Method) -> None:
    answer = ask(robot(anchors), lengths, method)
    (solution,) = answer.solutions
    assert answer.undecided == () and answer.outcome is Outcome.INCOMPLETE
    assert CableState.UNDECIDED in solution.cable_states
    assert abs(solution.position.mean(axis=1) - pose).max() < 1e-12
    assert (solution.position[:, 1] - solution.position[:, 0]).max() < 1e-12


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("stretch", "lengths"),
    [
        (Elasticity(stiffness=Fraction(100)), [2, math.dist((0, 0, -9.848), SQUARE[1])]),
        (None, [2, math.hypot(4, 2)]),
    ],
)
def test_a_cable_just_taut_switches(stretch, lengths, method: Method) -> None:
    answer = ask(robot(SQUARE[:2], stretch), lengths, method)
    (solution,) = answer.solutions
    assert answer.outcome is Outcome.COMPLETE and solution.slack_respected is True
    assert solution.cable_states == (CableState.TAUT, CableState.SWITCHING)
    assert solution.note == "c2 just taut or just slack" and all(
        row.outcome is Outcome.COMPLETE for row in answer.subsets
    )
    assert solution.tensions[1, 0] == 0.0 and solution.tensions[1, 1] < 1e-9
    # On either side of the switch there is one pose, and it is near.
    for change, state in ((-1e-6, CableState.TAUT), (1e-6, CableState.SLACK)):
        (beside,) = ask(robot(SQUARE[:2], stretch), [lengths[0], lengths[1] + change], method).solutions
        assert beside.cable_states == (CableState.TAUT, state)
        assert abs(beside.position.mean(axis=1) - solution.position.mean(axis=1)).max() < 1e-4
    # A subset that was asked for is that of one side only.
    asked = ask(robot(SQUARE[:2], stretch), lengths, method, taut=(0,))
    assert asked.outcome is Outcome.INCOMPLETE
    assert asked.solutions[0].cable_states == (CableState.TAUT, CableState.UNDECIDED)


def test_threads_do_not_change_the_solutions() -> None:
    model = robot(SQUARE, Elasticity(stiffness=Fraction(5000)))
    lengths = [3, Fraction(16, 5), Fraction(31, 10), Fraction(7, 2)]
    one, two = (ask(model, lengths, Method.SEARCH, ignore_slack=True, threads=n) for n in (1, 2))
    assert [s.taut for s in one.solutions] == [s.taut for s in two.solutions]
    for s, t in zip(one.solutions, two.solutions, strict=True):
        assert np.array_equal(s.position, t.position) and np.array_equal(s.tensions, t.tensions)


def test_budgets_leave_pending_work() -> None:
    model = robot(SQUARE)
    lengths = [3, Fraction(16, 5), Fraction(31, 10), Fraction(7, 2)]
    answer = ask(model, lengths, Method.SEARCH, cell_limit=50)
    assert answer.outcome is Outcome.INCOMPLETE and answer.pending > 0
    assert answer.stop_reason is StopReason.CELL_LIMIT and answer.cells <= 50
    answer = ask(model, lengths, ignore_slack=True, time_limit=1e-9)
    assert answer.pending == 14 and answer.stop_reason is StopReason.TIME_LIMIT


def test_a_load_of_zero_is_refused() -> None:
    problem = Problem(
        robot(SQUARE, mass=1), ((Fraction(3),) * 2,) * 4, (Fraction(0), Fraction(0), Fraction("9.81"))
    )
    with pytest.raises(InputError, match="load"):
        solve(problem, Options())


def test_the_centre_of_mass_need_not_be_the_origin() -> None:
    centre = (Fraction("0.1"), Fraction("-0.2"), Fraction("0.3"))
    cables = tuple(Cable(c.name, c.frame_anchor, centre) for c in robot(SQUARE).cables)
    moved = Robot("moved", Platform(Fraction(80), centre), cables)
    lengths = [3, Fraction(16, 5), Fraction(31, 10), Fraction(7, 2)]
    (plain,), (shifted,) = (ask(model, lengths).solutions for model in (robot(SQUARE), moved))
    shift = [float(x) for x in centre]
    assert np.allclose(shifted.position.mean(axis=1) + shift, plain.position.mean(axis=1), atol=1e-12)
    assert np.allclose(shifted.height, plain.height, atol=1e-12)


@pytest.mark.parametrize("ignore_slack", [False, True])
def test_robots_on_a_lattice_against_exact_arithmetic(ignore_slack: bool) -> None:
    """Small integers make coincident, collinear, touching and redundant cables common."""
    kinds = set()
    for seed in range(100):
        rng = random.Random(900 + seed)
        anchors = [tuple(rng.randint(0, 2) for _ in range(3)) for _ in range(rng.randint(1, 5))]
        point = tuple(rng.randint(-2, 4) for _ in range(3))
        lengths = [
            Fraction(rng.choice((1, 2, 3, 0.5)) if seed % 2 else max(0.25, math.dist(point, a)))
            for a in anchors
        ]
        gravity = rng.choice(((0, 0, -1), (1, 0, 0), (1, 1, 0), (0, 1, -2)))
        model = robot(anchors, gravity=gravity)
        load = loaded(model).load
        exact = {}
        for size in (1, 2, 3):
            for taut in combinations(range(len(anchors)), size):
                points = [model.cables[i].frame_anchor for i in taut]
                pose = exact_pose(points, [lengths[i] for i in taut], load)
                if pose is not None and pose.carried():
                    exact[taut] = pose
        valid = [
            pose
            for pose in exact.values()
            if all(pose.excess(c.frame_anchor, s) <= 0 for c, s in zip(model.cables, lengths, strict=True))
        ]
        found = [ask(model, lengths, method, ignore_slack=ignore_slack) for method in METHODS]
        kinds.add((found[0].outcome, len(valid) > 0))
        assert found[0].outcome is found[1].outcome
        assert [s.taut for s in found[0].solutions] == [s.taut for s in found[1].solutions]
        for answer in found:
            wanted = list(exact.values()) if ignore_slack else valid
            boxes = [s.position for s in answer.solutions] + [u.position for u in answer.undecided]
            for pose in wanted:
                assert any(contains(box, pose) for box in boxes), (anchors, lengths, gravity)
            for solution in answer.solutions:
                assert any(contains(solution.position, pose) for pose in wanted)
    assert (
        ignore_slack
        or {(Outcome.COMPLETE, True), (Outcome.COMPLETE, False), (Outcome.INCOMPLETE, True)} <= kinds
    )


def contains(box: np.ndarray, pose: ExactPose) -> bool:
    """Return True when an exact pose lies in a box (3, 2)."""
    for j in range(3):
        axis = tuple(Fraction(int(j == k)) for k in range(3))
        low, high = (tuple(Fraction(float(x)) * a for a in axis) for x in box[j])
        if pose.component(axis, low) < 0 or pose.component(axis, high) > 0:
            return False
    return True
