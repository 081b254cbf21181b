"""The checker's arithmetic over a cell, against exact numbers at random places in the cell."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_mat, ctx, fmpq

from certificates import newton
from certificates.arithmetic.balls import BITS, column, hull
from certificates.arithmetic.floats import Floats, machine_rounds
from certificates.arithmetic.forms import Form
from certificates.arithmetic.integers import Integers
from certificates.arithmetic.jets import Jet
from certificates.arithmetic.vectors import cross, dot
from certificates.frames import settings
from certificates.geometry import Rotated
from certificates.problem import read_problem
from certificates.roots import System
from certificates.subsets import Kind
from certificates.verdicts import NotProved
from tests.support.made_certificates import platform

SEED = 20261130
SYMBOLS, DATA = 4, 3
KINDS = (Floats, Integers)
PAIRS = [(i, j) for j in range(SYMBOLS) for i in range(j + 1)]
exactly = np.frompyfunc(lambda x: fmpq(*x.as_integer_ratio()), 1, 1)
"""A double, or an integer, as a rational."""


def random_doubles(generator: np.random.Generator, shape: tuple[int, ...], most: int) -> Any:
    """Return doubles of all sizes up to 2^most, denormals and zeros too."""
    spans = ((-3, 3), (-60, most), (-1074, most) if most > 3 else (-60, most))
    exponents = np.stack([generator.integers(*span, shape) for span in spans])
    chosen = np.choose(generator.integers(0, 3, shape), exponents)
    found = np.ldexp(generator.uniform(-1.0, 1.0, shape), chosen)
    return np.where(generator.random(shape) < 0.1, 0.0, found)


def random_form(kind: type[Form], generator: np.random.Generator, cells: int) -> Form:
    """Return a form with coefficients of all sizes, in so many cells."""
    most = 400 if kind is Floats else 3
    n = int(generator.integers(0, SYMBOLS + 1))
    curved = generator.random() < 0.7
    data = int(generator.integers(0, DATA + 1))
    shapes = [(cells,), (n, cells), (n * (n + 1) // 2 if curved else 0, cells), (cells,), (data, cells)]
    value, slopes, curves, rest, drifts = (kind.numbers(random_doubles(generator, s, most)) for s in shapes)
    return kind(value, slopes, curves, abs(rest), drifts)


def at(form: Form, symbols: Any, rest: Any) -> Any:
    """Return the exact numbers that a form encloses for symbols (7, N) and shares of its rest."""
    found = exactly(form.value) + rest * exactly(form.rest)
    for slope, e in zip(form.slopes, symbols, strict=False):
        found = found + exactly(slope) * e
    for curve, (i, j) in zip(form.curves, PAIRS, strict=False):
        found = found + exactly(curve) * symbols[i] * symbols[j]
    for drift, e in zip(form.drifts, symbols[SYMBOLS:], strict=False):
        found = found + exactly(drift) * e
    return found / form.UNIT


def require_enclosure(form: Form, symbols: Any, numbers: Any) -> None:
    """Fail unless the numbers are ones that a form encloses for these symbols; infinite ones enclose all."""
    known = np.isfinite((form.rest / form.UNIT).astype(float)) & np.isfinite(
        sum(abs(v) for v in ((form.value / form.UNIT).astype(float), form.bulk / form.UNIT)).astype(float)
    )
    some = np.flatnonzero(np.broadcast_to(known, numbers.shape))
    form, symbols, numbers = wide(form, len(numbers)).at(some), symbols[:, some], numbers[some]
    lo, hi = (at(form, symbols, fmpq(side)) for side in (-1, 1))
    assert np.all(lo <= numbers) and np.all(numbers <= hi)
    with np.errstate(all="ignore"):
        lowest, highest, size = form.lowest(), form.highest(), form.size()
        ends = [np.isfinite((v / form.UNIT).astype(float)) for v in (lowest, highest, size)]
        for bound, is_known, holds in zip(
            (lowest, highest, size), ends, (np.less_equal, np.greater_equal, np.greater_equal), strict=True
        ):
            inner = lo if bound is lowest else hi if bound is highest else np.maximum(abs(lo), abs(hi))
            assert np.all(holds(exactly(bound[is_known]) / form.UNIT, inner[is_known]))
        assert not np.any(form.has_no_zero() & (lo <= 0) & (hi >= 0))


def wide(form: Form, cells: int) -> Form:
    """Return a form with an entry for every cell."""
    parts = (form.value, form.slopes, form.curves, form.rest, form.drifts)
    return type(form)(*(np.broadcast_to(v, (*v.shape[:-1], cells)) for v in parts))


def require_sound_arithmetic(kind: type[Form], rounds: int, cells: int) -> int:
    """Compare sums, products and weighted sums with rationals; return the number of forms that were made."""
    generator = np.random.default_rng(SEED)
    for _ in range(rounds):
        a, b = (random_form(kind, generator, cells) for _ in range(2))
        e = exactly(generator.integers(-64, 65, (SYMBOLS + DATA, cells)) / 64.0)
        x, y = (at(form, e, exactly(generator.integers(-1, 2, cells) * 1.0)) for form in (a, b))
        w = [generator.uniform(-3, 3, cells), generator.choice((0.0, 0.5, 1e-9, 1e9), cells)]
        given = [exactly(kind.numbers(v)) / kind.UNIT for v in w]
        with np.errstate(all="ignore"):
            made = [(a + b, x + y), (a - b, x - y), (-a, -x), (a * b, x * y), (a * a - b * b, x * x - y * y)]
            made += [(a * 3, x * 3), (2 - a, 2 - x), (a * b - b * a, 0 * x)]
            made.append((kind.combine(w, [a, b]), given[0] * x + given[1] * y))
            lines = [v.upto(1) for v in (a, b)]
            made.append((lines[0] * lines[1], at(lines[0], e, 0) * at(lines[1], e, 0)))
        for form, numbers in made:
            require_enclosure(form, e, numbers)
    return rounds * cells * 10


@pytest.mark.parametrize("kind", KINDS)
def test_arithmetic_encloses_the_exact_numbers(kind: type[Form]):
    assert require_sound_arithmetic(kind, 12, 60) > 6_000


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_arithmetic_encloses_the_exact_numbers_at_length(kind: type[Form]):
    rounds = 1001 if kind is Floats else 101
    assert require_sound_arithmetic(kind, rounds, 100) > (1_000_000 if kind is Floats else 100_000)


def test_the_machine_rounds_as_it_must():
    assert machine_rounds()


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_too_large_proves_nothing(kind: type[Form]):
    huge = kind.near(np.array([1e300, 1.0]))
    with np.errstate(all="ignore"):
        square = huge * huge * huge
        nothing = square - square
        if kind is Floats:
            assert not np.isfinite(square.size()[0]) and not (nothing.lowest()[0] > -1e308)
            assert (
                not nothing.has_no_zero()[0] and not nothing.within(np.full(2, -1e308), np.full(2, 1e308))[0]
            )
        assert nothing.within(np.full(2, -1e-9), np.full(2, 1e-9))[1]


@pytest.mark.parametrize("kind", KINDS)
def test_a_product_of_lines_has_no_rest_but_that_of_rounding(kind: type[Form]):
    a, b = (
        kind.near(np.ones(1), np.array([[1.0], [0.0]])),
        kind.near(np.full(1, 3.0), np.array([[0.0], [1.0]])),
    )
    product = a * b
    assert product.doubles()[0] == 3.0 and list(product.slope_doubles(2)[:, 0]) == [3.0, 1.0]
    assert list((product.curves[:, 0] / kind.UNIT).astype(float)) == [0.0, 1.0, 0.0]
    assert float(product.rest[0] / kind.UNIT) < 2e-14


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_become_forms(kind: type[Form]):
    generator = random.Random(SEED)
    for _ in range(200):
        x = generator.uniform(-9, 9) * 10.0 ** generator.randint(-25, 5)
        lo, hi = sorted((x, generator.uniform(-9, 9)))
        form = kind.between(np.array([lo]), np.array([hi]), 2)
        for inner in (lo, hi, lo + generator.random() * (hi - lo)):
            gap = Fraction(min(max(inner, lo), hi)) * kind.UNIT - Fraction(form.value[0])
            assert abs(gap) <= Fraction(form.slopes[2, 0]) + Fraction(form.rest[0])
        with ctx.workprec(BITS):
            ball = arb(x).exp() if x < 60 else arb(x)
            constant = kind.enclosing(ball)
            assert constant.lowest()[0] / arb(kind.UNIT) <= ball <= constant.highest()[0] / arb(kind.UNIT)
        assert kind.near(np.array([x])).doubles()[0] == pytest.approx(x, abs=1e-17)
    assert kind.enclosing(arb(0)).size()[0] < 1e-200
    assert list(kind.near(np.ones(1), np.array([[0.5]])).slope_doubles(3)[:, 0]) == [0.5, 0.0, 0.0]


@pytest.mark.parametrize("kind", KINDS)
def test_bounds_are_on_the_right_side(kind: type[Form]):
    generator = np.random.default_rng(SEED)
    a, b, c, d = (kind.numbers_up(v) for v in generator.uniform(0.0, 2.0, (4, 500)))
    A, B, C, D = (exactly(v) / kind.UNIT for v in (a, b, c, d))
    assert np.all(exactly(kind.bound([(a, b), (c, d)], a)) / kind.UNIT >= A * B + C * D + A)
    assert np.all(exactly(kind.quotient(a, b)) / kind.UNIT * B >= A)
    assert np.all(exactly(kind.square_quotient(a, b)) / kind.UNIT * B <= A * A)
    assert np.all((exactly(kind.root(a)) / kind.UNIT) ** 2 >= A)
    assert np.all(~kind.exceeds(a, b - d, c, d) | (A * (B - D) >= C * D))
    assert kind.exceeds(a, b, a, b).any() == (kind is Integers)


def test_jets_have_the_derivatives_of_a_rotation():
    with ctx.workprec(BITS):
        u = [arb("0.3"), arb("-0.2"), arb("0.7")]
        a, b = ([arb(v) for v in w] for w in ([1, 2, 3], [-1, 4, 2]))
        step = arb(2) ** -60

        def number(w: list[arb]) -> arb:
            return dot(cross(a, w), b) * w[0] - 3 + 2 * dot(w, w) - w[1]

        jet = number([Jet(v, {k: 1}) for k, v in enumerate(u)])
        assert jet.value.overlaps(number(u))
        for k in range(3):
            ahead = number([v + step * (i == k) for i, v in enumerate(u)])
            behind = number([v - step * (i == k) for i, v in enumerate(u)])
            assert abs((ahead - behind) / (2 * step) - jet.slopes[k]) < arb(2) ** -50


def test_newton_encloses_the_zeros_for_all_data():
    with ctx.workprec(BITS):
        data = hull(arb("1.999"), arb("2.001"))

        def circle(x: list[arb], axes: arb_mat) -> tuple[arb_mat, arb_mat]:
            """Vanish where a circle of square radius ``data`` meets the diagonal."""
            values = column([x[0] ** 2 + x[1] ** 2 - data, x[0] - x[1]])
            return values, arb_mat([[2 * x[0], 2 * x[1]], [1, -1]]) * axes

        found = newton.zero(circle, [arb(3), arb(1)])
        product, gap = found.image(
            lambda x: [Jet(x[0], {0: 1}) * Jet(x[1], {1: 1}), Jet(x[0] - x[1], {0: 1, 1: -1})]
        )
        assert product.rad() < 0.0006 and gap.rad() < 1e-50
        for square in ("1.999", "2", "2.001"):
            assert all(v.contains((arb(square) / 2).sqrt().mid()) for v in found.entries())
            assert product.contains((arb(square) / 2).mid())
        with pytest.raises((NotProved, ZeroDivisionError)):
            newton.zero(lambda x, axes: (column([x[0] ** 2 + 1]), arb_mat([[2 * x[0]]]) * axes), [arb(1)])
        with pytest.raises((NotProved, ZeroDivisionError)):
            newton.zero(lambda x, axes: (column([x[0] ** 2]), arb_mat([[2 * x[0]]]) * axes), [arb(1)])


def test_newton_follows_the_data_to_first_order():
    with ctx.workprec(BITS):

        def circle(x: list[arb], axes: arb_mat) -> tuple[arb_mat, arb_mat]:
            """Vanish where a circle of square radius 2 + d / 100 meets the diagonal."""
            values = column([x[0] ** 2 + x[1] ** 2 - 2 - x[2] / 100, x[0] - x[1]])
            return values, arb_mat([[2 * x[0], 2 * x[1], arb(-1) / 100], [1, -1, 0]]) * axes

        for data in (hull(-1, 1), hull(0, 1), hull(-1, fmpq(-1, 2)), arb(fmpq(1, 3))):
            found = newton.zero(circle, [arb(3), arb(1)], [data])
            (product,) = found.image(lambda x: [Jet(x[0], {0: 1}) * Jet(x[1], {1: 1})])
            assert product.contains((2 + data / 100) / 2) and product.rad() < data.rad() / 200 + 5e-5
            for d in (data.lower(), data.mid(), data.upper()):
                root = ((2 + d / 100) / 2).sqrt()
                assert all(v.overlaps(root) for v in found.entries()[:2])


@pytest.mark.parametrize("digits", [2, 59, 60, 70])
def test_lengths_of_a_range_are_all_looked_at(digits: int):
    """Also of one that is narrower than balls are."""
    shortest, longest = fmpq(3), 3 + fmpq(1, 10**digits)
    question = read_problem(platform(b"", b"", b"", b""))
    question = replace(question, lengths=[(shortest, longest), *question.lengths[1:]])
    (setting,) = settings(question, (0, 1, 2), Kind.GENERAL)
    with ctx.workprec(BITS):
        exact = setting.cables(question, (0, 1, 2))
        system = System(setting, exact, exact.mapped, 0)
        ends = {k: exact.swings[k] * hull(-1, 1) for k in system.ranged}
        square = exact.ranging(ends).length_square(0)
        assert square.contains(shortest**2) and square.contains(longest**2)
        assert system.ranged == [0] and exact.swings[1].is_zero()


@pytest.mark.parametrize("kind", KINDS)
def test_forms_of_a_platform_enclose_its_exact_numbers(kind: type[Form]):
    generator, count = np.random.default_rng(SEED), 30
    question = read_problem(platform(b"", b"", b"", b""))
    (setting,) = settings(question, (0, 1, 2), Kind.GENERAL)
    with ctx.workprec(BITS):
        exact = setting.cables(question, (2, 0, 1))
        over_cells = exact.mapped(kind.enclosing)
        for chart in range(4):
            middle = generator.uniform(-1, 1, (6, count)) * np.array([[1.0]] * 3 + [[5.0]] * 3)
            radius = np.array([[0.1]] * 3 + [[0.5]] * 3)
            lo, hi = middle - radius, middle + radius
            forms = [kind.between(lo[k], hi[k], k) for k in range(6)]
            over = Rotated(over_cells, chart, forms[:3])
            enclosures = [*over.lengths(forms[3:], over.lines), *itertools.chain(*over.wrenches(forms[3:]))]
            for c in range(count):
                shares = generator.integers(0, 9, 6).tolist()
                place = [
                    arb(a) + (arb(b) - arb(a)) * k / 8
                    for a, b, k in zip(lo[:, c].tolist(), hi[:, c].tolist(), shares, strict=True)
                ]
                there = Rotated(exact, chart, place[:3])
                numbers = [
                    *there.lengths(place[3:], there.lines),
                    *itertools.chain(*there.wrenches(place[3:])),
                ]
                for form, number in zip(enclosures, numbers, strict=True):
                    low, high = (v[c if len(v) > 1 else 0] for v in (form.lowest(), form.highest()))
                    assert low / arb(kind.UNIT) <= number <= high / arb(kind.UNIT)
