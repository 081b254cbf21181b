"""The pose that the last one becomes while the lengths go straight to new ones, compiled.

The way from the lengths before to those after is cut in pieces. Of each the hull of its lengths, ranges
included, is a box of data, over which a tube is proved (``mechanics.six_dof.tube``): for every choice of
lengths exactly one zero of the taut cables' system within v of a polynomial, and it lies within w. Then

1. its tensions are positive and the other cables shorter than their lengths, for every choice: these zeros
   are static poses with just these cables taut; and
2. for one choice where two pieces meet, the zero of the one lies within v of the polynomial of the other.

Zeros move continuously with the lengths and are regular, so those of two tubes that meet once are the same
for all choices that both have. So for every choice before and every choice after, the pose that starts as
the last one moves continuously while the lengths go from the one to the other along a straight line, with
the same cables taut all along, and ends as the one zero of the last tube. Whether other poses are near is not
said.

Arrays, for n taut cables of N and m equations, taut cables first: ``F`` (rows, columns of a form, LANES)
forms with the rows of ``tube.TABLE``; ``model`` is an ``arrays.Model`` whose lengths are written; ``data``
(n + 1, 7, 2) as in ``six_dof.track``; ``before, after`` (N, 2) lengths in m; ``free`` (m,), ``rows`` (m - n,
6); ``C`` (m, m) the inverse of the derivative, ``E`` (m, m, 2); ``v, w`` (m,) radii; ``z`` (6 + n,); ``delta,
off`` (n,); ``box`` (6 + n, 2); ``note`` (7 + n, 2) the shares of the way where a part of it begins and ends,
and bounds of its zeros; ``link`` is a ``Link``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.kernels import interval
from cdpr_interval.kernels.kernel import entry, kernel, part
from cdpr_interval.kernels.lanes import splat, store
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.kernels.second_order import Symbols, bounds, combine2
from cdpr_interval.mechanics.six_dof import system as newton
from cdpr_interval.mechanics.six_dof.form_system import Z, excess, rotation_forms
from cdpr_interval.mechanics.six_dof.tube import (
    LANE,
    NONE,
    OUT,
    as_polynomial,
    extents,
    first_lane,
    moved_by_errors,
    polynomial,
    proved_within,
)
from cdpr_interval.mechanics.six_dof.tube_terms import column_of, levelled
from solvers.six_dof.track import GONE, LOOSE, NEWTON_STEPS, OTHER, TIGHT, TRACKED, contract, holds

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SHARE = 0.03
"""Radii without a second zero over what a piece of the way moves the pose. Larger ones need shorter pieces:
of the way to +-0.1 mm a platform of 0.5 m goes 42 % with 0.25, 97 % with 0.03, where a cable may be loose."""
NEAR = 1.0 / 32.0
"""Shortest piece, over the whole way, before a place where a cable may switch; ``cross`` goes on there."""
ROOM = 4.0
"""Radii without a second zero over those of the zero that the piece begins with, at least;"""
VAGUE_ROOM = 1.25
"""where data with ranges make most of both they are nearly the same from piece to piece."""
SHORTEST = 1.0 / 1024.0
"""Of a piece, over the whole way: what is not proved over that is not proved."""
MOST_PIECES = 256
"""Tried on one way: a bound of the time a call takes."""
NOTED_PARTS = 8
"""Of a part of the way that is noted: its bounds are the hull of theirs."""
ABOVE_ERRORS = 1.5
"""Radii without a second zero over what errors move it, at least: room for what the derivative varies."""
WIDER_TRIES = 4
"""Radii tried, while their images come nearer: with wide ranges residuals are large."""
WIDER = 1.1
"""Radii over the images of the last ones,"""
MOST_OVER = 4.0
"""which are not followed further than this."""
VAGUE_LINK = 0.05
"""Radii of a zero at the end of a piece over those without a second one, above which it is contracted."""
CONTRACTIONS = 3
"""Of the last enclosure, by the operator of Krawczyk."""
ROUNDED = 4e-16
"""Covers the rounding of a few operations, relative."""


class Link(NamedTuple):
    """What is known of the last pose: its zero for one choice, or a region in which it is alone."""

    known: Any
    """(1,) bool: the zero is known within ``radii`` of ``zero``; else there is the region."""
    zero: Floats
    """(6 + n,) for the middles of the lengths before."""
    radii: Floats
    """(6 + n,)."""
    region: Floats
    """(7,): u and p of the reference, and the radius in m; see ``track``."""


@kernel()
def piece_of_way(before: Any, after: Any, first: float, last: float, i: int) -> tuple[float, float]:
    """Return bounds of a cable's lengths on a piece of the way; 0 <= first <= last <= 1."""
    slack = 4.0 * ROUNDED * (before[i, 1] + after[i, 1])
    lo0 = before[i, 0] + first * (after[i, 0] - before[i, 0])
    lo1 = before[i, 0] + last * (after[i, 0] - before[i, 0])
    hi0 = before[i, 1] + first * (after[i, 1] - before[i, 1])
    hi1 = before[i, 1] + last * (after[i, 1] - before[i, 1])
    if before[i, 0] == after[i, 0]:
        lo0 = lo1 = before[i, 0] + slack
    if before[i, 1] == after[i, 1]:
        hi0 = hi1 = before[i, 1] - slack
    return down(min(lo0, lo1) - slack), up(max(hi0, hi1) + slack)


