"""Statistics of numbers and of angles: an angle of 179 degrees is near one of -179."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

PERCENTILES = (5, 25, 50, 75, 95)
TURN = 360.0


def statistics(values: Sequence[float]) -> dict[str, float]:
    """Return count, mean, standard deviation, least, largest and percentiles."""
    mean = math.fsum(values) / len(values)
    deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in values) / len(values))
    found = {"count": len(values), "mean": mean, "std": deviation, "min": min(values), "max": max(values)}
    shares = np.percentile(np.array(values), PERCENTILES).tolist()
    return found | {f"p{percent}": value for percent, value in zip(PERCENTILES, shares, strict=True)}


def circular_statistics(degrees: Sequence[float]) -> dict[str, float]:
    """Return the same of angles, measured from their mean direction.

    Parameters
    ----------
    degrees : sequence of float

    Returns
    -------
    dict
        The mean is in (-180, 180]; all else is the mean plus a deviation in [-180, 180): around half a turn a
        percentile may be 181. ``resultant`` is the length of the mean of the unit vectors: 1 where all
        angles are the same, near 0 where they have no mean direction.
    """
    mean, resultant = mean_direction(degrees)
    found = statistics(unwrapped(degrees))
    # The mean of the deviations is not quite zero: the mean of angles is their direction.
    return found | {"mean": mean, "resultant": resultant}


def mean_direction(degrees: Sequence[float]) -> tuple[float, float]:
    """Return the direction in degrees and the length of the mean of unit vectors."""
    angles = [math.radians(angle) for angle in degrees]
    x, y = (math.fsum(map(part, angles)) / len(angles) for part in (math.cos, math.sin))
    return math.degrees(math.atan2(y, x)), min(math.hypot(x, y), 1.0)


def unwrapped(degrees: Sequence[float]) -> list[float]:
    """Return angles within half a turn of their mean direction: beside each other as numbers too."""
    mean, _ = mean_direction(degrees)
    return [mean + deviation(angle, mean) for angle in degrees]


def deviation(angle: float, mean: float) -> float:
    """Return the way from one angle to another, in [-180, 180) degrees."""
    return (angle - mean + TURN / 2) % TURN - TURN / 2
