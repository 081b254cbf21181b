"""``cdpr-solve winch``: winches moved by a person: status, where, move, jog, home, marks, stop, simulate."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeVar

import click

from solvers.commands.numbers import read_distance, read_float, say_middles, warn_of_lengths
from solvers.commands.winch_output import (
    print_path,
    print_status,
    print_truth,
    print_where,
    say_dry,
    shown_hanging,
    shown_pose,
    shown_way,
)
from solvers.shell.completion import files, robot_argument
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from cdpr_interval.driver.group import WinchGroup
    from cdpr_interval.driver.reference import Reference
    from cdpr_interval.mechanics.statics import Pose
    from cdpr_interval.robots.cable_robot import Robot
    from solvers.winches.path import Path as CablePath
    from solvers.winches.path import Proved

Function = TypeVar("Function", bound=Callable[..., Any])

DEFAULT_TOLERANCE = "0.002"
"""m: of home lengths."""


def _options(*names: str) -> Callable[[Function], Function]:
    """Return a decorator with options that several commands have."""
    known: dict[str, Callable[[Function], Function]] = {
        "bus": click.option("--bus", metavar="INTERFACE:CHANNEL", help="Real drives, e.g. socketcan:can0."),
        "state": click.option(
            "--state",
            metavar="FILE",
            shell_complete=files,
            help="What is known of the cables between commands.",
        ),
        "from": click.option(
            "--from", "start", metavar="X,Y,Z[,R,P,Y]", help="Dry run: where the platform is."
        ),
        "json": click.option("--json", "as_json", is_flag=True, help="Print JSON instead of text."),
        "log": click.option(
            "--log", metavar="FILE", shell_complete=files, help="Audit log; lines are added."
        ),
        "live": click.option("--live", is_flag=True, help="Move real drives; without it: a dry run."),
        "arm": click.option("--arm", metavar="NAME", help="With --live: the name of the robot, typed."),
    }

    def decorate(function: Function) -> Function:
        for name in reversed(names):
            function = known[name](function)
        return function

    return decorate


class Winches(click.Group):
    """Subcommands whose refusals are one line and exit code 3."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run a subcommand."""
        from cdpr_interval.errors import CdprError, InputError, NotSupportedError
        from solvers.cli import Ending, ExitCode

        try:
            return super().invoke(ctx)
        except (InputError, NotSupportedError):
            raise
        except CdprError as error:
            return Ending(ExitCode.INCOMPLETE, str(error))


@click.group(
    "winch",
    cls=Winches,
    short_help="Move winches, read lengths back, say where the platform is.",
    epilog=examples("winch where four_winches --from 2,1.5,1"),
)
def command() -> None:
    """Move the winches of a robot as one, and say where the platform is.

    Nothing moves without --live: every command without it runs on simulated drives. Software is not the
    emergency stop: a hardware one must be within reach. Exit code 3: refused, or stopped by an interlock.
    """


@command.command("status", epilog=examples("winch status four_winches --from 2,1.5,1"))
@robot_argument
@_options("bus", "state", "from", "json")
def status(robot: str, **given: Any) -> int:
    """Show drives, readings and what is known of the lengths; nothing moves."""
    model = _robot(robot)
    with _winches(model, given) as group:
        group.pass_cycles(2)
        print_status(group.snapshot, given["as_json"])
    return 0


@command.command("where", epilog=examples("winch where four_winches --from 2,1.5,1 --json"))
@robot_argument
@_options("bus", "state", "from", "json")
def where(robot: str, **given: Any) -> int:
    """Print the certified poses for the lengths the winches measure."""
    from solvers.cli import Ending, ExitCode
    from solvers.winches.where import whereabouts

    model = _robot(robot)
    _, ranges, _ = _measured(model, given)
    found = whereabouts(model, ranges)
    print_where(model, ranges, found, given["as_json"])
    left = ExitCode.INTERRUPTED if found.is_interrupted else ExitCode.INCOMPLETE
    return Ending(ExitCode.COMPLETE if found.is_complete else left, found.message)


