"""Where the centre of mass can be in a cell, before any form is made: a box cut by the paths of all cables.

With p = p_c + q, X_i = p + R(u) b_i is within |q| + delta_i of X0_i = p_c + R(u_c) b_i, where R(u) and R(v)
differ by an angle of at most 2 |u - v|, so that delta_i <= 2 |u - u_c| |b_i|. A path length has slope one and
bends by at most H+ = 1 / sigma, with two joints max(1 / sigma, 1 / x), and at least -H- = min(0, 1 - (h + r)
/ x) / sigma, so

    -delta_i - H- d^2 / 2 <= L(X) - L0 - a0 . q <= delta_i + H+ d^2 / 2,     d = |q| + delta_i.

Each taut cable so bounds a0 . q from both sides, each slack one from above, and three together bound q.

Arrays: ``real`` is a ``RealModel``; ``C`` (1, width, LANES) cells, columns ``REAL_COLUMNS``; ``desk`` is a
``Desk``; ``seen`` (N, SEEN) cables; ``triple`` (3,) indices.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.mechanics.rotation import HALF_TURNS, rotation_at
from solvers.six_dof.real.columns import (
    ALONG,
    AWAY,
    CENTRE,
    DENSITIES,
    DRIFT,
    FARTHEST,
    FREE,
    HELD,
    HIGHEST,
    HUB,
    LEAST_FREE,
    LEAST_SIDE,
    LOWEST,
    NEAREST,
    NEXT,
    OFF_LENGTH,
    OFF_POINT,
    PATH,
    REACH,
    REAL_COLUMNS,
    SEEN,
    SIZE,
    SPOT,
    WAY,
)
from solvers.six_dof.real.path import ROUNDING, around, around_simple, see, see_simple

LOOKS = 5
"""Most times that all cables cut a box."""
STEPS = 8
"""Steps of the perceptron that looks for directions along which all ropes pull back."""
SHAVINGS = 2
"""Times that all shells cut a box in one look."""
GAIN = 0.75
"""Share of its width that a look must take a side to, for another look."""
NARROW = 4.0
"""Reach over the free length at which the forms of a cell are made."""
POSITION_SHARE = 2.0
"""How wide positions may be over what the rotations move the platform by: wider ones are bisected first."""
LEAST_VOLUME = 1e-2
"""Least volume that three directions span to be solved for positions."""
EMPTY, WIDE, READY = range(3)
"""What a survey says of a cell."""


class Desk(NamedTuple):
    """Where one thread surveys cells."""

    seen: NDArray[np.float64]
    """(N, SEEN)."""
    bounds: NDArray[np.float64]
    """(N, 2) of a0 . q."""
    smooth: NDArray[np.bool_]
    """(N,)."""
    held: NDArray[np.float64]
    """(LANES, HELD)."""
    spots: NDArray[np.float64]
    """(N, SPOT, LANES)."""
    turn: NDArray[np.float64]
    """(3, 3) R(u_c) D_c."""
    middle: NDArray[np.float64]
    """(3,) u_c."""
    inverse: NDArray[np.float64]
    """(3, 3) of the triple's directions."""


def new_desk(count: int, lanes: int) -> Desk:
    """Return arrays for ``count`` cables."""
    return Desk(
        np.zeros((count, SEEN)),
        np.zeros((count, 2)),
        np.zeros(count, dtype=np.bool_),
        np.zeros((lanes, HELD)),
        np.zeros((count, SPOT, lanes)),
        np.zeros((3, 3)),
        np.zeros(3),
        np.zeros((3, 3)),
    )


@kernel()
def half_widths(C: Any, lane: int, first: int) -> float:
    """Return the norm of the half widths of three variables, from above."""
    total = 0.0
    for k in range(3):
        w = 0.5 * (C[0, first + 2 * k + 1, lane] - C[0, first + 2 * k, lane])
        total += w * w
    return float(math.sqrt(total) * (1.0 + 1e-14) + 1e-300)


@kernel()
def look_at(real: Any, C: Any, lane: int, turned: float, desk: Any) -> bool:
    """See all cables from the middle of the cell; False when one of them cannot have its length.

    Writes ``seen``, ``smooth`` and, of smooth cables, the bounds of a0 . q.
    """
    # Without a call for cables that are not simple the loop over them is a seventh faster.
    if real.is_simple:
        return look_at_simple(real, C, lane, turned, desk)
    return look_at_any(real, C, lane, turned, desk)


