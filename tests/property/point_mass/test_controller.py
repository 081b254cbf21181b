"""The prepared solver of a point mass: the same answers as `forward_kinematics`, bit for bit."""

from __future__ import annotations

import math
import random
import subprocess
import sys
import threading
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cdpr_interval import InputError, NotSupportedError, load_robot
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.loaded import MOST_KEPT, loaded
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from solvers import PointMass, PoseStatus, forward_kinematics
from solvers.answers.data import CableState, Outcome
from solvers.answers.result import Result
from solvers.point_mass.arrays import build_arrays, robot_arrays, with_load
from solvers.point_mass.controller import PointMassPose

ORIGIN = (Fraction(0), Fraction(0), Fraction(0))
ROOT = Path(__file__).parents[3]
KINDS = ("inextensible", "stiffness", "axial")
SQUARE = ((0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0))


def robot(anchors, kind: str = "inextensible", mass: object = 80) -> Robot:
    elasticity = {
        "inextensible": None,
        "stiffness": Elasticity(stiffness=Fraction(10**5)),
        "axial": Elasticity(axial_stiffness=Fraction(10**6, 3)),
    }[kind]
    cables = tuple(
        Cable(f"c{i + 1}", tuple(Fraction(str(x)) for x in a), ORIGIN, elasticity)
        for i, a in enumerate(anchors)
    )
    return Robot("test", Platform(Fraction(str(mass))), cables)


def planted(rng: random.Random, count: int, kind: str) -> tuple[Robot, list[float], list[float]]:
    """Return a robot with its exit points above a point, and lengths that hold the mass near it."""
    anchors = [[round(rng.uniform(*span), 3) for span in ((-5, 5), (-5, 5), (3, 6))] for _ in range(count)]
    point = [rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-1, 1)]
    slack = [rng.choice((0.0, 0.002, 0.2)) for _ in anchors]
    lengths = [math.dist(point, a) * (1 + s) for a, s in zip(anchors, slack, strict=True)]
    return robot(anchors, kind), lengths, point


def same(pose: PointMassPose, result: Result) -> None:
    """Compare with what `forward_kinematics` found: equal to the last bit."""
    assert pose.complete == (result.outcome is Outcome.COMPLETE)
    assert pose.proved == bool(result.solutions)
    if result.solutions:
        (solution,) = result.solutions
        for name in ("position", "height", "tensions", "distances"):
            assert np.array_equal(getattr(pose, name), getattr(solution, name)), name
        assert (pose.states, pose.taut, pose.note) == (
            solution.cable_states,
            solution.taut,
            solution.note,
        )
        assert pose.point == solution.nominal.position and pose.reason == ""
    elif result.undecided:
        (region,) = result.undecided
        assert pose.status is PoseStatus.UNPROVED
        assert pose.reason == region.reason and np.array_equal(pose.position, region.position)
        assert set(pose.states) == {CableState.UNDECIDED}
        assert (pose.tensions == (0.0, np.inf)).all()
    else:
        assert pose.status is PoseStatus.NO_POSE and pose.reason
        assert np.isnan(pose.bounds).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("count", range(1, 9))
def test_planted_robots(kind: str, count: int) -> None:
    rng = random.Random(100 * count + KINDS.index(kind))
    found = set()
    for _ in range(12):
        model, lengths, _ = planted(rng, count, kind)
        solver = PointMass(model)
        pose = solver.solve(lengths)
        same(pose, forward_kinematics(model, lengths))
        found.add(pose.status)
        force = [rng.uniform(-300, 300), rng.uniform(-300, 300), rng.uniform(-3000, 0)]
        forced = forward_kinematics(model, lengths, external_force=force)
        for _ in range(2):
            same(solver.solve(lengths, force), forced)
        same(solver.solve(tuple(lengths)), forward_kinematics(model, lengths))
    assert PoseStatus.PROVED in found


