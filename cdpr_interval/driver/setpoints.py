"""Where the target should be at a time: set-points with times, straight lines between, and a way to rest."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

Lengths = tuple[float, ...]
"""m, file order."""
SLOWING_SHARE = 0.8
"""Of the acceleration limit, used to slow down when the caller is late."""


@dataclass
class Stream:
    """Set-points of a caller: (time, lengths), times ascending; the first is where the target stands."""

    times: list[float]
    points: list[Lengths]
    at_rest: bool = False
    """True: the last point is the end of the way, and nobody is late."""

    def add(self, time: float, lengths: Lengths, at_rest: bool) -> None:
        """Add a later set-point."""
        self.times.append(time)
        self.points.append(lengths)
        self.at_rest = at_rest

    def lengths(self, time: float) -> Lengths | None:
        """Return where the target should be; None when the caller is late."""
        if time >= self.times[-1]:
            return self.points[-1] if self.at_rest or time == self.times[-1] else None
        after = bisect_right(self.times, time)
        if after == 0:
            return self.points[0]
        (start, end), (before, next_) = self.times[after - 1 : after + 1], self.points[after - 1 : after + 1]
        share = (time - start) / (end - start)
        # What lies behind is not needed any more.
        del self.times[: after - 1], self.points[: after - 1]
        return tuple(a + share * (b - a) for a, b in zip(before, next_, strict=True))

    def is_over(self, time: float) -> bool:
        """Return whether the end of the way is reached."""
        return self.at_rest and time >= self.times[-1]


@dataclass
class Slowing:
    """The way to rest when the caller is late: straight on, all slower together where the limits allow."""

    start: float
    """s."""
    lengths_at_start: Lengths
    speeds: Lengths
    """m/s at the start."""
    times: Lengths
    """s until each winch rests."""

    @classmethod
    def of(
        cls,
        start: float,
        lengths: Lengths,
        speeds: Lengths,
        accelerations: Sequence[float],
        limits: Sequence[tuple[float, float]],
    ) -> Slowing:
        """Return the way to rest from lengths in m and speeds in m/s."""
        together = max(abs(v) / (SLOWING_SHARE * a) for v, a in zip(speeds, accelerations, strict=True))
        times = []
        for length, v, a, (low, high) in zip(lengths, speeds, accelerations, limits, strict=True):
            inside = low <= length + v * together / 2 <= high
            times.append(together if inside else abs(v) / a)
        return cls(start, lengths, speeds, tuple(times))

    def lengths(self, time: float) -> Lengths:
        """Return where the target should be."""
        found = []
        for length, speed, duration in zip(self.lengths_at_start, self.speeds, self.times, strict=True):
            t = min(max(time - self.start, 0.0), duration)
            found.append(length + (speed * t * (1 - t / (2 * duration)) if duration else 0.0))
        return tuple(found)

    def is_over(self, time: float) -> bool:
        """Return whether all winches rest."""
        return time >= self.start + max(self.times)


def smooth(share: float) -> float:
    """Return how far a smooth motion is after a share of its time: 0 to 1, at rest at both ends.

    A polynomial of degree 5; for way and time 1 its speed reaches 15/8, its acceleration 10/sqrt(3).
    """
    t = min(max(share, 0.0), 1.0)
    return t * t * t * (10.0 + t * (6.0 * t - 15.0))


PEAK_SPEED = 15 / 8
PEAK_ACCELERATION = 10 / math.sqrt(3)


def smooth_time(way: float, speed: float, acceleration: float) -> float:
    """Return the least time in s for a smooth motion over a way in m within limits in m/s and m/s^2."""
    return max(PEAK_SPEED * abs(way) / speed, math.sqrt(PEAK_ACCELERATION * abs(way) / acceleration))


def sampled(start: float, duration: float, cycle: float, ways: Iterable[tuple[float, float]]) -> Stream:
    """Return a smooth motion as a stream: from and to in m for each winch, one set-point a cycle."""
    pairs = list(ways)
    steps = max(int(duration / cycle) + 1, 1)
    stream = Stream([start], [tuple(a for a, _ in pairs)])
    for k in range(1, steps + 1):
        share = smooth(k / steps)
        stream.add(start + k * cycle, tuple(a + share * (b - a) for a, b in pairs), k == steps)
    return stream
