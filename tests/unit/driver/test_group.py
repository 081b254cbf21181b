"""All winches as one, on simulated drives with a simulated clock."""

from __future__ import annotations

import contextlib
import json
from fractions import Fraction as F
from itertools import pairwise

import pytest

from cdpr_interval.driver import cia402
from cdpr_interval.driver.bus import BusError
from cdpr_interval.driver.cia402 import DriveState
from cdpr_interval.driver.counter import nearest
from cdpr_interval.driver.group import WinchesStopped, WinchGroup
from cdpr_interval.driver.reference import ReferenceState
from cdpr_interval.driver.requests import Refused
from cdpr_interval.driver.simulated_drive import FaultKind, SimulatedFault
from cdpr_interval.driver.snapshot import GroupState
from cdpr_interval.driver.violation import Interlock
from cdpr_interval.errors import InputError
from cdpr_interval.robots.cable_robot import Robot
from tests.support.winch_robots import (
    LINEAR,
    MULTILAYER,
    STARTS,
    TABLE,
    TOLERANCE,
    Bench,
    between,
    marks,
    robot_with_winches,
    smooth_path,
)

GOAL = [3.6, 3.0, 3.5, 3.1]
START = [float(length) for length in STARTS]


def moved(bench: Bench, goal: list[float] = GOAL, duration: float = 2.2) -> Bench:
    bench.group.follow(smooth_path([c.commanded for c in bench.group.snapshot.cables], goal, duration))
    return bench


@pytest.mark.parametrize(
    "drum", [None, MULTILAYER, TABLE, LINEAR], ids=["helical", "layers", "table", "linear"]
)
def test_a_path_is_followed_and_read_back(drum):
    bench = Bench(robot_with_winches(drum=drum) if drum else None).enabled()
    moved(bench)
    assert bench.group.state is GroupState.HOLDING
    for cable, goal in zip(bench.group.snapshot.cables, GOAL, strict=True):
        assert cable.length == pytest.approx(goal, abs=2e-6)
    assert bench.contains_truth()


def test_enable_is_bumpless():
    """Until a drive is enabled its target is where it is; then it stays."""
    bench = Bench(readings=(2**31 - 3, -(2**31), 12345, 0)).homed()
    bench.sent.clear()
    bench.group.enable()
    for i, drive in enumerate(bench.drives):
        assert {commands[i].target for _, commands in bench.sent} == {drive.position}
        assert drive.motor == 0
    words = [commands[0].control for _, commands in bench.sent]
    assert list(dict.fromkeys(words)) == [0x00, 0x06, 0x07, 0x0F]


def test_a_counter_that_wraps_is_no_jump():
    bench = Bench(readings=(2**31 - 1000, -(2**31) + 1000, 0, 0)).enabled()
    moved(bench)
    moved(bench, START)
    assert bench.contains_truth() and bench.group.state is GroupState.HOLDING


def test_no_mode_no_torque():
    bench = Bench().homed()
    bench.bus.inject(SimulatedFault(2, FaultKind.REFUSED_MODE))
    with pytest.raises(WinchesStopped, match=r"c3: not-enabled: .*mode 0 instead of 8"):
        bench.group.enable()
    assert all(drive.state is not DriveState.ENABLED for drive in bench.drives)


