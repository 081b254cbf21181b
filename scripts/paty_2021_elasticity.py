"""Table 3 and section 5 of Paty et al. 2021: E = 102.2 +-35 GPa, a range of which both ends are taken."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from paty_2021_design import NAMES, ONE_JOINT, RADII, TWO_JOINTS
from paty_2021_model import MODULUS_LEAST, MODULUS_MOST, Design, corners, ends, robot, sets_of_three, solved
from paty_2021_rows import Row, claim, number, unprinted
from paty_2021_targets import Path, Settings, mean, straight

ARMS = {ONE_JOINT: Fraction(40, 13) * Fraction(RADII[ONE_JOINT][0]), TWO_JOINTS: Fraction("0.1")}
"""m, of table 3; 107.7 mm is printed for the first, its line gives 107.69."""
MEANS = {ONE_JOINT: "53.75", TWO_JOINTS: "23.28"}
"""mm, table 3."""
BELOW, ABOVE, TOTAL = 0, 1, 2
BOUNDS = {ONE_JOINT: ("-0.29", "1.5", "3.33"), TWO_JOINTS: ("-1.2", "3.9", "21.91")}
"""Section 5.1: deviations of the mean in mm, and their difference in percent of the mean."""
INVERSIONS = {ONE_JOINT: "1.55", TWO_JOINTS: "1.23"}
"""m, section 5.2."""
START, END = (-2.32, 0.0, 0.0), (2.32, 0.0, 3.75)
"""m, of the path of section 5.2."""
BETWEEN = 9
"""Moduli, the ends included, by which it is checked that the ends bound what lies between."""


@dataclass(frozen=True)
class Ends:
    """A quantity for E in the middle, at the lower and at the upper end."""

    middle: Any
    least: Any
    most: Any


def optimal(joints: int, settings: Settings) -> Design:
    """Return the design of table 3."""
    return Design(4, joints, ARMS[joints], RADII[joints][0], settings.lead_in)


def elasticity(settings: Settings) -> Iterator[Row]:
    """Table 3 and section 5."""
    found = {joints: means(optimal(joints, settings), settings) for joints in NAMES}
    one, two = found[ONE_JOINT], found[TWO_JOINTS]
    for joints, name in NAMES.items():
        less = two.middle < one.middle
        yield number(f"{name}*: mean error, mm (table 3)", MEANS[joints], found[joints].middle, less)
    for joints, name in NAMES.items():
        yield from bounds(name, found[joints], BOUNDS[joints])
    yield claim(
        "SR*: the least mean stays above the largest of DR*",
        f"SR* {lowest(one):.2f}, DR* {highest(two):.2f} mm",
        lowest(one) > highest(two),
    )
    shares = [(highest(e) - lowest(e)) / e.middle for e in (one, two)]
    text = f"SR* {100 * shares[0]:.2f}, DR* {100 * shares[1]:.2f} %"
    yield claim("the mean of SR* depends less on E than that of DR*", text, shares[0] < shares[1])
    yield from on_the_path(settings)


def means(design: Design, settings: Settings) -> Ends:
    """Return mean errors, mm."""
    whole = robot(design, (MODULUS_LEAST, MODULUS_MOST))
    return Ends(*(1000 * mean(r, settings.points).error for r in (robot(design), *ends(whole))))


def lowest(e: Ends) -> float:
    """Return the least of the three."""
    return min(e.middle, e.least, e.most)


def highest(e: Ends) -> float:
    """Return the largest of the three."""
    return max(e.middle, e.least, e.most)


def bounds(name: str, e: Ends, printed: tuple[str, str, str]) -> Iterator[Row]:
    """Yield by how much the mean lies lower and higher at the ends."""
    below, above = lowest(e) - e.middle, highest(e) - e.middle
    stiff, soft = e.most < e.middle, e.least > e.middle
    yield number(f"{name}*: mean at 137.2 GPa less that at 102.2, mm", printed[BELOW], below, stiff)
    yield number(f"{name}*: mean at 67.2 GPa less that at 102.2, mm", printed[ABOVE], above, soft)
    total = 100 * (above - below) / e.middle
    yield number(f"{name}*: total variation, % of the mean", printed[TOTAL], total)


def on_the_path(settings: Settings) -> Iterator[Row]:
    """Yield what E does along the path of section 5.2."""
    path = straight(START, END, settings.path_points)
    found = {joints: along(optimal(joints, settings), path) for joints in NAMES}
    for joints, name in NAMES.items():
        yield from inversion(f"{name}*", INVERSIONS[joints], found[joints], path)
    one, two = found[ONE_JOINT], found[TWO_JOINTS]
    late, early = crossing(one, path), crossing(two, path)
    yield claim(
        "the ends of E change places later for SR*", f"SR* {late:.2f}, DR* {early:.2f} m", late > early
    )
    more = [a > b for a, b in zip(vars(one).values(), vars(two).values(), strict=True)]
    text = f"at {', '.join(str(m.sum()) for m in more)} of {len(path.abscissa)} targets"
    yield claim("SR* errs more than DR* all along, for the same E", text, np.all(more))
    for joints, name in NAMES.items():
        yield from changes(f"{name}*", optimal(joints, settings), found[joints], path)
    upper = path.abscissa > path.abscissa[-1] / 2
    widths = [1000 * float(np.abs(e.most - e.least)[upper].mean()) for e in (one, two)]
    text = f"mean width SR* {widths[0]:.2f}, DR* {widths[1]:.2f} mm"
    yield claim("in the second half the error of DR* depends more on E", text, widths[0] < widths[1])
    for joints, name in NAMES.items():
        yield from percent(f"{name}*", found[joints], path)
        yield between(f"{name}*", optimal(joints, settings), found[joints], path)


def along(design: Design, path: Path) -> Ends:
    """Return errors (T,) on a path, m."""
    whole = robot(design, (MODULUS_LEAST, MODULUS_MOST))
    return Ends(*(solved(r, path.targets).error for r in (robot(design), *ends(whole))))


def crossing(e: Ends, path: Path) -> float:
    """Return the abscissa from which on stiffer cables err less, m; not a number where there is none."""
    less = e.most - e.least
    (places,) = np.nonzero((less[:-1] > 0) & (less[1:] <= 0))
    if not len(places):
        return math.nan
    k = int(places[0])
    share = less[k] / (less[k] - less[k + 1])
    return float(path.abscissa[k] + share * (path.abscissa[k + 1] - path.abscissa[k]))


def inversion(name: str, printed: str, e: Ends, path: Path) -> Iterator[Row]:
    """Yield where the ends of E change places."""
    at = crossing(e, path)
    before, after = path.abscissa < at, path.abscissa > at
    ordered = bool((e.most > e.least)[before].all() and (e.most < e.least)[after].all())
    text = "everywhere" if ordered else "not everywhere"
    yield number(f"{name}: abscissa at which 67.2 and 137.2 GPa err alike, m", printed, at)
    yield claim(f"{name}: below it 137.2 GPa errs more, above it less", text, ordered)


def changes(name: str, design: Design, e: Ends, path: Path) -> Iterator[Row]:
    """Yield where other three cables take over: the cable left out changes sides."""
    chosen = solved(robot(design), path.targets).chosen
    left_out = np.array([6 - sum(cables) for cables in sets_of_three(4)])
    side = np.sign(corners(4)[left_out[chosen], 0])
    (places,) = np.nonzero(np.diff(side))
    text = f"{len(places)} change" + ("s" if len(places) != 1 else "")
    at = float(path.abscissa[places + 1].mean()) if len(places) else math.nan
    yield number(f"{name}: abscissa of the change of cables, m", "3", at, len(places) == 1, text)


def percent(name: str, e: Ends, path: Path) -> Iterator[Row]:
    """Yield between which signed parts the error along the path differs from that in the middle of E."""
    for gpa, error in ((67.2, e.least), (137.2, e.most)):
        part = 100 * (error / e.middle - 1.0)
        low, high = int(part.argmin()), int(part.argmax())
        text = f"{part[low]:+.2f} at {path.abscissa[low]:.2f}, {part[high]:+.2f} at {path.abscissa[high]:.2f}"
        yield unprinted(f"{name}: error at {gpa} GPa against 102.2, % (figure 19)", text)


def between(name: str, design: Design, e: Ends, path: Path) -> Row:
    """Return by how much moduli between the ends leave what the ends bound."""
    low, high = np.minimum(e.least, e.most), np.maximum(e.least, e.most)
    inside = np.linspace(MODULUS_LEAST, MODULUS_MOST, BETWEEN)[1:-1]
    found = [solved(robot(design, float(modulus)), path.targets).error for modulus in inside]
    beyond = np.max([np.maximum(low - error, error - high) for error in found], axis=0)
    k = int(beyond.argmax())
    text = f"at {int((beyond > 1e-9).sum())} of {len(beyond)} targets, {1000 * beyond[k]:.3f} mm at most"
    return unprinted(f"{name}: errors for E between the ends that these do not bound", text)