@kernel()
def look_at_simple(real: Any, C: Any, lane: int, turned: float, desk: Any) -> bool:
    """As `look_at`, where all cables are simple."""
    return bool(look_with(see_simple, around_simple, real, C, lane, turned, desk))


@kernel()
def look_at_any(real: Any, C: Any, lane: int, turned: float, desk: Any) -> bool:
    """As `look_at`, of any cables."""
    return bool(look_with(see, around, real, C, lane, turned, desk))


@kernel(inline="always")
def look_with(see: Any, around: Any, real: Any, C: Any, lane: int, turned: float, desk: Any) -> bool:
    """As `look_at`, with the kernels that see one cable and bound it."""
    held, seen = desk.held, desk.seen
    half = half_widths(C, lane, 6)
    for k in range(3):
        held[lane, CENTRE + k] = 0.5 * (C[0, 6 + 2 * k, lane] + C[0, 7 + 2 * k, lane])
    for i in range(real.exits.shape[0]):
        x0, x1, x2 = held[lane, CENTRE], held[lane, CENTRE + 1], held[lane, CENTRE + 2]
        for j in range(3):
            x0 += desk.turn[0, j] * real.arms[i, j]
            x1 += desk.turn[1, j] * real.arms[i, j]
            x2 += desk.turn[2, j] * real.arms[i, j]
        see(real, i, x0, x1, x2, seen)
        seen[i, WAY], seen[i, WAY + 1] = x0 - real.exits[i, 0], x1 - real.exits[i, 1]
        seen[i, WAY + 2] = x2 - real.exits[i, 2]
        off = 2.0 * ROUNDING * seen[i, SIZE] + real.shift[i, 0] + real.shift[i, 1] * seen[i, AWAY]
        delta = turned * real.arm_lengths[i] * (1.0 + 1e-12) + off
        reach = half + delta
        is_taut = i < real.n_taut
        desk.smooth[i] = around(real, i, reach, seen)
        seen[i, LOWEST], seen[i, HIGHEST] = real.paths[i, 0], real.paths[i, 1]
        if is_taut and real.compliance[i, 1] > 0.0 and not stretch(real, C, lane, i, desk):
            return False
        low, high = seen[i, LOWEST], seen[i, HIGHEST]
        if seen[i, AWAY] - reach + real.least_excess[i] > high:
            return False
        if is_taut and seen[i, AWAY] + reach + real.most_excess[i] < low:
            return False
        shell(real, i, x0, x1, x2, reach, delta, desk, lane)
        if not desk.smooth[i]:
            continue
        sigma = seen[i, LEAST_FREE]
        above = 0.5 * reach * reach / sigma
        below = 0.0
        if real.radius[i] > 0.0:
            # By how much a may turn at all, or by the second derivative.
            below = min(2.0 * reach, (reach + seen[i, DRIFT]) / sigma * reach)
            most = below
            if seen[i, LEAST_SIDE] > 0.0:
                bend = max(0.0, (real.arm[i] + real.radius[i]) / seen[i, LEAST_SIDE] - 1.0)
                below = min(below, bend * above)
            if real.joints[i] == 2:
                bend = sigma / seen[i, LEAST_SIDE] if seen[i, LEAST_SIDE] > 0.0 else math.inf
                above = max(above, min(most, bend * above))
        near = seen[i, OFF_LENGTH] + 2.0 * seen[i, OFF_POINT] * reach / sigma
        desk.bounds[i, 1] = high - seen[i, PATH] + (delta + below + near) * (1.0 + 1e-12)
        desk.bounds[i, 0] = -math.inf
        if is_taut:
            desk.bounds[i, 0] = low - seen[i, PATH] - (delta + above + near) * (1.0 + 1e-12)
    return True