@pytest.mark.parametrize(
    ("kind", "amount", "interlock"),
    [
        (FaultKind.FREEZE, 0.0, Interlock.DATA_AGE),
        (FaultKind.HEARTBEAT, 0.0, Interlock.HEARTBEAT),
        (FaultKind.EMERGENCY, 0.0, Interlock.EMERGENCY),
        (FaultKind.REBOOT, 0.0, Interlock.REBOOT),
        (FaultKind.REFUSED_MODE, 0.0, Interlock.MODE),
        (FaultKind.LATENCY, 0.08, Interlock.DATA_AGE),
        (FaultKind.STUCK_ENCODER, 0.0, Interlock.FOLLOWING_ERROR),
    ],
)
def test_a_fault_of_one_stops_all(kind, amount, interlock):
    bench = Bench().enabled()
    path = smooth_path(START, GOAL, 2.2)
    started = bench.bus.now()
    bench.group.supervisor.command(path[0][1], started + path[0][0])
    for time, point in path[1:100]:
        bench.group.supervisor.command(point, started + time)
    bench.group.wait(lambda snapshot: bench.bus.now() > started + 0.5, 2.0)
    bench.bus.inject(SimulatedFault(1, kind, amount))
    before = bench.bus.now()
    assert bench.group.wait(lambda snapshot: snapshot.state is GroupState.STOPPED, 1.0)
    causes = bench.group.snapshot.causes
    assert (interlock, "c2") in {(cause.interlock, cause.cable) for cause in causes}
    assert bench.bus.now() - before < 0.2
    last = bench.sent[-1][1]
    assert {command.control for command in last} == {cia402.QUICK_STOP}
    bench.group.pass_cycles(60)
    assert all(drive.state is not DriveState.ENABLED or kind is FaultKind.FREEZE for drive in bench.drives)
    # Nothing moves again by itself, nor when asked to.
    for request in (
        bench.group.enable,
        lambda: bench.group.command(GOAL),
        lambda: bench.group.jog("c1", 0.01),
    ):
        with pytest.raises(Refused, match="acknowledge first"):
            request()


def test_after_an_emergency_acknowledge_resets_and_does_not_enable():
    bench = Bench().enabled()
    bench.bus.inject(SimulatedFault(0, FaultKind.EMERGENCY))
    bench.group.pass_cycles(20)
    assert bench.drives[0].state is DriveState.FAULT
    bench.sent.clear()
    bench.group.acknowledge()
    assert bench.group.state is GroupState.DISABLED and not bench.group.snapshot.latched
    assert all(drive.state is DriveState.DISABLED for drive in bench.drives)
    bench.group.pass_cycles(50)
    # Trap 7: a reset must never end in OPERATION ENABLED.
    assert not any(c.control & 0x08 for _, commands in bench.sent for c in commands)
    bench.group.enable()
    assert bench.contains_truth()


def test_a_persisting_cause_stops_again():
    bench = Bench().enabled()
    bench.bus.inject(SimulatedFault(0, FaultKind.HEARTBEAT))
    bench.group.pass_cycles(30)
    with pytest.raises(WinchesStopped, match="c1: heartbeat"):
        bench.group.acknowledge()
    bench.drives[0].repair()
    bench.group.pass_cycles(10)
    bench.group.acknowledge()
    assert bench.group.state is GroupState.DISABLED


def test_a_rebooted_drive_must_be_connected_again():
    bench = Bench().enabled()
    bench.bus.inject(SimulatedFault(3, FaultKind.REBOOT))
    bench.group.pass_cycles(60)
    with pytest.raises(Refused, match="connect again"):
        bench.group.acknowledge()
    bench.group.connect()
    bench.group.acknowledge()
    assert bench.group.state is GroupState.DISABLED


@pytest.mark.parametrize("silence", [FaultKind.FREEZE, FaultKind.HEARTBEAT])
@pytest.mark.parametrize("stopped", [False, True])
def test_connecting_again_to_a_silent_drive_leaves_all_off(silence, stopped):
    """The other drives were configured anew: the old connection cannot be kept, so nothing pretends it is."""
    bench, events = Bench().enabled(), []
    bench.bus.inject(SimulatedFault(0, silence))
    if stopped:
        bench.group.pass_cycles(30)
    else:
        bench.group.disable()
    causes, known = bench.group.snapshot.causes, bench.group.known()
    assert bool(causes) == stopped
    bench.sent.clear()
    bench.group.supervisor._tell = lambda kind, data: events.append((kind, data.get("to")))
    with pytest.raises(BusError, match="drive 0: no heartbeat"):
        bench.group.connect()
    snapshot = bench.group.snapshot
    assert snapshot.state is GroupState.OFF and snapshot.causes == causes and bench.group.known() == known
    assert all(cable.drive is None for cable in snapshot.cables)
    for ask in (bench.group.enable, bench.group.disable, lambda: bench.group.pass_cycles(1)):
        with pytest.raises(Refused):
            ask()
    with pytest.raises(Refused, match="off" if stopped else "nothing is latched"):
        bench.group.acknowledge()
    with pytest.raises(BusError):
        bench.group.connect()
    assert not bench.sent
    assert events == [("state", "off")]
    bench.drives[0].repair()
    bench.group.connect()
    assert bench.group.snapshot.causes == causes
    assert bench.group.state is (GroupState.STOPPED if stopped else GroupState.DISABLED)
    bench.group.pass_cycles(30)
    if bench.group.snapshot.latched:  # a frozen drive heard of no brake, and failed when its master left
        bench.group.acknowledge()
    bench.group.enable()
    assert bench.contains_truth()


