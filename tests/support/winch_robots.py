"""Robots with winches for tests: drums of each kind, drives whose truth lies anywhere in the tolerances."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F

from cdpr_interval import load_robot
from cdpr_interval.driver.bus import Command
from cdpr_interval.driver.group import WinchGroup
from cdpr_interval.driver.simulated_drive import SimulatedDrive
from cdpr_interval.driver.simulator import SimulatedBus
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.winch import (
    HelicalDrum,
    LinearDrum,
    Mark,
    MarkSensor,
    MultilayerDrum,
    TableDrum,
    Winch,
    WinchLimits,
)

STARTS = (F("3.1"), F("3.2"), F("3.3"), F("3.4"))
"""m of cable paid out at the start."""
TOLERANCE = F("0.001")
"""m by which the home lengths may be wrong."""


def between(lo: str | int, hi: str | int | None = None) -> Range:
    return Range(F(lo), F(lo if hi is None else hi))


LIMITS = WinchLimits((F("0.5"), F(6)), F("0.5"), F(1), F("0.01"), None)
HELICAL = HelicalDrum(between("0.04998", "0.05002"), between("0.002"), between("0.0025"))
MULTILAYER = MultilayerDrum(
    between("0.0299", "0.0301"), between("0.003"), F(8), 5, between("0.866", 1), F(9), F(1, 2)
)
TABLE = TableDrum(tuple((F(k), F(k) * F("0.31") + F(k * k) / 4000) for k in range(23)), F("0.0005"))
LINEAR = LinearDrum(between("5.899e-8", "5.901e-8"))


def marks(spacing: F = F(1, 4), tolerance: F = F("0.0005"), offset: F = F("0.1"), **others: F) -> MarkSensor:
    """Return marks all along a cable of some metres."""
    places = [(f"m{k}", k * spacing) for k in range(2, int(F(6) / spacing))]
    found = tuple(Mark(name, Range(place - tolerance, place + tolerance)) for name, place in places)
    return MarkSensor(found, offset, others.get("hysteresis", F(0)), others.get("latency", F(0)))


def winch(node: int = 1, sign: int = 1, drum: object = HELICAL, sensor: MarkSensor | None = None) -> Winch:
    gear, counts = (F(1), 1) if isinstance(drum, LinearDrum) else (F(156, 7), 65536)
    return Winch(drum, gear, counts, sign, F(1), LIMITS, node, sensor)  # type: ignore[arg-type]


def robot_with_winches(
    name: str = "merlet_4_1", drum: object = HELICAL, sensor: MarkSensor | None = None
) -> Robot:
    """Return a shipped robot with a winch on every cable; signs alternate."""
    robot = load_robot(name)
    cables = tuple(
        replace(cable, winch=winch(i + 1, 1 if i % 2 else -1, drum, sensor))
        for i, cable in enumerate(robot.cables)
    )
    return replace(robot, cables=cables)


class Bench:
    """Simulated drives, everything that was sent to them, and the group that moves them."""

    def __init__(
        self,
        robot: Robot | None = None,
        starts: tuple[F, ...] = STARTS,
        shares: tuple[F, ...] = (F(0), F(1, 3), F(2, 3), F(1)),
        readings: tuple[int, ...] = (0, 5, -7, 11),
        log: object = None,
    ) -> None:
        self.robot = robot or robot_with_winches()
        self.starts = starts
        self.sent: list[tuple[float, tuple[Command, ...]]] = []
        self.drives = [
            SimulatedDrive(cable.winch, start, share, first_reading=reading)  # type: ignore[arg-type]
            for cable, start, share, reading in zip(self.robot.cables, starts, shares, readings, strict=True)
        ]
        self.bus = SimulatedBus(
            self.drives, observer=lambda time, commands: self.sent.append((time, commands))
        )
        self.group = WinchGroup(self.robot, self.bus, log)  # type: ignore[arg-type]

    def homed(self) -> Bench:
        """Connect and set the home lengths, wrong by less than the tolerance."""
        self.group.connect()
        self.group.home([Range(s - TOLERANCE, s + TOLERANCE) for s in self.starts])
        return self

    def enabled(self) -> Bench:
        self.homed()
        self.group.enable()
        return self

    @property
    def true_lengths(self) -> list[F]:
        return [drive.true_length for drive in self.drives]

    def contains_truth(self) -> bool:
        ranges = self.group.length_ranges()
        return all(F(lo) <= true <= F(hi) for (lo, hi), true in zip(ranges, self.true_lengths, strict=True))


def smooth_path(
    start: list[float], end: list[float], duration: float, cycle: float = 0.01
) -> list[tuple[float, list[float]]]:
    """Return set-points of a smooth motion, the first a cycle from now."""
    steps = max(int(duration / cycle), 1)
    found = []
    for k in range(1, steps + 1):
        t = k / steps
        share = t**3 * (10 + t * (6 * t - 15))
        point = [a + share * (b - a) for a, b in zip(start, end, strict=True)]
        found.append((5 * cycle + k * cycle, point))
    return found
