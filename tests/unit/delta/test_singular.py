"""Singular poses of Deltas: each kind from exact data, none beside them, boxes proved free or not."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import arb

from cdpr_interval import InputError, NotSupportedError
from cdpr_interval.exact import balls
from cdpr_interval.exact.angle import Angle
from cdpr_interval.exact.range import Range
from cdpr_interval.exact.surds import Root3, Surd, rational, roots_of
from cdpr_interval.mechanics.delta import delta_of, drives_at
from cdpr_interval.mechanics.delta_singular import (
    Bars,
    ball_is_zero,
    cross,
    exact_bars,
    ranks_of,
    surd_is_zero,
)
from cdpr_interval.robots.delta import DeltaRobot
from cdpr_interval.robots.formats.reader import load_delta
from solvers import delta_kinematics, delta_poses
from solvers.delta.kinematics import free_of_singular_poses

SEED = 20261201
HALF = Fraction(1, 2)
NUMBER = Surd((), {})
FRAME = [
    (Root3(Fraction(1)), Root3(Fraction(0))),
    (Root3(-HALF), Root3(Fraction(0), HALF)),
    (Root3(-HALF), Root3(Fraction(0), -HALF)),
]
"""Cosine and sine of 0, 120 and 240 degrees."""
CASES = {
    "regular": ([("0.5", "0", "0.8"), ("-0.25", "0.433", "0.8"), ("-0.25", "-0.433", "0.8")], (6, 3, 3), ()),
    "b": ([("0.2", "0.1", "0.9"), ("0.2", "0.1", "0.9"), ("-0.6", "-0.3", "0.7")], (5, 2, 3), ("b",)),
    "d": ([("0.9", "0.2", "0"), ("-0.3", "0.8", "0"), ("-0.6", "-0.3", "0")], (3, 2, 1), ("d",)),
    "a": ([("0.2", "0.1", "0.9")] * 3, (3, 1, 2), ("a",)),
    "coplanar bars": (
        [("0.5", "0.1", "0.8"), ("-0.4", "0.3", "0.7"), ("-0.21", "0.3", "0.87")],
        (5, 2, 3),
        ("coplanar bars",),
    ),
}  # fmt: skip
"""Directions of the bars; ranks of the six rows, of the bars and of the normals."""


def bars_along(directions) -> Bars:
    """Return bars of a platform of radius 0.1."""

    def number(value: Root3) -> Surd:
        return rational(value, NUMBER)

    along = [[number(Root3(Fraction(x))) for x in u] for u in directions]
    tangents = [[number(-s), number(c), number(Root3(Fraction(0)))] for c, s in FRAME]
    tenth = Root3(Fraction(1, 10))
    joints = [[number(tenth * c), number(tenth * s), number(Root3(Fraction(0)))] for c, s in FRAME]
    return Bars(along, [cross(t, u) for t, u in zip(tangents, along, strict=True)], joints, along[0])


def rank_in_floats(bars: Bars) -> int:
    """Return the rank of the six rows themselves, of two bars a chain, by singular values."""
    u, p = (np.array([[float(x.ball()) for x in row] for row in rows]) for rows in (bars.along, bars.joints))
    rows = []
    for k, (c, s) in enumerate(FRAME):
        t = np.array([-float(s.ball()), float(c.ball()), 0.0])
        rows += [[*u[k], *np.cross(p[k] + side * 0.05 * t, u[k])] for side in (1, -1)]
    return int(np.linalg.matrix_rank(np.array(rows), tol=1e-9))


@pytest.mark.parametrize("name", CASES)
def test_ranks_of_published_and_constructed_directions(name: str):
    """Cases b, d and the coplanar one as computed elsewhere; all of them beside the six rows in floats."""
    directions, ranks, kinds = CASES[name]
    bars = bars_along(directions)
    with balls.precision():
        found = ranks_of(bars, surd_is_zero)
        assert (found.six, found.bars, found.normals) == ranks and found.kinds == kinds
        assert rank_in_floats(bars) == ranks[0]


def test_coplanar_normals_and_parallel_planes():
    """Planes parallel to one line, and two parallel planes: both level, as they hold two tangents."""
    with balls.precision():
        level = bars_along([("1", "0.3", "0"), ("-0.2", "1", "0"), ("-0.5", "0.1", "0.8")])
        found = ranks_of(level, surd_is_zero)
        assert (found.six, found.bars, found.normals, found.kinds) == (5, 3, 2, ("c",))
        assert rank_in_floats(level) == 5
        # n_k = t_k x u_k has no part along a line w where u_k is a mix of t_k and w.
        w = (Fraction(1, 5), Fraction(3, 10), Fraction(1))
        number = [rational(Root3(x), NUMBER) for x in w]
        mixed = [
            [
                x + rational(Root3(Fraction(k + 1, 4)) * t, NUMBER)
                for x, t in zip(number, (-s, c, Root3(Fraction(0))), strict=True)
            ]
            for k, (c, s) in enumerate(FRAME)
        ]
        plain = bars_along(CASES["a"][0])
        tangents = [
            [rational(-s, NUMBER), rational(c, NUMBER), rational(Root3(Fraction(0)), NUMBER)]
            for c, s in FRAME
        ]
        bars = Bars(mixed, [cross(t, u) for t, u in zip(tangents, mixed, strict=True)], plain.joints, [])
        found = ranks_of(bars, surd_is_zero)
        assert (found.six, found.bars, found.normals, found.kinds) == (5, 3, 2, ("coplanar normals",))
        assert rank_in_floats(bars) == 5


def delta(base: str, platform: str, bar: str, arm: str) -> DeltaRobot:
    return DeltaRobot("exact", base, platform, bar, arm)


@pytest.mark.parametrize(
    ("robot", "height", "kinds", "rank", "drives"),
    [
        (delta("2.5", "0.5", "5", "5"), "-4", ("d",), 3, (False,) * 3),
        (delta("3.5", "0.5", "2", "5"), "-2", ("a",), 3, (False,) * 3),
        (delta("5.5", "0.5", "7", "6"), "-12", (), 6, (True,) * 3),
    ],
)
def test_singular_poses_are_recognised_and_their_neighbours_not(robot, height, kinds, rank, drives):
    """All bars level; all knees in one point; arms and bars stretched: poses that are exact in decimals."""
    found = delta_kinematics(robot, (0, 0, height)).singularity
    assert (found.singular, found.kinds, found.rank, found.drives_singular) == (True, kinds, rank, drives)
    for nudge in (Fraction(1, 10**12), Fraction(1, 1000)):
        near = Fraction(height) + nudge
        moved = delta_kinematics(robot, (0, 0, near)).singularity
        assert moved.singular is False and moved.rank == 6
    # With a range nothing is called singular, and nothing regular.
    wide = robot.replace(bar=(robot.bar - Fraction(1, 10**6), robot.bar + Fraction(1, 10**6)))
    if True in drives:
        with pytest.raises(NotSupportedError, match="may be at the end of a chain's reach"):
            delta_kinematics(wide, (0, 0, height))
    else:
        assert delta_kinematics(wide, (0, 0, height)).singularity.singular is None


def test_exact_and_enclosed_knees_agree():
    generator, seen = np.random.default_rng(SEED), 0
    with balls.precision():
        for name in ("delta_580", "clavel_r063_b200"):
            robot = load_delta(name)
            whole = delta_of(robot)
            for _ in range(40):
                place = [Fraction(f"{x:.3f}") for x in generator.uniform(-1, 1, 3) * float(robot.bar)]
                bars = exact_bars(robot, tuple(place))
                if bars is None:
                    continue
                seen += 1
                centre = [balls.from_fraction(x) for x in place]
                for i in range(3):
                    knee = whole.knee(i, drives_at(whole, i, centre).useful)
                    for u, p, c in zip(bars.along[i], centre, knee, strict=True):
                        assert abs(u.ball() - (p - c)) < 1e-30
    assert seen > 20


def test_boxes_are_proved_free_and_those_with_a_singular_pose_are_not():
    robot = load_delta("delta_580")
    free = delta_kinematics(robot, (0, 0, "-0.4"), box=("0.02", "0.02", "0.02"))
    assert free.box.free is True and free.outcome == "complete"
    for exact, height in ((delta("2.5", "0.5", "5", "5"), -4), (delta("5.5", "0.5", "7", "6"), -12)):
        generator = np.random.default_rng(SEED)
        with balls.precision():
            for _ in range(5):
                half = [Fraction(f"{x:.3f}") for x in generator.uniform(0.05, 0.4, 3)]
                off = [
                    Fraction(f"{x:.3f}") * h
                    for x, h in zip(generator.uniform(-0.9, 0.9, 3), half, strict=True)
                ]
                box = [Range(c + o - h, c + o + h) for c, o, h in zip((0, 0, height), off, half, strict=True)]
                assert free_of_singular_poses(delta_of(exact), box, most=2000).free is None


def test_speeds_are_those_of_differences():
    step, generator = Fraction(1, 10**9), np.random.default_rng(SEED)
    for _ in range(20):
        place = [Fraction(f"{x:.4f}") for x in generator.uniform((-0.1, -0.1, -0.5), (0.1, 0.1, -0.35))]
        rates = [Fraction(f"{x:.3f}") for x in generator.uniform(-1, 1, 3)]
        found = delta_kinematics("delta_580", place, rates=rates)
        middles = [Fraction(float(a)) for a in found.drives.mean(axis=1)]
        ends = [
            delta_poses("delta_580", [m + sign * step * r for m, r in zip(middles, rates, strict=True)])
            .solutions[0].position.mean(axis=1)
            for sign in (1, -1)
        ]  # fmt: skip
        assert found.velocity.mean(axis=1) == pytest.approx((ends[0] - ends[1]) / (2 * float(step)), abs=1e-6)
        back = delta_kinematics(
            "delta_580", place, velocity=[Fraction(float(v)) for v in found.velocity.mean(axis=1)]
        )
        assert back.rates.mean(axis=1) == pytest.approx([float(r) for r in rates], abs=1e-9)
        inverse = found.jacobian_inverse.mean(axis=2)
        assert inverse @ found.velocity.mean(axis=1) == pytest.approx([float(r) for r in rates], abs=1e-9)
        values = np.linalg.svd(inverse, compute_uv=False)
        assert (
            (found.singular_values[:, 0] <= values + 1e-9) & (values - 1e-9 <= found.singular_values[:, 1])
        ).all()


def test_what_has_no_kinematics():
    with pytest.raises(InputError, match="out of reach"):
        delta_kinematics("delta_580", (0, 0, -4))
    with pytest.raises(InputError, match="not together with"):
        delta_kinematics("delta_580", (0, 0, "-0.4"), velocity=(0, 0, 1), rates=(0, 0, 1))
    with pytest.raises(InputError, match="half widths must be greater than 0"):
        delta_kinematics("delta_580", (0, 0, "-0.4"), box=(0, 1, 1))


def test_numbers_with_roots_that_are_zero_and_that_are_nearly():
    generator = np.random.default_rng(SEED)

    def drawn() -> Root3:
        a, b = (Fraction(int(n), int(d)) for n, d in generator.integers(1, 9, (2, 2)))
        return Root3(a * int(generator.choice((-1, 1))), b)

    for _ in range(300):
        x = drawn()
        root = (x * x).root()
        assert root in (x, -x) and root.sign >= 0
        squares = [y * y + Root3(Fraction(k)) for k, y in enumerate((drawn(), drawn(), drawn()))]
        a, b, c = roots_of(squares)
        e = a + b - c
        hidden = e * e - (a * a + b * b + c * c) - (a * b - a * c - b * c) - (a * b - a * c - b * c)
        assert hidden.is_zero is True and (e + rational(Root3(Fraction(1, 10**30)), a)).is_zero in (
            True,
            False,
        )
    two, five, ten = roots_of([Root3(Fraction(n)) for n in (2, 5, 10)])
    assert (two * five - ten).is_zero is True
    assert (two * five - ten + rational(Root3(Fraction(1, 10**60)), two)).is_zero is False


def test_an_angle_of_0_without_a_unit_is_exact():
    """The list of the handbook, ``[0, 120deg, 240deg]``, stands at multiples of 30 degrees, too."""
    zero = Angle(Range.exact(0), in_degrees=False)
    robot = DeltaRobot(
        "d", "0.15", "0.025", "0.38", arm="0.2", arm_angles=(zero, Angle.degrees(120), Angle.degrees(240))
    )
    assert exact_bars(robot, (Fraction(0), Fraction(0), Fraction("-0.4"))) is not None


def test_no_kind_is_told_where_it_is_not_known_which_bars_are_parallel():
    """Bars in one plane to the letter, two of which may be parallel within their balls."""
    near = [[arb(1), arb(0), arb(0, 1e-9)], [arb(1), arb(0), arb(0)], [arb(0), arb(0), arb(1)]]
    normals = [[arb(i == j) for j in range(3)] for i in range(3)]
    found = ranks_of(Bars(near, normals, normals, [arb(1)] * 3), ball_is_zero)
    assert (found.six, found.kinds) == (5, ())


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"box": ("1mm..2mm", "1mm", "1mm")}, r"box\[0\]: must be one number"),
        ({"rates": ("1m", "0", "0")}, r"rates\[0\]: '1m' is a length, not a number without a unit"),
        ({"rates": ("1rad/s", "0", "0")}, r"rates\[0\]: '1rad/s' is not a number .it has no unit here."),
        ({"velocity": 3}, "velocity: must hold three speeds, got 3"),
    ],
)
def test_one_clear_line(given, message):
    with pytest.raises(InputError, match=message):
        delta_kinematics("delta_580", ("0", "0", "-0.4"), **given)