@pytest.mark.parametrize("kind", KINDS)
def test_ranges_enclose_what_their_ends_give(kind: str) -> None:
    rng = random.Random(7)
    for count in (1, 3, 4, 6):
        model, lengths, _ = planted(rng, count, kind)
        solver = PointMass(model)
        ranges = [(x, x * (1 + 1e-5)) for x in lengths]
        pose = solver.solve(ranges)
        same(pose, forward_kinematics(model, ranges))
        assert np.array_equal(solver.solve(np.array(ranges)).bounds, pose.bounds, equal_nan=True)
        for end in (0, 1):
            inner = solver.solve([r[end] for r in ranges])
            assert not (pose.proved and inner.proved) or (
                (pose.position[:, 0] <= inner.position[:, 1]).all()
                and (inner.position[:, 0] <= pose.position[:, 1]).all()
            )


@pytest.mark.parametrize(
    ("anchors", "lengths", "status", "complete"),
    [
        # Two balls apart; four, of which three have a common point.
        (((0, 0, 0), (4, 0, 0)), [1.0, 2.0], PoseStatus.NO_POSE, True),
        (SQUARE, [2.9, 2.9, 2.9, 2.0], PoseStatus.NO_POSE, True),
        # Touching balls: no tensions hold the load at their one common point; there they do.
        (((0, 0, 0), (4, 0, 0)), [2.0, 2.0], PoseStatus.NO_POSE, True),
        (((0, 0, 0), (0, 0, -4)), [2.0, 2.0], PoseStatus.PROVED, False),
        # Four equal cables; a third cable that is only just reached; a cable whose tension just vanishes.
        (SQUARE, [3.0] * 4, PoseStatus.PROVED, False),
        (((0, 0, 0), (3, 0, 0), (0, 1, 3)), [2.5, 2.5, math.sqrt(28.25)], PoseStatus.PROVED, True),
        (((0, 0, 0), (3, 0, 0)), [4.0, 5.0], PoseStatus.PROVED, True),
    ],
)
def test_cases_at_the_border(anchors, lengths, status, complete) -> None:
    model = robot(anchors)
    pose = PointMass(model).solve(lengths)
    assert (pose.status, pose.complete) == (status, complete)
    open_state = CableState.SWITCHING if complete else CableState.UNDECIDED
    assert status is not PoseStatus.PROVED or open_state in pose.states
    same(pose, forward_kinematics(model, lengths))


@pytest.mark.parametrize("kind", KINDS[1:])
def test_an_elastic_cable_just_taut(kind: str) -> None:
    model = robot(((0, 0, 0), (3, 0, 0)), kind)
    alone = PointMass(robot(((0, 0, 0),), kind)).solve([4.0])
    lengths = [4.0, math.hypot(3.0, alone.position[2].mean())]
    pose = PointMass(model).solve(lengths)
    assert pose.proved and pose.complete and pose.not_slack == (0, 1) and pose.note
    assert pose.states == (CableState.TAUT, CableState.SWITCHING)
    same(pose, forward_kinematics(model, lengths))


def test_every_spelling_of_a_length() -> None:
    model = load_robot("merlet_4_1")
    solver = PointMass(model)
    spellings = (
        "3.1,3.2,3.3,3.4",
        ["3.1", Decimal("3.2"), Fraction(33, 10), 3.4],
        {"c4": "3.4", "c1": "3.1", "c2": "3.2", "c3": "3.3"},
        np.array([3.1, 3.2, 3.3, 3.4]),
        np.array([3.1, 3.2, 3.3, 3.4], dtype=np.float32),
        [np.float64(3.1), (3.2, 3.2), [3.3, 3.3], 3.4],
        [3, 4, 3, 4],
    )
    for lengths in spellings:
        same(solver.solve(lengths), forward_kinematics(model, lengths))
    for force in ((0, 0, -1), ["1.5", "0", "0"], np.array([1.0, 2.0, 3.0]), [1e7, 0.0, 0.0]):
        same(solver.solve(spellings[0], force), forward_kinematics(model, spellings[0], external_force=force))
    assert solver.robot is model