@kernel()
def put_lengths(model: Any, data: Any, before: Any, after: Any, first: float, last: float) -> None:
    """Write the lengths of a piece of the way to the model, and the middle of their squares to ``data``."""
    for i in range(before.shape[0]):
        lo, hi = piece_of_way(before, after, first, last, i)
        square_lo, square_hi = interval.sqr(lo, hi)
        middle = 0.5 * square_lo + 0.5 * square_hi
        model.lengths[i, 0], model.lengths[i, 1] = lo, hi
        model.lengths_sq[i] = middle
        model.lengths_sq_err[i] = up(max(up(square_hi - middle), up(middle - square_lo)))
        if i < model.n_taut:
            data[i, 6, 0] = data[i, 6, 1] = middle


@kernel()
def place_on(model: Any, before: Any, after: Any, at: float, delta: Any, off: Any) -> None:
    """Write the symbols delta (n,) of the middle lengths at a place of the way, and their errors off (n,)."""
    for i in range(model.n_taut):
        lo = before[i, 0] + at * (after[i, 0] - before[i, 0])
        hi = before[i, 1] + at * (after[i, 1] - before[i, 1])
        middle = 0.5 * lo + 0.5 * hi
        size = model.lengths_sq_err[i]
        delta[i] = min(max((middle * middle - model.lengths_sq[i]) / size, -1.0), 1.0)
        # Where the way goes far the place is as exact as its longer end.
        longest = max(before[i, 1], after[i, 1])
        off[i] = min(10.0 * ROUNDED * longest * longest / size, 2.0)


@kernel()
def polynomial_at(F: Any, c: int, n: int, delta: Any, off: Any) -> tuple[float, float]:
    """Return an unknown's polynomial at delta (n,), and a bound of its error for symbols known to off."""
    row = Z + c
    value, size, slope = F[row, 0, LANE], abs(F[row, 0, LANE]), 0.0
    for i in range(n):
        value += F[row, 1 + i, LANE] * delta[i]
        size += abs(F[row, 1 + i, LANE])
        slope += abs(F[row, 1 + i, LANE]) * off[i]
        for j in range(i, n):
            q = F[row, column_of(i, j), LANE]
            value += q * delta[i] * delta[j]
            size += abs(q)
            slope += abs(q) * (off[i] + off[j]) * 2.0
    return value, (slope + 60.0 * ROUNDED * size) * 1.01


@kernel()
def linked(F: Any, n: int, free: Any, v: Any, w: Any, delta: Any, off: Any, size: float, link: Any) -> bool:
    """Return True when the tube's zero at delta is proved to be the one that ``link`` knows."""
    if link.known[0]:
        for i in range(free.shape[0]):
            c = free[i]
            value, error = polynomial_at(F, c, n, delta, off)
            # Also False for NaN.
            if not up(up(abs(value - link.zero[c]) + error) + link.radii[c]) < v[i]:
                return False
        return True
    box = np.empty((6, 2))
    for i in range(free.shape[0]):
        if free[i] < 6:
            value, error = polynomial_at(F, free[i], n, delta, off)
            error = up(error + w[i])
            box[free[i], 0], box[free[i], 1] = down(value - error), up(value + error)
    return bool(holds(link.region[:6], box, link.region[6], size))