@command.command("move", epilog=examples("winch move four_winches --from 2,1.5,1 --pose 1.9,1.5,1"))
@robot_argument
@click.option("--pose", required=True, metavar="X,Y,Z[,R,P,Y]", help="Goal, angles as 30deg or 0.5rad.")
@click.option("--quaternion", metavar="W,X,Y,Z", help="Orientation of the goal, scalar first.")
@click.option("--settle", is_flag=True, help="Go to the nearest static pose of the taut cables.")
@click.option("--time", "seconds", metavar="S", help="Duration.  [default: the shortest the limits allow]")
@click.option("--time-limit", metavar="S", help="Give up planning and proving after so many seconds.")
@_options("live", "arm", "bus", "state", "from", "log")
@click.option("-q", "--quiet", is_flag=True, help="No progress.")
def move(robot: str, **given: Any) -> int:
    """Plan a path to a pose, prove every step of it, and run it: on simulated drives, or with --live.

    Nothing is moved before the whole path is proved. Exit code 3 also at the time limit, 130 at Ctrl-C:
    the last line says how far the path was proved.
    """
    from solvers.cli import Ending, ExitCode
    from solvers.shell.interrupt import OutOfTime
    from solvers.winches.where import whereabouts

    model = _robot(robot)
    goal = _pose(given["pose"], given["quaternion"])
    for name, label in (("seconds", "--time"), ("time_limit", "--time-limit")):
        given[name] = None if given[name] is None else _positive(given[name], label)
    live = _armed(model, given)
    held, ranges, references = _measured(model, given, live)
    told: list[Proved] = []
    # Planning takes all of the processor: the cycle must not run meanwhile.
    try:
        path = _planned(model, given, held, ranges, references, goal, told)
    except OutOfTime:
        return Ending(ExitCode.INCOMPLETE, f"stopped at the time limit: {shown_way(told)}")
    except KeyboardInterrupt:
        return Ending(ExitCode.INTERRUPTED, f"interrupted: {shown_way(told)}")
    click.echo(f"goal {shown_pose(model, goal)}")
    if given["settle"]:
        click.echo(f"settled {shown_pose(model, path.goal)}")
    print_path(model, path)
    with _winches(model, given, live) as group:
        group.pass_cycles(2)
        _require_unmoved(group, ranges)
        group.enable()
        group.follow(path.points)
        ranges = group.length_ranges()
    print_where(model, ranges, whereabouts(model, ranges), as_json=False)
    say_dry(live)
    return 0


@command.command("jog", epilog=examples("winch jog four_winches --cable c1 --by -5mm"))
@robot_argument
@click.option("--cable", required=True, metavar="NAME", help="The winch to move.")
@click.option("--by", "way", required=True, metavar="D", help="In m or as 5mm; positive pays out.")
@_options("live", "arm", "bus", "state", "from", "log")
def jog(robot: str, **given: Any) -> int:
    """Move one winch slowly, at most 0.1 m; the only motion that needs no reference.

    A dry run without --from or --state starts in the middle of the limits, lengths unknown.
    """
    model = _robot(robot)
    way = read_distance(given["way"], "--by")
    live = _armed(model, given)
    with _winches(model, given, live, anywhere=True) as group:
        group.enable()
        group.jog(given["cable"], way)
        print_status(group.snapshot, as_json=False)
        say_dry(live)
    return 0


@command.command(
    "home",
    epilog=examples(
        "winch home four_winches --bus udp_multicast:239.74.163.2 --state four.json --pose 2,1.5,1"
    ),
)
@robot_argument
@click.option("--pose", metavar="X,Y,Z[,R,P,Y]", help="Where the platform hangs now.")
@click.option("--lengths", metavar="L1,L2,...", help="Measured lengths in m, ranges allowed.")
@click.option(
    "--tolerance", default=DEFAULT_TOLERANCE, show_default=True, metavar="M", help="Of exact lengths."
)
@_options("bus", "state", "log")
def home(robot: str, **given: Any) -> int:
    """Say how long the cables are now; nothing moves. The drives keep readings, --state their meaning."""
    from cdpr_interval.errors import InputError

    model = _robot(robot)
    if given["state"] is None or given["bus"] is None:
        raise InputError("home: needs --bus and --state FILE, where the references are kept")
    lengths, place = _home_lengths(model, given)
    with _winches(model, given) as group:
        group.pass_cycles(2)
        group.home(lengths)
        if place is not None:
            click.echo(f"home {place}")
        print_status(group.snapshot, as_json=False)
    return 0


@command.command("marks", epilog=examples("winch marks four_winches"))
@robot_argument
@_options("state", "log", "json")
def marks(robot: str, **given: Any) -> int:
    """Show the marks of every cable, and what the log says they told about length and drum."""
    model = _robot(robot)
    events = [] if given["log"] is None else _mark_events(Path(given["log"]))
    rows = _mark_rows(model)
    if given["as_json"]:
        click.echo(json.dumps({"marks": rows, "events": events}))
        return 0
    for row in rows:
        low, high = row["length_m"]
        click.echo(f"{row['cable']}  {row['mark']}  seen at a length of {low:.4f} to {high:.4f} m")
    for event in events:
        turn = event["metres_per_turn"]
        drum = "" if turn is None else f", {turn[0]:.5f} to {turn[1]:.5f} m a turn"
        result = (
            f"corrected by {event['correction_m']:+.5f} m{drum}" if event["accepted"] else event["reason"]
        )
        click.echo(f"{event['time_s']:.3f} s  {event['cable']}  {event['mark'] or 'unknown mark'}  {result}")
    return 0


