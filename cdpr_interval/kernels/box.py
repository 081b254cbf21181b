"""Boxes: arrays of bounds whose last axis is (lo, hi), and the few things that everybody does with them."""

from __future__ import annotations

from typing import Any

from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.rounding import down, up


@kernel("void(f8[:, ::1], f8[:, ::1])")
def copy(a: Any, out: Any) -> None:
    """Copy the box a (n, 2) to out (n, 2); numba compiles the checks of a slice's assignment for seconds."""
    for k in range(a.shape[0]):
        out[k, 0] = a[k, 0]
        out[k, 1] = a[k, 1]


@kernel("void(f8[::1], f8[:, ::1])")
def point(x: Any, out: Any) -> None:
    """Write the box out (n, 2) that holds the point x (>= n,) only."""
    for k in range(out.shape[0]):
        out[k, 0] = x[k]
        out[k, 1] = x[k]


@kernel("void(f8[::1], f8[::1], f8[:, ::1])")
def spread(x: Any, radius: Any, out: Any) -> None:
    """Write a box out (n, 2) that holds x (>= n,) +- radius (n,)."""
    for k in range(radius.shape[0]):
        out[k, 0] = down(x[k] - radius[k])
        out[k, 1] = up(x[k] + radius[k])


@kernel("void(f8[:, ::1], f8[:, ::1])")
def meet(a: Any, out: Any) -> None:
    """Intersect the box out (n, 2) with the box a (n, 2)."""
    for k in range(a.shape[0]):
        out[k, 0] = max(out[k, 0], a[k, 0])
        out[k, 1] = min(out[k, 1], a[k, 1])


@entry("b1(f8[:, ::1], f8[:, ::1], i8)")
def contains(outer: Any, inner: Any, n: int) -> bool:
    """Return True when the first n sides of ``inner`` (>= n, 2) lie in those of ``outer`` (>= n, 2)."""
    for i in range(n):  # noqa: SIM110 - numba compiles no generator expressions
        if not (outer[i, 0] <= inner[i, 0] and inner[i, 1] <= outer[i, 1]):
            return False
    return True


@kernel("b1(f8[:, ::1], f8[:, ::1], i8)")
def disjoint(a: Any, b: Any, n: int) -> bool:
    """Return True when the first n sides of two boxes a, b (>= n, 2) have no common point."""
    for i in range(n):  # noqa: SIM110 - numba compiles no generator expressions
        if a[i, 1] < b[i, 0] or b[i, 1] < a[i, 0]:
            return True
    return False


@kernel("void(f8[:, ::1], i8[::1], f8[:, ::1])")
def gather(a: Any, chosen: Any, out: Any) -> None:
    """Write the chosen (n,) sides of the box a (m, 2) to out (n, 2)."""
    for i in range(chosen.shape[0]):
        out[i, 0] = a[chosen[i], 0]
        out[i, 1] = a[chosen[i], 1]


@kernel("void(f8[:, ::1], i8[::1], f8[:, ::1])")
def scatter(a: Any, chosen: Any, out: Any) -> None:
    """Write the box a (n, 2) to the chosen (n,) sides of out (m, 2)."""
    for i in range(chosen.shape[0]):
        out[chosen[i], 0] = a[i, 0]
        out[chosen[i], 1] = a[i, 1]


@kernel("void(f8[:, :, ::1], i8, i8, f8, f8)")
def accumulate(out: Any, i: int, j: int, lo: float, hi: float) -> None:
    """Add [lo, hi] to entry (i, j) of an interval matrix out (m, n, 2)."""
    out[i, j, 0] = down(out[i, j, 0] + lo)
    out[i, j, 1] = up(out[i, j, 1] + hi)
