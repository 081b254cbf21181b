"""No leaf of a cell that holds a static pose over pulleys is confirmed, whatever it says."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_mat, ctx

from certificates.arithmetic.balls import BITS, column, unit
from certificates.arithmetic.floats import Floats
from certificates.arithmetic.forms import Form
from certificates.arithmetic.integers import Integers
from certificates.arithmetic.vectors import cross, dot
from certificates.claims import Pose, is_routed_stability
from certificates.leaves import Cells, in_some_view
from certificates.problem import FORMAT, Problem, read_problem
from certificates.routed.views import Lengths
from certificates.search import RoutedSearch
from certificates.stability import rope_to, variation_of_ropes
from certificates.tree import Node
from certificates.verdicts import NotProved
from tests.unit.certificates.test_routed import SEED

TAUT, SLACK = (0, 1, 2), (3, 4)
Numbers = list[arb]
Generator = np.random.Generator


def text(x: arb) -> str:
    """Return a number to 45 digits, exactly."""
    return str(Fraction(int((x.mid() * arb(10) ** 45).floor().unique_fmpz()), 10**45))


def wrapped(generator: Generator) -> tuple[dict[str, Any], Numbers, Numbers, arb]:
    """Return a pulley, and of an anchor on its rope: the way from A, dL/dX and L."""
    k = unit([arb(float(v)) for v in generator.normal(size=3)])
    u = unit(cross(k, [arb(float(v)) for v in generator.normal(size=3)]))
    r, wrap = arb(float(10.0 ** generator.uniform(-3, 0))), arb(float(generator.uniform(0.01, 5.45)))
    psi = arb.pi() - wrap
    n, lead_in = (psi.cos(), psi.sin()), arb(float(generator.choice((0, 0.5))))
    free = r * arb(float(10.0 ** generator.uniform(-1, 2)))
    if n[1] < 0:
        # The rope returns to the swivel axis: the anchor is before it.
        free = min(free, r * (1 + n[0]) / -n[1] * arb(0.97))
    x, y = r * (1 + n[0]) + free * n[1], r * n[1] - free * n[0]
    pulley = {"radius_m": text(r), "axis": [text(v) for v in k], "lead_in_m": text(lead_in)}
    way = [x * a + y * b for a, b in zip(u, k, strict=True)]
    return pulley, way, [n[1] * a - n[0] * b for a, b in zip(u, k, strict=True)], lead_in + r * wrap + free


def planted(generator: Generator) -> Problem:
    """Return a robot with a pose at u = 0, x = 0, whose taut cables end over or under its centre of mass."""
    ropes = [wrapped(generator) for _ in range(5)]
    tensions = [arb(float(generator.uniform(0.1, 1))) for _ in TAUT]
    load = [sum((t * ropes[i][2][k] for i, t in enumerate(tensions)), arb(0)) for k in range(3)]
    above = arb(float(generator.uniform(-0.5, 0.5)))
    point = [v * above for v in unit(load)]
    ends = [point] * 4 + [[arb(0.1), arb(-0.2), arb(0.3)]]
    lengths = [text(n + (arb(0.001) if i in SLACK else 0)) for i, (*_, n) in enumerate(ropes)]
    cables = [
        {
            "name": f"c{i}",
            "frame_anchor_m": [text(a - b) for a, b in zip(end, way, strict=True)],
            "platform_anchor_m": [text(a) for a in end],
            "pulley": pulley,
        }
        for i, (end, (pulley, way, *_)) in enumerate(zip(ends, ropes, strict=True))
    ]
    robot = {"name": "r", "sha256": "", "gravity_m_s2": ["0"] * 3, "mass_kg": "1", "cables": cables}
    question = {"taut": list(TAUT), "ignore_slack": False, "ignore_tension_sign": False}
    made = {
        "format": FORMAT,
        "tool": {"name": "", "version": ""},
        "claim": "",
        "robot": robot | {"centre_of_mass_m": ["0"] * 3},
        "lengths_m": [[n, n] for n in lengths],
        "external_force_N": [text(v) for v in load],
        "question": question,
    }
    return read_problem(made | {"solutions": [], "subsets": [], "not_certified": []})


def closed(search: RoutedSearch, bounds: Any, kept: Any, kind: type[Form]) -> Any:
    """Return for each thing that leaves may say, and for cuts, in which cells of chart 0 it is confirmed."""
    count = bounds.shape[-1]
    load = np.array([float(v) for v in search.platform.load])
    y = np.zeros((6, count))
    y[:3] = np.round(load / abs(load).max() * 2**28)[:, None]
    none, number = np.zeros((0, count)), np.arange(count)
    said = [(Node.NO_LENGTH, none, none), (Node.UNBALANCED, y, none), (Node.CUT, none, kept)]
    said += [(Node.TOO_LONG, np.full((1, count), i), none) for i in SLACK]
    return np.array(
        [
            in_some_view(search, Cells(node, 0, 0 * number, bounds, number, data, left), kind)
            for node, data, left in said
        ]
    )


def require_static(search: RoutedSearch) -> None:
    """Fail unless the planted pose has the lengths, and tensions that balance the load."""
    at = [arb(0)] * 3
    posed = Lengths(search.platform, 0, at)
    *wrenches, load = posed.wrenches(at)
    columns = arb_mat(wrenches).transpose()
    t = (arb_mat(wrenches) * columns).solve(-arb_mat(wrenches) * column(load))
    assert all(v > 0 for v in t.entries())
    assert all(abs(v) < 1e-40 for v in [*(columns * t + column(load)).entries(), *posed.equations(at)])


@pytest.mark.parametrize(("kind", "robots", "count"), [(Floats, 30, 80), (Integers, 4, 10)])
def test_no_cell_that_holds_a_pose_is_excluded(kind: type[Form], robots: int, count: int):
    generator, beside = np.random.default_rng(SEED), np.zeros(5, dtype=int)
    with ctx.workprec(BITS), np.errstate(all="ignore"):
        for _ in range(robots):
            entry = {"order": list(TAUT), "roots": [], "trees": [""] * 4}
            search = RoutedSearch(planted(generator), TAUT, entry, 0)
            require_static(search)
            lo, hi = (10.0 ** generator.uniform(-6, -0.5, (6, count)) for _ in range(2))
            holding, entries = np.stack([-lo, hi], axis=1), generator.integers(6, size=count)
            cut, cells = holding.copy(), np.arange(count)
            cut[entries, 0, cells] = 0.01 * hi[entries, cells]
            assert not closed(search, holding, cut, kind).any()
            # The same cells moved away in p: what is said of them may be true.
            away = holding.copy()
            away[3:] += generator.choice((-3.0, 3.0), (3, 1, count)) * (lo + hi)[3:, None]
            beside += closed(search, away, away, kind).sum(axis=1)
        search.problem = replace(search.problem, ignore_slack=True)
        assert not closed(search, away, away, kind)[3:].any()
    assert (beside > 0).all()


def way(problem: Problem, i: int, end: Numbers) -> tuple[arb, arb]:
    """Return L and its free part, by the arc cosine."""
    pulley = problem.pulleys[i]
    assert pulley is not None
    g = [a - arb(b) for a, b in zip(end, problem.exits[i], strict=True)]
    r, y = arb(pulley.radius), dot(g, unit(pulley.axis))
    x = (dot(g, g) - y * y).sqrt() - r
    square = x * x + y * y
    psi, free = arb.atan2(y, x) + (r / square.sqrt()).acos(), (square - r * r).sqrt()
    return arb(pulley.before) + r * (arb.pi() - psi) + free, free


def moved(problem: Problem, i: int, motion: Numbers, s: arb) -> Numbers:
    """Return where a cable of the planted pose ends, moved by s times v and turned by s times omega."""
    v, axis = motion[:3], unit(motion[3:])
    angle, arm = s * dot(motion[3:], motion[3:]).sqrt(), [arb(x) for x in problem.points[i]]
    sideways = cross(axis, arm)
    back = cross(axis, sideways)
    rows = zip(arm, sideways, back, v, strict=True)
    return [a + angle.sin() * b + (1 - angle.cos()) * c + s * d for a, b, c, d in rows]


def test_the_second_variation_is_that_of_the_lengths():
    """Beside a second difference of sum T L along finite motions."""
    generator = np.random.default_rng(SEED)
    with ctx.workprec(400):
        for _ in range(20):
            problem = planted(generator)
            arms = {i: [arb(x) for x in problem.points[i]] for i in TAUT}
            densities = {i: arb(float(generator.uniform(0.1, 1))) for i in TAUT}
            form, rows = variation_of_ropes(problem, {i: (r, r, densities[i]) for i, r in arms.items()})
            motion, step = [arb(float(v)) for v in generator.normal(size=6)], arb(2) ** -80
            second = arb(0)
            for row, (i, t) in zip(rows, densities.items(), strict=True):
                back, (here, free), ahead = (
                    way(problem, i, moved(problem, i, motion, step * k)) for k in (-1, 0, 1)
                )
                second += t * free * (ahead[0] - 2 * here + back[0]) / (step * step)
                assert abs((ahead[0] - back[0]) / (2 * step) - dot(row, motion)) < 1e-30
            found = dot(motion, (form * column(motion)).entries())
            assert abs(second - found) < 1e-20 * (1 + abs(found))


def test_a_cable_that_may_carry_nothing_holds_no_motion_back():
    """Nor does an unstable pose follow, as the cable may be slack."""
    generator, unstable = np.random.default_rng(SEED), 0
    identity = arb_mat(3, 3, [1, 0, 0, 0, 1, 0, 0, 0, 1])
    with ctx.workprec(BITS):
        for _ in range(20):
            problem = planted(generator)
            densities = {i: arb(float(generator.uniform(0.1, 1))) for i in TAUT}
            word: Any = SimpleNamespace(stability="unstable", states=("taut",) * 3 + ("slack",) * 2)
            pose = Pose(identity, arb_mat(3, 1), densities)
            unstable += is_routed_stability(problem, word, TAUT, pose)
            loose = Pose(identity, arb_mat(3, 1), {**densities, 2: arb(0, 1e-40)})
            assert not is_routed_stability(problem, word, TAUT, loose)
            arms = {i: [arb(x) for x in problem.points[i]] for i in TAUT}
            cables = {i: (r, r, loose.densities[i]) for i, r in arms.items()}
            assert len(variation_of_ropes(problem, cables)[1]) == 2
    assert unstable > 0


def test_a_rope_that_may_have_run_past_its_pulley_is_refused():
    """Straight ahead of A the wrap is 0: of balls of anchors around there it may be negative, or none."""
    with ctx.workprec(BITS):
        problem = planted(np.random.default_rng(SEED))
        pulley = problem.pulleys[0]
        assert pulley is not None
        k, r = unit(pulley.axis), arb(pulley.radius)
        u = unit(cross(k, [arb(1), arb(2), arb(3)]))
        for x, y, is_known in (
            (arb(0.5), arb(3), True),
            (arb(0.01), arb(3, 0.5), False),
            (arb(0, 1), arb(3), False),
        ):
            end = [arb(a) + r * (x * b + y * c) for a, b, c in zip(problem.exits[0], u, k, strict=True)]
            if is_known:
                assert rope_to(problem, 0, end).wrapped >= arb(pulley.before)
            else:
                with pytest.raises(NotProved, match="may run past its pulley"):
                    rope_to(problem, 0, end)
