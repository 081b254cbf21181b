"""Across a place where a cable becomes slack or taut, compiled: its two systems proved as a pair.

Each has a tube over the same lengths (``mechanics.six_dof.tube``), and for every choice exactly one of the
two zeros is a static pose, or both are the same; see ``cross``.

Arrays, for n taut cables, the one that may switch the last, and m = 6 + n equations: as in ``continuation``;
``slack_data`` (n, 7, 2) is ``data`` without that cable; ``A, B`` (m, m) are inverses of the derivatives with
t_k = 0 and with its length, ``E`` (m, m, 2); ``v, w, apart, slack_w`` (m,) are radii; ``slack_z`` (6 + n,),
``slack_box`` (6 + n, 2); ``notes`` (4, 7 + n, 2) are ``note`` of ``continuation``; ``link`` is a ``Link`` to
the zero with the cable's length, ``slack_link`` is a ``Link`` to that without tension.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.kernels import interval
from cdpr_interval.kernels.kernel import entry, kernel, part
from cdpr_interval.kernels.lanes import splat
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.kernels.second_order import bounds, combine2, constant, copy, largest
from cdpr_interval.mechanics.six_dof import system as newton
from cdpr_interval.mechanics.six_dof.form_system import Z
from cdpr_interval.mechanics.six_dof.tube import (
    GIVEN,
    INVERSE,
    NONE,
    OUT,
    SLACK_ONE,
    TAUT_ONE,
    extents,
    first_lane,
    inverse_at,
    moved_by_errors,
    place,
    polynomial,
    proved_within,
)
from cdpr_interval.mechanics.six_dof.tube_terms import levelled
from solvers.six_dof.continuation import (
    ROOM,
    SHARE,
    SHORTEST,
    VAGUE_ROOM,
    carries,
    end_box,
    keep_link,
    linked,
    note_part,
    piece_of_way,
    place_on,
    polynomial_at,
    put_lengths,
    sharpen_link,
    times_scale,
)
from solvers.six_dof.track import NEWTON_STEPS, TRACKED

APART = 1.25
"""Radii over the distance of the two zeros of a cable that may switch, and what errors move both."""
SLACK_NOW, TAUT_NOW, OPEN_NOW = range(3)
"""What the cable that may switch is at a place of the way: for all choices, or the one or the other."""
FINEST = 1.0 / 4096.0
"""Parts of a piece in which it is found where a cable switches."""


@kernel()
def copy_polynomial(F: Any, S: Any, source: int, out: int, count: int) -> None:
    """Copy the rows of so many unknowns."""
    for c in range(count):
        copy(F, out + c, source + c, S)


@kernel()
def one_way(F: Any, S: Any, E: Any, v: Any, k: int) -> bool:
    """Prove that more t_k draws the platform's point nearer, for all matrices of the last proof with cable k.

    That is, the entry of t_k in y = J^-1 e_k is negative, row k being s (|e_k|^2 - l_k^2). y solves y = C e_k
    + E y: with g the growth of E in the norm of v, the entry differs from that of C(delta) e_k by at most v_k
    g / (1 - g) times the norm of C(delta) e_k.
    """
    m = v.shape[0]
    growth, norm = 0.0, 0.0
    for i in range(m):
        total = 0.0
        for j in range(m):
            total = up(total + up(interval.mag(E[i, j, 0], E[i, j, 1]) * v[j]))
        growth = max(growth, up(total / v[i]))
        norm = max(norm, up(first_lane(largest(F, INVERSE + place(i, k), S), F) / v[i]))
    _, hi = bounds(F, INVERSE + place(6 + k, k), S)
    off = up(up(up(v[6 + k] * growth) / down(1.0 - growth)) * norm)
    return growth < 1.0 and first_lane(hi, F) < -off


@part()
def both_polynomials(
    F: Any, S: Any, model: Any, data: Any, slack_data: Any, chart: int, radii: Any, z: Any, slack_z: Any,
    B: Any, A: Any, apart: Any, v: Any,
) -> bool:  # fmt: skip
    """Find both systems' tubes over the lengths in the model, and radii v (m,) that hold their difference.

    ``radii`` (6 + n,) are those of what is known of the last pose. ``B``, ``A`` (m, m) are written as
    ``polynomial`` has it, bounds of the difference to ``apart`` (m,).
    """
    n, m = model.n_taut, z.shape[0]
    free, rows, C, other = np.arange(m), np.eye(6), np.empty((m - 1, m - 1)), np.empty(m)
    moved, also = np.empty(m), np.empty(m)
    constant(F, GIVEN, splat(0.0), splat(0.0), S)
    for i in range(n - 1):
        slack_data[i, 6, 0], slack_data[i, 6, 1] = data[i, 6, 0], data[i, 6, 1]
    if not newton.improve(data, rows, free, z, B, NEWTON_STEPS):
        return False
    if not newton.improve(slack_data, rows, free[: m - 1], slack_z[: m - 1], C, NEWTON_STEPS):
        return False
    if not inverse_at(F, S, model, chart, rows, free, n - 1, slack_z, A):
        return False
    times_scale(z, B)
    polynomial(F, S, model, chart, rows, free, NONE, z, B)
    copy_polynomial(F, S, Z, TAUT_ONE, m)
    extents(F, free, SHARE, v, S)
    moved_by_errors(F, B, moved, S)
    polynomial(F, S, model, chart, rows, free, n - 1, slack_z, A)
    copy_polynomial(F, S, Z, SLACK_ONE, m)
    extents(F, free, SHARE, other, S)
    moved_by_errors(F, A, also, S)
    for c in range(m):
        combine2(F, OUT, TAUT_ONE + c, splat(1.0), SLACK_ONE + c, splat(-1.0), S)
        apart[c] = first_lane(largest(F, OUT, S), F)
        least = max(max(v[c], other[c]), APART * (apart[c] + moved[c] + also[c]))
        v[c] = max(least, (ROOM if least > ROOM * moved[c] else VAGUE_ROOM) * radii[c])
    levelled(F, model.size, free, v)
    return True


@part()
def both_proved(
    F: Any, S: Any, model: Any, chart: int, B: Any, A: Any, apart: Any, v: Any, w: Any, slack_w: Any
) -> bool:
    """Prove both tubes, and of every choice that exactly one of the two zeros is a static pose."""
    k, m = model.n_taut - 1, v.shape[0]
    free, rows, E = np.arange(m), np.eye(6), np.empty((m, m, 2))
    copy_polynomial(F, S, SLACK_ONE, Z, m)
    if not proved_within(F, S, model, chart, rows, free, k, A, v, slack_w, E):
        return False
    if carries(F, S, model, chart, free, slack_w, k)[0] != TRACKED:
        return False
    copy_polynomial(F, S, TAUT_ONE, Z, m)
    if not proved_within(F, S, model, chart, rows, free, NONE, B, v, w, E):
        return False
    if not one_way(F, S, E, v, k) or carries(F, S, model, chart, free, w, k)[0] != TRACKED:
        return False
    inside = True
    for c in range(m):
        inside = inside and up(up(apart[c] + w[c]) + slack_w[c]) < v[c]
    return inside


@kernel()
def sure_until(
    F: Any, model: Any, before: Any, after: Any, start: float, end: float, w: Any, is_taut: bool
) -> float:
    """Return how far from start towards end the cable is proved taut, or slack, for all choices.

    That is, how far t_k of the zeros of B has one sign; their polynomial lies in the rows Z.
    """
    n = model.n_taut
    lengths, z, box = np.empty(before.shape), np.empty(6 + n), np.empty((6 + n, 2))
    unknown, radius = np.full(1, 5 + n), np.full(1, w[5 + n])
    here, step, least = start, 0.125 * (end - start), FINEST * abs(end - start)
    while abs(step) > least:
        there = min(max(here + step, min(start, end)), max(start, end))
        for i in range(before.shape[0]):
            lo, hi = piece_of_way(before, after, min(here, there), max(here, there), i)
            lengths[i, 0], lengths[i, 1] = lo, hi
        end_box(F, model, lengths, unknown, radius, z, box)
        if not (box[5 + n, 0] > 0.0 if is_taut else box[5 + n, 1] < 0.0):
            step *= 0.5
            continue
        here, step = there, 2.0 * step
        if here == end:
            break
    return here


@kernel()
def note_switch(
    F: Any, S: Any, model: Any, before: Any, after: Any, start: float, end: float, w: Any, slack_w: Any,
    was: int, now: int, notes: Any,
) -> None:  # fmt: skip
    """Write what is proved before, during and after the switch of a piece to ``notes`` (4, 7 + n, 2).

    What has no extent begins where it ends. During, the zeros of B and those of A are two notes. Both
    polynomials lie in their rows, and that of B in the rows Z, also afterwards. Nothing is written where
    there are no notes.
    """
    if notes.shape[0] == 0:
        return
    free = np.arange(w.shape[0])
    first, last = start, end
    if was != OPEN_NOW:
        first = sure_until(F, model, before, after, start, end, w, was == TAUT_NOW)
    if now != OPEN_NOW:
        last = max(first, sure_until(F, model, before, after, end, start, w, now == TAUT_NOW))
    notes[0, 0], notes[3, 0] = start, end
    note_part(F, model, before, after, first, last, free, w, notes[1])
    if was == TAUT_NOW:
        note_part(F, model, before, after, start, first, free, w, notes[0])
    if now == TAUT_NOW:
        note_part(F, model, before, after, last, end, free, w, notes[3])
    copy_polynomial(F, S, SLACK_ONE, Z, w.shape[0])
    note_part(F, model, before, after, first, last, free, slack_w, notes[2])
    if was == SLACK_NOW:
        note_part(F, model, before, after, start, first, free, slack_w, notes[0])
    if now == SLACK_NOW:
        note_part(F, model, before, after, last, end, free, slack_w, notes[3])
    copy_polynomial(F, S, TAUT_ONE, Z, w.shape[0])


@kernel()
def state_at(F: Any, n: int, delta: Any, off: Any, radius: float) -> int:
    """Return what the last of n taut cables is at delta (n,), by the zero of B in the rows Z."""
    tension, error = polynomial_at(F, 5 + n, n, delta, off)
    # Also open for NaN.
    if not abs(tension) > up(error + radius):
        return OPEN_NOW
    return TAUT_NOW if tension > 0.0 else SLACK_NOW


@kernel()
def known_to(was: int, link: Any, slack_link: Any) -> Any:
    """Return the radii (6 + n,) within which the last pose is known, or both that it may be."""
    if was == OPEN_NOW:
        return np.maximum(link.radii, slack_link.radii)
    return link.radii if was == TAUT_NOW else slack_link.radii


@entry()
def cross(
    F: Any, S: Any, model: Any, data: Any, slack_data: Any, chart: int, before: Any, after: Any,
    start: float, first_step: float, was: int, link: Any, slack_link: Any, z: Any, box: Any, slack_box: Any,
    notes: Any,
) -> tuple[bool, float, int]:  # fmt: skip
    """Prove a piece of the way on which the last taut cable of the model may become slack, or taut again.

    Two systems have the same unknowns: in B the cable k has its length, in A t_k = 0. Over the lengths of the
    piece each has a tube, and both zeros of one choice, with the line between them, lie within v of either's
    polynomial. The mean value theorem in its integral form, with J_A and J_B the means of the derivatives
    over that line, which only differ in row k, gives for d = z_B - z_A

        J_A d = t_k(z_B) e_k,    row k of J_B d = s (l_k^2 - |e_k(z_A)|^2),

    so that s (l_k^2 - |e_k(z_A)|^2) is t_k(z_B) over the entry of ``one_way``, which is negative: t_k(z_B) >
    0 exactly where cable k is too short for z_A. So for every choice one of the two is a static pose and the
    other is none, or both are the same; there is no third within v, and the pose moves continuously.

    Parameters
    ----------
    slack_data : (n, 7, 2)
        As ``data``, without the cable.
    was, link, slack_link, z
        What the cable is in the last pose; what is known of that pose; its floats. Written.
    box, slack_box : (6 + n, 2)
        Bounds of both zeros for all lengths after, where the piece ends there.
    notes : (4, 7 + n, 2) or (0, 7 + n, 2)
        Written, if there are any: see ``note_switch``.

    Returns
    -------
    proved, way, now
        How much of the way is proved now, and what the cable is at its end, for the lengths' middles.
    """
    n, m = model.n_taut, z.shape[0]
    k, free, rows = n - 1, np.arange(m), np.eye(6)
    B, A, apart, v = np.empty((m, m)), np.empty((m, m)), np.empty(m), np.empty(m)
    w, slack_w, delta, off = np.empty(m), np.empty(m), np.empty(n), np.empty(n)
    step, least = min(first_step, 1.0 - start), min(SHORTEST, 1.0 - start)
    radii = known_to(was, link, slack_link)
    while step >= least:
        there = min(start + step, 1.0)
        step *= 0.5
        put_lengths(model, data, before, after, start, there)
        at, slack_at = z.copy(), z.copy()
        slack_at[6 + k] = 0.0
        if not both_polynomials(F, S, model, data, slack_data, chart, radii, at, slack_at, B, A, apart, v):
            continue
        if not both_proved(F, S, model, chart, B, A, apart, v, w, slack_w):
            continue
        place_on(model, before, after, start, delta, off)
        copy_polynomial(F, S, SLACK_ONE, Z, m)
        if was != TAUT_NOW and not linked(F, n, free, v, slack_w, delta, off, model.size, slack_link):
            continue
        copy_polynomial(F, S, TAUT_ONE, Z, m)
        if was != SLACK_NOW and not linked(F, n, free, v, w, delta, off, model.size, link):
            continue
        place_on(model, before, after, there, delta, off)
        now = state_at(F, n, delta, off, w[6 + k])
        note_switch(F, S, model, before, after, start, there, w, slack_w, was, now, notes)
        end_box(F, model, after, free, w, z, box)
        keep_link(F, n, free, w, delta, off, link)
        sharpen_link(data, rows, free, before, after, there, link)
        copy_polynomial(F, S, SLACK_ONE, Z, m)
        end_box(F, model, after, free, slack_w, z, slack_box)
        keep_link(F, n, free, slack_w, delta, off, slack_link)
        sharpen_link(slack_data, rows, free[: m - 1], before, after, there, slack_link)
        z[:] = slack_link.zero if now == SLACK_NOW else link.zero
        return True, there, now
    return False, start, was