def test_no_process_data_after_connecting_leaves_all_off(monkeypatch):
    bench = Bench().homed()
    monkeypatch.setattr(bench.bus, "_listen", lambda i, drive: None)
    with pytest.raises(Refused, match="no process data from c1, c2, c3, c4"):
        bench.group.connect()
    assert bench.group.state is GroupState.OFF and not bench.bus.connected
    monkeypatch.undo()
    bench.group.connect()
    assert bench.group.state is GroupState.DISABLED and bench.contains_truth()


def test_a_stop_before_connecting_is_acknowledged_after_it():
    bench = Bench()
    bench.group.stop("the door is open")
    bench.group.connect()
    assert bench.group.state is GroupState.STOPPED
    with pytest.raises(Refused, match="the door is open: acknowledge first"):
        bench.group.enable()
    bench.group.acknowledge()
    bench.group.enable()
    assert {c.control for c in bench.sent[0][1]} == {cia402.QUICK_STOP}


def test_a_late_caller_can_be_acknowledged_with_the_brakes_on():
    bench = Bench().enabled()
    bench.group.command([START[0] + 1e-4, *START[1:]])
    bench.group.wait(lambda snapshot: snapshot.latched and snapshot.state is GroupState.HOLDING, 2.0)
    with contextlib.suppress(WinchesStopped):
        bench.group.disable()
    assert bench.group.state is GroupState.DISABLED and bench.group.snapshot.latched
    bench.group.acknowledge()
    assert bench.group.state is GroupState.DISABLED and not bench.group.snapshot.latched
    bench.group.enable()


def test_a_late_caller_makes_all_slow_down_and_hold():
    """A stream that stops without an end: rest within the acceleration limit, latched, still enabled."""
    bench = Bench().enabled()
    speed, length = 0.0, START[0]
    time = bench.bus.now() + 0.06
    bench.group.command(START, time - 0.01)
    for _ in range(60):
        speed = min(speed + 0.008, 0.4)
        length += 0.01 * speed
        bench.group.command([length, *START[1:]], time)
        time += 0.01
    bench.group.wait(lambda snapshot: snapshot.latched, 2.0)
    assert bench.group.state is GroupState.MOVING
    with pytest.raises(Refused, match="slowing down"):
        bench.group.acknowledge()
    assert bench.group.wait(lambda snapshot: snapshot.state is GroupState.HOLDING, 2.0)
    assert [cause.interlock for cause in bench.group.snapshot.causes] == [Interlock.CALLER]
    assert all(drive.state is DriveState.ENABLED for drive in bench.drives)
    rest = bench.group.snapshot.cables[0].length
    assert rest == pytest.approx(length + 0.4**2 / (2 * 0.8), abs=0.003)
    with pytest.raises(Refused, match="acknowledge"):
        bench.group.command(GOAL)
    bench.group.acknowledge()
    moved(bench, START)


def test_a_late_caller_at_a_limit_still_stays_inside():
    """Running fast towards a limit: what cannot be stopped before it never leaves."""
    bench = Bench(starts=(F("5.5"), *STARTS[1:])).enabled()
    length, speed, time = 5.5, 0.0, bench.bus.now() + 0.06
    bench.group.command([length, *START[1:]], time - 0.01)
    with pytest.raises((InputError, WinchesStopped, Refused)):
        for _ in range(200):
            speed = min(speed + 0.008, 0.45)
            length += 0.01 * speed
            bench.group.command([length, *START[1:]], time)
            time += 0.01
            if time > bench.bus.now() + 0.1:
                bench.group.pass_cycles(1)
            if bench.group.snapshot.latched:
                raise WinchesStopped(bench.group.snapshot.causes)
    bench.group.pass_cycles(150)
    assert bench.true_lengths[0] < 6 + F("0.01")
    assert_targets_inside(bench)


