"""A platform on two inextensible cables: the planar problem of degree 12.

Cables, platform points, centre of mass and load lie in one plane (balance of moments), the platform in one
of two mirrored ways. Complex numbers stand for vectors of that plane, -i is along the load: the rotation is
r = (1 + i u)^2 / s with s = 1 + u^2, d = a - r q the way between the centres of the circles on which the
first platform point lies, x the way to it from A_1. Of

    |x|^2 = l_1^2,  d . x = K = (|d|^2 + l_1^2 - l_2^2) / 2,  (x x f) (r q x (d - x)) = (d x x) (r b_1 x f)

(the last one from force and moments) the first two give x = (K d + sigma i d) / N with N = |d|^2 and
sigma^2 = D = l_1^2 N - K^2; the third becomes A + B sigma = 0. So A^2 = B^2 D, of degree 16 in u, and of
degree 12 without the factor N^2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from flint import acb_poly, arb, arb_poly, ctx, fmpq, fmpz, nmod, nmod_poly

from cdpr_interval.symbolic.elimination import Vanishes
from cdpr_interval.symbolic.poses import BITS, TIGHT
from cdpr_interval.symbolic.residues import primes, residue
from cdpr_interval.symbolic.statics import Exact, dot

Scalar = Any
Polynomial = Any
Pair = tuple[Any, Any]
TURN = (fmpq(20, 29), fmpq(21, 29))
"""A fixed turn of the platform's axes: symmetric data have poses at half a turn, where u is infinite."""


@dataclass(frozen=True)
class Planar:
    """The problem's exact data; ``points`` are from the centre of mass. Lengths in m, forces in N."""

    exits: list[Exact]
    points: list[Exact]
    load: Exact
    lengths: Exact

    def squares(self) -> list[fmpq]:
        """Return the squares of the lengths that the plane's coordinates need.

        They are those of f, of the part of a = A_2 - A_1 across it, of b_1 and of b_2's part across b_1.
        """
        a, (b, c) = self.span, self.points
        load, first = dot(self.load, self.load), dot(b, b)
        if load == 0 or first == 0:
            raise Vanishes("the plane needs a load, and a first platform point beside the centre of mass")
        return [load, dot(a, a) - dot(a, self.load) ** 2 / load, first, dot(c, c) - dot(b, c) ** 2 / first]

    @property
    def span(self) -> Exact:
        """A_2 - A_1."""
        return [y - x for x, y in zip(*self.exits, strict=True)]


@dataclass(frozen=True)
class Plane:
    """The same in plane coordinates, numbers of some kind; the load is (0, -1)."""

    span: Pair
    points: tuple[Pair, Pair]
    squares: Pair
    """Of the lengths."""


def plane(problem: Planar, roots: Sequence[Scalar], convert: Callable[[fmpq], Scalar], side: int) -> Plane:
    """Return plane coordinates from the square roots of `Planar.squares`; ``side`` mirrors the platform."""
    load, across, first, second = roots
    b, c = problem.points
    span = (across, convert(-dot(problem.span, problem.load)) / load)
    straight: list[Pair] = [(first, 0 * first), (convert(dot(b, c)) / first, second * side)]
    x, y = (convert(v) for v in TURN)
    turned = [(x * v - y * w, y * v + x * w) for v, w in straight]
    lengths = [convert(v * v) for v in problem.lengths]
    return Plane(span, (turned[0], turned[1]), (lengths[0], lengths[1]))


def inner(a: Pair, b: Pair) -> Any:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1]


def outer(a: Pair, b: Pair) -> Any:
    """Return a x b."""
    return a[0] * b[1] - a[1] * b[0]


@dataclass(frozen=True)
class Elimination:
    """A, B, D and what leads to them, multiplied by powers of s = 1 + u^2: polynomials in u."""

    plane: Plane
    s: Polynomial
    turn: Pair
    """s r."""
    d: Pair
    k: Polynomial
    n: Polynomial
    a: Polynomial
    b: Polynomial
    disc: Polynomial

    @property
    def whole(self) -> Polynomial:
        """A^2 - B^2 D."""
        return self.a * self.a - self.b * self.b * self.disc


