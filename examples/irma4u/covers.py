"""Where IRMA4U can be, for eight measured configurations whose lengths are known to 2 mm.

For each configuration ``fk`` covers every static pose for any lengths in the ranges: it lies in an entry or
in an undecided region of the answer. The table says which cables can be taut around the orientation of the
inertial unit, within which bounds roll and pitch then are, and how far one choice of lengths in the ranges is
from the measured ones for which a pose is proved whose roll and pitch agree with the unit to 30 mrad.

``python examples/irma4u/covers.py`` (a minute on one core, kernels compiled).
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from solvers import forward_kinematics, inverse_kinematics
from solvers.answers.angles import rpy_enclosures
from solvers.answers.data import Solution, Undecided
from solvers.answers.result import Result

Floats = NDArray[np.float64]
Range = tuple[float, float]

MEASURED = Path(__file__).parent / "measured.csv"
ROBOT = "irma4u"
TOLERANCE = "0.002"
"""m, of every length."""
AGREES = 0.03
"""rad, of roll and of pitch, between a pose and the inertial unit."""
STEPS = 8
"""Steps of the search for lengths: far more than it needs."""


@dataclass(frozen=True)
class Measured:
    """One configuration as it was measured."""

    name: str
    lengths: tuple[str, ...]
    """m, decimals as they stand in the file."""
    rotation: Floats
    """(3, 3) of the inertial unit, platform to base."""

    @property
    def rpy(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw of the inertial unit in rad, R = Rz(yaw) Ry(pitch) Rx(roll) as everywhere here."""
        r = self.rotation
        return math.atan2(r[2, 1], r[2, 2]), math.asin(-r[2, 0]), math.atan2(r[1, 0], r[0, 0])

    def ranges(self, tolerance: Fraction) -> list[tuple[Fraction, Fraction]]:
        """Return the exact ranges of the lengths, m."""
        return [(Fraction(x) - tolerance, Fraction(x) + tolerance) for x in self.lengths]


def measured(path: Path = MEASURED) -> list[Measured]:
    """Return the configurations of a file."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = csv.DictReader(lines)
    return [
        Measured(
            row["configuration"],
            tuple(row[f"c{i}_m"] for i in range(1, 5)),
            imu_rotation(*(float(row[f"{angle}_rad"]) for angle in ("roll", "pitch", "yaw"))),
        )
        for row in rows
    ]


def imu_rotation(roll: float, pitch: float, yaw: float) -> Floats:
    """Return R = Rx(roll) Ry(pitch) Rz(yaw), the order of the source."""
    about = []
    for axis, angle in enumerate((roll, pitch, yaw)):
        turn, (i, j) = np.eye(3), ((axis + 1) % 3, (axis + 2) % 3)
        turn[i, i] = turn[j, j] = math.cos(angle)
        turn[j, i], turn[i, j] = math.sin(angle), -math.sin(angle)
        about.append(turn)
    x, y, z = about
    return np.asarray(x @ y @ z)


Found = Solution | Undecided


def found_in(result: Result) -> list[Found]:
    """Return all entries and regions of an answer."""
    return [*result.solutions, *result.undecided]


def places(result: Result, one: Measured) -> list[Found]:
    """Return where the platform can be: the entries and regions of an answer around the measured orientation.

    They are those that hold a roll and a pitch within 30 mrad of the inertial unit's, and all others that
    overlap with them, directly or through others: for some lengths other cables are taut.
    """
    left = found_in(result)
    todo = [found for found in left if agrees(found, one)]
    left = [found for found in left if not agrees(found, one)]
    around = []
    while todo:
        place = todo.pop()
        around.append(place)
        todo += [found for found in left if meet(found, place)]
        left = [found for found in left if not meet(found, place)]
    return around


def agrees(found: Found, one: Measured) -> bool:
    """Return whether some roll and some pitch of a place are within 30 mrad of the inertial unit's."""
    roll, pitch, _ = rpy_enclosures(found.rotation)
    # Where an angle is not bounded it may be anything.
    return (roll is None or near(roll, one.rpy[0])) and (pitch is None or near(pitch, one.rpy[1]))


