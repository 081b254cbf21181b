"""Inverse roots and angles of forms, against exact numbers at random places in the cells."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx, fmpq

from certificates.arithmetic.floats import Floats
from certificates.arithmetic.forms import Form
from certificates.arithmetic.integers import Integers
from certificates.arithmetic.jets import Jet
from certificates.arithmetic.series import HIGHEST, LOWEST, angle, inverse_root
from tests.unit.certificates.test_forms import SEED, SYMBOLS, at, exactly, wide

BITS = 300
KINDS = (Floats, Integers)
Numbers = list[arb]


def form_near(kind: type[Form], generator: np.random.Generator, middle: Any, spread: Any) -> Form:
    """Return forms with these values, whose other coefficients add up to about ``spread``."""
    cells = len(middle)
    share = generator.dirichlet(np.ones(16), cells).T * spread * generator.choice((-1.0, 1.0), (16, cells))
    value, slopes = kind.numbers(middle), kind.numbers(share[:SYMBOLS])
    return kind(value, slopes, kind.numbers(share[SYMBOLS:14]), abs(kind.numbers(share[14])))


def balls(values: Any) -> Numbers:
    """Return rationals as balls."""
    return [arb(v) for v in values]


def escaped(form: Form, symbols: Any, numbers: Numbers) -> int:
    """Return how many bounded numbers are not ones that a form encloses for these symbols."""
    form = wide(form, len(numbers))
    usual = np.flatnonzero((form.size() / form.UNIT).astype(float) < 1e30)
    lo, hi = (
        at(form.at(usual), symbols[:, usual], exactly(np.full(len(usual), side))) for side in (-1.0, 1.0)
    )
    return sum(not (arb(a) <= numbers[i] <= arb(b)) for i, a, b in zip(usual, lo, hi, strict=True))


def tried(kind: type[Form], rounds: int, cells: int, one_round: Callable[..., tuple[int, int]]) -> int:
    """Return how many results were bounded; fail where one of them was wrong."""
    generator, bounded = np.random.default_rng(SEED), 0
    with ctx.workprec(BITS), np.errstate(all="ignore"):
        for _ in range(rounds):
            wrong, count = one_round(kind, generator, cells)
            assert not wrong
            bounded += count
    return bounded


def root_round(kind: type[Form], generator: np.random.Generator, cells: int) -> tuple[int, int]:
    """Compare inverse roots, of narrow and wide forms, some of them around 0."""
    middle = 10.0 ** generator.uniform(-3, 3, cells)
    form = form_near(kind, generator, middle, middle * 10.0 ** generator.uniform(-12, 0.3, cells))
    e = exactly(generator.integers(-64, 65, (SYMBOLS, cells)) / 64.0)
    x, found = at(form, e, exactly(generator.integers(-1, 2, cells) * 1.0)), inverse_root(form)
    return escaped(found, e, [v.rsqrt() for v in balls(x)]), bounded_in(found)


def angle_round(kind: type[Form], generator: np.random.Generator, cells: int) -> tuple[int, int]:
    """Compare angles of unit vectors that turn with the symbols, by up to a right angle and more."""
    psi = generator.uniform(LOWEST - 0.5, HIGHEST + 0.5, cells)
    spread = 10.0 ** generator.uniform(-9, 0.4, cells)
    e = exactly(generator.integers(-64, 65, (SYMBOLS, cells)) / 64.0)
    # Of psi + d: the sine and cosine of d by Taylor, and a rest that covers the others' terms.
    d = form_near(kind, generator, 0.0 * psi, spread)
    turned = at(d, e, exactly(generator.integers(-1, 2, cells) * 1.0))
    with np.errstate(all="ignore"):
        cube = kind.bound([(kind.bound([(d.size(), d.size())]), d.size())])
        s, c = d + kind.unknown(cube), 1 - d * d * kind.constant(0.5) + kind.unknown(cube)
    cosine, sine = (kind.near(np.array([float(f(arb(float(v)))) for v in psi])) for f in (arb.cos, arb.sin))
    tiny = kind.unknown(kind.numbers_up(np.full(cells, 1e-15)))
    cosine, sine = cosine + tiny, sine + tiny
    found = angle(c * cosine - s * sine, c * sine + s * cosine)
    return escaped(
        found, e, [arb(float(p)) + t for p, t in zip(psi, balls(turned), strict=True)]
    ), bounded_in(found)


def bounded_in(form: Form) -> int:
    """Return in how many cells something is known."""
    return int(np.sum((form.size() / form.UNIT).astype(float) < 1e30))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("one_round", [root_round, angle_round])
def test_series_enclose_the_exact_numbers(kind: type[Form], one_round: Callable[..., tuple[int, int]]):
    assert tried(kind, 3, 300, one_round) > 500


@pytest.mark.slow
@pytest.mark.parametrize("one_round", [root_round, angle_round])
def test_series_enclose_the_exact_numbers_at_length(one_round: Callable[..., tuple[int, int]]):
    assert tried(Floats, 170, 1000, one_round) > 100_000
    assert tried(Integers, 15, 1000, one_round) > 9_000


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_known_of_roots_around_zero_and_angles_of_all_directions(kind: type[Form]):
    with np.errstate(all="ignore"):
        around = kind.between(np.array([-1.0, 0.0]), np.array([2.0, 1.0]), 0)
        x, y = (kind.between(np.array([-1.0]), np.array([1.0]), k) for k in range(2))
        assert bounded_in(inverse_root(around)) == 0 and bounded_in(angle(x, y)) == 0


@pytest.mark.parametrize("kind", KINDS)
def test_remainders_are_large_enough_where_most_is_left_to_them(kind: type[Form]):
    """1 / sqrt(1 - e) with e next to 1/2: a power more would be too little."""
    form, e = kind.near(np.array([1.0]), [np.array([0.499])]), np.full((SYMBOLS, 1), fmpq(-1), dtype=object)
    found, number = inverse_root(form), at(form, e, 0)[0]
    with ctx.workprec(BITS):
        assert bounded_in(found) == 1 and not escaped(found, e, [arb(number).rsqrt()])


@pytest.mark.parametrize(("value", "slope"), [(2**130, 1 - 2**130), (1, 2**110)])
def test_integers_enclose_roots_of_numbers_that_are_far_from_their_values(value: int, slope: int):
    """The guess may be 0 in units, and a square of what is left above what stands for infinite."""
    none = np.zeros((0, 1), dtype=object)
    parts = np.array([value], dtype=object), np.array([[slope]], dtype=object)
    with np.errstate(all="ignore"):
        found = inverse_root(Integers(*(v * Integers.UNIT for v in parts), none, np.array([0], dtype=object)))
    middle = (found.value + found.slopes.sum(axis=0) + found.curves.sum(axis=0))[0]
    with ctx.workprec(BITS):
        exact = arb(value + slope).rsqrt() * Integers.UNIT
        assert arb(middle - found.rest[0]) <= exact <= arb(middle + found.rest[0])


def test_an_angle_beyond_the_table_is_unknown():
    """Between HIGHEST + pi / 6 and LOWEST - pi / 6, a turn on, the angle has two names: none is told."""
    beyond = np.linspace(HIGHEST + 0.53, LOWEST + 2 * np.pi - 0.53, 50)
    tiny = Floats.unknown(np.full(50, 1e-15))
    with np.errstate(all="ignore"):
        assert bounded_in(angle(Floats.near(np.cos(beyond)) + tiny, Floats.near(np.sin(beyond)) + tiny)) == 0


@pytest.mark.parametrize("kind", KINDS)
def test_an_angle_is_unknown_where_the_opposite_direction_is_possible(kind: type[Form]):
    """The sine of (+-1, 0) from the direction 0 is 0 both times."""
    with np.errstate(all="ignore"):
        x, y = kind.between(np.array([-1.0]), np.array([1.0]), 0), kind.near(np.zeros(1))
        assert bounded_in(angle(x + kind.constant(0.25), y)) == 0
        assert bounded_in(angle(x * kind.constant(0.25) + kind.constant(1.0), y)) == 1


def test_slopes_are_those_of_differences():
    with ctx.workprec(BITS):
        x, step = arb(2), arb(2) ** -60
        slope = inverse_root(Jet(x, {0: arb(1)})).slopes[0]
        assert abs((inverse_root(x + step) - inverse_root(x)) / step - slope) < arb(2) ** -50
        a, b = (Jet(f(arb(1)), {0: d}) for f, d in ((arb.cos, -arb(1).sin()), (arb.sin, arb(1).cos())))
        assert abs(angle(a, b).slopes[0] - 1) < arb(2) ** -100 and abs(angle(a, b).value - 1) < arb(2) ** -100
