"""The winch model: counts to length and back, monotone, and bounds that enclose the exact law."""

from __future__ import annotations

import math
from fractions import Fraction as F

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from cdpr_interval.driver.counter import nearest, wrapped
from cdpr_interval.driver.drum import OffTheDrum, law_of
from cdpr_interval.driver.reference import home
from cdpr_interval.driver.winch import WinchModel, bounds
from cdpr_interval.exact.irrational import PI, square_root
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.winch import HelicalDrum, MultilayerDrum, TableDrum
from tests.support.winch_robots import HELICAL, LINEAR, MULTILAYER, TABLE, between, winch

mp.dps = 60
DRUMS = {"helical": HELICAL, "multilayer": MULTILAYER, "table": TABLE, "linear": LINEAR}
LENGTHS = st.fractions(F("0.5"), F(6), max_denominator=10**9)
SIGNS = st.sampled_from((-1, 1))
drums = pytest.mark.parametrize("drum", DRUMS.values(), ids=DRUMS)


def test_pi_and_roots_are_enclosed():
    assert mpf(PI.lo.numerator) / PI.lo.denominator < mp.pi < mpf(PI.hi.numerator) / PI.hi.denominator
    assert PI.width < F(1, 10**38)
    for number in (F(0), F(2), F(1, 3), F(10**12 + 1, 7)):
        root = square_root(Range(number, number))
        assert root.lo**2 <= number <= root.hi**2 and root.width < F(1, 2**90)


@drums
@settings(deadline=None, max_examples=60)
@given(length=LENGTHS, sign=SIGNS, zero=st.integers(-(2**31), 2**31))
def test_round_trips(drum, length, sign, zero):
    model = WinchModel(winch(drum=drum, sign=sign), zero)
    counts = model.counts(length)
    assert model.counts(model.length(counts)) == counts
    assert model.law.length(model.law.turns(length)) == length
    # A length is met to half a count.
    assert abs(model.length(counts) - length) <= abs(model.rate(counts).hi) + abs(model.rate(counts).lo)


@drums
@settings(deadline=None, max_examples=60)
@given(length=LENGTHS, sign=SIGNS, step=st.integers(1, 10**7))
def test_the_law_is_monotone_with_the_sign(drum, length, sign, step):
    model = WinchModel(winch(drum=drum, sign=sign))
    counts = model.counts(length)
    try:
        longer = model.length(counts + sign * step)
    except OffTheDrum:
        return
    assert longer > model.length(counts)
    rate = model.rate(counts)
    assert rate.lo * sign > 0 and rate.hi * sign > 0


@drums
@settings(deadline=None, max_examples=60)
@given(length=LENGTHS, share=st.fractions(F(1, 100), F(99, 100), max_denominator=1000))
def test_the_rate_encloses_the_slope(drum, length, share):
    law = law_of(drum, F(1) if drum is LINEAR else F(10000))
    turns = law.turns(length)
    slope = law.slope(turns)
    step = F(1, 10**6)
    for other in (turns - step, turns + step):
        if law.ends is None or law.ends[0] <= other <= law.ends[1]:
            quotient = (law.length(other) - length) / (other - turns)
            assert slope.lo <= quotient <= slope.hi


def exact_multilayer(drum: MultilayerDrum, pick, breaks, turns: F) -> mpf:
    """Return the length paid out when the radii and the places of the layers' changes are the picked ones."""
    radius = pick(drum.core_radius) + pick(drum.cable_diameter) / 2
    growth = pick(drum.packing) * pick(drum.cable_diameter)
    edges = [F(0), *(drum.turns_per_layer * (k + 1) + d for k, d in enumerate(breaks)), F(10**9)]
    wound, total = -turns, mpf(0)
    for layer in range(drum.layers):
        part = min(wound, edges[layer + 1]) - edges[layer]
        if part > 0:
            r = radius + layer * growth
            total += 2 * mp.pi * mpf(r.numerator) / r.denominator * mpf(part.numerator) / part.denominator
    return mpf(drum.cable_length.numerator) / drum.cable_length.denominator - total


@settings(deadline=None, max_examples=150)
@given(st.data())
def test_bounds_enclose_every_multilayer_drum_that_the_file_allows(data):
    shares = {}

    def pick(quantity: Range) -> F:
        key = id(quantity)
        if key not in shares:
            shares[key] = data.draw(st.fractions(F(0), F(1), max_denominator=16))
        return quantity.lo + shares[key] * quantity.width

    slack = MULTILAYER.transition_turns
    breaks = [
        data.draw(st.fractions(-slack, slack, max_denominator=16)) for _ in range(MULTILAYER.layers - 1)
    ]
    law = law_of(MULTILAYER, F(1))
    places = st.fractions(-MULTILAYER.turns_per_layer * MULTILAYER.layers, F(0), max_denominator=1000)
    start, end = data.draw(places), data.draw(places)
    exact = exact_multilayer(MULTILAYER, pick, breaks, end) - exact_multilayer(
        MULTILAYER, pick, breaks, start
    )
    span = law.span(Range(start, start), Range(end, end))
    assert (
        mpf(span.lo.numerator) / span.lo.denominator <= exact <= mpf(span.hi.numerator) / span.hi.denominator
    )


