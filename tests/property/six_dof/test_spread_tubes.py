"""Platforms whose points, mass and force have ranges: forms, tubes and answers against exact choices."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.exact.range import Range
from cdpr_interval.kernels import second_order
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import width
from cdpr_interval.mechanics.six_dof import form_system, geometry, tube
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model, longer_and_shorter
from cdpr_interval.mechanics.six_dof.rows import FORMS, LOAD, WRENCH
from cdpr_interval.robots.cable_robot import Cable, Robot
from cdpr_interval.robots.numbers import Point
from solvers import forward_kinematics
from solvers.answers.data import Outcome, Solution
from solvers.answers.result import Result
from solvers.six_dof.cells import pose_cells
from solvers.six_dof.cells.columns import POSE_COLUMNS
from solvers.six_dof.cells.kinds import SPREAD_POSE_CELLS
from solvers.six_dof.cells.own_tubes import own_tube
from solvers.six_dof.cells.roots import GENERAL
from solvers.six_dof.cells.tube import Tube
from solvers.six_dof.cells.tube_prover import TubeProver
from tests.support.exact_rows import Point as Place
from tests.support.exact_rows import error_column, polynomial
from tests.support.exact_system import Dual, equations, total
from tests.support.kernel_callers import Callers
from tests.support.planted.platform import plant as plant_robot
from tests.support.planted.verdict import Verdict, judge
from tests.support.planted_platform import (
    HALF_TURN_SIGNS,
    Planted,
    apply,
    cross,
    dot,
    minus,
    plant,
    root_range,
)
from tests.support.platform_cells import pose_cell

forms = Callers(form_system)
rows = Callers(geometry)
cells = Callers(pose_cells)
kernels = Callers(second_order)
SYMBOLS = tube.ALL_SYMBOLS
Vectors = list[list[Fraction]]


@dataclass(frozen=True)
class Spread:
    """A planted robot seen with ranges of its points and load, in which its own data lie somewhere."""

    robot: Planted
    middle: Planted
    """With the middle points, and the squares of length that these have at the planted pose."""
    hybrid: Model
    own: Model
    eps: list[Fraction]
    """The symbols of points and load that the robot's data are."""

    def symbols(self, model: Model) -> Place:
        """Return the values of all symbols; those of lengths are for a model's lengths."""
        squares = (self.robot if model.own_points else self.middle).lengths_sq
        delta = [
            (squares[i] - Fraction(model.lengths_sq[i])) / Fraction(model.lengths_sq_err[i])
            for i in range(self.robot.n)
        ]
        assert all(abs(x) <= 1 for x in (*delta, *self.eps))
        return Place([*delta, *[Fraction(0)] * (6 - len(delta))], [Fraction(0)] * 12 + self.eps)


