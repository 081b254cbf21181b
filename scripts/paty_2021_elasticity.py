"""Table 3 and section 5 of Paty et al. 2021: E = 102.2 +-35 GPa, a range of which both ends are taken."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from paty_2021_design import BEST_RADIUS, NAMES, ONE_JOINT, TWO_JOINTS, responses
from paty_2021_model import (
    MODULUS_LEAST,
    MODULUS_MOST,
    Design,
    Floats,
    corners,
    ends,
    robot,
    sets_of_three,
    solved,
)
from paty_2021_rows import Row, claim, number, unprinted
from paty_2021_targets import Path, Settings, mean, straight

BEST_ARM = {ONE_JOINT: Fraction(40, 13) * BEST_RADIUS[ONE_JOINT], TWO_JOINTS: Fraction("0.1")}
"""m, of table 3; 107.7 mm is printed for the first, its line gives 107.69."""
MEANS = {ONE_JOINT: "53.75", TWO_JOINTS: "23.28"}
"""mm, table 3."""
BOUNDS = {ONE_JOINT: ("-0.29", "1.5", "3.33"), TWO_JOINTS: ("-1.2", "3.9", "21.91")}
"""Section 5.1: deviations of the mean in mm, and their difference in percent of the mean."""
INVERSIONS = {ONE_JOINT: "1.55", TWO_JOINTS: "1.23"}
"""m, section 5.2."""
START, END = (-2.32, 0.0, 0.0), (2.32, 0.0, 3.75)
"""m, of the path of section 5.2."""
MODULI = 9
"""By which it is seen whether the ends of E bound what lies between: the ends, the middle, six more."""


@dataclass(frozen=True)
class Means:
    """Mean errors in mm for E at the lower end, in the middle and at the upper end."""

    soft: float
    middle: float
    stiff: float

    @property
    def lowest(self) -> float:
        """Return the least of the three."""
        return min(self.soft, self.middle, self.stiff)

    @property
    def highest(self) -> float:
        """Return the largest of the three."""
        return max(self.soft, self.middle, self.stiff)

    @property
    def variation(self) -> float:
        """Return how far they lie apart, in percent of the middle."""
        return 100 * (self.highest - self.lowest) / self.middle


def elasticity(settings: Settings) -> Iterator[Row]:
    """Table 3 and section 5."""
    found = {joints: means(optimal(joints, settings), settings) for joints in NAMES}
    one, two = found[ONE_JOINT], found[TWO_JOINTS]
    for joints, name in NAMES.items():
        less = two.middle < one.middle
        yield number(f"{name}*: mean error, mm (table 3)", MEANS[joints], found[joints].middle, less)
    y, _, _ = responses(settings)
    for joints, name in NAMES.items():
        best = 1000 * min(y[:4] if joints == ONE_JOINT else y[4:])
        text = f"{found[joints].middle:.2f}, best test {best:.2f} mm"
        yield claim(f"{name}* errs less than the four tests of its kind", text, found[joints].middle < best)
    for joints, name in NAMES.items():
        yield from bounds(f"{name}*", found[joints], BOUNDS[joints])
    text = f"SR* {one.lowest:.2f}, DR* {two.highest:.2f} mm"
    yield claim("the least mean of SR* stays above the largest of DR*", text, one.lowest > two.highest)
    text = f"SR* {one.variation:.2f}, DR* {two.variation:.2f} %"
    yield claim("the mean of SR* depends less on E than that of DR*", text, one.variation < two.variation)
    yield from on_the_path(settings)


def optimal(joints: int, settings: Settings) -> Design:
    """Return the design of table 3."""
    return Design(4, joints, BEST_ARM[joints], BEST_RADIUS[joints], settings.lead_in)


def means(design: Design, settings: Settings) -> Means:
    """Return the mean errors of a design."""
    soft, stiff = ends(robot(design, (MODULUS_LEAST, MODULUS_MOST)))
    found = (1000 * mean(whole, settings.points).error for whole in (soft, robot(design), stiff))
    return Means(*found)


def bounds(name: str, m: Means, printed: tuple[str, str, str]) -> Iterator[Row]:
    """Yield by how much the mean lies lower and higher at the ends."""
    below, above, total = printed
    at_stiff, at_soft = m.lowest == m.stiff, m.highest == m.soft
    yield number(
        f"{name}: least mean, at 137.2 GPa, from that at 102.2, mm", below, m.lowest - m.middle, at_stiff
    )
    yield number(
        f"{name}: largest mean, at 67.2 GPa, from that at 102.2, mm", above, m.highest - m.middle, at_soft
    )
    yield number(f"{name}: total variation, % of the mean", total, m.variation)


def on_the_path(settings: Settings) -> Iterator[Row]:
    """Yield what E does along the path of section 5.2."""
    whole = straight(START, END, settings.path_points)
    studies = [study(optimal(joints, settings), whole) for joints in NAMES]
    held = np.all([np.isfinite(errors.moduli).all(axis=0) for errors in studies], axis=0)
    path = Path(whole.targets[held], whole.abscissa[held])
    one, two = (OnPath(errors.moduli[:, held], errors.left_out[held]) for errors in studies)
    missed = int((~held).sum())
    yield unprinted("targets on the path that no three cables hold, left out", f"{missed} of {len(held)}")
    for name, errors, printed in zip(("SR*", "DR*"), (one, two), INVERSIONS.values(), strict=True):
        yield from inversion(name, printed, errors, path)
    late, early = crossing(one, path), crossing(two, path)
    text = f"SR* {late:.2f}, DR* {early:.2f} m"
    yield claim("the ends of E change places later for SR*", text, late > early)
    more = (one.ends > two.ends).sum(axis=1)
    text = f"at {', '.join(map(str, more))} of {len(path.abscissa)} targets"
    yield claim("SR* errs more than DR* all along, for the same E", text, (one.ends > two.ends).all())
    yield changes("SR*", one, path)
    yield changes("DR*", two, path)
    upper = path.abscissa > path.abscissa[-1] / 2
    widths = [1000 * float(np.abs(errors.stiff - errors.soft)[upper].mean()) for errors in (one, two)]
    text = f"mean width SR* {widths[0]:.2f}, DR* {widths[1]:.2f} mm"
    yield claim("in the second half the error of DR* depends more on E", text, widths[0] < widths[1])
    for name, errors in (("SR*", one), ("DR*", two)):
        yield from percent(name, errors, path)
        yield between(name, errors)


@dataclass(frozen=True)
class OnPath:
    """Errors of a robot along a path."""

    moduli: Floats
    """(`MODULI`, T), m: for E evenly spaced over its range, both ends and the middle included."""
    left_out: NDArray[np.int64]
    """(T,): the cable that does not carry, with E in the middle."""

    @property
    def soft(self) -> Floats:
        """Return the errors (T,) at the lower end of E."""
        return np.asarray(self.moduli[0])

    @property
    def middle(self) -> Floats:
        """Return the errors (T,) in the middle of E."""
        return np.asarray(self.moduli[MODULI // 2])

    @property
    def stiff(self) -> Floats:
        """Return the errors (T,) at the upper end of E."""
        return np.asarray(self.moduli[-1])

    @property
    def ends(self) -> Floats:
        """Return the three of them (3, T)."""
        return np.stack([self.soft, self.middle, self.stiff])


def study(design: Design, path: Path) -> OnPath:
    """Return the errors of a design along a path; rows of targets that no cables hold are not numbers."""
    soft, stiff = ends(robot(design, (MODULUS_LEAST, MODULUS_MOST)))
    inside = [robot(design, float(e)) for e in np.linspace(MODULUS_LEAST, MODULUS_MOST, MODULI)[1:-1]]
    found = [solved(whole, path.targets) for whole in (soft, *inside, stiff)]
    without = np.array([6 - sum(cables) for cables in sets_of_three(4)])
    return OnPath(np.stack([poses.error for poses in found]), without[found[MODULI // 2].chosen])


def crossing(errors: OnPath, path: Path) -> float:
    """Return the abscissa from which on stiffer cables err less, m; not a number where there is none."""
    more = errors.stiff - errors.soft
    (places,) = np.nonzero((more[:-1] > 0) & (more[1:] <= 0))
    if not len(places):
        return math.nan
    k = int(places[0])
    share = more[k] / (more[k] - more[k + 1])
    return float(path.abscissa[k] + share * (path.abscissa[k + 1] - path.abscissa[k]))


def inversion(name: str, printed: str, errors: OnPath, path: Path) -> Iterator[Row]:
    """Yield where the ends of E change places."""
    at = crossing(errors, path)
    more = errors.stiff > errors.soft
    as_said = np.where(path.abscissa < at, more, ~more)
    yield number(f"{name}: abscissa at which 67.2 and 137.2 GPa err alike, m", printed, at)
    text = f"at {int(as_said.sum())} of {len(more)} targets"
    yield claim(f"{name}: below it 137.2 GPa errs more, above it less", text, as_said.all())


def changes(name: str, errors: OnPath, path: Path) -> Row:
    """Return where other three cables take over: the cable left out changes sides."""
    side = np.sign(corners(4)[errors.left_out, 0])
    (places,) = np.nonzero(np.diff(side))
    at = float(path.abscissa[places + 1].mean()) if len(places) else math.nan
    remark = "" if len(places) == 1 else f"mean of {len(places)} changes"
    return number(f"{name}: abscissa of the change of cables, m", "3", at, len(places) == 1, remark)


def percent(name: str, errors: OnPath, path: Path) -> Iterator[Row]:
    """Yield between which signed parts the error along the path differs from that in the middle of E."""
    for gpa, error in ((67.2, errors.soft), (137.2, errors.stiff)):
        part = 100 * (error / errors.middle - 1.0)
        low, high = int(part.argmin()), int(part.argmax())
        text = f"{part[low]:+.2f} at {path.abscissa[low]:.2f}, {part[high]:+.2f} at {path.abscissa[high]:.2f}"
        yield unprinted(f"{name}: error at {gpa} GPa against 102.2, % (figure 19)", text)


def between(name: str, errors: OnPath) -> Row:
    """Return by how much moduli between the ends leave what the ends bound."""
    low, high = np.minimum(errors.soft, errors.stiff), np.maximum(errors.soft, errors.stiff)
    beyond = np.maximum(low - errors.moduli, errors.moduli - high).max(axis=0)
    text = f"at {int((beyond > 0).sum())} of {len(beyond)} targets, {1000 * beyond.max():.3f} mm at most"
    return unprinted(f"{name}: errors for E in between that the ends do not bound", text)
