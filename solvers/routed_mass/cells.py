"""Where else a point mass on routed cables may rest: cells of positions, compiled.

A cable over a pulley is convex as long as its rope leaves outward. In the plane of the cable the half-plane x
> arm + radius (x the distance from the swivel axis) holds no point of the pulley; there the length is convex
and does not fall with x. The supremum of its tangent planes there is convex on all of space and equal to the
length wherever x > arm + radius. So all poses at which every cable is straight or has x > arm + radius are
minima of one convex function, on the same set of reach: where one of them is isolated there is no other. What
is left to search are the cylinders x <= arm + radius around the swivel axes. A cable that is slack by a
margin wider than any way around its pulley counts as one with x > arm + radius. None of this holds with the
bisector, whose direction is no gradient; with two joints where the rope starts so near to A that the pulley
can hang over its start, which leaves points without a way; and where no such pose is known. Then all that is
in reach is searched.

A cell is a row ``x lo, x hi, y lo, y hi, z lo, z hi, share``.

Arrays: ``context`` is ``(data, outward, taut, known, alone, smallest)``: ``data`` a
`solvers.routed_mass.data.Routed` of N cables; ``outward`` is true where a pose as above is proved;
``known`` (3 + m, 2) is the domain of a proved zero of the equations with the m inextensible cables ``taut``
(m,), ascending; ``alone`` is the cable whose poses alone are known, -1 without one; ``smallest`` the smallest
width of a cell. ``box`` (3, 2); ``ways`` (N, WAY, 2); ``gradients`` (N, 3, 2); ``tension`` (N, 2), of a cable
that may be taut without a bound (0, inf); ``y`` (3,) a direction.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels.box import contains
from cdpr_interval.kernels.interval import add, div, mid, mig, mul, sqr, sqrt, sub
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.mechanics.cables.rows import (
    ACROSS,
    ALONG,
    ARM,
    AXIS,
    BALANCED,
    BISECTED,
    EXIT,
    FIXED,
    FREE,
    KIND,
    LEAD_IN,
    LENGTH,
    RADIUS,
    WAY,
)
from cdpr_interval.mechanics.cables.ways import gradient_over, sharpened_length, straight_way, way_over
from solvers.point_mass.cell_rows import box_of, halve, keep, widest
from solvers.routed_mass.balance import pull

SWEEPS = 8
"""Rounds of coordinate descent towards balance: few are enough for a direction."""
TILTS = 3
"""Rounds in which a direction is turned away from cables whose tension has no bound."""


@kernel()
def beyond(route: Any, way: Any) -> bool:
    """Return True when a cable with this way (WAY, 2) is straight or leaves outward on the whole box."""
    if route[KIND, 0] == FIXED:
        return True
    return route[KIND, 0] != BISECTED and way[ACROSS, 0] > up(route[ARM, 1] + route[RADIUS, 1])


@kernel()
def rough_way(route: Any, box: Any, way: Any) -> None:
    """Write length, direction and distance from the axis as far as A tells them, in a tenth of the time.

    The rope leaves within arm + radius of A. It is not shorter than lead-in and line to A less twice that,
    and not longer than `hangs_loose` says.
    """
    straight_way(route, box, way)
    if route[KIND, 0] == FIXED:
        return
    own = up(route[ARM, 1] + route[RADIUS, 1])
    near, far = down(way[FREE, 0] - own), up(way[FREE, 1] + own)
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], route[EXIT + j, 0], route[EXIT + j, 1])
        way[ALONG + j, 0], way[ALONG + j, 1] = -1.0, 1.0
        if near > 0.0:
            lo, hi = div(down(lo - own), up(hi + own), near, far)
            way[ALONG + j, 0], way[ALONG + j, 1] = max(lo, -1.0), min(hi, 1.0)
    way[LENGTH, 0] = max(down(down(way[FREE, 0] + route[LEAD_IN, 0]) - up(2.0 * own)), 0.0)
    way[LENGTH, 1] = up(up(way[FREE, 1] + route[LEAD_IN, 1]) + loop(route))
    square = 0.0
    slo, shi = 0.0, 0.0
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], route[EXIT + j, 0], route[EXIT + j, 1])
        lo, hi = mul(lo, hi, route[AXIS + j, 0], route[AXIS + j, 1])
        slo, shi = add(slo, shi, lo, hi)
    # x^2 = |X - A|^2 - y^2.
    slo, shi = sqr(slo, shi)
    square = down(sqr(way[FREE, 0], way[FREE, 1])[0] - shi)
    way[ACROSS, 0], way[ACROSS, 1] = max(down(math.sqrt(max(square, 0.0))), 0.0), math.inf


@kernel()
def loop(route: Any) -> float:
    """Return what a way is at most longer than lead-in and line to A: arms and a turn around the pulley."""
    return up(4.0 * route[ARM, 1] + up(9.0 * route[RADIUS, 1]))


@kernel()
def hangs_loose(route: Any, length: Any, box: Any) -> bool:
    """Return True when the length (2,) is longer than any way to the box, and than its convex continuation.

    A way is no longer than lead-in + arm, a turn around the pulley, arm + |X - A|. The continuation grows at
    most as fast as the distance from the point at x = arm + radius, y = 0, where it is the length of the way.
    """
    slo, shi = 0.0, 0.0
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], route[EXIT + j, 0], route[EXIT + j, 1])
        lo, hi = sqr(lo, hi)
        slo, shi = add(slo, shi, lo, hi)
    far = sqrt(slo, shi)[1]
    return up(up(far + route[LEAD_IN, 1]) + loop(route)) < length[0]


@kernel()
def is_beyond(data: Any, i: int, box: Any, way: Any) -> bool:
    """Return what `all_beyond` does of one cable with this way (WAY, 2)."""
    route = data[0][i]
    if route[KIND, 0] == BALANCED and not route[LEAD_IN, 0] > up(route[ARM, 1] + route[RADIUS, 1]):
        return False
    loose = route[KIND, 0] != BISECTED and hangs_loose(route, data[2][i], box)
    return loose or beyond(route, way)


@kernel()
def all_beyond(data: Any, box: Any, ways: Any) -> bool:
    """Return True when every cable is straight, leaves outward or hangs loose on the whole box."""
    for i in range(ways.shape[0]):  # noqa: SIM110 - numba compiles no generator expressions
        if not is_beyond(data, i, box, ways[i]):
            return False
    return True


@kernel()
def tensions_over(data: Any, ways: Any, tension: Any) -> bool:
    """Enclose the tensions (N, 2) over a box with these ways; False: a cable is too short."""
    _, elastic, lengths, _, _ = data
    for i in range(lengths.shape[0]):
        if elastic[i]:
            tension[i, 0], tension[i, 1], _, _ = pull(data, i, ways[i])
            continue
        if ways[i, LENGTH, 0] > lengths[i, 1]:
            return False
        tension[i, 0], tension[i, 1] = 0.0, 0.0
        if ways[i, LENGTH, 1] >= lengths[i, 0]:
            tension[i, 1] = math.inf
    return True


@kernel()
def bounded_by_load(data: Any, ways: Any, tension: Any) -> bool:
    """Cut tensions (N, 2) by the balance along the load, if all cables pull against it; False: none left."""
    load = data[4]
    count = tension.shape[0]
    e = np.empty(3)
    size = 0.0
    for j in range(3):
        e[j] = mid(load[j, 0], load[j, 1])
        size += e[j] * e[j]
    size = math.sqrt(size)
    along, shares = 0.0, np.empty(count)
    for j in range(3):
        e[j] /= size
        along = up(along + mul(e[j], e[j], load[j, 0], load[j, 1])[1])
    for i in range(count):
        total = 0.0
        for j in range(3):
            total = down(total + mul(e[j], e[j], ways[i, ALONG + j, 0], ways[i, ALONG + j, 1])[0])
        shares[i] = total
        if tension[i, 1] > 0.0 and not total > 0.0:
            return True
    for i in range(count):
        if tension[i, 1] > 0.0:
            tension[i, 1] = min(tension[i, 1], up(along / shares[i]))
            if tension[i, 0] > tension[i, 1]:
                return False
    return True


@kernel()
def best_direction(data: Any, ways: Any, tension: Any, y: Any) -> None:
    """Write what of the load the cables leave at the middle of a box, y (3,), by coordinate descent."""
    load = data[4]
    count = tension.shape[0]
    t, a = np.empty(count), np.empty((count, 3))
    for j in range(3):
        y[j] = mid(load[j, 0], load[j, 1])
    for i in range(count):
        t[i] = tension[i, 0]
        for j in range(3):
            a[i, j] = mid(ways[i, ALONG + j, 0], ways[i, ALONG + j, 1])
            y[j] -= t[i] * a[i, j]
    for _ in range(SWEEPS):
        for i in range(count):
            if not tension[i, 1] > 0.0:
                continue
            square = a[i, 0] * a[i, 0] + a[i, 1] * a[i, 1] + a[i, 2] * a[i, 2] + 1e-300
            new = t[i] + (y[0] * a[i, 0] + y[1] * a[i, 1] + y[2] * a[i, 2]) / square
            new = min(max(new, tension[i, 0]), tension[i, 1])
            for j in range(3):
                y[j] -= (new - t[i]) * a[i, j]
            t[i] = new
    for _ in range(TILTS):
        for i in range(count):
            if tension[i, 1] == math.inf:
                most = 0.0
                for j in range(3):
                    most += max(y[j] * ways[i, ALONG + j, 0], y[j] * ways[i, ALONG + j, 1])
                if most > 0.0:
                    for j in range(3):
                        y[j] -= 1.01 * most * a[i, j]


@kernel()
def unbalanced(data: Any, ways: Any, tension: Any) -> bool:
    """Prove that no tensions within bounds (N, 2) balance the load in a box with these ways."""
    load = data[4]
    for j in range(3):
        slo, shi = -load[j, 1], -load[j, 0]
        for i in range(tension.shape[0]):
            lo, hi = mul(tension[i, 0], tension[i, 1], ways[i, ALONG + j, 0], ways[i, ALONG + j, 1])
            slo, shi = add(slo, shi, lo, hi)
        if mig(slo, shi) > 0.0:
            return True
    y = np.empty(3)
    best_direction(data, ways, tension, y)
    # y . f > sup of y . sum t_i a_i.
    left = 0.0
    for j in range(3):
        left = down(left + mul(y[j], y[j], load[j, 0], load[j, 1])[0])
    for i in range(tension.shape[0]):
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = mul(y[j], y[j], ways[i, ALONG + j, 0], ways[i, ALONG + j, 1])
            slo, shi = add(slo, shi, lo, hi)
        left = down(left - mul(tension[i, 0], tension[i, 1], slo, shi)[1])
    return left > 0.0


@kernel()
def impossible(data: Any, ways: Any, tension: Any) -> bool:
    """Prove that there is no pose in a box with these ways; tension (N, 2) is scratch."""
    if not tensions_over(data, ways, tension) or not bounded_by_load(data, ways, tension):
        return True
    return unbalanced(data, ways, tension)


@kernel()
def only_this(tension: Any, alone: int) -> bool:
    """Return True when no cable but one has a tension (N, 2) above zero."""
    for i in range(tension.shape[0]):  # noqa: SIM110 - numba compiles no generator expressions
        if i != alone and tension[i, 1] > 0.0:
            return False
    return True


@kernel()
def is_the_known(data: Any, ways: Any, tension: Any, taut: Any, known: Any) -> bool:
    """Prove that every pose in a box with these ways is a zero of the known equations in their domain.

    The inextensible cables among those that may be taut, with tensions (N, 2) here, are the known ones (m,),
    each of them has to carry, and their tensions lie in the domain (3 + m, 2).
    """
    elastic, load = data[1], data[4]
    m = 0
    for i in range(tension.shape[0]):
        if not elastic[i] and tension[i, 1] > 0.0:
            if m == taut.shape[0] or taut[m] != i:
                return False
            m += 1
    if m < taut.shape[0]:
        return False
    if m > 0:
        balance_across_pairs(load, ways, tension)
    for b in range(m):
        lo, hi = tension[taut[b], 0], tension[taut[b], 1]
        if not (lo > 0.0 and known[3 + b, 0] <= lo and hi <= known[3 + b, 1]):
            return False
    return True


@kernel()
def balance_along(load: Any, ways: Any, y: Any, along: Any, tension: Any) -> None:
    """Cut tensions (N, 2) by y . f = sum t_i (y . a_i) for a direction y (3,); along (N, 2) is scratch."""
    count = tension.shape[0]
    for i in range(count):
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = mul(y[j], y[j], ways[i, ALONG + j, 0], ways[i, ALONG + j, 1])
            slo, shi = add(slo, shi, lo, hi)
        along[i, 0], along[i, 1] = slo, shi
    for i in range(count):
        if along[i, 0] <= 0.0 <= along[i, 1] or tension[i, 1] == 0.0:
            continue
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = mul(y[j], y[j], load[j, 0], load[j, 1])
            slo, shi = add(slo, shi, lo, hi)
        for h in range(count):
            if h != i:
                lo, hi = mul(tension[h, 0], tension[h, 1], along[h, 0], along[h, 1])
                slo, shi = sub(slo, shi, lo, hi)
        lo, hi = div(slo, shi, along[i, 0], along[i, 1])
        tension[i, 0], tension[i, 1] = max(tension[i, 0], lo), min(tension[i, 1], hi)


@kernel()
def balance_across_pairs(load: Any, ways: Any, tension: Any) -> None:
    """Cut tensions (N, 2) by the balance along directions across two cables each, and along each cable."""
    count = tension.shape[0]
    y, along = np.empty(3), np.empty((count, 2))
    for p in range(count):
        if tension[p, 1] == 0.0:
            continue
        for j in range(3):
            y[j] = mid(ways[p, ALONG + j, 0], ways[p, ALONG + j, 1])
        balance_along(load, ways, y, along, tension)
        for q in range(p):
            if tension[q, 1] == 0.0:
                continue
            for j in range(3):
                a, b = (j + 1) % 3, (j + 2) % 3
                y[j] = mid(ways[p, ALONG + a, 0], ways[p, ALONG + a, 1]) * mid(
                    ways[q, ALONG + b, 0], ways[q, ALONG + b, 1]
                ) - mid(ways[p, ALONG + b, 0], ways[p, ALONG + b, 1]) * mid(
                    ways[q, ALONG + a, 0], ways[q, ALONG + a, 1]
                )
            balance_along(load, ways, y, along, tension)


@entry()
def process(context: Any, cell: Any, children: Any) -> int:
    """Decide one cell, see `cdpr_interval.engine.depth_first`."""
    data, outward, taut, known, alone, smallest = context
    routes = data[0]
    count = routes.shape[0]
    box = np.empty((3, 2))
    box_of(cell, box)
    ways, gradient, at_middle = np.empty((count, WAY, 2)), np.empty((3, 2)), np.empty((WAY, 2))
    tension = np.empty((count, 2))
    for i in range(count):
        rough_way(routes[i], box, ways[i])
    if outward and all_beyond(data, box, ways):
        return 0
    if impossible(data, ways, tension):
        return 0
    for i in range(count):
        if not way_over(routes[i], box, ways[i]):
            return 0
    if outward and all_beyond(data, box, ways):
        return 0
    if impossible(data, ways, tension):
        return 0
    for i in range(count):
        gradient_over(routes[i], ways[i], gradient)
        sharpened_length(routes[i], box, ways[i], gradient, at_middle)
    if impossible(data, ways, tension):
        return 0
    if alone >= 0 and only_this(tension, alone):
        return 0
    if contains(known, box, 3) and is_the_known(data, ways, tension, taut, known):
        return 0
    keep(box, cell, children[0])
    return halve(box, widest(box), smallest, children)


@entry()
def run_cells(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Explore cells depth first, see `cdpr_interval.engine.depth_first.depth_first`."""
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)


