"""What the commands of winches print: as text, or as JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from cdpr_interval.driver.snapshot import Snapshot
    from cdpr_interval.mechanics.statics import Pose
    from cdpr_interval.robots.cable_robot import Robot
    from solvers.answers.data import Solution
    from solvers.answers.ik_result import IkResult
    from solvers.winches.path import Path as CablePath
    from solvers.winches.path import Proved
    from solvers.winches.where import Whereabouts


def _outward(lo: float, hi: float, decimals: int = 6) -> tuple[str, str]:
    """Return bounds as decimals that still enclose."""
    from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal

    step = Decimal(1).scaleb(-decimals)
    return str(Decimal(lo).quantize(step, ROUND_FLOOR)), str(Decimal(hi).quantize(step, ROUND_CEILING))


def shown_pose(robot: Robot, pose: Pose) -> str:
    """Return a pose as it was understood: position, and the angles of what turns."""
    from cdpr_interval.mechanics.orientation import rpy_from_rotation
    from solvers.answers.angles import shown_angles
    from solvers.classes import class_of

    place = f"({', '.join(f'{x:z.6f}' for x in pose.position.tolist())}) m"
    angles = shown_angles(rpy_from_rotation(pose.rotation))
    return f"{place}, roll pitch yaw ({angles})" if class_of(robot).turns else place


def shown_hanging(robot: Robot, found: IkResult) -> str:
    """Return where a robot hangs near a pose that was asked for, and how far that is from it."""
    import numpy as np

    from cdpr_interval.mechanics.statics import Pose

    return f"{shown_pose(robot, Pose(np.array(found.position), np.array(found.rotation)))}: {found.message}"


def print_status(snapshot: Snapshot, as_json: bool) -> None:
    """Print drives, readings and what is known of the lengths."""
    if as_json:
        ranges = [cable.length_range() for cable in snapshot.cables]
        root = snapshot.to_json()
        for cable, bounds in zip(root["cables"], ranges, strict=True):
            cable["length_range_m"] = None if bounds is None else list(bounds)
        click.echo(json.dumps(root))
        return
    click.echo(f"winches {snapshot.state.value}")
    for cause in snapshot.causes:
        click.echo(f"  {cause}")
    for cable in snapshot.cables:
        bounds = cable.length_range()
        text = "length unknown" if bounds is None else f"{' to '.join(_outward(*bounds))} m"
        source = "" if cable.reference is None else f", since {cable.reference.source}"
        drive = "silent" if cable.drive is None else cable.drive.value
        click.echo(f"  {cable.name}  {drive}  {cable.counts} counts  {cable.state.value}{source}  {text}")


def print_where(robot: Robot, ranges: list[tuple[float, float]], found: Whereabouts, as_json: bool) -> None:
    """Print measured lengths and the certified poses for them."""
    from solvers.answers.angles import shown_angles
    from solvers.classes import class_of

    names = robot.cable_names
    if as_json:
        document = {
            "lengths_m": [list(bounds) for bounds in ranges],
            "message": found.message,
            "poses": [pose.to_json(names) for pose in found.poses],
            "at_the_middles_only": [_nominal(solution) for solution in found.lost],
        }
        click.echo(json.dumps(document))
        return
    for name, (lo, hi) in zip(names, ranges, strict=True):
        click.echo(f"{name}  {' to '.join(_outward(lo, hi))} m")
    click.echo(found.message)
    for pose in found.poses:
        place = ", ".join(f"[{', '.join(_outward(lo, hi))}]" for lo, hi in pose.position.tolist())
        taut = ",".join(names[i] for i in pose.taut) or "no cable proved"
        either = ",".join(names[i] for i in pose.tight if i not in pose.taut)
        shared = f"{either} taut or just slack, " if either else ""
        click.echo(f"position ({place}) m, {taut} taut, {shared}{pose.stability.value}")
        if class_of(robot).turns:
            angles = shown_angles(pose.solution.nominal.rpy)
            click.echo(f"  roll pitch yaw near ({angles})")
    for solution in found.lost:
        nominal = solution.nominal
        place = ", ".join(f"{x:z.6f}" for x in nominal.position)
        angles = shown_angles(nominal.rpy)
        click.echo(f"for the middles of the lengths only: ({place}) m, roll pitch yaw near ({angles})")


def _nominal(solution: Solution) -> dict[str, Any]:
    nominal = solution.nominal
    return {
        "position_m": list(nominal.position),
        "quaternion_wxyz": list(nominal.quaternion_wxyz),
        "rpy_rad": list(nominal.rpy),
    }


def print_path(robot: Robot, path: CablePath) -> None:
    """Print what was proved of a path, cable by cable."""
    names = robot.cable_names
    either = [names[i] for i in path.tight if i not in path.taut]
    shared = f"; taut or just slack, the position is proved either way: {','.join(either)}" if either else ""
    taut = ",".join(names[i] for i in path.taut) or "none"
    click.echo(
        f"path of {path.times[-1]:.2f} s proved in {path.pieces} pieces, taut all along: {taut}{shared}"
    )
    click.echo("cable  goal m      margin m  peak m/s  peak m/s2  tension N")
    for i, name in enumerate(robot.cable_names):
        least, most = path.tensions[i].tolist()
        lo, hi = _outward(least, most, 2)
        row = f"{path.lengths[-1, i]:<10.6f}  {path.margins[i]:<8.4f}  {path.speeds[i]:<8.4f}"
        click.echo(f"{name:<5}  {row}  {path.accelerations[i]:<9.4f}  {lo} to {hi}")


def shown_way(told: Sequence[Proved]) -> str:
    """Return how far a path is proved that is not proved to its end."""
    if not told:
        return "no part of the path is proved; nothing was moved"
    (far,) = told
    share = int(100 * far.travel)
    time = f"{far.seconds:.2f} of {far.duration:.2f} s"
    return f"the path is proved for {time}, {share} % of the way; nothing was moved"


def say_dry(live: bool) -> None:
    """Say on standard error that nothing was moved, when nothing was."""
    if not live:
        click.echo("dry run on simulated drives: nothing was moved", err=True)


def print_truth(robot: Robot, lengths: list[float], as_json: bool) -> None:
    """Print true lengths in m, and where the platform hangs with them."""
    from solvers.winches.where import whereabouts

    found = whereabouts(robot, [(length, length) for length in lengths])
    if as_json:
        points = [list(pose.point) for pose in found.poses]
        click.echo(json.dumps({"true_lengths_m": lengths, "true_positions_m": points}))
        return
    click.echo("true lengths " + ", ".join(f"{length:.6f}" for length in lengths) + " m")
    for pose in found.poses:
        click.echo("true position (" + ", ".join(f"{x:.6f}" for x in pose.point) + ") m")
    sys.stdout.flush()