@pytest.mark.parametrize(
    ("lengths", "force", "message"),
    [
        ([3.0, 3.0, 3.0], None, "lengths: 3 lengths for 4 cables (c1, c2, c3, c4)"),
        ([3.0, math.nan, 3.0, 3.0], None, "lengths[1]: nan is not a finite number"),
        ([3.0, math.inf, 3.0, 3.0], None, "lengths[1]: inf is not a finite number"),
        ([3.0, 3.0, 0.0, 3.0], None, "lengths[2]: must be positive, got 0"),
        (np.array([3.0, 3.0, 3.0, -1.0]), None, "lengths[3]: must be positive, got -1"),
        ([3.0, 3.0, 3.0, 1e100], None, "lengths[3]: 1e+100 is out of range"),
        ([3.0, 3.0, 3.0, (3.0, 2.0)], None, "lengths[3]: the lower bound 3 is above the upper bound 2"),
        ([3.0, 3.0, 3.0, (3.0, 2.0, 1.0)], None, "lengths[3]: must be a number or a pair (lo, hi), got "),
        ([3.0, 3.0, 3.0, "abc"], None, "lengths[3]: 'abc' is not a number"),
        ([3.0, 3.0, 3.0, True], None, "lengths[3]: True is not a number"),
        (3.0, None, "lengths: must be a list with one length per cable, got 3.0"),
        ([3.0] * 4, (1.0, 2.0), "external_force: must hold 3 numbers, got 2"),
        ([3.0] * 4, (1.0, math.nan, 2.0), "external_force[1]: nan is not a finite number"),
        ([3.0] * 4, 7, "external_force: must hold 3 numbers, got 7"),
        ([3.0] * 4, ["0", "0", "784.8"], "the weight and the external force cancel"),
    ],
)
def test_bad_input_is_named(lengths, force, message) -> None:
    model = load_robot("merlet_4_1")
    with pytest.raises(InputError) as light:
        PointMass(model).solve(lengths, force)
    assert light.value.messages[0].startswith(message)
    with pytest.raises(InputError) as full:
        forward_kinematics(model, lengths, external_force=force)
    assert full.value.messages == light.value.messages


def test_every_error_at_once() -> None:
    with pytest.raises(InputError) as error:
        PointMass(load_robot("merlet_4_1")).solve([-1.0, 3.0, math.nan, 3.0], (0.0, math.inf, 0.0))
    assert len(error.value.messages) == 3


def test_robots_it_cannot_treat() -> None:
    with pytest.raises(InputError, match="must be a point mass"):
        PointMass(load_robot("uc2"))
    mixed = robot(SQUARE, "stiffness")
    vague = (Range(Fraction(-1), Fraction(1)), Fraction(0), Fraction(-9))
    mixed = Robot("mixed", mixed.platform, (*mixed.cables[:3], robot(SQUARE).cables[3]), gravity=vague)
    with pytest.raises(NotSupportedError, match="ranges of gravity"):
        PointMass(mixed)


@pytest.mark.parametrize("law", [None, "stiffness"])
def test_ranges_of_data_are_answered_as_fk_does(law: str | None) -> None:
    plain = robot(SQUARE) if law is None else robot(SQUARE, law)
    vague = Robot("vague", Platform(Range(Fraction(1), Fraction(2))), plain.cables)
    lengths, force = [(3.0, 3.001), 3.1, 3.2, 3.3], ["-1..1", 0, 0]
    for solver, given in ((PointMass(vague), None), (PointMass(plain), force), (PointMass(vague), force)):
        pose = solver.solve(lengths, given)
        (solution,) = forward_kinematics(solver.robot, lengths, external_force=given or (0, 0, 0)).solutions
        assert pose.proved and np.array_equal(pose.position, solution.position)
        assert np.array_equal(pose.tensions, solution.tensions)
        assert tuple(pose.states) == solution.cable_states
    with pytest.raises(InputError, match="may cancel"):
        PointMass(vague).solve(lengths, [0, 0, "0..100"])