def near(degrees: Range, angle: float) -> bool:
    """Return whether a range in degrees comes within 30 mrad of an angle in rad."""
    lo, hi = in_rad(degrees)
    return any(lo - AGREES <= angle + turn <= hi + AGREES for turn in (-2 * math.pi, 0.0, 2 * math.pi))


def in_rad(degrees: Range) -> Range:
    """Return a range of degrees in rad."""
    return math.radians(degrees[0]), math.radians(degrees[1])


def taut_of(result: Result, found: Found) -> str:
    """Return the taut cables of an entry or a region."""
    names = [result.cables[i] for i in found.taut]
    if isinstance(found, Solution):
        states = zip(result.cables, found.cable_states, strict=True)
        names += [f"{name}?" for name, state in states if state.value in ("undecided", "switching")]
    return " ".join(sorted(names))


def hull(around: Sequence[Found], angle: int) -> str:
    """Return the bounds in rad of an angle (0 roll, 1 pitch) over all poses of some places."""
    ranges = [rpy_enclosures(found.rotation)[angle] for found in around]
    ends = [in_rad((-180.0, 180.0) if found is None else found) for found in ranges]
    return f"{min(lo for lo, _ in ends):+.3f} .. {max(hi for _, hi in ends):+.3f}" if ends else "none"


@dataclass(frozen=True)
class Witness:
    """A choice of exact lengths in the ranges, and its proved pose with four taut cables."""

    off: float
    """m, the largest distance of a length from the measured one."""
    roll: float
    pitch: float
    """rad, how far from the inertial unit's they are at most, all of the pose's box counted."""
    in_cover: bool
    """The box of the pose overlaps an entry or a region of the cover."""


def witness(one: Measured, start: Floats, cover: Result) -> Witness | None:
    """Return the pose of four taut cables with about the inertial unit's orientation and nearest lengths.

    Plain floats settle poses with that orientation and move them until the lengths fit best; then ``fk``
    proves the pose of the decimals found, or None is returned.
    """
    lengths = fitting_lengths(one, start)
    result = forward_kinematics(ROBOT, lengths, taut="c1,c2,c3,c4")
    best: Witness | None = None
    for pose in result.solutions:
        roll, pitch, _ = rpy_enclosures(pose.rotation)
        if not pose.is_decided or roll is None or pitch is None:
            continue
        away = [
            max(abs(end - angle) for end in in_rad(found))
            for found, angle in ((roll, one.rpy[0]), (pitch, one.rpy[1]))
        ]
        off = max(abs(Fraction(x) - Fraction(y)) for x, y in zip(lengths, one.lengths, strict=True))
        held = any(meet(pose, place) for place in found_in(cover))
        now = Witness(float(off), away[0], away[1], held)
        if best is None or max(now.roll, now.pitch) < max(best.roll, best.pitch):
            best = now
    return best


def fitting_lengths(one: Measured, position: Floats) -> list[str]:
    """Return lengths as decimals to a micrometre, near the measured ones, of a pose near an orientation."""
    wanted, best, off = np.array([float(x) for x in one.lengths]), None, math.inf
    for _ in range(STEPS):
        pose = inverse_kinematics(ROBOT, position, rpy=one.rpy, settle=True)
        distances = np.array(pose.distances)
        if pose.is_static and np.abs(distances - wanted).max() < off:
            best, off = distances, float(np.abs(distances - wanted).max())
        position = position - np.linalg.lstsq(slopes(one, position), distances - wanted, rcond=None)[0]
    return [f"{x:.6f}" for x in (wanted if best is None else best)]


def slopes(one: Measured, position: Floats) -> Floats:
    """Return the derivatives (4, 3) of the lengths by the position, by differences of 10 um."""
    steps = 1e-5 * np.eye(3)
    ways = [
        [np.array(inverse_kinematics(ROBOT, position + s * step, rpy=one.rpy).distances) for s in (1, -1)]
        for step in steps
    ]
    return np.array([(after - before) / 2e-5 for after, before in ways]).T


