"""A six-dof platform on inextensible cables as the compiled kernels see it.

Everything the kernels need is a plain array: a middle and an error that together enclose the
exact rational of the input. Rotations are covered by four charts: R = R(u) D_c with the Cayley
rotation R(u), u in [-1, 1]^3, and D_c the identity or the half turn about x, y or z, so that in
chart c the arms are D_c b_i.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range, RangeVector, difference, middle_of
from cdpr_interval.mechanics.rotation import HALF_TURNS

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Model(NamedTuple):
    """Arrays for the kernels; N cables of which the first n are taut, the others slack.

    Lengths in m, forces in N. ``*_err`` bounds |exact - value|.
    """

    n_taut: int
    planar: bool
    """The problem is reduced to the plane y = 0 (two cables)."""
    statics: bool
    """Cells without an equilibrium of non-negative tensions are excluded."""
    hanging: bool
    """Some taut cables end at the centre of mass, the pivot among them, and at most three do not: cells where
    only the former can have tension are excluded."""
    slack: bool
    """Cells where a cable outside the subset would be too long are excluded."""
    exits: Floats
    """(N, 3) exit points A_i."""
    exits_err: Floats
    arms: Floats
    """(4, N, 3) arms D_c b_i."""
    arms_err: Floats
    """(N, 3)."""
    exit_steps: Floats
    """(N, N, 3) A_i - A_j."""
    exit_steps_err: Floats
    arm_steps: Floats
    """(4, N, N, 3) D_c (b_i - b_j)."""
    arm_steps_err: Floats
    """(N, N, 3)."""
    square: Floats
    """(N, N) |A_i - A_j|^2 + |b_i - b_j|^2; |c_i - c_j|^2 = square - 2 (A_i - A_j) . R (b_i - b_j)."""
    square_err: Floats
    lengths: Floats
    """(N, 2) bounds of l_i."""
    lengths_sq: Floats
    """(N,) l_i^2."""
    lengths_sq_err: Floats
    load: Floats
    """(3,) f."""
    load_err: Floats
    exit_spread: Floats
    """(N, 3) how far exit points may be from the middles above, along the axes.

    Where these spreads are not zero, ``lengths`` are the distances between the middle points that go with the
    cables' own lengths: longer and shorter by the ``gaps``."""
    arm_spread: Floats
    """(N,) how far arms may be from their middles."""
    gaps: Floats
    """(N,) how far a cable's vector may be from that between the middle points."""
    anchor_sides: Floats
    """(N, 3) how far each arm's entries may be from their middles by its own doing,"""
    centre_sides: Floats
    """(3,) and by that of the centre of mass, alike for all arms; ``arm_spread`` bounds both together."""
    vague: bool
    """Some of these spreads are not zero."""
    own_points: bool
    """``lengths`` are the cables' own, between the points of each choice; only for tubes."""
    size: float
    """A length of the platform, by which moments are divided (only scales float work)."""
    orders: Ints
    """(m, n) permutations of the taut cables; the first three of a row are its triple."""


def split(ranges: list[Range]) -> tuple[Floats, Floats]:
    """Return middles and error bounds of exact ranges."""
    pairs = [nearest(r.lo) if r.lo is r.hi or r.lo == r.hi else middle_and_error(r.lo, r.hi) for r in ranges]
    return np.array([m for m, _ in pairs]), np.array([e for _, e in pairs])


def nearest(x: Fraction) -> tuple[float, float]:
    """Return the double nearest to an exact number and a bound of its error."""
    numerator, denominator = x.numerator, x.denominator
    try:
        # Divisions of integers are correctly rounded.
        m = numerator / denominator
        a, b = m.as_integer_ratio()
        excess = abs(numerator * b - a * denominator)
        return m, math.nextafter(excess / (denominator * b), math.inf) if excess else 0.0
    except OverflowError:
        return middle_and_error(x, x)


def middle_and_error(low: Fraction, high: Fraction) -> tuple[float, float]:
    """Return a double near the middle of a range and a bound of its distance from all of the range."""
    lo, hi = enclose(low)[0], enclose(high)[1]
    m = 0.5 * lo + 0.5 * hi
    middle = Fraction(m)
    return m, enclose(max(high - middle, middle - low))[1]