@kernel()
def reach(data: Any, box: Any) -> bool:
    """Write a box (3, 2) of all positions at which the cables can balance the load; False: there is none.

    An inextensible cable reaches as far as it is long. Without one: farther from all exit points than twice
    their spread all cables pull inward at more than 60 degrees from the tangent, so one that is stretched by
    more than twice the load outweighs it.
    """
    routes, elastic, lengths, k, load = data
    size = 0.0
    for j in range(3):
        size = up(size + max(abs(load[j, 0]), abs(load[j, 1])))
        box[j, 0], box[j, 1] = -math.inf, math.inf
    all_elastic = True
    for i in range(routes.shape[0]):
        all_elastic = all_elastic and elastic[i]
        if elastic[i]:
            continue
        for j in range(3):
            far = farthest(routes[i], lengths[i, 1])
            box[j, 0] = max(box[j, 0], down(routes[i, EXIT + j, 0] - far))
            box[j, 1] = min(box[j, 1], up(routes[i, EXIT + j, 1] + far))
    if all_elastic:
        spread = 0.0
        for i in range(routes.shape[0]):
            own = up(routes[i, ARM, 1] + routes[i, RADIUS, 1])
            for j in range(3):
                own = up(own + max(abs(routes[i, EXIT + j, 0]), abs(routes[i, EXIT + j, 1])))
            spread = max(spread, own)
        least = math.inf
        for i in range(routes.shape[0]):
            stretched = up(lengths[i, 1] + up(2.0 * size / k[i, 0]))
            least = min(least, up(spread + farthest(routes[i], stretched)))
        least = up(max(2.0 * spread, least) * 1.001 + 1e-300)
        for j in range(3):
            box[j, 0], box[j, 1] = -least, least
    for j in range(3):  # noqa: SIM110 - numba compiles no generator expressions
        if not box[j, 0] <= box[j, 1]:
            return False
    return True