def assert_targets_inside(bench: Bench) -> None:
    """Every target ever sent lies within the limits, by the reference that held then (no marks here)."""
    for i, axis in enumerate(bench.group.supervisor.axes):
        assert axis.reference is not None
        low, high = axis.limits.length
        reading = bench.drives[i].first_reading
        for _, commands in bench.sent:
            reading = nearest(commands[i].target, reading)
            assert low <= axis.reference.nominal(reading) <= high


def test_requests_that_are_wrong_change_nothing():
    bench = Bench().enabled()
    group = bench.group
    for lengths, message in (
        ([3.1, 3.2, 3.3], "4 cables, got 3"),
        ([3.1, 3.2, 3.3, float("nan")], "c4: set-point nan m"),
        ([3.1, 3.2, 3.3, 6.5], "c4: set-point 6.5 m, limits 0.5 to 6 m"),
        ([3.1, 3.2, 3.3, 3.6], r"c4: \+5.0000 m/s to this set-point"),
    ):
        with pytest.raises(InputError, match=message):
            group.command(lengths)
    with pytest.raises(InputError, match="must be later"):
        group.command(START, at=0.0)
    with pytest.raises(InputError, match="at most 10 s ahead"):
        group.command(START, at=bench.bus.now() + 100)
    with pytest.raises(InputError, match="no cable 'c9'"):
        group.jog("c9", 0.01)
    with pytest.raises(InputError, match=r"at most 0.1 m at a time"):
        group.jog("c1", 0.2)
    assert group.state is GroupState.HOLDING and not group.snapshot.latched


def test_too_fast_or_abrupt_targets_are_stopped_at_the_gate():
    """A step of the path within the speed limit but not within the acceleration limit never leaves."""
    bench = Bench().enabled()
    bench.sent.clear()
    bench.group.command([START[0] + 0.016, *START[1:]], bench.bus.now() + 0.05)
    assert bench.group.wait(lambda snapshot: snapshot.latched, 1.0)
    (cause,) = bench.group.snapshot.causes
    assert cause.interlock is Interlock.ACCELERATION and cause.cable == "c1"
    assert {commands[0].target for _, commands in bench.sent} == {bench.drives[0].position}


def test_unreferenced_cables_can_be_jogged_only():
    bench = Bench()
    bench.group.connect()
    bench.group.enable()
    with pytest.raises(Refused, match="c1 is unreferenced"):
        bench.group.command(START)
    with pytest.raises(Refused, match="no length is known: c1 is unreferenced"):
        bench.group.length_ranges()
    before = bench.true_lengths
    bench.group.jog("c2", 0.05)
    moved_by = [float(b - a) for a, b in zip(before, bench.true_lengths, strict=True)]
    assert moved_by == [0, pytest.approx(0.05, rel=2e-3), 0, 0]


def test_homes_beyond_the_limits_are_refused():
    bench = Bench()
    bench.group.connect()
    with pytest.raises(InputError, match=r"c1: home length \[5.9, 6.1\] m, limits 0.5 to 6 m"):
        bench.group.home({"c1": (5.9, 6.1)})
    with pytest.raises(InputError, match="positive and ascending"):
        bench.group.home({"c1": (3.0, 2.0)})
    with pytest.raises(InputError, match="no cable 'x'"):
        bench.group.home({"x": 3.0})
    bench.group.home({"c1": (3.09, 3.11)})
    states = [cable.state for cable in bench.group.snapshot.cables]
    assert states == [ReferenceState.REFERENCED] + [ReferenceState.UNREFERENCED] * 3


def marked(**given: F) -> Robot:
    return robot_with_winches(sensor=marks(**given))


@pytest.mark.parametrize("hysteresis", [F(0), F("0.002")])
def test_marks_narrow_the_lengths(hysteresis):
    """Home is known to a decimetre or so; each mark that passes leaves half a millimetre."""
    bench = Bench(marked(hysteresis=hysteresis))
    bench.group.connect()
    rough = F("0.02")
    bench.group.home([(start - rough, start + rough) for start in STARTS])
    bench.group.enable()
    before = [hi - lo for lo, hi in bench.group.length_ranges()]
    moved(bench)
    after = [hi - lo for lo, hi in bench.group.length_ranges()]
    assert min(before) >= 0.04 and max(after) < 0.003
    assert bench.contains_truth()
    assert all(cable.reference.source.startswith("mark m") for cable in bench.group.snapshot.cables)
    # The lengths asked for are met by the corrected lengths.
    for cable, goal in zip(bench.group.snapshot.cables, GOAL, strict=True):
        assert cable.length == pytest.approx(goal, abs=2e-6)


