"""Winches for one command: drives in memory for a dry run, or a real bus; what is kept between commands."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from cdpr_interval.driver.bus import DriveBus
from cdpr_interval.driver.canopen_bus import CanOpenBus
from cdpr_interval.driver.group import WinchGroup
from cdpr_interval.driver.reference import Known
from cdpr_interval.driver.simulated_drive import SimulatedDrive
from cdpr_interval.driver.simulator import SimulatedBus
from cdpr_interval.driver.state_file import read_state, write_state
from cdpr_interval.errors import InputError
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.statics import Pose
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.winch import Winch
from solvers.answers.ik_result import IkResult
from solvers.classes import class_of
from solvers.kinematics.inverse import inverse_kinematics

DRY_TOLERANCE = Fraction(1, 1000)
"""m by which the lengths of simulated drives count as known when nothing else says so."""


@dataclass(frozen=True)
class BusAddress:
    """Where the drives are, as python-can takes it."""

    interface: str
    channel: str


def read_bus(text: str) -> BusAddress:
    """Return the address of ``INTERFACE:CHANNEL``; `InputError` for another text."""
    interface, colon, channel = text.partition(":")
    if not (interface and colon and channel):
        raise InputError(f"--bus: must be INTERFACE:CHANNEL, for example socketcan:can0, got {text!r}")
    return BusAddress(interface, channel)


def winches_of(robot: Robot) -> list[Winch]:
    """Return the winches of all cables; `InputError` when there are none."""
    found = [cable.winch for cable in robot.cables if cable.winch is not None]
    if len(found) != len(robot.cables):
        raise InputError(f"robot '{robot.name}' has no winches: add a winch block to every cable")
    return found


def hanging_at(robot: Robot, pose: Pose, label: str = "--pose") -> IkResult:
    """Return where the robot hangs near a pose, with its lengths; `InputError` when it hangs nowhere near."""
    found = inverse_kinematics(robot, pose.position, pose.rotation, settle=class_of(robot).turns)
    if found.lengths is None:
        raise InputError(f"{label}: {found.message}")
    return found


def lengths_at(robot: Robot, pose: Pose, label: str = "--pose") -> list[Fraction]:
    """Return the lengths in m with which the robot hangs at a pose; `InputError` when it cannot."""
    return [Fraction(length) for length in hanging_at(robot, pose, label).lengths or ()]


@contextmanager
def winches(
    robot: Robot,
    address: BusAddress | None,
    state: Path | None,
    start: Sequence[Fraction] | None = None,
    log: Path | None = None,
    anywhere: bool = False,
) -> Iterator[WinchGroup]:
    """Connect the winches of a robot; leaving stops and disables them, and writes the state file.

    Parameters
    ----------
    robot : Robot
    address : BusAddress, optional
        None: drives in memory, a dry run, and the state file is only read.
    state : Path, optional
        References and readings of an earlier command; written at the end when the drives are real.
    start : sequence of Fraction, optional
        m: lengths at which drives in memory start; the default is the state file's.
    log : Path, optional
        Audit log.
    anywhere : bool
        Drives in memory may be where nothing says they are: they start in the middle of their limits, and
        their lengths count as unknown.

    Raises
    ------
    InputError
        For a wrong state file, or when nothing says where drives in memory are.
    """
    fitted = winches_of(robot)
    known = [None] * len(fitted) if state is None or not state.exists() else read_state(state, robot)
    if address is None:
        bus = _dry(fitted, known, start, anywhere)
    else:
        bus = CanOpenBus.of(robot, address.interface, address.channel)
    group = WinchGroup(robot, bus, log)
    if start is None or address is not None:
        group.adopt(known)
    with group:
        if start is not None and address is None:
            group.home([Range(length - DRY_TOLERANCE, length + DRY_TOLERANCE) for length in start])
        try:
            yield group
        finally:
            if state is not None and address is not None:
                write_state(state, robot, group.known())


def _dry(
    fitted: Sequence[Winch], known: Sequence[Known | None], start: Sequence[Fraction] | None, anywhere: bool
) -> DriveBus:
    """Return drives in memory, where the state file says the real ones are, or at given lengths."""
    if start is not None:
        return SimulatedBus([SimulatedDrive(w, length) for w, length in zip(fitted, start, strict=True)])
    drives = []
    for winch, one in zip(fitted, known, strict=True):
        if one is None and anywhere:
            least, most = winch.limits.length
            drives.append(SimulatedDrive(winch, (least + most) / 2))
            continue
        if one is None:
            raise InputError("--from: missing (where is the platform? or --state FILE of earlier commands)")
        drives.append(SimulatedDrive(winch, one.reference.nominal(one.reading), first_reading=one.reading))
    return SimulatedBus(drives)