def spread(robot: Planted, rng: random.Random, size: Fraction) -> Spread:
    """Return a robot of exact data with ranges of up to +- ``size``, and its data anywhere in these."""
    n, signs = robot.n, HALF_TURN_SIGNS[robot.chart]
    share = lambda: rng.choice([Fraction(-1), Fraction(1), Fraction(rng.randint(-99, 99), 100)])  # noqa: E731
    side = lambda: size * Fraction(rng.randint(0, 8), 8)  # noqa: E731
    exits, arms = [[(side(), share()) for _ in range(3)] for _ in range(n)], []
    centre, load = [(side(), share()) for _ in range(3)], [(side(), share()) for _ in range(3)]
    arms = [[(side(), share()) for _ in range(3)] for _ in range(n)]
    # In a chart an arm's entries have its signs; the symbols are those of the chart.
    moved = [
        [s * (own * e + shared * c) for s, (own, e), (shared, c) in zip(signs, arm, centre, strict=True)]
        for arm in arms
    ]
    anchors = [
        [a - s * e for a, (s, e) in zip(v, x, strict=True)] for v, x in zip(robot.anchors, exits, strict=True)
    ]
    points = [[b - d for b, d in zip(v, x, strict=True)] for v, x in zip(robot.points, moved, strict=True)]
    middle_load = [f - s * e for f, (s, e) in zip(robot.load, load, strict=True)]

    def around(v: Sequence[Fraction], by: Sequence[Fraction]) -> tuple[Range, Range, Range]:
        x, y, z = (Range(a - b, a + b) for a, b in zip(v, by, strict=True))
        return x, y, z

    shared = [s for s, _ in centre]
    own = build_model(
        [around(v, [s for s, _ in x]) for v, x in zip(anchors, exits, strict=True)],
        [
            around(v, [s + c for (s, _), c in zip(x, shared, strict=True)])
            for v, x in zip(points, arms, strict=True)
        ],
        [
            Range(r.lo - size * rng.randint(0, 4) / 4, r.hi + size / 4)
            for r in map(root_range, robot.lengths_sq)
        ],
        around(middle_load, [s for s, _ in load]),
        n,
        spread=True,
        centre=np.array([float(s) * (1.0 + 1e-15) for s in shared]),
    )._replace(own_points=True)
    bounds, squares, errors = longer_and_shorter(own.lengths, own.gaps)
    hybrid = own._replace(own_points=False, lengths=bounds, lengths_sq=squares, lengths_sq_err=errors)
    turned = [apply(robot.rotation(robot.u), b) for b in points]
    spokes = [minus(minus(a, robot.p), r) for a, r in zip(anchors, turned, strict=True)]
    middle = replace(robot, anchors=anchors, points=points, lengths_sq=[dot(e, e) for e in spokes])
    eps = [e for x in exits for _, e in x] + [Fraction(0)] * (18 - 3 * n)
    eps += [e for x in arms for _, e in x] + [Fraction(0)] * (18 - 3 * n)
    eps += [c for _, c in centre] + [e for _, e in load]
    return Spread(robot, middle, hybrid, own, eps)


def spreads(n: int, seed: int, sizes: Sequence[Fraction]) -> list[Spread]:
    rng = random.Random(seed)
    return [spread(plant(rng, n), rng, size) for size in sizes for _ in range(2)]


SIZES = (Fraction(1, 10**6), Fraction(1, 3000))
every_count = pytest.mark.parametrize("n", (3, 4, 5, 6))


@every_count
@pytest.mark.parametrize("own", [True, False], ids=["own", "middle"])
def test_forms_enclose_the_system_of_every_choice(n: int, own: bool) -> None:
    """Statics and all derivatives are the choice's own; lengths are so, or those of the middle points."""
    e = error_column(SYMBOLS)
    rng = random.Random(3)
    for case in spreads(n, 30 + n, SIZES):
        robot, model = case.robot, case.own if own else case.hybrid
        F = np.full((form_system.TABLE.height, width(SYMBOLS), LANES), np.nan)
        # A choice's derivatives are asked for where its own lengths hold.
        z = [*robot.u, *robot.p, *robot.t]
        for k in range(6 + n):
            row = F[form_system.Z + k]
            row[:] = 0.0
            row[1 : 1 + n, 0] = [1e-4 * rng.uniform(-1.0, 1.0) for _ in range(n)]
            row[-1 - len(case.eps) : -1, 0] = [1e-4 * rng.uniform(-1.0, 1.0) for _ in case.eps]
        at = case.symbols(model)
        for k, x in enumerate(z):
            row = F[form_system.Z + k]
            row[0] = float(x - polynomial(row[:, 0], at))
            row[e] = 1e-12
            kernels.close(F, form_system.Z + k, SYMBOLS)
            assert abs(polynomial(row[:, 0], at) - x) <= Fraction(1, 10**12)
        forms.form_system(F, model, robot.chart, True, SYMBOLS)

        def encloses(row: int, exact: Fraction, F: Any = F, at: Place = at) -> bool:
            return abs(exact - polynomial(F[row, :, 0], at)) <= Fraction(F[row, e, 0])

        for k in range(6 + n):
            point = [Dual(x, int(j == k)) for j, x in enumerate(z)]
            scale = total([Dual(1), *(x * x for x in point[:3])])
            of_choice, of_middle = (equations(r, robot.chart, point) for r in (robot, case.middle))
            for i in range(n + 6):
                both = [of_choice[i]] if own or i >= n else [of_middle[i], of_choice[i]]
                exact = [scale * equation for equation in both]
                assert encloses(form_system.EQUATIONS + i, exact[0].value)
                for one in exact:
                    assert encloses(form_system.JACOBIAN + form_system.MOST_UNKNOWNS * i + k, one.slope)