def test_a_correction_by_a_mark_is_no_jump():
    """At the mark the target goes on as before; the correction is worked off at the rate of the file."""
    bench = Bench(marked())
    bench.group.connect()
    # Everybody is 15 mm wrong.
    bench.group.home([(start - F("0.03"), start) for start in STARTS])
    bench.group.enable()
    bench.sent.clear()
    moved(bench)
    for i, axis in enumerate(bench.group.supervisor.axes):
        quantum = abs(axis.model.nominal_rate(0))
        targets = [commands[i].target for _, commands in bench.sent]
        steps = [(b - a) * quantum for a, b in pairwise(targets)]
        changes = [b - a for a, b in pairwise(steps)]
        assert max(map(abs, steps)) < 0.5 * 0.01 + quantum
        assert max(map(abs, changes)) < 1e-4 + 2 * quantum
    assert bench.contains_truth()


@pytest.mark.parametrize(
    ("kind", "amount", "text"),
    [
        (FaultKind.SLIP, 0.03, "outside the range predicted"),
        (FaultKind.WRONG_LAYER, 0.05, "outside the range predicted|passed unseen|cannot say"),
        (FaultKind.MISSED_MARK, 0.0, "passed unseen"),
        (FaultKind.DOUBLED_MARK, 0.0, "outside the range predicted"),
    ],
)
def test_what_marks_contradict_degrades_the_cable_and_stops(kind, amount, text):
    bench = Bench(marked()).enabled()
    bench.bus.inject(SimulatedFault(0, kind, amount))
    with pytest.raises(WinchesStopped, match=f"c1: mark: .*({text})"):
        moved(bench, [4.4, *GOAL[1:]], 5.0)
        moved(bench, START, 5.0)
    assert bench.group.snapshot.cables[0].state is ReferenceState.DEGRADED
    with pytest.raises(Refused, match="c1 is degraded"):
        bench.group.length_ranges()
    bench.group.pass_cycles(30)
    bench.group.acknowledge()
    bench.group.enable()
    with pytest.raises(Refused, match="c1 is degraded"):
        bench.group.command(START)
    # By hand it can still be moved, and a new home makes it well.
    bench.group.jog("c1", -0.02)
    bench.drives[0].repair()
    true = bench.true_lengths[0]
    bench.group.home({"c1": (true - TOLERANCE, true + TOLERANCE)})
    bench.group.command([c.commanded for c in bench.group.snapshot.cables], at_rest=True)
    assert bench.contains_truth()


def test_marks_too_near_for_what_is_known_are_not_guessed():
    bench = Bench(marked(spacing=F(1, 20)))
    bench.group.connect()
    bench.group.home([(start - F("0.03"), start + F("0.03")) for start in STARTS])
    bench.group.enable()
    with pytest.raises(WinchesStopped, match="cannot say which mark was seen"):
        moved(bench)


def test_the_drum_is_measured_between_marks():
    bench = Bench(marked()).enabled()
    events = []
    bench.group._event = lambda kind, data: events.append((kind, data))
    bench.group.supervisor._tell = bench.group._event
    moved(bench, [4.4, *GOAL[1:]], 5.0)
    measured = [data["metres_per_turn"] for kind, data in events if kind == "mark" and data["cable"] == "c1"]
    true = float(bench.drives[0]._law.slopes[0].mid)
    assert len(measured) >= 4 and measured[0] is None
    assert all(lo <= true <= hi and hi - lo < 0.005 for lo, hi in measured[1:])


def test_the_log_has_the_seconds_before_a_stop(tmp_path):
    path = tmp_path / "audit.jsonl"
    bench = Bench(log=path).enabled()
    moved(bench)
    bench.bus.inject(SimulatedFault(0, FaultKind.EMERGENCY))
    bench.group.pass_cycles(20)
    bench.group.close()
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    kinds = [line["event"] for line in lines]
    assert kinds.count("stop") == kinds.count("before") == 1 and "home" in kinds and "state" in kinds
    (stop,) = [line for line in lines if line["event"] == "stop"]
    assert any("c1: emergency" in cause for cause in stop["causes"])
    (before,) = [line for line in lines if line["event"] == "before"]
    assert len(before["cycles"]) > 100 and before["cycles"][-1]["cables"][0]["drive"] == "operation enabled"