def eliminated(found: Plane, u: Polynomial) -> Elimination:
    """Eliminate x; ``u`` is the unknown as a polynomial."""
    s, c, z = 1 + u * u, 1 - u * u, 2 * u

    def rotated(v: Pair) -> Pair:
        """Return s r v."""
        return c * v[0] - z * v[1], z * v[0] + c * v[1]

    first, second = found.points
    way = (second[0] - first[0], second[1] - first[1])
    q, reach = rotated(way), inner(way, way)
    a = found.span
    d = (s * found.span[0] - q[0], s * found.span[1] - q[1])
    n = s * (inner(found.span, found.span) + reach) - 2 * inner(a, q)
    half = (0 * found.span[0] + 1) / 2
    k = n * half + s * ((found.squares[0] - found.squares[1]) * half)
    disc = s * n * found.squares[0] - k * k
    # With the load f = (0, -1): v x f = -v_0, (i v) x f = -v . f = v_1.
    alpha, beta, gamma, delta = -d[0], d[1], outer(q, a), inner(q, a) - s * reach
    arm = -rotated(first)[0]
    left = k * (n - k) * alpha * gamma - beta * delta * disc
    right = beta * (n - k) * gamma - k * alpha * delta - n * n * arm
    return Elimination(found, s, (c, z), d, k, n, left, right, disc)


def eliminant_modulo(problem: Planar, side: int) -> nmod_poly:
    """Return the eliminant modulo a prime for which the plane's coordinates exist."""
    squares = problem.squares()
    for prime in primes(2000):
        try:
            roots = [square_root(residue(v, prime), prime) for v in squares]
        except (ValueError, ZeroDivisionError):
            continue

        def convert(x: fmpq, p: int = prime) -> nmod:
            return nmod(residue(x, p), p)

        found = eliminated(plane(problem, roots, convert, side), nmod_poly([0, 1], prime))
        quotient, rest = divmod(found.whole, found.n * found.n)
        if rest != 0:
            raise AssertionError("the known factor does not divide the eliminant")
        if quotient.degree() < 0:
            raise Vanishes("the eliminant vanishes identically")
        return quotient
    raise ArithmeticError("no prime has the square roots that the plane needs")


def square_root(x: int, prime: int) -> nmod:
    """Return a square root modulo a prime; raise `ValueError` where there is none."""
    return nmod(int(nmod_root(x, prime)), prime)


def nmod_root(x: int, prime: int) -> fmpz:
    """Return a root of y^2 = x."""
    roots = nmod_poly([-x % prime, 0, 1], prime).roots()
    if not roots:
        raise ValueError("no square root")
    return fmpz(int(roots[0][0]))


@dataclass(frozen=True)
class PlanarPose:
    """A real solution in balls: where the centre of mass is from A_1 (m), tensions over lengths."""

    u: arb
    height: arb
    """Against the load."""
    along: arb
    """Across it."""
    densities: tuple[arb, arb]
    """In units of |f| / m."""


def poses(problem: Planar, side: int) -> list[PlanarPose]:
    """Enclose all real solutions of one mirrored problem; raise `ArithmeticError` where roots touch."""
    with ctx.workprec(BITS):
        roots = [arb(v).sqrt() for v in problem.squares()]
        found = eliminated(plane(problem, roots, arb, side), arb_poly([0, 1]))
        polynomial, _ = divmod(found.whole, found.n * found.n)
        try:
            zeros = acb_poly(polynomial).roots(TIGHT)
        except ValueError as error:
            raise ArithmeticError(str(error)) from None
        return [pose_at(found, zero.real) for zero in zeros if zero.imag.contains(0)]


def pose_at(found: Elimination, u: arb) -> PlanarPose:
    """Return the pose at a root of the eliminant."""

    def at(p: arb_poly) -> arb:
        """Return a polynomial's value."""
        return p(u)

    s, n = at(found.s), at(found.n)
    d = (at(found.d[0]) / s, at(found.d[1]) / s)
    # A s^4 + B s^3 (s sigma) = 0.
    sigma = -at(found.a) / at(found.b) / s
    k, size = at(found.k) / s, n / s
    x = ((k * d[0] - sigma * d[1]) / size, (k * d[1] + sigma * d[0]) / size)
    second = -x[0] / sigma
    first = (0 - second * (x[0] - d[0])) / x[0]
    turn, b = (at(found.turn[0]) / s, at(found.turn[1]) / s), found.plane.points[0]
    centre = (x[0] - turn[0] * b[0] + turn[1] * b[1], x[1] - turn[1] * b[0] - turn[0] * b[1])
    return PlanarPose(u, centre[1], centre[0], (first, second))