def far_apart(robot: Planted, rng: random.Random, size: Fraction) -> tuple[Planted, Model]:
    """Return a robot with long cables, and a model with its exit points off, along the cables.

    Where q is much longer than the arm, |q|^2 changes more than all else. Statics do not hold.
    """
    turned = [apply(robot.rotation(robot.u), b) for b in robot.points]
    spokes = [
        [8 * x for x in minus(minus(a, robot.p), r)] for a, r in zip(robot.anchors, turned, strict=True)
    ]
    signs = [rng.choice((-1, 1)) for _ in spokes]
    anchors = [
        [p + r + (1 if e > 0 else -1) * s * size + e for p, r, e in zip(robot.p, turn, spoke, strict=True)]
        for turn, spoke, s in zip(turned, spokes, signs, strict=True)
    ]
    own = [minus(minus(a, robot.p), r) for a, r in zip(anchors, turned, strict=True)]
    robot = replace(robot, anchors=anchors, lengths_sq=[dot(e, e) for e in own])
    exits = [
        [a - (1 if e > 0 else -1) * s * size for a, e in zip(anchor, spoke, strict=True)]
        for anchor, spoke, s in zip(anchors, spokes, signs, strict=True)
    ]
    exact = lambda v: tuple(map(Range.exact, v))  # noqa: E731
    model = build_model(
        [tuple(Range(x - size, x + size) for x in v) for v in exits],
        [exact(b) for b in robot.points],
        [root_range(x) for x in robot.lengths_sq],
        exact(robot.load),
        robot.n,
        spread=True,
    )._replace(own_points=True)
    return robot, model


@every_count
def test_forms_without_symbols_of_points_enclose_the_system_of_every_choice(n: int) -> None:
    """Equations and derivatives at any place near, where a choice's own lengths need not hold either."""
    symbols, rng = tube.SYMBOLS, random.Random(4)
    e = error_column(symbols)
    cases = [(case.robot, case.own) for case in spreads(n, 40 + n, SIZES)]
    cases += [far_apart(plant(rng, n), rng, size) for size in SIZES]
    for robot, model in cases:
        F = np.full((form_system.TABLE.height, width(symbols), LANES), np.nan)
        z = [x + Fraction(rng.randint(-9, 9), 10**9) for x in (*robot.u, *robot.p, *robot.t)]
        for k in range(6 + n):
            row = F[form_system.Z + k]
            row[:] = 0.0
            row[0], row[e] = float(z[k]), 1e-12
            kernels.close(F, form_system.Z + k, symbols)
        forms.form_system(F, model, robot.chart, True, symbols)
        for k in range(6 + n):
            point = [Dual(x, int(j == k)) for j, x in enumerate(z)]
            scale = total([Dual(1), *(x * x for x in point[:3])])
            for i, equation in enumerate(equations(robot, robot.chart, point)):
                exact = scale * equation
                for row_of, value in (
                    (form_system.EQUATIONS + i, exact.value),
                    (form_system.JACOBIAN + form_system.MOST_UNKNOWNS * i + k, exact.slope),
                ):
                    # Symbols of lengths are what they are within their ranges.
                    found = F[row_of, :, 0]
                    off = Fraction(found[e]) + sum(map(Fraction, np.abs(found[1:e])))
                    assert abs(value - Fraction(found[0])) <= off, (i, k)