@kernel()
def pulled(real: Any, C: Any, lane: int, v0: float, v1: float, v2: float, desk: Any) -> bool:
    """Bound the densities of the taut cables by the forces along a v; False where they cannot balance.

    sum t_i (X_i - T_i) . v = f . v with t_i >= 0: where all (X_i - T_i) . v are positive, f . v is, and
    bounds each t_i.
    """
    load = real.load[0] * v0 + real.load[1] * v1 + real.load[2] * v2
    off = real.load_err[0] + real.load_err[1] + real.load_err[2]
    off += ROUNDING * (abs(real.load[0]) + abs(real.load[1]) + abs(real.load[2]))
    for i in range(real.n_taut):
        if not along(real, i, v0, v1, v2, desk) > 0.0:
            return True
    # The direction is a unit vector but for rounding.
    if load + 2.0 * off <= 0.0:
        return False
    for i in range(real.n_taut):
        k = DENSITIES + 2 * i
        most = (load + 2.0 * off) / along(real, i, v0, v1, v2, desk) * (1.0 + 1e-12)
        C[0, k + 1, lane] = min(C[0, k + 1, lane], most)
    return True


@kernel()
def along(real: Any, i: int, v0: float, v1: float, v2: float, desk: Any) -> float:
    """Return a lower bound of (X - T) . v of a taut cable over the cell."""
    seen = desk.seen
    if desk.smooth[i]:
        drift = seen[i, DRIFT] + ROUNDING * seen[i, SIZE]
        total = seen[i, ALONG] * v0 + seen[i, ALONG + 1] * v1 + seen[i, ALONG + 2] * v2
        return float(
            total * seen[i, FREE] - (seen[i, REACH] + drift) * (1.0 + 1e-12) - 2.0 * seen[i, OFF_POINT]
        )
    total = seen[i, WAY] * v0 + seen[i, WAY + 1] * v1 + seen[i, WAY + 2] * v2
    far = seen[i, REACH] + real.foot_reach[i] + real.shift[i, 0] + 2.0 * ROUNDING * seen[i, SIZE]
    return float(total - far * (1.0 + 1e-12))


@kernel()
def held_up(real: Any, C: Any, lane: int, desk: Any) -> bool:
    """Bound the densities by the forces along some directions; False where they cannot balance the load.

    The directions are the load's, and two that a perceptron finds: with all ropes pulling back, and with the
    load not pulling forward besides.
    """
    f0, f1, f2 = real.load[0], real.load[1], real.load[2]
    size = math.sqrt(f0 * f0 + f1 * f1 + f2 * f2)
    if not size > 0.0:
        return True
    f0, f1, f2 = f0 / size, f1 / size, f2 / size
    if not pulled(real, C, lane, f0, f1, f2, desk):
        return False
    for turn in range(2):
        v0, v1, v2 = 0.0, 0.0, 0.0
        if turn == 1:
            v0, v1, v2 = -f0, -f1, -f2
        for i in range(real.n_taut):
            away = desk.seen[i, AWAY]
            v0 += desk.seen[i, WAY] / away
            v1 += desk.seen[i, WAY + 1] / away
            v2 += desk.seen[i, WAY + 2] / away
        for _ in range(STEPS):
            size = math.sqrt(v0 * v0 + v1 * v1 + v2 * v2)
            if not size > 1e-6:
                break
            worst, place = 0.0, -1
            if turn == 1:
                worst = -(f0 * v0 + f1 * v1 + f2 * v2) / size - 1e-9
                place = real.n_taut if worst < 0.0 else -1
            for i in range(real.n_taut):
                now = along(real, i, v0 / size, v1 / size, v2 / size, desk) / desk.seen[i, AWAY]
                if now <= worst or (place < 0 and now <= 0.0):
                    worst, place = now, i
            if place < 0 or worst > 0.0:
                if not pulled(real, C, lane, v0 / size, v1 / size, v2 / size, desk):
                    return False
                break
            if place == real.n_taut:
                v0, v1, v2 = v0 - f0, v1 - f1, v2 - f2
            else:
                away = desk.seen[place, AWAY]
                v0 += desk.seen[place, WAY] / away
                v1 += desk.seen[place, WAY + 1] / away
                v2 += desk.seen[place, WAY + 2] / away
    return True