def _vectors(vectors: list[RangeVector]) -> tuple[Floats, Floats]:
    m, e = split([x for v in vectors for x in v])
    return m.reshape(-1, 3), e.reshape(-1, 3)


def apart(vectors: list[RangeVector]) -> tuple[list[RangeVector], Floats]:
    """Return the middles of vectors, and bounds (N, 3) of how far from them each entry may be."""
    half = [[enclose(x.width / 2)[1] for x in v] for v in vectors]
    found = []
    for v in vectors:
        x, y, z = map(Range.exact, middle_of(v))
        found.append((x, y, z))
    return found, np.array(half).reshape(-1, 3)


def norms(vectors: Floats) -> Floats:
    """Return upper bounds (N,) of the norms of vectors (N, 3) >= 0, 0 for zero."""
    most = vectors.max(axis=1, initial=0.0)
    scale = np.where(most > 0.0, most, 1.0)
    found = np.linalg.norm(vectors / scale[:, None], axis=1) * (1.0 + 1e-15) * scale
    return np.asarray(np.where(most > 0.0, np.nextafter(found, np.inf), 0.0))


def longer_and_shorter(lengths: Floats, by: Floats) -> tuple[Floats, Floats, Floats]:
    """Return bounds (N, 2) of lengths widened by ``by`` (N,), the middles of their squares and the errors."""
    lo = np.maximum(np.nextafter(lengths[:, 0] - by, 0.0), 0.0)
    hi = np.nextafter(lengths[:, 1] + by, np.inf)
    least, most = np.nextafter(lo * lo, 0.0), np.nextafter(hi * hi, np.inf)
    middle = 0.5 * least + 0.5 * most
    error = np.nextafter(np.maximum(most - middle, middle - least), np.inf)
    return np.stack([lo, hi], axis=1), middle, error


def _norm_sq(a: RangeVector) -> Range:
    return a[0].squared() + a[1].squared() + a[2].squared()


def platform_size(arms: Floats) -> float:
    """Return the power of two nearest to the length of the longest arm.

    1 if all are zero. A power of two divides without rounding.
    """
    most = float(np.sqrt((arms**2).sum(axis=1).max())) or 1.0
    return float(2.0 ** np.round(np.log2(most)))