def value_at(found: Tube, k: int, at: Place) -> Fraction:
    """Return an unknown's exact value on a tube's polynomial."""
    row = np.zeros(width(SYMBOLS))
    row[: found.polynomial.shape[1]] = found.polynomial[k]
    row[-1 - found.sways.shape[1] : -1] = found.sways[k]
    return polynomial(row, at)


@every_count
def test_tubes_hold_the_exact_zero(n: int) -> None:
    proved = {"own": 0, "middle": 0}
    for case in spreads(n, 60 + n, SIZES):
        robot = case.robot
        z = np.array([float(x) for x in (*robot.u, *robot.p, *robot.t)])
        found = {"own": own_tube(case.own, GENERAL, robot.chart, z)}
        near = TubeProver(case.hybrid, GENERAL).root_near(robot.chart, z[:3], z[3:6])
        found["middle"] = near if isinstance(near, Tube) else None
        for name, one in found.items():
            if one is None:
                continue
            proved[name] += 1
            at = case.symbols(case.own if name == "own" else case.hybrid)
            for k, x in enumerate((*robot.u, *robot.p, *robot.t)):
                assert abs(x - value_at(one, k, at)) <= Fraction(one.radii[k])
                assert one.box[k, 0] <= x <= one.box[k, 1]
                assert one.radii[k] < one.reach[k]
    assert min(proved.values()) >= 2


def in_cell(value: Fraction, lo: float, hi: float) -> Fraction:
    """Return the symbol of a value in bounds, as forms have it."""
    middle = 0.5 * (lo + hi) if lo < hi else lo
    radius = max(np.nextafter(hi - middle, np.inf), np.nextafter(middle - lo, np.inf)) if lo < hi else 0.0
    return (value - Fraction(middle)) / Fraction(radius) if radius else Fraction(0)


@every_count
def test_wrenches_over_cells_vary_with_the_points(n: int) -> None:
    """Rows of a cell in (u, x) against the exact wrenches of a choice at a pose in it."""
    S, rng = SPREAD_POSE_CELLS.symbols, random.Random(9)
    e = error_column(S)
    for case in spreads(n, 90 + n, SIZES):
        robot, model, seen = case.robot, case.hybrid, replace(case.middle, model=case.hybrid)
        reach = 1e-3
        cell = pose_cell(rng, seen, reach)
        F = np.full((FORMS.height, width(S), LANES), np.nan)
        C = np.repeat(cell[None, :, None], LANES, axis=2)
        rows.rotation_rows(F, C, POSE_COLUMNS.chart, S)
        rows.triple_rows(F, model, S)
        cells.position_variables(F, C, S)
        rows.wrench_rows(F, model, S)
        place = [*seen.u, *seen.way()]
        eps = [in_cell(x, cell[2 * k], cell[2 * k + 1]) for k, x in enumerate(place)]
        # Cells have arms before the chart's half turn, tubes after it.
        signs = [1] * 18 + [HALF_TURN_SIGNS[robot.chart][k % 3] for k in range(21)] + [1] * 3
        points = [x * s for x, s in zip(case.eps, signs, strict=True)]
        at = Place(eps, [*case.symbols(model).eps, *points])
        size, scale = Fraction(model.size), 1 + dot(robot.u, robot.u)
        arms = [apply(robot.rotation(robot.u), b) for b in robot.points]
        pivot = arms[int(model.orders[0, 0])]
        exact = []
        for i in model.orders[0, :n].tolist():
            spoke = minus(minus(robot.anchors[i], robot.p), arms[i])
            exact.append([*spoke, *(x / size for x in cross(minus(arms[i], pivot), spoke))])
        exact.append([*robot.load, *(-x / size for x in cross(pivot, robot.load))])
        first = [WRENCH + 6 * j for j in range(n)] + [LOAD]
        for row, wrench in zip(first, exact, strict=True):
            for k, x in enumerate(wrench):
                form = F[row + k, :, 0]
                assert abs(scale * x - polynomial(form, at)) <= Fraction(form[e])
                assert form[e] <= 100.0 * (reach + float(SIZES[1])) ** 2 * (1.0 + np.abs(form[0]))