@kernel()
def stretch(real: Any, C: Any, lane: int, i: int, desk: Any) -> bool:
    """Bound path length and density of a cable that stretches by each other; False: it has none.

    L = l + c t sigma; L and sigma have slopes of at most 1 and 1 + sway / sigma in X.
    """
    seen = desk.seen
    reach = seen[i, REACH]
    if desk.smooth[i]:
        off = (1.0 + real.sway[i] / seen[i, LEAST_FREE]) * reach + 2.0 * seen[i, OFF_POINT]
        near, far = seen[i, LEAST_FREE] * (1.0 - 1e-12), (seen[i, FREE] + off) * (1.0 + 1e-12)
        off = (reach + seen[i, OFF_LENGTH]) * (1.0 + 1e-12)
        least, most = seen[i, PATH] - off, seen[i, PATH] + off
    else:
        near, far = (
            0.0,
            (seen[i, AWAY] + reach + real.foot_reach[i]) * (1.0 + 1e-12) + ROUNDING * seen[i, SIZE],
        )
        least = seen[i, AWAY] - reach + real.least_excess[i]
        most = seen[i, AWAY] + reach + real.most_excess[i]
    k = DENSITIES + 2 * i
    room = ROUNDING * (seen[i, SIZE] + real.lengths[i, 1])
    lowest = (least - real.lengths[i, 1] - room) / (real.compliance[i, 1] * far)
    C[0, k, lane] = max(C[0, k, lane], lowest * (1.0 - 1e-12 if lowest > 0.0 else 1.0 + 1e-12))
    if near > 0.0 and real.compliance[i, 0] > 0.0:
        highest = (most - real.lengths[i, 0] + room) / (real.compliance[i, 0] * near)
        C[0, k + 1, lane] = min(C[0, k + 1, lane], highest * (1.0 + 1e-12 if highest > 0.0 else 1.0 - 1e-12))
    if not C[0, k, lane] <= C[0, k + 1, lane]:
        return False
    low = real.lengths[i, 0] + real.compliance[i, 0] * C[0, k, lane] * near
    high = real.lengths[i, 1] + real.compliance[i, 1] * C[0, k + 1, lane] * far
    seen[i, LOWEST] = low * (1.0 - 1e-14)
    seen[i, HIGHEST] = min(seen[i, HIGHEST], high * (1.0 + 1e-14))
    return bool(seen[i, LOWEST] <= seen[i, HIGHEST])


@kernel()
def shell(
    real: Any, i: int, x0: float, x1: float, x2: float, reach: float, delta: float, desk: Any, lane: int
) -> None:
    """Write between which distances from A - R(u_c) b the path of a cable keeps the centre of mass.

    L - |X - A| lies between two constants; where the cable is smooth it has slope a - (X - A) / |X - A|, at
    most (h + r) / (|X - A| - h - r) since T is within h + r of A, also of a rope that has lifted off.
    """
    seen = desk.seen
    for k in range(3):
        x = x0 if k == 0 else (x1 if k == 1 else x2)
        seen[i, HUB + k] = real.exits[i, k] - (x - desk.held[lane, CENTRE + k])
    least, most = real.least_excess[i], real.most_excess[i]
    if desk.smooth[i] and real.radius[i] > 0.0:
        far = real.arm[i] + real.radius[i]
        room = seen[i, AWAY] - reach - far
        if room > 0.0:
            change = far / room * reach * (1.0 + 1e-12) + 2.0 * seen[i, OFF_LENGTH]
            excess = seen[i, PATH] - seen[i, AWAY]
            least, most = max(least, excess - change), min(most, excess + change)
    off = delta + ROUNDING * seen[i, SIZE]
    seen[i, FARTHEST] = (seen[i, HIGHEST] - least + off) * (1.0 + 1e-12)
    seen[i, NEAREST] = 0.0
    if i < real.n_taut:
        seen[i, NEAREST] = max(0.0, (seen[i, LOWEST] - most - off) * (1.0 - 1e-12))


@kernel()
def cut_by_shell(C: Any, lane: int, i: int, seen: Any) -> bool:
    """Cut the box to distances between NEAREST and FARTHEST from a hub; False when nothing is left."""
    size = seen[i, SIZE]
    for k in range(3):
        least, most = 0.0, 0.0
        for j in range(3):
            if j != k:
                lo = C[0, 6 + 2 * j, lane] - seen[i, HUB + j]
                hi = C[0, 7 + 2 * j, lane] - seen[i, HUB + j]
                away = max(0.0, max(lo, -hi))
                far = max(-lo, hi)
                least += away * away
                most += far * far
        room = seen[i, FARTHEST] * seen[i, FARTHEST] * (1.0 + 1e-12) - least * (1.0 - 1e-12)
        if room < 0.0:
            return False
        half = math.sqrt(room)
        narrow(C, lane, k, seen[i, HUB + k], -half, half, size)
        gap = seen[i, NEAREST] * seen[i, NEAREST] * (1.0 - 1e-12) - most * (1.0 + 1e-12)
        if gap > 0.0:
            half = math.sqrt(gap) - ROUNDING * size
            hub = seen[i, HUB + k]
            if C[0, 6 + 2 * k, lane] - hub > -half:
                narrow(C, lane, k, hub, half, math.inf, size)
            if C[0, 7 + 2 * k, lane] - hub < half:
                narrow(C, lane, k, hub, -math.inf, -half, size)
        if C[0, 6 + 2 * k, lane] > C[0, 7 + 2 * k, lane]:
            return False
    return True