@kernel()
def cut(e: Any, least: float, most: float, box: Any) -> bool:
    """Contract a box (3, 2) to least <= e . X <= most for e (3,); False where nothing is left."""
    lo, hi = np.empty(3), np.empty(3)
    for j in range(3):
        lo[j], hi[j] = mul(e[j], e[j], box[j, 0], box[j, 1])
    for j in range(3):
        if e[j] == 0.0:
            continue
        a, b = (j + 1) % 3, (j + 2) % 3
        above, below = down(least - up(hi[a] + hi[b])), up(most - down(lo[a] + lo[b]))
        above, below = div(above, below, e[j], e[j])
        box[j, 0], box[j, 1] = max(box[j, 0], above), min(box[j, 1], below)
        if not box[j, 0] <= box[j, 1]:
            return False
    return True


@kernel()
def across(e: Any, route: Any, box: Any) -> float:
    """Bound |(I - e e^T) (X - A)| over a box (3, 2), for e (3,) of length 1 up to rounding."""
    total = 0.0
    for i in range(3):
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = sub(box[j, 0], box[j, 1], route[EXIT + j, 0], route[EXIT + j, 1])
            clo, chi = mul(-e[i], -e[i], e[j], e[j])
            if i == j:
                clo, chi = add(clo, chi, 1.0, 1.0)
            lo, hi = mul(clo, chi, lo, hi)
            slo, shi = add(slo, shi, lo, hi)
        far = max(abs(slo), abs(shi))
        total = up(total + up(far * far))
    # What rounding of e leaves is far below a thousandth.
    return up(1.001 * up(math.sqrt(total)))


