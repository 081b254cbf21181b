"""Section 3.3 of Paty et al. 2021: position errors along a path and on the plane z = 2.5 m."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from paty_2021_model import HEIGHT, SIDE, Design, Floats, Poses, robot, solved
from paty_2021_rows import Row, claim, number, unprinted
from paty_2021_targets import Path, Settings, plane, rising

AT_CENTRE, BETWEEN, AT_CORNER = "centre", "between", "corners"
NEAR, FAR = 0.1, 0.8
"""Parts of the way from the centre of the plane to a corner: up to the first it is the centre, from the
second the corners."""


def both(cables: int, settings: Settings) -> tuple[Design, Design]:
    """Return the robots of section 3 with pulleys on one joint and on two."""
    return Design(cables, 1, lead_in=settings.lead_in), Design(cables, 2, lead_in=settings.lead_in)


def paths(settings: Settings) -> Iterator[Row]:
    """Section 3.3.1: errors along a straight path, as far as the tension limit lets the robot go."""
    for cables, printed in ((3, "6.61"), (4, "7.07")):
        length = rising(cables, 2).abscissa[-1]
        remark = "6.6127 with its end points as printed, to the centimetre" if cables == 3 else ""
        yield number(f"CDPR{cables}: length of the path, m", printed, length, remark=remark)
    yield number("CDPR3: volume of the outer envelope, m3", "54.13", math.sqrt(3) / 4 * SIDE**2 * HEIGHT)
    yield number("CDPR4: volume of the outer envelope, m3", "125", SIDE**2 * HEIGHT)
    for cables in (3, 4):
        path = rising(cables, settings.path_points)
        found = [(design, solved(robot(design), path.targets)) for design in both(cables, settings)]
        for design, poses in found:
            yield from along(design, poses, path)
        yield from compared(found, path)


def reach(poses: Poses) -> int:
    """Return how many targets there are before the first at which a tension is above the limit."""
    beyond = np.nonzero(poses.valid & ~poses.within)[0]
    return int(beyond[0]) if len(beyond) else len(poses.targets)


def along(design: Design, poses: Poses, path: Path) -> Iterator[Row]:
    """Yield how far a robot gets on its path, and its least and largest error on the way."""
    end = reach(poses)
    error, s = poses.error[:end], path.abscissa[:end]
    yield unprinted(
        f"{design.name}: within the tension limit up to abscissa, height, m",
        f"{s[-1]:.2f}, {poses.targets[end - 1, 2]:.2f}",
    )
    missed = np.nonzero(~poses.valid[:end])[0]
    where = f", at {s[missed[0]]:.2f} to {s[missed[-1]]:.2f} m" if len(missed) else ""
    text = f"{len(missed)} of {end}{where}"
    yield unprinted(f"{design.name}: targets of these that no three cables hold, left out", text)
    low, high = int(np.nanargmin(error)), int(np.nanargmax(error))
    text = f"{error[low]:.4f} at {s[low]:.2f}, {error[high]:.4f} at {s[high]:.2f}"
    yield unprinted(f"{design.name}: least and largest error on the others, m (figure 11)", text)


def compared(found: Sequence[tuple[Design, Poses]], path: Path) -> Iterator[Row]:
    """Yield what the paper says of one and of two joints on the path."""
    (design, one), (_, two) = found
    name = f"CDPR{design.cables}"
    heights = [float(poses.targets[reach(poses) - 1, 2]) for poses in (one, two)]
    yield claim(
        f"{name}: one joint lets it get slightly higher than two",
        f"SR {heights[0]:.3f}, DR {heights[1]:.3f} m",
        heights[0] > heights[1],
    )
    no_less = one.valid & two.valid & (two.error >= one.error)
    up_to = path.targets[int(no_less.argmax()), 2] if no_less.any() else HEIGHT
    yield claim(
        f"{name}: two joints err less on the lower part (a third at least)",
        f"up to a height of {up_to:.2f} m",
        up_to >= HEIGHT / 3,
    )


def planes(settings: Settings) -> Iterator[Row]:
    """Section 3.3.2: errors on the plane z = 2.5 m."""
    for cables in (3, 4):
        targets = plane(cables, settings.plane_intervals)
        one, two = (solved(robot(design), targets) for design in both(cables, settings))
        yield from (three_cables if cables == 3 else four_cables)(one, two, settings)
        for design, poses in zip(both(cables, settings), (one, two), strict=True):
            missed = int((~poses.valid).sum())
            text = f"{missed} of {len(targets)}, {100 * missed / len(targets):.1f} %"
            yield unprinted(f"{design.name}: targets that no three cables hold, left out", text)
        held = one.valid & two.valid
        smaller = (two.error < one.error)[held]
        yield claim(
            f"CDPR{cables}: two joints err less everywhere on the plane",
            f"at {smaller.sum()} of {held.sum()} targets",
            smaller.all(),
        )


def three_cables(one: Poses, two: Poses, settings: Settings) -> Iterator[Row]:
    """Yield the rows of CDPR3 on the plane."""
    yield extreme("CDPR3_SR: least error, in the centre, m", "0.13", one, np.nanargmin, AT_CENTRE)
    yield extreme("CDPR3_SR: largest error, at the corners, m", "0.21", one, np.nanargmax, AT_CORNER)
    rigid = solved(robot(both(3, settings)[1], None), two.targets)
    for poses, what in ((two, ""), (rigid, ", no stretch")):
        k = int(np.nanargmin(poses.error))
        yield claim(
            f"CDPR3_DR: least error between centre and corners{what}",
            f"{poses.error[k]:.4f} m at {shown(poses, k)}",
            place(poses, k) == BETWEEN,
        )


def four_cables(one: Poses, two: Poses, settings: Settings) -> Iterator[Row]:
    """Yield the rows of CDPR4 on the plane."""
    yield extreme("CDPR4_SR: least error, in the centre, m", "0.09", one, np.nanargmin, AT_CENTRE)
    yield extreme("CDPR4_SR: largest error, at the corners, m", "0.19", one, np.nanargmax, AT_CORNER)
    yield extreme("CDPR4_DR: least error, in the corners, m", "0.035", two, np.nanargmin, AT_CORNER)
    yield extreme("CDPR4_DR: largest error, in the central area, m", "0.08", two, np.nanargmax, AT_CENTRE)


def extreme(quantity: str, printed: str, poses: Poses, which: Callable[[Floats], np.intp], where: str) -> Row:
    """Return the row of the least or largest error on the plane."""
    k = int(which(poses.error))
    row = number(quantity, printed, poses.error[k], place(poses, k) == where)
    return Row(row.quantity, f"{row.ours} at {shown(poses, k)}", printed, row.value, row.holds)


def place(poses: Poses, k: int) -> str:
    """Return in which part of the plane a target lies."""
    x, y = poses.targets[k, :2]
    far = math.hypot(*max(poses.targets[:, :2], key=lambda p: math.hypot(*p)))
    part = math.hypot(x, y) / far
    return AT_CENTRE if part <= NEAR else AT_CORNER if part >= FAR else BETWEEN


def shown(poses: Poses, k: int) -> str:
    """Return x and y of a target."""
    x, y = poses.targets[k, :2]
    return f"({x + 0.0:.2f}, {abs(y) if abs(y) < 5e-3 else y:.2f})"