@kernel()
def cut_by_cable(C: Any, lane: int, i: int, size: float, desk: Any) -> bool:
    """Cut the box by the bounds of a0 . q of one cable; False when nothing is left."""
    total = 0.0
    for k in range(3):
        total += abs(desk.seen[i, ALONG + k]) * farthest(C, lane, k, desk.held[lane, CENTRE + k])
    total *= 1.0 + 1e-12
    low, high = desk.bounds[i, 0], desk.bounds[i, 1]
    if low > total or high < -total:
        return False
    for k in range(3):
        a = desk.seen[i, ALONG + k]
        rest = total - abs(a) * farthest(C, lane, k, desk.held[lane, CENTRE + k]) + ROUNDING * size
        if a > 1e-3:
            narrow(C, lane, k, desk.held[lane, CENTRE + k], (low - rest) / a, (high + rest) / a, size)
        elif a < -1e-3:
            narrow(C, lane, k, desk.held[lane, CENTRE + k], (high + rest) / a, (low - rest) / a, size)
    return not empty_box(C, lane)


@kernel()
def half_width(C: Any, lane: int, k: int) -> float:
    """Return the half width of a position."""
    return float(0.5 * (C[0, 7 + 2 * k, lane] - C[0, 6 + 2 * k, lane]))


@kernel()
def farthest(C: Any, lane: int, k: int, centre: float) -> float:
    """Return how far a position may be from ``centre``, from above."""
    most = max(C[0, 7 + 2 * k, lane] - centre, centre - C[0, 6 + 2 * k, lane])
    return float(most * (1.0 + 1e-14) + 1e-300)


@kernel()
def empty_box(C: Any, lane: int) -> bool:
    """Return True when no position is left."""
    found = False
    for k in range(3):
        found = found or C[0, 6 + 2 * k, lane] > C[0, 7 + 2 * k, lane]
    return found


@kernel()
def narrow(C: Any, lane: int, k: int, centre: float, low: float, high: float, size: float) -> None:
    """Cut position ``k`` to centre + [low, high], but for a rounding of ``size``."""
    low = centre + low - ROUNDING * (size + abs(low))
    high = centre + high + ROUNDING * (size + abs(high))
    if low > C[0, 6 + 2 * k, lane]:
        C[0, 6 + 2 * k, lane] = low
    if high < C[0, 7 + 2 * k, lane]:
        C[0, 7 + 2 * k, lane] = high


@kernel()
def invert(seen: Any, triple: Any, inverse: Any) -> bool:
    """Write the inverse (3, 3) of the directions of three cables; False where they are nearly dependent."""
    for j in range(3):
        a, b = triple[(j + 1) % 3], triple[(j + 2) % 3]
        for k in range(3):
            m, n = ALONG + (k + 1) % 3, ALONG + (k + 2) % 3
            inverse[k, j] = seen[a, m] * seen[b, n] - seen[a, n] * seen[b, m]
    volume = 0.0
    for k in range(3):
        volume += seen[triple[0], ALONG + k] * inverse[k, 0]
    if not abs(volume) > LEAST_VOLUME:
        return False
    for j in range(3):
        for k in range(3):
            inverse[k, j] /= volume
    return True