def meet(one: Found, other: Found) -> bool:
    """Return whether two places overlap, position and rotation."""
    return overlap(one.position, other.position) and overlap(one.rotation, other.rotation)


def overlap(a: Floats, b: Floats) -> bool:
    """Return whether two boxes (..., 2) overlap."""
    return bool((np.maximum(a[..., 0], b[..., 0]) <= np.minimum(a[..., 1], b[..., 1])).all())


def middle_of(result: Result, one: Measured) -> Floats:
    """Return the middle of the place nearest to the orientation of the inertial unit, m."""
    found = found_in(result)
    away = [np.abs(place.rotation.mean(axis=2) - one.rotation).max() for place in found]
    return np.asarray(found[int(np.argmin(away))].position.mean(axis=1))


@dataclass(frozen=True)
class Row:
    """What is found of one configuration."""

    one: Measured
    result: Result
    seconds: float
    """Processor time of the cover."""
    around: list[Found]
    witness: Witness | None

    @property
    def is_cover(self) -> bool:
        """True when every pose for any lengths in the ranges lies in an entry or a region."""
        return self.result.stop_reason == "exhausted" and not self.result.pending

    @property
    def taut_sets(self) -> list[str]:
        """What is taut in the places around the measured orientation."""
        return sorted({taut_of(self.result, found) for found in self.around}, key=lambda x: (len(x), x))

    def is_proved(self, tolerance: Fraction) -> bool:
        """Return whether a pose in the cover, for lengths in the ranges, is proved to agree."""
        found = self.witness
        if found is None or not (self.is_cover and found.in_cover):
            return False
        return found.roll <= AGREES and found.pitch <= AGREES and found.off <= tolerance

    def text(self, tolerance: Fraction) -> str:
        """Return the line of the table."""
        proved = self.is_proved(tolerance)
        shown = f"{1e3 * self.witness.off:.2f} mm" if proved and self.witness else "-"
        elsewhere = len(self.result.solutions) + len(self.result.undecided) - len(self.around)
        roll, pitch, _ = self.one.rpy
        agreed = (
            "yes, proved" if proved else "may be" if self.around else "no" if self.is_cover else "unknown"
        )
        return (
            f"{self.one.name:2}{'cover' if self.is_cover else 'stopped':9}"
            f"{hull(self.around, 0):18}{roll:+.3f}  {hull(self.around, 1):18}{pitch:+.3f}  "
            f"{agreed:16}{shown:>9}{elsewhere:11}"
            f"{self.result.statistics.cells:9}{self.seconds:7.1f}  {', '.join(self.taut_sets)}"
        )


HEAD = (
    f"{'#':2}{'ended':9}{'roll, cover':18}{'IMU':8}{'pitch, cover':18}{'IMU':8}{'within 30 mrad':16}"
    f"{'proved at':>9}{'elsewhere':>11}{'cells':>9}{'CPU s':>7}  taut sets possible there"
)


def row(one: Measured, tolerance: Fraction) -> Row:
    """Cover a configuration, and look for lengths whose pose agrees."""
    before = time.process_time()
    result = forward_kinematics(ROBOT, one.ranges(tolerance))
    seconds = time.process_time() - before
    around = places(result, one)
    found = witness(one, middle_of(result, one), result) if around else None
    return Row(one, result, seconds, around, found)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tolerance", default=TOLERANCE, help="of every length, m (default: %(default)s)")
    parser.add_argument("configurations", nargs="*", help="0 to 7; all by default")
    options = parser.parse_args()
    tolerance = Fraction(options.tolerance)
    print(f"lengths +-{options.tolerance} m; angles in rad, R = Rz(yaw) Ry(pitch) Rx(roll)\n{HEAD}")
    for one in measured():
        if not options.configurations or one.name in options.configurations:
            print(row(one, tolerance).text(tolerance), flush=True)


if __name__ == "__main__":
    main()