@kernel()
def keep_link(F: Any, n: int, free: Any, w: Any, delta: Any, off: Any, link: Any) -> None:
    """Write the tube's zero at delta to ``link``."""
    link.known[0] = True
    for i in range(free.shape[0]):
        value, error = polynomial_at(F, free[i], n, delta, off)
        link.zero[free[i]], link.radii[free[i]] = value, up(error + w[i])


@part()
def sharpen_link(data: Any, rows: Any, free: Any, before: Any, after: Any, at: float, link: Any) -> None:
    """Contract what ``link`` knows of the zero at a place of the way; lengths in ``data`` are overwritten.

    The radii of a long piece, or of wide ranges, are much more than is known of one choice.
    """
    n = data.shape[0] - 1
    z, box, C = link.zero.copy(), np.empty((6 + n, 2)), np.empty((free.shape[0], free.shape[0]))
    for i in range(n):
        lo = before[i, 0] + at * (after[i, 0] - before[i, 0])
        hi = before[i, 1] + at * (after[i, 1] - before[i, 1])
        middle, longest = 0.5 * lo + 0.5 * hi, max(before[i, 1], after[i, 1])
        off = 10.0 * ROUNDED * longest * longest
        data[i, 6, 0], data[i, 6, 1] = down(middle * middle - off), up(middle * middle + off)
    for c in range(6 + n):
        box[c, 0] = box[c, 1] = z[c]
    for i in range(free.shape[0]):
        c = free[i]
        box[c, 0], box[c, 1] = down(z[c] - link.radii[c]), up(z[c] + link.radii[c])
    newton.improve(data, rows, free, z, C, NEWTON_STEPS)
    for _ in range(CONTRACTIONS):
        contract(data, rows, free, C, box)
    for i in range(free.shape[0]):
        c = free[i]
        middle = 0.5 * box[c, 0] + 0.5 * box[c, 1]
        link.zero[c] = middle
        link.radii[c] = up(max(box[c, 1] - middle, middle - box[c, 0]))


@kernel()
def carries_with(F: Any, S: Symbols, own: int, other: int) -> bool:
    """Prove that a row is positive wherever another one is not negative: it is above c times that, c >= 0."""
    product, square = 0.0, 0.0
    for k in range(1, 1 + len(S.noise)):
        product += F[own, k, LANE] * F[other, k, LANE]
        square += F[other, k, LANE] * F[other, k, LANE]
    if not (product > 0.0 and square > 0.0):
        return False
    combine2(F, OUT, own, splat(1.0), other, splat(-product / square), S)
    lo, _ = bounds(F, OUT, S)
    return first_lane(lo, F) > 0.0


@kernel()
def carries(F: Any, S: Symbols, model: Any, chart: int, free: Any, w: Any, switching: int) -> tuple[int, int]:
    """Prove along the tube that taut cables carry and the others do not; else return why not and the cable.

    Of a taut one that is ``switching`` nothing is asked, and of the other tensions only where its is not
    negative. The polynomial in the rows Z is left without errors.
    """
    n, K = model.n_taut, len(S.noise)
    errors = 1 + K + K * (K + 1) // 2
    for i in range(free.shape[0]):
        store(F, Z + free[i], errors, splat(w[i]))
    status, cable = TRACKED, -1
    for i in range(n):
        lo, _ = bounds(F, Z + 6 + i, S)
        if i == switching or first_lane(lo, F) > 0.0:
            continue
        if switching < 0 or not carries_with(F, S, Z + 6 + i, Z + 6 + switching):
            status, cable = LOOSE, i
    if status == TRACKED:
        rotation_forms(F, S)
        for j in range(n, model.lengths.shape[0]):
            if not first_lane(excess(F, model, chart, j, S), F) < 0.0:
                status, cable = TIGHT, j
    for i in range(free.shape[0]):
        as_polynomial(F, Z + free[i], S)
    return status, cable