@kernel()
def cut_by_triple(real: Any, C: Any, lane: int, size: float, desk: Any) -> bool:
    """Cut the box by three cables together; False when nothing is left.

    q = M (a . q) + (I - M A) q; the rounding of I - M A is some units of the sizes in M A.
    """
    triple = real.triple
    for j in range(3):
        if not desk.smooth[triple[j]]:
            return True
    if not invert(desk.seen, triple, desk.inverse):
        return True
    # The box may have been cut to one side of the centre.
    total = 0.0
    for k in range(3):
        total += farthest(C, lane, k, desk.held[lane, CENTRE + k])
    for k in range(3):
        low, high, most = 0.0, 0.0, 0.0
        for j in range(3):
            m, i = desk.inverse[k, j], triple[j]
            a, b = m * desk.bounds[i, 0], m * desk.bounds[i, 1]
            low += min(a, b)
            high += max(a, b)
            most += abs(m)
        off = 8.0 * ROUNDING * (1.0 + most) * (total + abs(low) + abs(high))
        narrow(C, lane, k, desk.held[lane, CENTRE + k], low - off, high + off, size)
    return not empty_box(C, lane)


@kernel()
def turn(C: Any, lane: int, desk: Any) -> float:
    """Write R(u_c) D_c to ``desk.turn``; return by what angle rotations of the cell differ from it."""
    for k in range(3):
        desk.middle[k] = 0.5 * (C[0, 2 * k, lane] + C[0, 2 * k + 1, lane])
    rotation_at(desk.middle, desk.turn)
    chart = int(C[0, REAL_COLUMNS.chart, lane])
    for k in range(3):
        for j in range(3):
            desk.turn[k, j] *= HALF_TURNS[chart, j]
    return float(min(2.0 * half_widths(C, lane, 0), 2.0))


@kernel()
def look_again(real: Any, C: Any, lane: int, desk: Any) -> bool:
    """See all cables of a surveyed cell; False when one of them cannot have its length."""
    return bool(look_at(real, C, lane, turn(C, lane, desk), desk))


@kernel()
def survey(real: Any, C: Any, lane: int, desk: Any) -> int:
    """Cut the positions of a lane's cell; return EMPTY, WIDE (bisect NEXT of ``held``) or READY.

    Guarantee: every pose of the cell whose taut cables have their lengths, the others at most theirs, stays
    in it.
    """
    turned = turn(C, lane, desk)
    count, taut = real.exits.shape[0], real.n_taut
    for _ in range(LOOKS):
        before = max(half_width(C, lane, 0), half_width(C, lane, 1), half_width(C, lane, 2))
        if not look_at(real, C, lane, turned, desk):
            return EMPTY
        if real.elastic and real.statics and not held_up(real, C, lane, desk):
            return EMPTY
        size = desk.seen[0, SIZE]
        for _ in range(SHAVINGS):
            for i in range(count):
                if not cut_by_shell(C, lane, i, desk.seen):
                    return EMPTY
        for i in range(count):
            if desk.smooth[i] and not cut_by_cable(C, lane, i, size, desk):
                return EMPTY
        if taut >= 3 and not cut_by_triple(real, C, lane, size, desk):
            return EMPTY
        if max(half_width(C, lane, 0), half_width(C, lane, 1), half_width(C, lane, 2)) > GAIN * before:
            break
    if not look_at(real, C, lane, turned, desk):
        return EMPTY
    return choose(real, C, lane, desk)


@kernel()
def choose(real: Any, C: Any, lane: int, desk: Any) -> int:
    """Return READY when all taut cables are smooth and far off against the cell; else what to bisect."""
    ready, arm = True, 0.0
    for i in range(real.exits.shape[0]):
        if i < real.n_taut:
            ready = ready and desk.smooth[i] and desk.seen[i, REACH] < NARROW * desk.seen[i, LEAST_FREE]
            arm = max(arm, real.arm_lengths[i])
    desk.held[lane, NEXT] = widest(real, C, lane, arm, POSITION_SHARE)
    return READY if ready else WIDE


@kernel()
def widest(real: Any, C: Any, lane: int, arm: float, share: float) -> int:
    """Return the variable to bisect: a position where the box is wide, else the widest entry of u."""
    best, place = 0, 0
    for k in range(1, 3):
        if C[0, 2 * k + 1, lane] - C[0, 2 * k, lane] > C[0, 2 * best + 1, lane] - C[0, 2 * best, lane]:
            best = k
        if half_width(C, lane, k) > half_width(C, lane, place):
            place = k
    turned = C[0, 2 * best + 1, lane] - C[0, 2 * best, lane]
    return int(3 + place if half_width(C, lane, place) > share * arm * turned else best)