# Answers.


def around(point: Point, by: Fraction) -> Point:
    x, y, z = (Range(Fraction(c) - by, Fraction(c) + by) for c in point)  # type: ignore[arg-type]
    return x, y, z


def with_ranges(robot: Robot, by: str, mass: str = "0", centre: str = "0") -> Robot:
    """Return a robot with every coordinate of its points +- by (m) and its mass +- a share."""
    side, share = Fraction(by), Fraction(mass)
    cables = [
        cable.replace(
            frame_anchor=around(cable.frame_anchor, side), platform_anchor=around(cable.platform_anchor, side)
        )
        for cable in robot.cables
    ]
    kg = robot.platform.mass
    assert isinstance(kg, Fraction)
    platform = robot.platform.replace(
        mass=Range(kg * (1 - share), kg * (1 + share)),
        centre_of_mass=around(robot.platform.centre_of_mass, Fraction(centre)),
    )
    return robot.replace(cables=tuple(cables), platform=platform)


def chosen(robot: Robot, pick: Callable[[Range], Fraction]) -> Robot:
    """Return the robot with a number for each of its ranges."""

    def one(x: Any) -> Any:
        return pick(x) if isinstance(x, Range) else x

    def point(v: Point) -> Point:
        x, y, z = map(one, v)
        return x, y, z

    def cable(c: Cable) -> Cable:
        return c.replace(frame_anchor=point(c.frame_anchor), platform_anchor=point(c.platform_anchor))

    platform = robot.platform.replace(
        mass=one(robot.platform.mass), centre_of_mass=point(robot.platform.centre_of_mass)
    )
    return robot.replace(
        cables=tuple(map(cable, robot.cables)), platform=platform, gravity=point(robot.gravity)
    )


def is_in(pose: Solution, entry: Any, fields: Sequence[str] = ("position", "rotation")) -> bool:
    """Return whether an exact pose lies in an entry's bounds."""
    return all(
        bool(np.all(b[..., 0] - 1e-12 <= a[..., 0]) and np.all(a[..., 1] <= b[..., 1] + 1e-12))
        for a, b in ((getattr(pose, name), getattr(entry, name)) for name in fields)
    )


def check(robot: Robot, lengths: Sequence[tuple[Fraction, Fraction]], count: int, **more: Any) -> Result:
    """Assert that the poses of random choices lie in the tubes, one in each, or in regions."""
    whole = forward_kinematics(robot, lengths, **more)
    assert not whole.pending and whole.verify(robot) == []
    rng = random.Random(7)
    for k in range(count):

        def pick(x: Range, corner: bool = k % 2 == 0) -> Fraction:
            share = Fraction(rng.randint(0, 1) if corner else rng.randint(0, 64), 1 if corner else 64)
            return x.lo + share * (x.hi - x.lo)

        exact = forward_kinematics(chosen(robot, pick), [pick(Range(*pair)) for pair in lengths], **more)
        assert exact.outcome is Outcome.COMPLETE
        held = [0] * len(whole.solutions)
        for pose in exact.solutions:
            tubes = [j for j, tube in enumerate(whole.solutions) if is_in(pose, tube)]
            assert tubes or any(is_in(pose, region) for region in whole.undecided)
            for j in tubes:
                held[j] += 1
            alike = [whole.solutions[j] for j in tubes if whole.solutions[j].taut == pose.taut]
            fields = ("position", "rotation", "height", "tensions", "distances")
            if alike and not whole.undecided:
                (tube,) = alike
                assert is_in(pose, tube, fields)
                assert tube.stability in (pose.stability, "undecided")
        for tube, poses in zip(whole.solutions, held, strict=True):
            assert poses >= 1 or not tube.is_proved
            assert poses == 1 or whole.undecided or not tube.is_proved
    return whole