@kernel()
def end_box(F: Any, model: Any, after: Any, free: Any, w: Any, z: Any, box: Any) -> None:
    """Write bounds (6 + n, 2) of the zeros for the lengths ``after`` to box, their middles to z (6 + n,)."""
    n = model.n_taut
    middle, half, off = np.empty(n), np.empty(n), np.zeros(n)
    for i in range(n):
        lo, hi = interval.sqr(after[i, 0], after[i, 1])
        size = model.lengths_sq_err[i]
        slack = 10.0 * ROUNDED * (1.0 + model.lengths_sq[i] / size)
        first = max((lo - model.lengths_sq[i]) / size - slack, -1.0)
        last = min((hi - model.lengths_sq[i]) / size + slack, 1.0)
        middle[i] = 0.5 * first + 0.5 * last
        half[i] = max(last - middle[i], middle[i] - first) * (1.0 + 4.0 * ROUNDED)
    for i in range(free.shape[0]):
        row = Z + free[i]
        value, radius = polynomial_at(F, free[i], n, middle, off)
        for a in range(n):
            slope = F[row, 1 + a, LANE]
            for b in range(n):
                q = F[row, column_of(min(a, b), max(a, b)), LANE]
                slope += (2.0 if a == b else 1.0) * q * middle[b]
                radius += (1.0 if a == b else 0.5) * abs(q) * half[a] * half[b]
            radius += abs(slope) * half[a]
        radius = up(radius * (1.0 + 1e-12) + w[i])
        z[free[i]] = value
        box[free[i], 0], box[free[i], 1] = down(value - radius), up(value + radius)


@kernel()
def times_scale(z: Any, C: Any) -> None:
    """Make of the inverse C (m, m) of the derivatives of ``six_dof.system`` that of ``form_system``'s.

    At a zero the latter are s = 1 + |u|^2 times the former.
    """
    s = 1.0 + z[0] * z[0] + z[1] * z[1] + z[2] * z[2]
    for i in range(C.shape[0]):
        for j in range(C.shape[0]):
            C[i, j] /= s


@kernel()
def note_part(
    F: Any, model: Any, before: Any, after: Any, first: float, last: float, free: Any, w: Any, note: Any
) -> None:
    """Write where a part of the way begins and ends, and bounds of its zeros for all choices, to ``note``.

    The bounds are the hull of those of shorter parts: along the way the lengths change together.
    """
    count = before.shape[0]
    lengths, z, box = np.empty((count, 2)), np.empty(6 + model.n_taut), np.empty((6 + model.n_taut, 2))
    note[0, 0], note[0, 1] = first, last
    note[1:, 0], note[1:, 1] = np.inf, -np.inf
    here = first
    for k in range(1, NOTED_PARTS + 1):
        there = last if k == NOTED_PARTS else first + (last - first) * (k / NOTED_PARTS)
        for i in range(count):
            lengths[i, 0], lengths[i, 1] = piece_of_way(before, after, here, there, i)
        end_box(F, model, lengths, free, w, z, box)
        for i in range(free.shape[0]):
            note[1 + free[i], 0] = min(note[1 + free[i], 0], box[free[i], 0])
            note[1 + free[i], 1] = max(note[1 + free[i], 1], box[free[i], 1])
        here = there


@part()
def prove_piece(
    F: Any,
    S: Any,
    model: Any,
    data: Any,
    chart: int,
    rows: Any,
    free: Any,
    link: Any,
    z: Any,
    C: Any,
    v: Any,
    w: Any,
    E: Any,
) -> bool:
    """Prove a tube over the lengths in the model, from a float pose z (6 + n,) near it."""
    if not newton.improve(data, rows, free, z, C, NEWTON_STEPS):
        return False
    times_scale(z, C)
    polynomial(F, S, model, chart, rows, free, NONE, z, C)
    extents(F, free, SHARE, v, S)
    moved_by_errors(F, C, w, S)
    is_vague = False
    for i in range(free.shape[0]):
        if v[i] < ABOVE_ERRORS * w[i]:
            v[i], is_vague = ABOVE_ERRORS * w[i], True
    if link.known[0]:
        for i in range(free.shape[0]):
            v[i] = max(v[i], (VAGUE_ROOM if is_vague else ROOM) * link.radii[free[i]])
    levelled(F, model.size, free, v)
    most = MOST_OVER
    for _ in range(WIDER_TRIES):
        if proved_within(F, S, model, chart, rows, free, NONE, C, v, w, E):
            return True
        over = 0.0
        for i in range(free.shape[0]):
            over = max(over, w[i] / v[i])
            v[i] = max(v[i], WIDER * w[i])
        if not over < most:
            break
        most = over
    return False


