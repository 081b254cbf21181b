"""The symbolic layer against exact oracles: determinants, planted poses, known degrees, unlucky primes."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
import sympy
from flint import acb, arb, ctx, fmpq, fmpz_poly, nmod_mat, nmod_poly

from cdpr_interval.symbolic import elimination, poses
from cdpr_interval.symbolic.derivation import derivation, latex, rational
from cdpr_interval.symbolic.eliminant import eliminant, multiplicities, part_over_rationals, shared
from cdpr_interval.symbolic.elimination import Curves, Vanishes, resultant, survey
from cdpr_interval.symbolic.inextensible import closed_form
from cdpr_interval.symbolic.reconstruction import NotReconstructed, nearest_fraction, reconstructed
from cdpr_interval.symbolic.residues import primes, residue
from cdpr_interval.symbolic.statics import Statics, dot

SEED = 20261123
(PRIME,) = primes(1)
SQUARE = [(0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0)]
PERTURBED = [(0, 0, 0), (4, "1/7", "1/3"), ("1/5", 4, "-1/4"), ("21/5", "19/5", "1/9")]
STIFFNESS, LENGTHS, TENSIONS = (1000, 1100, 950, 1020), ("2.9", "3.1", 4, "4.1"), (441, 442, 202, 203)


def exact(values) -> list[fmpq]:
    return [fmpq(*Fraction(v).as_integer_ratio()) for v in values]


def springs(exits, count: int = 4, load=(0, 0, -785)) -> Statics:
    points = [exact(a) for a in exits[:count]]
    return Statics.elastic(points, exact(load), exact(STIFFNESS[:count]), exact(LENGTHS[:count]))


def pulled(exits, count: int = 4, load=(0, 0, -785)) -> Statics:
    return Statics.given_tensions([exact(a) for a in exits[:count]], exact(load), exact(TENSIONS[:count]))


def test_determinants_in_a_ring_of_polynomials():
    generator = random.Random(SEED)
    x, y = elimination.ring(PRIME).gens()
    for n in (1, 2, 4, 6):
        rows = [
            [
                generator.randrange(-2, 3) * x ** generator.randrange(3) + generator.randrange(-2, 3) * y
                for _ in range(n)
            ]
            for _ in range(n)
        ]
        rows[0][-1] = 0
        found = elimination.determinant(rows)
        for _ in range(5):
            u, v = (generator.randrange(PRIME) for _ in range(2))
            values = [int(entry(u, v)) if entry != 0 else 0 for row in rows for entry in row]
            value = int(found(u, v)) if found != 0 else 0
            assert value == int(nmod_mat(n, n, values, PRIME).det())


def test_rationals_modulo_a_prime():
    assert residue(fmpq(2, 3), PRIME) * 3 % PRIME == 2
    with pytest.raises(ZeroDivisionError):
        residue(fmpq(1, PRIME), PRIME)


def test_a_prime_with_other_factors_is_unlucky():
    first = survey(springs(SQUARE, 3), PRIME)[0]
    with pytest.raises(ZeroDivisionError):
        Curves(springs(SQUARE, 3), PRIME).divided(replace(first, powers=(99, *first.powers[1:])))


def test_polynomials_are_reconstructed_whatever_unlucky_primes_say():
    target = fmpz_poly([3**90, -7, 0, 2**100 + 1, 10**40])
    bad = set(primes(5)[1:3])

    def image(prime: int) -> nmod_poly:
        if prime == primes(4)[3]:
            raise ZeroDivisionError
        f = nmod_poly([int(c) % prime for c in target.coeffs()], prime)
        return f * nmod_poly([1, 1], prime) * 5 if prime in bad else f * 17

    assert reconstructed(image) == target
    generator = random.Random(SEED)
    with pytest.raises(NotReconstructed):
        reconstructed(lambda p: nmod_poly([generator.randrange(p), 1], p), most_primes=12)
    assert nearest_fraction(-22 * pow(7, -1, 10**9 + 7) % (10**9 + 7), 10**9 + 7) == (-22, 7)


@pytest.mark.parametrize(
    ("statics", "true", "others"),
    [
        (springs(SQUARE, 2), 6, {}),
        (springs(SQUARE, 3), 22, {}),
        (springs(PERTURBED, 3, ("1/2", "1/3", -785)), 22, {}),
        (springs(SQUARE), 76, {2: 96}),
        (springs(PERTURBED), 80, {}),
        (springs(PERTURBED, 4, ("1/2", "1/3", -785)), 80, {}),
        (pulled(SQUARE, 3), 14, {}),
        (pulled(SQUARE), 60, {}),
        (pulled(PERTURBED), 64, {}),
    ],
)
def test_degrees_modulo_a_prime(statics: Statics, true: int, others: dict[int, int]):
    curves = survey(statics, PRIME)
    sizes = multiplicities(resultant(statics, curves[:2], PRIME))
    common = multiplicities(shared(statics, PRIME)(PRIME))
    assert common[1] == true
    assert sizes[1] >= true and all(sizes[m] >= d for m, d in others.items())


def test_the_degrees_of_the_paper():
    """(6, 6, 2), (3, 3, 3), (9, 9, 3), then 15 and 18; 76 and 96; tensions: 30 and 144 in rho_1^2."""
    statics = springs(SQUARE)
    first, second = survey(statics, PRIME)[:2]
    assert first.degrees == (15, 15) and second.degrees == (18, 18)
    degrees = [
        (*(max(c.degrees()[k] for c in condition) for k in range(2)), len(condition) - 1)
        for condition in elimination.conditions_modulo(statics, PRIME)[0]
    ]
    assert degrees == [(6, 6, 2), (3, 3, 3), (9, 9, 3)]
    tension = pulled(SQUARE)
    curves = survey(tension, PRIME)
    whole = resultant(tension, [curves[1], curves[3]], PRIME)
    simple = next(f for f, m in whole.factor_squarefree()[1] if m == 1)
    true = simple.gcd(resultant(tension, curves[:2], PRIME))
    assert true.degree() == 2 * 30 and (simple // true).degree() == 2 * 144
    assert all(c == 0 for c in simple.coeffs()[1::2])


@pytest.mark.slow
def test_the_factors_76_and_96_are_irreducible():
    found = eliminant(springs(SQUARE))
    assert [f.degree for f in found.factors if f.is_true] == [76] and found.refuted == {2: 96, 4: 1}
    extraneous = part_over_rationals(springs(SQUARE), 2)
    assert extraneous.degree() == 96 and [f.degree() for f, _ in extraneous.factor()[1]] == [96]
    # All 76 roots belong to one zero of the system each: nothing extraneous is in the true factor.
    with ctx.workprec(poses.BITS):
        roots = [r for r, _ in found.factors[0].polynomial.complex_roots()]
        zeros = [poses.solutions_at(found.statics, found.curves, r) for r in roots[::7]]
    assert all(len(z) == 1 for z in zeros)
    assert sum(z.is_static for _, zs in found.real_solutions for z in zs) == 1


@pytest.mark.parametrize("count", [1, 2, 3])
def test_planted_springs_are_found(count: int):
    """Lengths are chosen for a pose, so that it is static with known tensions."""
    generator = random.Random(SEED + count)
    for _ in range(4):
        exits = [
            [fmpq(generator.randint(-9, 9), 4) for _ in range(2)] + [fmpq(generator.randint(0, 3), 4)]
            for _ in range(3)
        ]
        tension_over_length = [fmpq(generator.randint(20, 60)) for _ in range(count)]
        pose = [fmpq(generator.randint(-4, 4), 3), fmpq(generator.randint(-4, 4), 3), fmpq(-3)]
        spokes = [[c - a for c, a in zip(pose, point, strict=True)] for point in exits[:count]]
        # Unstretched lengths are rational where distances are: exit points are moved a little.
        for k, e in enumerate(spokes):
            square = sum((x * x for x in e), fmpq(0))
            size = fmpq(*Fraction(float(square) ** 0.5).limit_denominator(50).as_integer_ratio())
            direction = rational_direction(e)
            spokes[k] = [size * x for x in direction]
            exits[k] = [c - x for c, x in zip(pose, spokes[k], strict=True)]
        load = [
            sum((t * e[k] for t, e in zip(tension_over_length, spokes, strict=True)), fmpq(0))
            for k in range(3)
        ]
        sizes = [exact_norm(e) for e in spokes]
        stiffness = [w + 500 for w in tension_over_length]
        lengths = [(u - w) * rho / u for u, w, rho in zip(stiffness, tension_over_length, sizes, strict=True)]
        statics = Statics.elastic(exits[:count], load, stiffness, lengths)
        try:
            found = eliminant(statics)
        except Vanishes:
            continue
        static = [z for _, zs in found.real_solutions for z in zs if z.is_static]
        with ctx.workprec(poses.BITS):
            assert any(all(v.overlaps(acb(c)) for v, c in zip(z.centre, pose, strict=True)) for z in static)
        assert any(f.is_true and f.polynomial(sizes[0]) == 0 for f in found.factors)


def rational_direction(v: list[fmpq]) -> list[fmpq]:
    """Return a rational unit vector near the direction of a vector (stereographic projection)."""
    size = float(sum((x * x for x in v), fmpq(0))) ** 0.5
    x, y = (float(v[0]) / (size - float(v[2])), float(v[1]) / (size - float(v[2])))
    p, q = (fmpq(*Fraction(t).limit_denominator(20).as_integer_ratio()) for t in (x, y))
    s = 1 + p * p + q * q
    return [2 * p / s, 2 * q / s, (p * p + q * q - 1) / s]


def exact_norm(v: list[fmpq]) -> fmpq:
    square = sum((x * x for x in v), fmpq(0))
    root = fmpq(square.p.sqrt(), square.q.sqrt())
    assert root * root == square
    return root


def test_symmetric_data_lose_no_pose():
    """Three equal springs at the corners of a square: roots coincide, the static pose is found."""
    found = eliminant(
        Statics.elastic(
            [exact(a) for a in SQUARE[:3]], exact((0, 0, -785)), exact([1000] * 3), exact([3] * 3)
        )
    )
    static = [z for _, zs in found.real_solutions for z in zs if z.is_static]
    assert len(static) == 1 and static[0].centre[0].overlaps(static[0].centre[1])


def test_degenerate_data_are_named():
    with pytest.raises(Vanishes, match="coincide"):
        eliminant(springs([SQUARE[0], SQUARE[0], SQUARE[1]], 3))
    with pytest.raises(Vanishes, match="without a load"):
        eliminant(springs(SQUARE, 2, (0, 0, 0)))
    with pytest.raises(Vanishes, match="vanishes"):
        eliminant(springs([(0, 0, 0), (0, 0, 1), (0, 0, 2)], 3))
    with pytest.raises(Vanishes, match="given tension"):
        eliminant(pulled(SQUARE, 1))
    with pytest.raises(ValueError, match="cables"):
        eliminant(springs([*SQUARE, (1, 1, 0)], 0))
    with pytest.raises(Vanishes, match="collinear"):
        closed_form(
            [exact(a) for a in ((0, 0, 0), (1, 0, 0), (3, 0, 0))], exact((0, 0, -1)), exact((3, 3, 3))
        )
    with pytest.raises(Vanishes, match="along the load"):
        closed_form([exact(a) for a in ((0, 0, 0), (0, 0, 1))], exact((0, 0, -1)), exact((3, 3)))


def test_inextensible_poses_have_their_lengths_and_balance():
    generator = random.Random(SEED)
    for count in (1, 2, 3):
        for _ in range(20):
            exits = [exact([generator.randint(-5, 5) for _ in range(3)]) for _ in range(count)]
            load = exact([generator.randint(-3, 3), generator.randint(-3, 3), -20])
            lengths = exact([Fraction(generator.randint(30, 60), 7) for _ in range(count)])
            try:
                form = closed_form(exits, load, lengths)
            except Vanishes:
                continue
            assert (len(form.poses()) == 2) == (form.square > 0)
            with ctx.workprec(poses.BITS):
                for centre, tensions in form.poses():
                    spokes = [[c - arb(x) for c, x in zip(centre, a, strict=True)] for a in exits]
                    for spoke, length in zip(spokes, lengths, strict=True):
                        assert (sum((x * x for x in spoke), arb(0)) - length**2).contains(0)
                    for k in range(3):
                        pulls = [t / s * e[k] for t, s, e in zip(tensions, lengths, spokes, strict=True)]
                        assert (sum(pulls, arb(0)) - arb(load[k])).contains(0)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_the_derivation_says_what_is_computed(count: int):
    """The equations that sympy derives vanish at a proved zero of the system."""
    statics = springs(PERTURBED, count)
    symbols = sympy.symbols(f"rho_1:{count + 1}") + sympy.symbols(f"w_1:{count + 1}") + sympy.symbols("x y z")
    zero = a_zero(statics)
    with ctx.workprec(poses.BITS):
        rho = [v.real for v in zero.distances]
        w = [t.real / r for t, r in zip(zero.tensions, rho, strict=True)]
        values = [
            sympy.Float(v.mid().str(60, radius=False), 60) for v in [*rho, *w, *(c.real for c in zero.centre)]
        ]
    replaced = dict(zip(symbols, values, strict=True))
    for step in derivation(statics):
        for formula in step.formulas:
            left = formula.lhs - formula.rhs if isinstance(formula, sympy.Equality) else formula
            assert abs(left.evalf(50, subs=replaced)) < 1e-30, step.title
    document = latex(statics, ["degree 22 & true_1"])
    assert (
        document.count(r"\begin{dmath*}") == document.count(r"\end{dmath*}") > 5 and r"\& true\_1" in document
    )
    assert rational(fmpq(-3, 7)) == sympy.Rational(-3, 7)


def a_zero(statics: Statics) -> poses.Solution:
    """Return a real zero near a hanging pose."""
    with ctx.workprec(poses.BITS):
        for height in range(1, 40):
            centre = [acb(1), acb(1), acb(-height) / 5]
            rho = [
                sum(((c - acb(x)) ** 2 for c, x in zip(centre, a, strict=True)), acb(0)).sqrt()
                for a in statics.exits
            ]
            found = poses.zero_near(statics, [*centre, *rho])
            if found is not None and found.is_real:
                return found
    raise AssertionError("no zero")


def test_real_roots_come_in_order_and_every_one_has_a_pose():
    found = eliminant(springs(PERTURBED, 3))
    roots = [float(r.real) for r, _ in found.real_solutions]
    assert (
        len(roots) > 1 and all(a < b for a, b in pairwise(roots)) and all(z for _, z in found.real_solutions)
    )
    for root, zeros in found.real_solutions:
        for z in zeros:
            assert z.distances[0].overlaps(root)
            for k in range(3):
                pull = sum(
                    (
                        t / r * (z.centre[k] - acb(a[k]))
                        for t, r, a in zip(z.tensions, z.distances, found.statics.exits, strict=True)
                    ),
                    acb(0),
                )
                assert (pull - acb(found.statics.load[k])).contains(0)
    assert dot(found.statics.load, found.statics.load) == 785**2