def plus_minus(lengths: Sequence[str], by: str) -> list[tuple[Fraction, Fraction]]:
    return [(Fraction(x) - Fraction(by), Fraction(x) + Fraction(by)) for x in lengths]


UC3 = ("7.5", "8", "7")


@pytest.mark.slow
def test_every_choice_of_all_data_has_its_poses_in_tubes_and_regions() -> None:
    robot = with_ranges(load_robot("uc3"), "0.001", "0.01")
    whole = check(robot, plus_minus(UC3, "0.001"), 12, taut=range(3))
    assert sum(entry.is_proved for entry in whole.solutions) >= 12


def test_small_ranges_of_all_data_leave_tubes_for_every_choice() -> None:
    robot = with_ranges(load_robot("uc4"), "0.00002", "0.01", "0.00005")
    whole = check(robot, plus_minus((*UC3, "9"), "0.0001"), 4, taut=range(4))
    assert whole.outcome is Outcome.COMPLETE and len(whole.solutions) == 3


def test_all_subsets_of_a_robot_with_ranges() -> None:
    """Two cables have a plane for every choice, one its family."""
    robot = with_ranges(load_robot("uc2"), "0.00005", "0.01", "0.00005")
    whole = check(robot, plus_minus(("7.5", "8"), "0.00005"), 6)
    assert whole.outcome is Outcome.COMPLETE and len(whole.solutions) == 8


def test_poses_do_not_depend_on_the_mass() -> None:
    """Of inextensible cables; tensions are in proportion to it."""
    robot, lengths = load_robot("uc3"), [Fraction(x) for x in UC3]
    exact = forward_kinematics(robot, lengths, taut=range(3))
    mass = forward_kinematics(with_ranges(robot, "0", "0.01"), lengths, taut=range(3))
    assert mass.outcome is Outcome.COMPLETE and len(mass.solutions) == len(exact.solutions) == 14
    for one, other in zip(exact.solutions, mass.solutions, strict=True):
        assert np.abs(one.position - other.position).max() < 1e-9
        assert np.allclose(other.tensions[:, 0], 0.99 * one.tensions[:, 0], rtol=1e-8)
        assert np.allclose(other.tensions[:, 1], 1.01 * one.tensions[:, 1], rtol=1e-8)


def test_a_force_with_a_range_moves_the_poses() -> None:
    lengths = [Fraction(x) for x in UC3]
    force = ((Fraction(-1, 500), Fraction(1, 500)), 0, (Fraction(-1, 1000), 0))
    whole = forward_kinematics("uc3", lengths, taut=range(3), external_force=force)
    assert not whole.pending and sum(entry.is_proved for entry in whole.solutions) >= 12
    rng = random.Random(5)
    for _ in range(4):
        choice = (Fraction(rng.randint(-2, 2), 1000), 0, Fraction(-rng.randint(0, 2), 2000))
        exact = forward_kinematics("uc3", lengths, taut=range(3), external_force=choice)
        for pose in exact.solutions:
            held = [
                tube for tube in whole.solutions if is_in(pose, tube, ("position", "rotation", "tensions"))
            ]
            assert len(held) == 1 or any(is_in(pose, region) for region in whole.undecided)


