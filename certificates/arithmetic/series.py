"""Inverse roots and angles of numbers of any kind, by power series whose remainders are bounded.

A guess comes first, so that what is left to the series is small: g near x^(-1/2) and e = x g^2 - 1, or a
direction of a table near the given one. For forms both are any doubles; a bad guess makes a wide form.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from flint import arb, ctx

from certificates.arithmetic.balls import BITS
from certificates.arithmetic.forms import Form
from certificates.arithmetic.jets import Jet

DIRECTIONS = 1024
"""Of the table: two neighbours are 0.005 rad apart."""
LOWEST, HIGHEST = -1.8, 3.37
"""Angles of the table, rad. What `angle` returns is at most pi / 6 beyond."""


def half(x: Any) -> Any:
    """Return x / 2."""
    return x * type(x).constant(0.5) if isinstance(x, Form) else x * arb(0.5)


def inverse_root(x: Any) -> Any:
    """Return 1 / sqrt(x); nothing is known of the result where x may not be positive.

    (1 + e)^(-1/2) = 1 - e / 2 + 3 e^2 / 8 - 5 e^3 / 16 + ... has coefficients of falling size: what follows
    the third term is at most 5 / 16 |e|^3 / (1 - |e|), not more than |e|^3 for |e| <= 1/2.
    """
    if isinstance(x, Jet):
        root = inverse_root(x.value)
        slope = half(-root * root * root)
        return Jet(root, {k: v * slope for k, v in x.slopes.items()})
    if not isinstance(x, Form):
        return x.rsqrt()
    kind, middle = type(x), x.doubles()
    is_usual = (middle > 1e-100) & (middle < 1e100)
    guess = kind.near(1.0 / np.sqrt(np.where(is_usual, middle, 1.0)))
    e = x * guess * guess - 1
    size = e.size()
    terms = 1 - half(e) + e * e * kind.constant(0.375)
    return where_small(size, guess * (terms + remainder(kind, size, 3)))


def remainder(kind: type[Form], size: Any, power: int) -> Form:
    """Return any number up to a power of a bound."""
    found = size
    for _ in range(power - 1):
        found = kind.bound([(found, size)])
    return kind.unknown(found)


def where_small(size: Any, form: Form) -> Form:
    """Return a form where a bound is at most 1/2; elsewhere nothing is known.

    There no term of it is left, and nothing is multiplied by a guess, which may be 0 in units: what stands
    for infinite in integers is not above everything.
    """
    kind = type(form)
    is_small = size <= kind.numbers(np.array([0.5]))
    known: Form = form * is_small
    return known + kind.unknown(np.where(is_small, kind.numbers(np.zeros(1)), kind.INFINITE))


@cache
def table(kind: type[Form]) -> tuple[Form, Form, Form]:
    """Return cosine, sine and angle of all directions of the table, each a cell of a form."""
    with ctx.workprec(BITS):
        angles = [arb(float(x)) for x in np.linspace(LOWEST, HIGHEST, DIRECTIONS)]
        rows = [[kind.enclosing(f(x)) for x in angles] for f in (arb.cos, arb.sin, arb)]
    none = rows[0][0]
    return tuple(  # type: ignore[return-value]
        kind(
            np.concatenate([f.value for f in row]),
            none.slopes,
            none.curves,
            np.concatenate([f.rest for f in row]),
        )
        for row in rows
    )


def angle(x: Any, y: Any) -> Any:
    """Return the angle of a unit vector (x, y), between LOWEST - pi / 6 and HIGHEST + pi / 6.

    Nothing is known of it where the vector may be farther than pi / 6 from a direction of the table. With s
    the sine of the angle from there, arcsin s = s + s^3 / 6 + 3 s^5 / 40 + ... has positive falling
    coefficients: what follows the second term is at most 3 / 40 |s|^5 / (1 - s^2) <= |s|^5 for |s| <= 1/2.
    """
    if isinstance(x, Jet):
        keys = x.slopes.keys() | y.slopes.keys()
        slopes = {k: x.value * y.slopes.get(k, 0) - y.value * x.slopes.get(k, 0) for k in keys}
        return Jet(angle(x.value, y.value), slopes)
    if not isinstance(x, Form):
        # The cut is where no direction of the table is near.
        return arb.atan2(y - x, y + x) + arb.pi() / 4
    kind = type(x)
    near = np.arctan2(y.doubles() - x.doubles(), y.doubles() + x.doubles()) + np.pi / 4
    place = (np.where(np.isfinite(near), near, 0.0) - LOWEST) / (HIGHEST - LOWEST) * (DIRECTIONS - 1)
    cosine, sine, first = (f.at(np.clip(np.rint(place), 0, DIRECTIONS - 1).astype(int)) for f in table(kind))
    s, ahead = y * cosine - x * sine, x * cosine + y * sine
    size = kind.bound([], np.where(ahead.lowest() > 0, s.size(), kind.INFINITE))
    return where_small(size, first + s + s * s * s * sixth(kind) + remainder(kind, size, 5))


@cache
def sixth(kind: type[Form]) -> Form:
    """Return 1 / 6."""
    with ctx.workprec(BITS):
        return kind.enclosing(arb(1) / 6)