@kernel()
def under_exits(data: Any, box: Any) -> bool:
    """Contract a box (3, 2) to where cables can hold the load; False where they can nowhere.

    With e along the load, against which no load in its ranges may pull: a pose lies below some tangent point,
    else all cables pull down. Lower below all of them than it is aside of any, every cable bears at most
    sqrt(2) times the load, and reaches no farther than stretched by that.
    """
    routes, _, lengths, k, load = data
    count = routes.shape[0]
    e, strength = np.empty(3), 0.0
    for j in range(3):
        e[j] = mid(load[j, 0], load[j, 1])
        strength = up(strength + max(abs(load[j, 0]), abs(load[j, 1])))
    size = math.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    for j in range(3):
        e[j] /= size
    top, bottom, aside, reached = math.inf, -math.inf, 0.0, math.inf
    down_load = 0.0
    for j in range(3):
        down_load = down(down_load + mul(e[j], e[j], load[j, 0], load[j, 1])[0])
    if not down_load > 0.0:
        return True
    for i in range(count):
        own = up(1.001 * up(routes[i, ARM, 1] + routes[i, RADIUS, 1]))
        alo, ahi = 0.0, 0.0
        for j in range(3):
            lo, hi = mul(e[j], e[j], routes[i, EXIT + j, 0], routes[i, EXIT + j, 1])
            alo, ahi = add(alo, ahi, lo, hi)
        aside = max(aside, up(across(e, routes[i], box) + own))
        top, bottom = min(top, down(alo - own)), max(bottom, up(ahi + own))
        longest = lengths[i, 1]
        if k[i, 0] > 0.0:
            longest = up(longest + up(up(1.5 * strength) / k[i, 0]))
        reached = min(reached, up(ahi + up(1.001 * farthest(routes[i], longest))))
    # An inextensible cable reaches as far as it is long in any case.
    return cut(e, top, max(up(bottom + aside), reached), box)