@settings(deadline=None, max_examples=150)
@given(st.data())
def test_bounds_enclose_every_helical_drum_that_the_file_allows(data):
    """The reading may be wrong by the encoder's error, the length at the reference anywhere in its range."""
    drum = HelicalDrum(between("0.04", "0.0401"), between("0.002", "0.0021"), between("0.0024", "0.0026"))
    model = WinchModel(winch(drum=drum, sign=data.draw(SIGNS)))
    share = st.fractions(F(0), F(1), max_denominator=16)
    r, d, p = (
        q.lo + data.draw(share) * q.width for q in (drum.groove_radius, drum.cable_diameter, drum.pitch)
    )
    radius = r + d / 2
    around = 2 * mp.pi * mpf(radius.numerator) / radius.denominator
    turn = mp.sqrt(around**2 + (mpf(p.numerator) / p.denominator) ** 2)
    length = Range(F("2.999"), F("3.001"))
    true_start = length.lo + data.draw(share) * length.width
    counts, other = data.draw(st.integers(-(10**7), 10**7)), data.draw(st.integers(-(10**7), 10**7))
    errors = [data.draw(st.fractions(F(-1), F(1), max_denominator=16)) for _ in range(2)]
    turns = model.winch.sign * (other + errors[1] - counts - errors[0]) / model.counts_per_drum_turn
    exact = (
        mpf(true_start.numerator) / true_start.denominator + turn * mpf(turns.numerator) / turns.denominator
    )
    found = home(model, counts, length).length_range(other)
    lo, hi = bounds(found)
    assert mpf(lo) <= exact <= mpf(hi)
    assert F(lo) <= found.lo and found.hi <= F(hi)


def test_the_bounds_are_not_much_wider_than_needed():
    """Exact drum, exact reference: two readings' encoder errors are all that is left."""
    drum = HelicalDrum(between("0.05"), between("0.002"), between("0.0025"))
    model = WinchModel(winch(drum=drum))
    found = home(model, 0, between("3")).length_range(10**6)
    assert abs(found.width - 4 * model.rate(0).mid) < F(1, 10**20)


def test_the_budget_names_its_parts():
    model = WinchModel(winch())
    reference = home(model, 1000, between("2.999", "3.001"))
    here, there = reference.budget(1000), reference.budget(3_000_000)
    assert here.reference == there.reference == F("0.001")
    assert here.drum == 0 and there.drum > F("0.0002")
    quantum = abs(model.rate(0).mid)
    assert F("1.9") * quantum < there.encoder < F("2.1") * quantum
    for counts, budget in ((1000, here), (3_000_000, there)):
        assert 2 * budget.total == reference.length_range(counts).width


def test_known_numbers():
    """Helical: hypot(2 pi 0.051, 0.0025) m a turn. Linear: IRMA-LAB's 5.90e-8 m a count."""
    assert float(law_of(HELICAL, F(1)).slopes[0].mid) == pytest.approx(
        math.hypot(2 * math.pi * 0.051, 0.0025), rel=1e-10
    )
    model = WinchModel(winch(drum=LINEAR))
    assert float(model.length(10**8) - model.length(0)) == pytest.approx(5.90)
    layers = law_of(MULTILAYER, F(1))
    # Seen from the bare drum: 0 turns, everything paid out; the outermost layer comes first when paying out.
    assert layers.length(F(0)) == 9 and layers.slopes[0].mid > layers.slopes[-1].mid


def test_a_rational_gear_does_not_drift():
    """A million drum turns of 156:7 are exactly 156000000/7 motor turns."""
    model = WinchModel(winch())
    assert model.turns(65536 * 156 * 10**6) == 7 * 10**6


@pytest.mark.parametrize("drum", [TABLE, MULTILAYER], ids=["table", "multilayer"])
def test_beyond_the_drum_is_an_error(drum):
    model = WinchModel(winch(drum=drum))
    with pytest.raises(OffTheDrum, match="the drum goes from"):
        model.counts(F(50))
    with pytest.raises(OffTheDrum):
        model.length(model.counts(F(3)) + 10**9)


def test_table_errors_are_in_the_bounds():
    drum = TableDrum(((F(0), F(0)), (F(1), F(1, 3)), (F(2), F(3, 4))), F("0.001"))
    span = law_of(drum, F(1)).span(between("0.5"), between("1.5"))
    nominal = F(1, 2) * F(1, 3) + F(1, 2) * F(5, 12)
    assert (span.lo, span.hi) == (nominal - F("0.002"), nominal + F("0.002"))


@given(st.integers(-(2**70), 2**70), st.integers(-(2**31) + 1, 2**31 - 1))
def test_a_wrapped_counter_is_unwrapped(reading, step):
    assert -(2**31) <= wrapped(reading) < 2**31
    assert nearest(wrapped(reading + step), reading) == reading + step
