"""Section 4 of Paty et al. 2021: the design of experiments and the best arm for each radius."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np
from paty_2021_model import MODULUS, Design, robot
from paty_2021_rows import Row, claim, number, unprinted
from paty_2021_targets import Settings, mean

ONE_JOINT, TWO_JOINTS = 1, 2
NAMES = {ONE_JOINT: "SR", TWO_JOINTS: "DR"}


@dataclass(frozen=True)
class Trial:
    """A test of the design of experiments, table 2."""

    joints: int
    arm: Fraction
    radius: Fraction
    """m."""


ARMS, RADII = (Fraction("0.1"), Fraction("0.15")), (Fraction("0.035"), Fraction("0.098"))
"""m: the levels of the factors."""
TRIALS = tuple(itertools.starmap(Trial, itertools.product(NAMES, ARMS, RADII)))
"""In the order of table 2."""
FACTORS = ("joint", "h", "r")


@cache
def responses(settings: Settings) -> tuple[tuple[float, ...], tuple[int, ...], int]:
    """Return the mean errors of the eight tests in m, their numbers of targets held, and that of all."""
    found = [
        mean(robot(Design(4, trial.joints, trial.arm, trial.radius, settings.lead_in)), settings.points)
        for trial in TRIALS
    ]
    return tuple(m.error for m in found), tuple(m.valid for m in found), found[0].total


def effects(values: Sequence[float]) -> dict[tuple[str, ...], float]:
    """Return the effects of factors and their interactions: means of the responses with their signs."""
    signs = np.array(list(itertools.product((-1, 1), repeat=len(FACTORS))))
    found = {}
    for size in range(1, len(FACTORS) + 1):
        for chosen in itertools.combinations(range(len(FACTORS)), size):
            sign = signs[:, chosen].prod(axis=1)
            found[tuple(FACTORS[i] for i in chosen)] = float((sign * values).mean())
    return found


def experiments(settings: Settings) -> Iterator[Row]:
    """Section 4.2: the mean errors of the eight tests, and the effects."""
    y, valid, total = responses(settings)
    stated = {0: ("0.05", y[0] == min(y)), 6: ("0.29", y[6] == max(y))}
    for i, trial in enumerate(TRIALS):
        arm, radius = (1000 * float(x) for x in (trial.arm, trial.radius))
        quantity = f"test {i + 1}: {NAMES[trial.joints]}, h {arm:.0f}, r {radius:.0f} mm: mean error, m"
        missed = total - valid[i]
        remark = f"{missed} of {total} targets left out: no three cables hold them" if missed else ""
        if i in stated:
            printed, holds = stated[i]
            yield number(quantity, printed, y[i], holds, remark)
        else:
            yield unprinted(quantity, f"{y[i]:.4f}", remark)
    spread = max(y) - min(y)
    yield claim("largest less least mean more than 0.24 m", f"{spread:.4f} m", spread > 0.24)
    yield from orders(y)
    yield from sizes(effects(y))


def orders(y: Sequence[float]) -> Iterator[Row]:
    """Yield what the paper says of the order of the tests."""
    order = [int(i) + 1 for i in np.argsort(y)]
    text = "by mean error: " + " ".join(map(str, order))
    yield claim("tests 1 and 6 err least", text, set(order[:2]) == {1, 6})
    yield claim("test 1 errs least of one joint, 6 of two", text, min(y[:4]) == y[0] and min(y[4:]) == y[5])
    yield claim("test 7 errs most, test 2 most of one joint", text, order[-1] == 7 and max(y[:4]) == y[1])


SMALL = 0.2
"""Part of the largest effect below which one counts as small: the paper says so of figure 16 in words."""


def sizes(found: dict[tuple[str, ...], float]) -> Iterator[Row]:
    """Yield the effects, and what the paper says of them."""
    for names, value in found.items():
        yield unprinted(f"effect of {' x '.join(names)} (half of high less low), m", f"{value:+.5f}")
    largest = max(found, key=lambda names: abs(found[names]))
    yield claim("joint x r has the largest effect", " x ".join(largest), largest == ("joint", "r"))
    for names, text, small in (
        (("joint",), "the joint alone has a small effect (below a fifth of it)", True),
        (FACTORS, "the interaction of all three is weak (below a fifth)", True),
        (("joint", "h"), "joint x h cannot be neglected (above a fifth)", False),
    ):
        share = abs(found[names] / found[largest])
        yield claim(text, f"{share:.2f} of the largest", (share < SMALL) == small)


@dataclass(frozen=True)
class Optimum:
    """The arm with the least mean error at a radius."""

    radius: float
    arm: float
    """m."""
    error: float
    """m."""

    @property
    def slope(self) -> float:
        """Return h / r."""
        return self.arm / self.radius


LONGEST_ARM = 5.0
"""In radii: twice what is found with one joint."""
ARM_STEP = 1e-5
"""m."""
GOLDEN = (math.sqrt(5) - 1) / 2


def optimum(joints: int, radius: Fraction, settings: Settings, modulus: float | None = MODULUS) -> Optimum:
    """Return the best arm at a radius in m, by golden section."""

    def error(arm: float) -> float:
        design = Design(4, joints, Fraction(arm), radius, settings.lead_in)
        return mean(robot(design, modulus), settings.line_points).error

    r = float(radius)
    lo, hi = r, LONGEST_ARM * r
    left, right = hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo)
    at_left, at_right = error(left), error(right)
    while hi - lo > ARM_STEP:
        if at_left < at_right:
            hi, right, at_right = right, left, at_left
            left = hi - GOLDEN * (hi - lo)
            at_left = error(left)
        else:
            lo, left, at_left = left, right, at_right
            right = lo + GOLDEN * (hi - lo)
            at_right = error(right)
    arm = (lo + hi) / 2
    return Optimum(r, arm, error(arm))


SLOPES = {ONE_JOINT: "3.077", TWO_JOINTS: "1.25"}
"""Equations 17 and 18: 40/13 and 5/4."""
BEST_RADIUS = {ONE_JOINT: Fraction("0.035"), TWO_JOINTS: Fraction("0.08")}
"""m, table 3."""
OTHER_RADII = {
    ONE_JOINT: (Fraction("0.02"), Fraction("0.05")),
    TWO_JOINTS: (Fraction("0.04"), Fraction("0.06")),
}
"""m."""


def optima(settings: Settings) -> Iterator[Row]:
    """Section 4.3: the best arm for each radius."""
    slopes = {}
    for joints, name in NAMES.items():
        found = [optimum(joints, radius, settings) for radius in (BEST_RADIUS[joints], *OTHER_RADII[joints])]
        slopes[joints] = found[0].slope
        at = f"r = {1000 * found[0].radius:.0f} mm"
        yield number(f"{name}: h / r of the optimum line, {at}", SLOPES[joints], found[0].slope)
        rigid = optimum(joints, BEST_RADIUS[joints], settings, None)
        yield number(f"{name}: the same for cables without stretch", SLOPES[joints], rigid.slope)
        yield from on_a_line(name, sorted(found, key=lambda best: best.radius))
    none = mean(robot(Design(4, 0, lead_in=settings.lead_in)), settings.line_points).error
    yield claim(
        "at h = r = 0 the extended model is the simple one: no error",
        f"{1000 * none:.2f} mm",
        none < 1e-6,
        "the stretch of the cables stays",
    )
    yield claim(
        "the line of two joints is less steep than that of one",
        f"SR {slopes[ONE_JOINT]:.3f}, DR {slopes[TWO_JOINTS]:.3f}",
        slopes[TWO_JOINTS] < slopes[ONE_JOINT],
    )


def on_a_line(name: str, found: Sequence[Optimum]) -> Iterator[Row]:
    """Yield the optima of a kind of pulley by radius, and what the paper says of their line."""
    for best in found:
        yield unprinted(
            f"{name}: h / r and least mean error at r = {1000 * best.radius:.0f} mm",
            f"{best.slope:.3f}, {1000 * best.error:.2f} mm",
        )
    slopes = [best.slope for best in found]
    yield claim(
        f"{name}: the optima lie on a line through the origin (within 1 %)",
        f"h / r from {min(slopes):.3f} to {max(slopes):.3f}",
        max(slopes) < 1.01 * min(slopes),
    )
    errors = [best.error for best in found]
    yield claim(
        f"{name}: on it the error falls towards the origin",
        ", ".join(f"{1000 * error:.2f}" for error in errors) + " mm",
        errors == sorted(errors),
    )