@kernel()
def farthest(route: Any, length: float) -> float:
    """Return how far from A an anchor may be on a cable of this length: the lead-in is gone for it."""
    if route[KIND, 0] == FIXED:
        return up(length)
    return up(up(length - route[LEAD_IN, 0]) + up(2.0 * up(route[ARM, 1] + route[RADIUS, 1])))


@kernel()
def cylinder(route: Any, within: Any, box: Any) -> bool:
    """Write the box (3, 2) around x <= arm + radius inside another box; False: nothing of it is there.

    On the axis A + s k, s is bounded by ``within``; the cylinder is at most arm + radius wider.
    """
    wide = up(route[ARM, 1] + route[RADIUS, 1])
    slo, shi = 0.0, 0.0
    for j in range(3):
        lo, hi = sub(within[j, 0], within[j, 1], route[EXIT + j, 0], route[EXIT + j, 1])
        lo, hi = mul(lo, hi, route[AXIS + j, 0], route[AXIS + j, 1])
        slo, shi = add(slo, shi, lo, hi)
    for j in range(3):
        lo, hi = mul(slo, shi, route[AXIS + j, 0], route[AXIS + j, 1])
        lo, hi = add(lo, hi, route[EXIT + j, 0], route[EXIT + j, 1])
        box[j, 0] = max(down(lo - wide), within[j, 0])
        box[j, 1] = min(up(hi + wide), within[j, 1])
        if not box[j, 0] <= box[j, 1]:
            return False
    return True


@entry()
def first_cells(data: Any, outward: bool, stack: Any) -> int:
    """Write the cells (>= N, WIDTH) that a search begins with; return their number."""
    routes = data[0]
    box, part = np.empty((3, 2)), np.empty((3, 2))
    if not reach(data, box) or not under_exits(data, box):
        return 0
    if not outward:
        keep_row(box, stack[0], 1.0)
        return 1
    count = 0
    for i in range(routes.shape[0]):
        if routes[i, KIND, 0] != FIXED and cylinder(routes[i], box, part) and under_exits(data, part):
            keep_row(part, stack[count], 1.0 / routes.shape[0])
            count += 1
    return count


@kernel()
def keep_row(box: Any, cell: Any, share: float) -> None:
    """Write a cell (WIDTH,) with a box (3, 2) and a share of the search."""
    for j in range(3):
        cell[2 * j], cell[2 * j + 1] = box[j, 0], box[j, 1]
    cell[6] = share
