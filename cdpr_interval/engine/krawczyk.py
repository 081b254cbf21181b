"""The Krawczyk operator: zeros of square systems proved, enclosed, and proved to be the only ones of a box.

For a system F of n equations in n unknowns, a point c, a matrix C in floats near the inverse of F' there and
a box X around c,

    K(X) = c - C F(c) + E (X - c),   E an enclosure of I - C F' over X,

holds every zero in X (mean value theorem, row by row). Where K(X) lies strictly inside X there is exactly
one, for every choice of the data that the enclosures of F(c) and E stand for, and it lies in K(X)
(R. Krawczyk 1969; R. E. Moore 1977; S. M. Rump, Acta Numerica 2010, theorem 13.2). Where |E| v < v for some
v > 0, every matrix in C F' is regular: X holds at most one zero (two would differ by a vector in the kernel).

A system knows its robot; this file knows none. It hands in kernels and a context of its own, any tuple:

* ``deviate(context, box, E)`` writes an enclosure of I - C F' over a box (n, 2) to E (n, n, 2);
* ``residual(context, box, f)`` writes an enclosure of F over a box (n, 2) to f (n, 2).

The operator moves in two ways. ``around`` stays at one point: F is evaluated once, and only |E| again and
again, which suits a domain that has to hold a given box. ``existence`` goes to the middle of each box and
keeps the signs of E, which suits wide ranges of data: their zeros need not lie evenly around any of them.

A zero that moves with symbols e (lengths within ranges, say) is a tube z(e) + W: ``around`` proves it as it
stands. Its unknowns are then the offsets w = z - z(e): x is 0, the context holds z(e) and a preconditioner
C(e), ``shift`` encloses -C(e) F(z(e), e) over all e, and ``deviate`` encloses I - C(e) F'(z(e) + w, e) over
all e and all w in the box. So for each e there is exactly one zero in z(e) + ``domain``, and it lies in z(e)
+ ``box``. The constant zero is the tube without symbols.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cdpr_interval.kernels import box as boxes
from cdpr_interval.kernels import interval
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.kernel import kernel, part
from cdpr_interval.kernels.rounding import down, up

LOST = 1e200
"""A radius above this will never lie inside anything."""
INFLATIONS = 15
"""Rounds of epsilon-inflation in ``existence`` before a zero counts as not provable."""
REFINEMENTS = 3
"""Krawczyk steps after the last of these rounds; each contracts quadratically down to rounding."""
REFINED = 0.9
"""A refinement that leaves every side at least this share of its width is the last."""
MARGIN = 0.1
"""Share of its width by which a box exceeds, on either side, the image it was made from."""
ROUNDING = 1e-15
"""Width of a first box over its unknowns, at least: some of their last digits."""
PERRON_STEPS = 12
"""Steps of the search for a positive vector that proves a matrix close to the identity regular."""
PERRON_FLOOR = 1e-3
"""Share of the vector before that is kept."""
GOOD = 0.5
"""Growth that is good enough: no better estimate is sought."""
BELOW_ONE = 1.0 - 2.0**-53
"""Largest double below 1."""


class Tries(NamedTuple):
    """How ``inflated`` goes from one box to the next."""

    boxes: int
    """Most boxes tried."""
    growth: float
    """The next radii over the images of the last ones."""
    kept: float
    """The next radii over the last ones, at least: 1 where they have to hold a given box."""


class Contractions(NamedTuple):
    """How far ``around`` contracts a box after the proof."""

    most: int
    """Most Krawczyk steps."""
    gain: float
    """A step that leaves all radii at least this share of theirs is the last one."""


@kernel("b1(f8[:, :, ::1], f8[:, ::1])")
def preconditioner(J: Any, C: Any) -> bool:
    """Write the float inverse of the middle of J (n, n, 2) to C (n, n); False where it is singular."""
    n = J.shape[0]
    a = np.zeros((n, 2 * n))
    for i in range(n):
        for j in range(n):
            a[i, j] = 0.5 * (J[i, j, 0] + J[i, j, 1])
        a[i, n + i] = 1.0
    if not solve_in_place(a, n, n):
        return False
    for i in range(n):
        for j in range(n):
            C[i, j] = a[i, n + j]
    return True


@kernel("void(f8[:, ::1], f8[:, ::1], f8[:, ::1])")
def correction(C: Any, f: Any, shift: Any) -> None:
    """Enclose -C f in shift (n, 2) for C (n, n) and f (n, 2)."""
    for i in range(C.shape[0]):
        lo, hi = 0.0, 0.0
        for k in range(C.shape[0]):
            a, b = interval.scale(C[i, k], f[k, 0], f[k, 1])
            lo, hi = interval.add(lo, hi, a, b)
        shift[i, 0], shift[i, 1] = -hi, -lo


@kernel("void(f8[:, ::1], f8[:, :, ::1], f8[:, :, ::1])")
def deviation(C: Any, J: Any, E: Any) -> None:
    """Enclose I - C J in E (n, n, 2) for C (n, n) and J (n, n, 2)."""
    n = C.shape[0]
    for i in range(n):
        for j in range(n):
            lo = 1.0 if i == j else 0.0
            hi = lo
            for k in range(n):
                a, b = interval.scale(C[i, k], J[k, j, 0], J[k, j, 1])
                lo, hi = interval.sub(lo, hi, a, b)
            E[i, j, 0] = lo
            E[i, j, 1] = hi


@kernel("b1(f8[:, :, ::1], f8[::1], f8[::1], f8[::1])")
def stretched(E: Any, v: Any, start: Any, out: Any) -> bool:
    """Bound start + |E| v from above in out (n,): E (n, n, 2), v, start (n,); True when it is below v."""
    inside = True
    for i in range(v.shape[0]):
        total = start[i]
        for j in range(v.shape[0]):
            total = up(total + up(interval.mag(E[i, j, 0], E[i, j, 1]) * v[j]))
        out[i] = total
        # A NaN fails the comparison.
        inside = inside and total < v[i]
    return inside


@kernel("f8(f8[:, :, ::1], f8[:, ::1])")
def growth(E: Any, box: Any) -> float:
    """Return how much |E| stretches a positive vector: below 1 only with a proof for E (n, n, 2).

    The vector comes from power iteration, started at the half widths of the box (n, 2); the value estimates
    the spectral radius of |E| from above.
    """
    n = box.shape[0]
    v, image, nothing = np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        nothing[i] = 0.0
        v[i] = up(box[i, 1] - box[i, 0]) + 1e-300
    best = math.inf
    for _ in range(PERRON_STEPS):
        smaller = stretched(E, v, nothing, image)
        ratio, largest = 0.0, 0.0
        for i in range(n):
            if not v[i] > 0.0:
                return best
            ratio = max(ratio, image[i] / v[i])
            largest = max(largest, image[i])
        if not largest < math.inf:
            return math.inf
        best = min(best, min(ratio, BELOW_ONE) if smaller else max(ratio, 1.0))
        if not largest > 0.0 or best < GOOD:
            return best
        for i in range(n):
            # The floor keeps v positive and the comparison strict where a row of E vanishes.
            v[i] = image[i] / largest + PERRON_FLOOR * v[i]
    return best


@kernel("void(f8[::1], f8[:, ::1], f8[:, ::1], f8[::1], f8[::1])")
def first_radii(x: Any, shift: Any, cover: Any, first: Any, radius: Any) -> None:
    """Bound |C F(x)| in ``first`` (n,), and write the radii ``radius`` (n,) of a first box around x (>= n,).

    The box may be mapped into itself, and holds the cover (n, 2). ``shift`` (n, 2) encloses -C F(x).
    """
    for r in range(radius.shape[0]):
        first[r] = interval.mag(shift[r, 0], shift[r, 1])
        radius[r] = 1.5 * first[r] + 1e-17 * abs(x[r]) + 1e-300
        radius[r] = max(radius[r], 1.01 * max(up(x[r] - cover[r, 0]), up(cover[r, 1] - x[r])))


# Inlined into its caller: numba does not cache a call that passes a function as a value.
@part()
def inflated(
    deviate: Any, context: Any, x: Any, first: Any, tries: Any, radius: Any, image: Any, E: Any, box: Any
) -> bool:
    """Grow a box around a point until the operator maps it strictly into itself.

    Parameters
    ----------
    deviate, context
        The system, see above.
    x, first : (>= n,), (n,)
        The point, and a bound of |C F(x)|.
    tries
        `Tries`.
    radius, image : (n,)
        Radii of the first box tried; overwritten by those of the last one, and of its image.
    E, box : (n, n, 2), (n, 2)
        Written: I - C F' over the last box, and that box.

    Guarantee
    ---------
    True: for every choice of the data the system has exactly one zero in the box, and every matrix in its
    derivative there is regular.
    """
    for _ in range(tries.boxes):
        boxes.spread(x, radius, box)
        deviate(context, box, E)
        if stretched(E, radius, first, image):
            return True
        for r in range(radius.shape[0]):
            if not image[r] < LOST:
                return False
            radius[r] = max(tries.growth * image[r], tries.kept * radius[r])
    return False


@part()
def around(
    deviate: Any, context: Any, x: Any, shift: Any, cover: Any, steps: Any, box: Any, domain: Any
) -> bool:
    """Prove the zero near a point, and contract its box.

    Parameters
    ----------
    deviate, context
        The system, see above.
    x : (>= n,)
        The point.
    shift : (n, 2)
        Encloses -C F(x), see ``correction``.
    cover : (n, 2)
        A box the domain must contain; rows (inf, -inf) ask for nothing.
    steps
        `Tries` and `Contractions`.
    box, domain : (n, 2)
        Written, see the guarantee.

    Guarantee
    ---------
    True: for every choice of the data the system has exactly one zero in ``domain``, every matrix in its
    derivative there is regular, and the zero lies in ``box``. False: nothing is claimed.
    """
    tries, contractions = steps
    n = box.shape[0]
    E, first, nothing = np.empty((n, n, 2)), np.empty(n), np.empty(n)
    radius, image, total = np.empty(n), np.empty(n), np.empty(n)
    for r in range(n):
        nothing[r] = 0.0
    first_radii(x, shift, cover, first, radius)
    if not inflated(deviate, context, x, first, tries, radius, image, E, box):
        return False
    boxes.copy(box, domain)
    for step in range(contractions.most):
        # Every zero of the domain lies in x + shift +- |E| radius, hence in x +- image.
        gain = step == 0
        for r in range(n):
            gain = gain or image[r] < contractions.gain * radius[r]
            radius[r] = min(image[r], radius[r])
        if not gain:
            break
        boxes.spread(x, radius, box)
        deviate(context, box, E)
        stretched(E, radius, nothing, total)
        for r in range(n):
            image[r] = min(up(first[r] + total[r]), radius[r])
            box[r, 0] = max(box[r, 0], down(x[r] + down(shift[r, 0] - total[r])))
            box[r, 1] = min(box[r, 1], up(x[r] + up(shift[r, 1] + total[r])))
    return True


@kernel("b1(f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1], f8[:, ::1], f8[:, ::1])")
def image_of(C: Any, middle: Any, f: Any, E: Any, box: Any, image: Any) -> bool:
    """Write the operator's image (n, 2) of a box (n, 2); True when it lies strictly inside.

    ``middle`` (n, 2) is a point in the box, ``f`` (n, 2) encloses F there and E (n, n, 2) I - C F' over the
    box, for C (n, n).
    """
    n = C.shape[0]
    inside = True
    for i in range(n):
        lo, hi = middle[i, 0], middle[i, 1]
        for k in range(n):
            a, b = interval.scale(C[i, k], f[k, 0], f[k, 1])
            lo, hi = interval.sub(lo, hi, a, b)
        for j in range(n):
            d0, d1 = interval.sub(box[j, 0], box[j, 1], middle[j, 0], middle[j, 1])
            a, b = interval.mul(E[i, j, 0], E[i, j, 1], d0, d1)
            lo, hi = interval.add(lo, hi, a, b)
        image[i, 0], image[i, 1] = lo, hi
        if not (box[i, 0] < lo and hi < box[i, 1]):
            inside = False
    return inside


@part()
def over(residual: Any, deviate: Any, context: Any, C: Any, box: Any, image: Any) -> bool:
    """Apply the operator to a box (n, 2), at its middle; True when the image lies strictly inside.

    Guarantee: ``image`` (n, 2) holds every zero in the box; with True there is exactly one, for every choice
    of the data. ``C`` (n, n) is the one that ``deviate`` takes.
    """
    n = C.shape[0]
    middle, f, E = np.empty((n, 2)), np.empty((n, 2)), np.empty((n, n, 2))
    for k in range(n):
        middle[k, 0] = interval.mid(box[k, 0], box[k, 1])
        middle[k, 1] = middle[k, 0]
    residual(context, middle, f)
    deviate(context, box, E)
    return image_of(C, middle, f, E, box, image)


@kernel("void(f8[:, ::1], f8[:, ::1], f8[::1], f8[:, ::1])")
def first_image(C: Any, f: Any, x: Any, image: Any) -> None:
    """Write about where a Newton step from x (n,) leads to image (n, 2), in floats; C (n, n), f (n, 2)."""
    for i in range(x.shape[0]):
        radius = 0.0
        for j in range(x.shape[0]):
            radius += abs(C[i, j]) * max(abs(f[j, 0]), abs(f[j, 1]))
        image[i, 0] = x[i] - radius
        image[i, 1] = x[i] + radius


@kernel("b1(f8[:, ::1], f8[::1], f8, f8[:, ::1])")
def inflate(image: Any, x: Any, size: float, box: Any) -> bool:
    """Write the image (n, 2) with a margin to box (n, 2); False where it is not bounded.

    The margin is at least the rounding of unknowns of the size of x (n,) and ``size``.
    """
    for i in range(x.shape[0]):
        width = image[i, 1] - image[i, 0]
        if not width < math.inf:
            return False
        slack = MARGIN * width + ROUNDING * (abs(x[i]) + size)
        box[i, 0] = image[i, 0] - slack
        box[i, 1] = image[i, 1] + slack
    return True


@kernel("b1(f8[:, ::1], f8[:, ::1])")
def refined(image: Any, box: Any) -> bool:
    """Intersect a box (n, 2) with its image (n, 2), which holds its zeros; True when a side shrank much."""
    smaller = False
    for i in range(box.shape[0]):
        width = box[i, 1] - box[i, 0]
        box[i, 0], box[i, 1] = max(box[i, 0], image[i, 0]), min(box[i, 1], image[i, 1])
        smaller = smaller or box[i, 1] - box[i, 0] < REFINED * width
    return smaller


@part()
def existence(apply: Any, context: Any, C: Any, x: Any, f: Any, size: float, refine: bool, box: Any) -> bool:
    """Grow a box around x until the operator maps it strictly into itself, and contract it.

    Parameters
    ----------
    apply, context
        ``apply(context, box, image)`` is ``over`` of the system.
    C : (n, n)
        The one that ``apply`` takes.
    x, f : (n,), (n, 2)
        The point, and the residuals there.
    size
        What unknowns near 0 are compared with.
    refine
        Go on contracting. Without ranges of the data only rounding is left after one step.
    box : (n, 2)
        Written, see the guarantee.

    Guarantee
    ---------
    True: the box holds exactly one zero, for every choice of the data.
    """
    image = np.empty(box.shape)
    first_image(C, f, x, image)
    proved = False
    for step in range(INFLATIONS + REFINEMENTS):
        if not proved and (step >= INFLATIONS or not inflate(image, x, size, box)):
            return False
        inside = apply(context, box, image)
        if not (proved or inside):
            continue
        # The zero lies in the box and, once that is proved, in every image.
        smaller = refined(image, box) or not proved
        proved = True
        if not (smaller and refine):
            return True
    return proved
