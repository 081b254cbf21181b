"""The checker's arithmetic over a cell, against exact numbers at random places in the cell."""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence
from fractions import Fraction

import pytest
from flint import arb, arb_mat, ctx

from certificates import newton
from certificates.arithmetic.balls import BITS, column, hull
from certificates.arithmetic.forms import UNIT, Form, between, combine, enclosing, near, slopes, units, value
from certificates.arithmetic.jets import Jet
from certificates.arithmetic.vectors import cross, dot
from certificates.frames import settings
from certificates.geometry import Turned
from certificates.problem import read_problem
from certificates.subsets import Kind
from certificates.verdicts import NotProved
from tests.support.made_certificates import platform

SEED = 20261123
SYMBOLS = 4


def random_form(generator: random.Random) -> Form:
    """Return a form with coefficients of all sizes, some of them zero."""

    def integer() -> int:
        return generator.choice((0, 1, -1)) * generator.getrandbits(generator.choice((3, 40, 60, 64)))

    n = generator.randrange(SYMBOLS + 1)
    curves = [integer() for _ in range(n * (n + 1) // 2)] if generator.random() < 0.7 else []
    return Form(
        integer(), [integer() for _ in range(n)], curves, generator.getrandbits(generator.choice((0, 9, 50)))
    )


def at(form: Form, symbols: Sequence[Fraction], rest: Fraction) -> Fraction:
    """Return the number that a form encloses for some symbols, and a share of its rest."""
    pairs = [(i, j) for j in range(SYMBOLS) for i in range(j + 1)]
    found = Fraction(form.value) + sum(s * e for s, e in zip(form.slopes, symbols, strict=False))
    found += sum(c * symbols[i] * symbols[j] for c, (i, j) in zip(form.curves, pairs, strict=False))
    return (found + rest * form.rest) / UNIT


def encloses(form: Form, symbols: Sequence[Fraction], number: Fraction) -> bool:
    """Return True when a number is one that a form encloses for some symbols."""
    lo, hi = (at(form, symbols, Fraction(side)) for side in (-1, 1))
    assert Fraction(form.lowest(), UNIT) <= lo and hi <= Fraction(form.highest(), UNIT)
    assert max(abs(lo), abs(hi)) <= Fraction(form.size(), UNIT)
    assert not (form.has_no_zero() and lo <= 0 <= hi)
    return lo <= number <= hi


def random_share(generator: random.Random) -> Fraction:
    """Return a number in [-1, 1], its ends more often than others."""
    return generator.choice((Fraction(1), Fraction(-1), Fraction(generator.randint(-64, 64), 64)))


def test_arithmetic_encloses_the_exact_numbers():
    generator = random.Random(SEED)
    for _ in range(4000):
        a, b = random_form(generator), random_form(generator)
        e = [random_share(generator) for _ in range(SYMBOLS)]
        x, y = (at(form, e, random_share(generator)) for form in (a, b))
        k, w = generator.randint(-5, 5), [generator.uniform(-3, 3), generator.choice((0.0, 0.5, 1e-9))]
        assert encloses(a + b, e, x + y) and encloses(a - b, e, x - y) and encloses(-a, e, -x)
        assert encloses(a * b, e, x * y) and encloses(a * k, e, x * k) and encloses(k * a, e, x * k)
        assert encloses(a + k, e, x + k) and encloses(k - a, e, k - x)
        exact = [Fraction(units(v), UNIT) for v in w]
        assert encloses(combine(w, [a, b]), e, exact[0] * x + exact[1] * y)


def test_a_product_of_lines_has_no_rest_but_that_of_rounding():
    a, b = Form(UNIT, [UNIT, 0]), Form(3 * UNIT, [0, UNIT])
    product = a * b
    assert (product.value, list(product.slopes)) == (3 * UNIT, [3 * UNIT, UNIT])
    assert list(product.curves) == [0, UNIT, 0] and product.rest < 10


def test_numbers_become_forms():
    generator = random.Random(SEED)
    for _ in range(500):
        x = generator.uniform(-9, 9) * 10.0 ** generator.randint(-25, 5)
        lo, hi = sorted((x, generator.uniform(-9, 9)))
        form = between(lo, hi, 2)
        for inner in (lo, hi, lo + generator.random() * (hi - lo)):
            exact = Fraction(min(max(inner, lo), hi))
            share = (exact * UNIT - form.value) / form.slopes[2]
            assert abs(share) <= 1
        with ctx.workprec(BITS):
            ball = arb(x).exp() if x < 100 else arb(x)
            constant = enclosing(ball)
            assert arb(constant.lowest()) / UNIT <= ball and ball <= arb(constant.highest()) / UNIT
        assert value(near(x)) == pytest.approx(x, abs=1e-17)
    assert between(0.0, 0.0, 3).slopes == [] and enclosing(arb(0)).size() == 0
    assert slopes(near(1.0, [0.5]), 3) == [0.5, 0.0, 0.0]
    with pytest.raises((OverflowError, ValueError)):
        near(float("nan"))


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


def test_forms_of_a_platform_enclose_its_exact_numbers():
    generator = random.Random(SEED)
    question = read_problem(platform(b"", b"", b"", b""))
    (setting,) = settings(question, (0, 1, 2), Kind.GENERAL)
    with ctx.workprec(BITS):
        exactly = setting.cables(question, (2, 0, 1))
        over_cells = exactly.mapped(enclosing)
        for chart, _ in itertools.product(range(4), range(30)):
            middle = [generator.uniform(-1, 1) for _ in range(3)] + [
                generator.uniform(-5, 5) for _ in range(3)
            ]
            bounds = [(m - r, m + r) for m, r in zip(middle, [0.1] * 3 + [0.5] * 3, strict=True)]
            forms = [between(lo, hi, k) for k, (lo, hi) in enumerate(bounds)]
            place = [arb(lo) + (arb(hi) - arb(lo)) * generator.randint(0, 8) / 8 for lo, hi in bounds]
            over, there = Turned(over_cells, chart, forms[:3]), Turned(exactly, chart, place[:3])
            wide = [*over.lengths(forms[3:], over.lines), *itertools.chain(*over.wrenches(forms[3:]))]
            exact = [*there.lengths(place[3:], there.lines), *itertools.chain(*there.wrenches(place[3:]))]
            for form, number in zip(wide, exact, strict=True):
                assert arb(form.lowest()) / UNIT <= number and number <= arb(form.highest()) / UNIT