def test_an_exception_in_the_cycle_stops_everything(monkeypatch):
    bench = Bench().enabled()

    def fail():
        raise RuntimeError("the adapter was unplugged")

    monkeypatch.setattr(bench.bus, "read_all", fail)
    bench.group.pass_cycles(1)
    bench.group.supervisor.cycle()
    (cause,) = bench.group.snapshot.causes
    assert cause.interlock is Interlock.INTERNAL and "unplugged" in cause.text
    assert {command.control for command in bench.sent[-1][1]} == {cia402.QUICK_STOP}


def test_references_survive_a_restart():
    """The drives keep their readings; a later run takes over what was known."""
    bench = Bench().enabled()
    moved(bench)
    kept = bench.group.known()
    bench.group.close()
    again = WinchGroup(bench.robot, bench.bus)
    again.adopt(kept)
    again.connect()
    for cable, goal in zip(again.snapshot.cables, GOAL, strict=True):
        assert cable.length == pytest.approx(goal, abs=2e-6)
    for drive in bench.drives:
        drive.faults.clear()


def test_robots_without_winches_are_refused():
    from cdpr_interval import load_robot

    with pytest.raises(InputError, match="no winch for c1, c2, c3, c4"):
        WinchGroup(load_robot("merlet_4_1"), Bench().bus)


def test_closing_while_moving_stops(tmp_path):
    bench = Bench().enabled()
    bench.group.command([START[0] + 1e-4, *START[1:]])
    bench.group.pass_cycles(3)
    bench.group.close()
    assert any({c.control for c in commands} == {cia402.QUICK_STOP} for _, commands in bench.sent)


def test_closing_while_holding_disables():
    """The drives are told before the bus is left: without a master they would fail."""
    bench = Bench().enabled()
    bench.group.close()
    assert {c.control for c in bench.sent[-1][1]} == {cia402.DISABLE_VOLTAGE}
    assert all(drive.state is DriveState.DISABLED and not drive.emergency for drive in bench.drives)


def test_home_can_be_bounds_or_numbers():
    bench = Bench()
    bench.group.connect()
    bench.group.home([3.1, F("3.2"), (3.25, 3.35), between("3.3", "3.5")])
    ranges = bench.group.length_ranges()
    assert ranges[0][0] == pytest.approx(3.1, abs=1e-5) and ranges[3][1] == pytest.approx(3.5, abs=1e-5)


def test_a_drive_that_lost_its_position_degrades_its_cable():
    """An encoder that counts from 0 after the supply was off must not pass for a cable that moved."""
    bench = Bench(readings=(5_000_000, 5_000_000, 5_000_000, 5_000_000)).enabled()
    moved(bench)
    kept = bench.group.known()
    bench.group.close()
    bench.drives[1].first_reading = -round(bench.drives[1].motor)
    again = WinchGroup(bench.robot, bench.bus)
    again.adopt(kept)
    again.connect()
    states = [cable.state for cable in again.snapshot.cables]
    assert states == [ReferenceState.REFERENCED, ReferenceState.DEGRADED] + [ReferenceState.REFERENCED] * 2


def test_a_mark_that_turned_back_is_not_taken_for_one_direction():
    """With hysteresis the direction matters; a cable that has just turned back has none."""
    bench = Bench(marked(hysteresis=F("0.004"))).enabled()
    axis = bench.group.supervisor.axes[0]
    for readings, direction in (([1, 2, 3], -1), ([3, 2, 1], 1), ([1, 3, 2], 0), ([1, 1, 2], 0), ([1], 0)):
        axis._history.clear()
        axis._history.extend(readings)
        assert axis._direction == direction


def test_a_mark_known_less_well_than_the_cable_only_confirms_it():
    bench = Bench(marked(tolerance=F("0.02"))).enabled()
    before = [hi - lo for lo, hi in bench.group.length_ranges()]
    moved(bench)
    assert any(cable.reference.source.startswith("mark") for cable in bench.group.snapshot.cables)
    assert max(hi - lo for lo, hi in bench.group.length_ranges()) < max(before) + 0.001
    assert bench.contains_truth()