@pytest.mark.parametrize(("name", "given"), [("uc3", UC3), ("uc2", ("7.5", "8"))])
def test_tubes_are_about_as_wide_as_the_data_move_them(name: str, given: tuple[str, ...]) -> None:
    """The stable pose, by the sum of what each datum moves it."""
    by, robot = Fraction("0.0005"), load_robot(name)
    lengths = [Fraction(x) for x in given]

    def stable(robot: Robot, lengths: Sequence[Fraction]) -> Any:
        found = forward_kinematics(robot, lengths, taut=range(len(lengths))).solutions
        (pose,) = [pose for pose in found if pose.stability == "stable"]
        return pose.position.mean(axis=1)

    reach = np.zeros(3)
    for i in range(len(lengths)):
        ends = [[x + sign * by * (k == i) for k, x in enumerate(lengths)] for sign in (-1, 1)]
        reach += np.abs(np.subtract(*(stable(robot, at) for at in ends)))
        for end in ("frame_anchor", "platform_anchor"):
            for axis in range(3):
                moved = []
                for sign in (-1, 1):
                    point = list(getattr(robot.cables[i], end))
                    point[axis] += sign * by
                    cables = list(robot.cables)
                    cables[i] = cables[i].replace(**{end: tuple(point)})
                    moved.append(stable(robot.replace(cables=tuple(cables)), lengths))
                reach += np.abs(np.subtract(*moved))
    ranged = with_ranges(robot, "0.0005")
    whole = forward_kinematics(ranged, plus_minus(given, "0.0005"), taut=range(len(lengths)))
    (tube,) = [entry for entry in whole.solutions if entry.stability == "stable"]
    wide = np.ptp(tube.position, axis=1)
    assert np.all(wide >= 0.999 * reach) and np.all(wide <= 1.1 * reach)


def test_a_family_that_only_the_middle_has_stays_open_by_name() -> None:
    """Three exit points on one vertical line: the pose turns about it, but not where they are off it."""
    cables = tuple(
        Cable(f"c{k}", (0, 0, 3 + k), point)
        for k, point in enumerate([(0.5, 0, 0), (-0.4, 0.3, 0), (0, -0.6, 0.1)])
    )
    robot = load_robot("uc3").replace(cables=cables)
    whole = forward_kinematics(with_ranges(robot, "0.001"), [3, 4, 5], taut=range(3))
    (region,) = whole.undecided
    assert "family of poses for some choices" in region.reason
    exact = forward_kinematics(robot, [3, 4, 5], taut=range(3))
    assert all(is_in(pose, region) for pose in exact.solutions)


@pytest.mark.parametrize(
    "kind", ("general-3", "general-4", "shared-points-3", "two-cables", "large-platform-4")
)
@pytest.mark.parametrize("share", [Fraction(1, 10**6), Fraction(1, 10**4)])
def test_a_planted_pose_is_in_a_tube_or_region(kind: str, share: Fraction) -> None:
    """All data are anywhere in their ranges, also at an end."""
    rng = random.Random(f"{kind} {share}")
    planted = plant_robot(kind, 11)
    size = share * max(hi for _, hi in planted.lengths)

    def ranged(x: Any, most: Fraction = size) -> Range:
        side = rng.choice([Fraction(0), Fraction(1), Fraction(rng.randint(0, 99), 99)])
        return Range(x - side * most, x + (1 - side) * most)

    def moved(v: Point) -> Point:
        x, y, z = map(ranged, v)
        return x, y, z

    cables = tuple(
        c.replace(frame_anchor=moved(c.frame_anchor), platform_anchor=moved(c.platform_anchor))
        for c in planted.robot.cables
    )
    mass = planted.robot.platform.mass
    assert isinstance(mass, Fraction)
    robot = planted.robot.replace(
        cables=cables, platform=planted.robot.platform.replace(mass=ranged(mass, mass * share))
    )
    lengths = [(lo - size * rng.randint(0, 1), hi + size * rng.randint(0, 1)) for lo, hi in planted.lengths]
    result = forward_kinematics(
        robot, lengths, taut=planted.taut, external_force=planted.external_force, cell_limit=300_000
    )
    assert result.verify(robot) == []
    verdict = judge(planted, result)
    assert verdict is not Verdict.LOST
    assert verdict is not Verdict.PENDING or result.pending > 0