def triples_by_spread(exits: Floats, arms: Floats, n: int, most: int = 4) -> Ints:
    """Return up to ``most`` orders of the taut cables, best triple first.

    A triple is good when the centres c_i of its spheres stay far from one line over all
    rotations: the 10 % quantile over a fixed sample of |m| = |(c_2 - c_1) x (c_3 - c_1)|.
    """
    if n < 3:
        return np.arange(n, dtype=np.int64)[None, :]
    q = np.random.default_rng(20120514).normal(size=(64, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    w, v = q[:, :1, None], q[:, 1:]
    cross = np.cross(v[:, None, :], arms[None, :n, :])
    rotated = arms[None, :n] + 2.0 * (w * cross + np.cross(v[:, None, :], cross))
    centres = exits[None, :n] - rotated
    scored = []
    for i in range(n):
        for j in range(i + 1, n):
            for k in range(j + 1, n):
                m = np.cross(centres[:, j] - centres[:, i], centres[:, k] - centres[:, i])
                score = float(np.quantile(np.linalg.norm(m, axis=1), 0.1))
                rest = [c for c in range(n) if c not in (i, j, k)]
                scored.append((-score, [i, j, k, *rest]))
    scored.sort()
    return np.array([order for _, order in scored[:most]], dtype=np.int64)


def central_first(orders: Ints, central: list[int]) -> Ints:
    """Return the orders with a cable at the centre of mass in front, where there is one.

    Moments are then about the centre of mass. A triple that has such a cable is only turned.
    """
    if not central:
        return orders
    turned = []
    for order in orders.tolist():
        first = next(i for i in order if i in central)
        turned.append([first, *(i for i in order if i != first)])
    return np.array(turned, dtype=np.int64)


def spread_apart(
    exits: list[RangeVector], arms: list[RangeVector], spread: bool, centre: Floats | None
) -> tuple[list[RangeVector], list[RangeVector], dict[str, Floats]]:
    """Return exit points and arms, and the fields of a model that say how far they may be from them.

    See ``build_model``.
    """
    exit_spread, half = np.zeros((len(exits), 3)), np.zeros((len(arms), 3))
    if spread:
        exits, exit_spread = apart(exits)
        arms, half = apart(arms)
    arm_spread = norms(half)
    shared = np.zeros(3) if centre is None else centre
    fields = {
        "exit_spread": exit_spread,
        "arm_spread": arm_spread,
        "gaps": np.asarray((norms(exit_spread) + arm_spread) * (1.0 + 1e-15)),
        # Both are rounded up, by less than two units each.
        "anchor_sides": np.where(half > 0.0, np.maximum(half - shared, 0.0) + 4.0 * np.spacing(half), 0.0),
        "centre_sides": shared,
    }
    return exits, arms, fields


def build_model(
    exits: list[RangeVector],
    arms: list[RangeVector],
    lengths: list[Range],
    load: RangeVector,
    n_taut: int,
    *,
    planar: bool = False,
    statics: bool = True,
    slack: bool = True,
    spread: bool = False,
    centre: Floats | None = None,
) -> Model:
    """Enclose exact data (taut cables first) in the arrays of a ``Model``.

    With ``spread`` the ranges of exit points and arms become spreads around their middles, else errors.
    ``centre`` (3,) bounds the part of the arms' half widths that is the centre of mass's, the same for all.
    """
    count = len(exits)
    central = [i for i in range(n_taut) if all(r.lo == r.hi == 0 for r in arms[i])]
    exits, arms, spreads = spread_apart(exits, arms, spread, centre)
    outer = [i for i in range(n_taut) if i not in central]
    # An arm with zero in the middle of its range: the cable ends at the centre of mass for some choices.
    doubtful = any(all(r.lo == r.hi == 0 for r in arms[i]) for i in outer)
    a, a_err = _vectors(exits)
    b, b_err = _vectors(arms)
    pairs = [(i, j) for i in range(count) for j in range(count)]
    steps_a = [difference(exits[i], exits[j]) for i, j in pairs]
    steps_b = [difference(arms[i], arms[j]) for i, j in pairs]
    da, da_err = (x.reshape(count, count, 3) for x in _vectors(steps_a))
    db, db_err = (x.reshape(count, count, 3) for x in _vectors(steps_b))
    square, square_err = (
        x.reshape(count, count)
        for x in split([_norm_sq(x) + _norm_sq(y) for x, y in zip(steps_a, steps_b, strict=True)])
    )
    squares = [Range(r.lo**2, r.hi**2) for r in lengths]
    l_sq, l_sq_err = split(squares)
    f, f_err = split(list(load))
    return Model(
        n_taut=n_taut,
        planar=planar,
        statics=statics,
        hanging=statics and 1 <= len(outer) <= 3 and len(central) > 0 and not doubtful,
        slack=slack,
        exits=a,
        exits_err=a_err,
        arms=np.ascontiguousarray(HALF_TURNS[:, None, :] * b),
        arms_err=b_err,
        exit_steps=np.ascontiguousarray(da),
        exit_steps_err=np.ascontiguousarray(da_err),
        arm_steps=np.ascontiguousarray(HALF_TURNS[:, None, None, :] * db),
        arm_steps_err=np.ascontiguousarray(db_err),
        square=np.ascontiguousarray(square),
        square_err=np.ascontiguousarray(square_err),
        lengths=np.array([[enclose(r.lo)[0], enclose(r.hi)[1]] for r in lengths]),
        lengths_sq=l_sq,
        lengths_sq_err=l_sq_err,
        load=f,
        load_err=f_err,
        **spreads,
        vague=bool(spreads["gaps"].any()),
        own_points=False,
        size=platform_size(b[:n_taut]),
        orders=central_first(triples_by_spread(a, b, n_taut), central),
    )