@part()
def try_piece(
    F: Any, S: Any, model: Any, data: Any, chart: int, rows: Any, free: Any, before: Any, after: Any,
    here: float, there: float, link: Any, z: Any, C: Any, w: Any,
) -> tuple[int, int]:  # fmt: skip
    """Prove a piece of the way, and write the pose at its end to ``link`` and z; else say why not."""
    n, m = model.n_taut, free.shape[0]
    v, E, delta, off, at = np.empty(m), np.empty((m, m, 2)), np.empty(n), np.empty(n), z.copy()
    put_lengths(model, data, before, after, here, there)
    if not prove_piece(F, S, model, data, chart, rows, free, link, at, C, v, w, E):
        return GONE, -1
    place_on(model, before, after, here, delta, off)
    if not linked(F, n, free, v, w, delta, off, model.size, link):
        return OTHER, -1
    status, cable = carries(F, S, model, chart, free, w, NONE)
    if status == TRACKED:
        place_on(model, before, after, there, delta, off)
        keep_link(F, n, free, w, delta, off, link)
        if (w > VAGUE_LINK * v).any():
            sharpen_link(data, rows, free, before, after, there, link)
        for i in range(m):
            z[free[i]] = link.zero[free[i]]
    return status, cable


@part()
def contracted(data: Any, rows: Any, free: Any, after: Any, z: Any, C: Any, box: Any) -> None:
    """Contract the bounds (6 + n, 2) of the zeros for the lengths ``after`` near z."""
    # Where Newton's method goes the derivative's inverse is better; any will do for a proof.
    at = z.copy()
    for i in range(data.shape[0] - 1):
        middle = 0.5 * after[i, 0] + 0.5 * after[i, 1]
        data[i, 6, 0] = data[i, 6, 1] = middle * middle
    newton.improve(data, rows, free, at, C, NEWTON_STEPS)
    for i in range(data.shape[0] - 1):
        data[i, 6, 0], data[i, 6, 1] = interval.sqr(after[i, 0], after[i, 1])
    for _ in range(CONTRACTIONS):
        contract(data, rows, free, C, box)


@entry()
def follow(
    F: Any, S: Any, model: Any, data: Any, chart: int, rows: Any, free: Any, before: Any, after: Any,
    start: float, near: float, link: Any, z: Any, box: Any, notes: Any,
) -> tuple[int, int, int, float, float]:  # fmt: skip
    """Prove the pose that the last one becomes while the lengths go straight from ``before`` to ``after``.

    Parameters
    ----------
    start : float
        The share of the way that is proved already; 1: only for the lengths after.
    near : float
        Shortest piece, over the whole way, that is tried where a cable may switch.
    link : Link
        What is known of the last pose; written.
    z : (6 + n,)
        The last pose, and where a pose was found, written.
    box : (6 + n, 2)
        Where followed, the enclosure of the pose for all lengths after.
    notes : (K, 7 + n, 2)
        Written, for the first K pieces; K may be 0.

    Returns
    -------
    status, pieces, cable, way, step
        ``TRACKED`` and how many pieces that took, or why not, and the cable at fault among the model's, -1
        for none; how much of the way is proved, and the last step tried.

    Guarantee
    ---------
    That of the module, with TRACKED.
    """
    C, w = np.empty((free.shape[0], free.shape[0])), np.empty(free.shape[0])
    here, step, pieces, status, cable = start, 1.0 - start, 0, GONE, -1
    for _ in range(MOST_PIECES):
        there = min(here + step, 1.0)
        status, cable = try_piece(
            F, S, model, data, chart, rows, free, before, after, here, there, link, z, C, w
        )
        if status == TRACKED:
            if pieces < notes.shape[0]:
                note_part(F, model, before, after, here, there, free, w, notes[pieces])
            here, step, pieces = there, 2.0 * step, pieces + 1
            if here == 1.0:
                end_box(F, model, after, free, w, z, box)
                contracted(data, rows, free, after, z, C, box)
                return TRACKED, pieces, -1, 1.0, step
        else:
            step *= 0.5
            if step < (near if cable >= 0 else SHORTEST):
                return status, pieces, cable, here, step
    return GONE, pieces, -1, here, step