@command.command("stop", epilog=examples("winch stop four_winches --bus udp_multicast:239.74.163.2"))
@robot_argument
@click.option("--bus", required=True, metavar="INTERFACE:CHANNEL", help="Where the drives are.")
def stop(robot: str, bus: str) -> int:
    """Stop all winches, also those that another program moves. It is not the emergency stop."""
    from cdpr_interval.driver.canopen_bus import stop_from_outside
    from solvers.winches.session import read_bus, winches_of

    model = _robot(robot)
    winches_of(model)
    address = read_bus(bus)
    stop_from_outside(model, address.interface, address.channel)
    click.echo("stop was sent to every drive")
    return 0


@command.command(
    "simulate",
    epilog=examples("winch simulate four_winches --bus udp_multicast:239.74.163.2 --pose 2,1.5,1 --for 60"),
)
@robot_argument
@click.option("--pose", required=True, metavar="X,Y,Z[,R,P,Y]", help="Where the platform hangs at the start.")
@click.option(
    "--bus", required=True, metavar="INTERFACE:CHANNEL", help="For example udp_multicast:239.74.163.2."
)
@click.option("--for", "seconds", metavar="S", help="End after so many seconds.  [default: at Ctrl-C]")
@click.option(
    "--share", default="0.5", show_default=True, metavar="X", help="True drums in their tolerances, 0 to 1."
)
@_options("json")
def simulate(robot: str, **given: Any) -> int:
    """Run simulated drives on a bus, for other commands; prints the true lengths and pose at the end."""
    import time
    from fractions import Fraction

    from cdpr_interval.driver.canopen_drive import SimulatedNetwork
    from cdpr_interval.driver.simulated_drive import SimulatedDrive
    from cdpr_interval.errors import InputError
    from solvers.winches.session import hanging_at, read_bus, winches_of

    model = _robot(robot)
    address = read_bus(given["bus"])
    share = read_float(given["share"], "--share")
    if not 0.0 <= share <= 1.0:
        raise InputError(f"--share: must be 0 to 1, got {share!r}")
    end = None if given["seconds"] is None else _positive(given["seconds"], "--for")
    found = hanging_at(model, _pose(given["pose"]))
    starts = [Fraction(length) for length in found.lengths or ()]
    drives = [
        SimulatedDrive(winch, length, Fraction(share))
        for winch, length in zip(winches_of(model), starts, strict=True)
    ]
    with SimulatedNetwork(drives, address.interface, address.channel):
        click.echo(f"{len(drives)} simulated drives on {given['bus']}; end with Ctrl-C", err=True)
        click.echo(f"start {shown_hanging(model, found)}", err=True)
        begun = time.monotonic()
        try:
            while end is None or time.monotonic() - begun < end:
                time.sleep(0.05)
        except KeyboardInterrupt:
            click.echo("", err=True)
    print_truth(model, [float(drive.true_length) for drive in drives], given["as_json"])
    return 0


def _robot(source: str) -> Robot:
    from cdpr_interval.robots.formats.reader import load_robot
    from solvers.questions.checked import on_legs, require_treated
    from solvers.winches.session import winches_of

    robot = load_robot(source)
    require_treated(robot, on_legs(robot, "winch"))
    winches_of(robot)
    return robot


def _pose(text: str, quaternion: str | None = None, label: str = "--pose") -> Pose:
    from solvers.questions.pose import read_pose

    pose = read_pose(text, quaternion, label)
    say_middles(text, label)
    return pose


def _positive(text: str, label: str, read: Callable[[str, str], float] = read_float) -> float:
    from cdpr_interval.errors import InputError

    value = read(text, label)
    if value <= 0.0:
        raise InputError(f"{label}: must be positive, got {text}")
    return value


def _armed(robot: Robot, given: dict[str, Any]) -> bool:
    """Return whether real drives may move; `InputError` when that is asked for but not armed."""
    from cdpr_interval.errors import InputError

    if not given["live"]:
        if given["bus"] is not None:
            raise InputError("--bus: only with --live, which moves real drives")
        return False
    if given["bus"] is None:
        raise InputError("--live: needs --bus")
    if given["start"] is not None:
        raise InputError("--from: only for a dry run")
    if not robot.winches.armed and given["arm"] != robot.name:
        raise InputError(f"--live: type the robot's name: --arm {robot.name}")
    return True