def test_a_weightless_mass_needs_a_force() -> None:
    model = robot(SQUARE, mass=0)
    solver, lengths = PointMass(model), [3.0, 3.1, 3.2, 3.3]
    with pytest.raises(InputError, match="cancel"):
        solver.solve(lengths)
    force = (0.0, 0.0, -5.0)
    same(solver.solve(lengths, force), forward_kinematics(model, lengths, external_force=force))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", ["1e-3", "1", "1e5"])
def test_a_force_added_later_gives_the_same_arrays(kind: str, size: str) -> None:
    model = robot(SQUARE, kind)
    force = (Fraction(size) / 3, -Fraction(size), Fraction(0))
    load, weight = loaded(model, force).load, loaded(model).load
    changed, new = with_load(build_arrays(model, weight), load), build_arrays(model, load)
    assert changed.load_exact == new.load_exact
    for name in ("elastic", "constant", "exit_bounds", "given", "load", "frame"):
        assert np.array_equal(getattr(changed, name), getattr(new, name)), name


def test_arrays_are_kept_for_a_few_robots() -> None:
    models = [robot(SQUARE, mass=80 + i) for i in range(MOST_KEPT + 1)]
    under_load = [loaded(model) for model in models]
    first = [robot_arrays(one) for one in under_load]
    assert all(a is robot_arrays(one) for a, one in zip(first[1:], under_load[1:], strict=True))
    assert robot_arrays(loaded(models[0])) is not first[0]
    again = robot_arrays(loaded(models[5], (Fraction(1), Fraction(0), Fraction(0))))
    assert again.load_exact[0] == 1 and again.exit_bounds is first[5].exit_bounds


@pytest.mark.parametrize(("name", "short"), [("merlet_4_1", "no-pose"), ("merlet_4_1_k100", "proved")])
def test_after_warming_up_no_call_waits_for_kernels(name: str, short: str) -> None:
    code = f"""
import sys
from numba.core.dispatcher import (Dispatcher)
from cdpr_interval import (load_robot)
from solvers import (PointMass)

def loaded():
    modules = [m for n, m in list(sys.modules.items()) if n.startswith(("solvers", "cdpr_interval"))]
    kernels = {{k for m in modules for k in vars(m).values() if isinstance(k, Dispatcher)}}
    return {{(k.__module__, k.__name__, s) for k in kernels for s in k.overloads}}

solver = PointMass(load_robot({name!r}))
solver.warm_up()
before = loaded()
statuses = [solver.solve(x).status.value for x in ([3.1, 3.2, 3.3, 3.4], [3.0] * 4, [0.5] * 4)]
print(*statuses, *sorted(map(str, loaded() - before)), sep="\\n")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert done.stderr == ""
    assert done.stdout.split("\n") == ["proved", "proved", short, ""]


def test_a_weightless_mass_can_be_warmed_up() -> None:
    solver = PointMass(robot(SQUARE, mass=0))
    solver.warm_up()
    assert solver.solve([3.0, 3.1, 3.2, 3.3], (0.0, 0.0, -5.0)).proved
    PointMass(robot(SQUARE[:1])).warm_up()


def test_one_instance_serves_threads() -> None:
    model, lengths, _ = planted(random.Random(4), 8, "inextensible")
    solver = PointMass(model)
    forces = [(10.0 * i, 0.0, -1.0) for i in range(4)]
    expected = [solver.solve(lengths, force).bounds for force in forces]
    wrong = []

    def ask(i: int) -> None:
        for _ in range(200):
            if not np.array_equal(solver.solve(lengths, forces[i]).bounds, expected[i]):
                wrong.append(i)

    threads = [threading.Thread(target=ask, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