def _winches(robot: Robot, given: dict[str, Any], live: bool | None = None, anywhere: bool = False) -> Any:
    from solvers.winches.session import lengths_at, read_bus, winches

    bus = given.get("bus")
    address = read_bus(bus) if bus is not None and live is not False else None
    start = given.get("start")
    lengths = None if start is None else lengths_at(robot, _pose(start, label="--from"), "--from")
    state, log = given.get("state"), given.get("log")
    return winches(
        robot,
        address,
        None if state is None else Path(state),
        lengths,
        None if log is None else Path(log),
        anywhere,
    )


def _measured(
    robot: Robot, given: dict[str, Any], live: bool | None = None
) -> tuple[list[float], list[tuple[float, float]], list[Reference]]:
    """Return the most likely lengths in m, their bounds, and the references they come from."""
    with _winches(robot, given, live) as group:
        group.pass_cycles(2)
        ranges, cables = group.length_ranges(), group.snapshot.cables
    lengths = [cable.length for cable in cables if cable.length is not None]
    return lengths, ranges, [cable.reference for cable in cables if cable.reference is not None]


def _planned(
    robot: Robot,
    given: dict[str, Any],
    held: list[float],
    ranges: list[tuple[float, float]],
    references: list[Reference],
    goal: Pose,
    told: list[Proved],
) -> CablePath:
    """Return the proved path, within the time limit; ``told`` keeps how far it is proved."""
    from solvers.commands.progress import shown
    from solvers.questions.problem import Progress
    from solvers.shell.interrupt import OutOfTime
    from solvers.winches.path import half_widths_of, plan
    from solvers.winches.session import winches_of

    limits = [winch.limits for winch in winches_of(robot)]
    widths = half_widths_of(references)
    start, limit = monotonic(), given["time_limit"]
    with shown("path", given["quiet"]) as display:

        def tell(proved: Proved) -> None:
            told[:] = [proved]
            # Between pieces, where nothing is half done: the first one imports and compiles.
            if limit is not None and proved.travel < 1.0 and monotonic() - start > limit:
                raise OutOfTime
            if display is not None:
                left = 1.0 - proved.travel
                display(Progress(proved.pieces, 0, left, 0, 0, 1, done=proved.travel))

        return plan(
            robot, limits, held, ranges, goal, given["seconds"], given["settle"], widths, progress=tell
        )


def _require_unmoved(group: WinchGroup, before: list[tuple[float, float]]) -> None:
    """Raise `Refused` when the lengths are not those for which the path was proved."""
    from cdpr_interval.driver.requests import Refused

    for cable, (lo, hi) in zip(group.snapshot.cables, before, strict=True):
        if cable.length is None or not lo <= cable.length <= hi:
            raise Refused(f"{cable.name} has moved since the path was planned")


def _home_lengths(robot: Robot, given: dict[str, Any]) -> tuple[list[Any], str | None]:
    """Return the lengths the cables have now, and the pose they were taken from as text."""
    from fractions import Fraction

    from cdpr_interval.errors import InputError
    from cdpr_interval.exact.range import Range
    from solvers.questions.lengths import read_lengths
    from solvers.winches.session import hanging_at

    if (given["pose"] is None) == (given["lengths"] is None):
        raise InputError("home: needs either --pose or --lengths")
    tolerance = Fraction(_positive(given["tolerance"], "--tolerance", read_distance))
    if given["pose"] is not None:
        found = hanging_at(robot, _pose(given["pose"]))
        exact = [Fraction(length) for length in found.lengths or ()]
        return [Range(x - tolerance, x + tolerance) for x in exact], shown_hanging(robot, found)
    ranges = read_lengths(given["lengths"], robot.cable_names, "--lengths")
    warn_of_lengths(robot, ranges, "--lengths")
    return [Range(lo - tolerance, hi + tolerance) if lo == hi else Range(lo, hi) for lo, hi in ranges], None


def _mark_rows(robot: Robot) -> list[dict[str, Any]]:
    from cdpr_interval.driver.marks import length_at

    rows = []
    for cable in robot.cables:
        sensor = None if cable.winch is None else cable.winch.sensor
        for mark in () if sensor is None else sensor.marks:
            assert sensor is not None and cable.winch is not None
            seen = length_at(sensor, mark, 0, cable.winch.limits.velocity)
            rows.append(
                {"cable": cable.name, "mark": mark.name, "length_m": [float(seen.lo), float(seen.hi)]}
            )
    return rows


def _mark_events(path: Path) -> list[dict[str, Any]]:
    from cdpr_interval.errors import InputError

    try:
        lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        return [line for line in lines if line["event"] == "mark"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"--log: {path}: {error}") from None
