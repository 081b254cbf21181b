"""Random faults at random times: what must never happen to winches, whatever goes wrong."""

from __future__ import annotations

import contextlib
from fractions import Fraction as F

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cdpr_interval.driver import cia402
from cdpr_interval.driver.counter import nearest
from cdpr_interval.driver.drum import OffTheDrum
from cdpr_interval.driver.group import WinchesStopped
from cdpr_interval.driver.reference import ReferenceState
from cdpr_interval.driver.requests import Refused
from cdpr_interval.driver.simulated_drive import FaultKind, SimulatedFault
from cdpr_interval.driver.snapshot import GroupState
from cdpr_interval.errors import CdprError
from tests.support.winch_robots import MULTILAYER, STARTS, Bench, marks, robot_with_winches, smooth_path

ROBOTS = {
    "helical": robot_with_winches(sensor=marks()),
    "layers": robot_with_winches(drum=MULTILAYER, sensor=marks(tolerance=F("0.001"))),
}
KINDS = st.sampled_from(FaultKind)
AMOUNTS = {
    FaultKind.SLIP: st.floats(-0.2, 0.2),
    FaultKind.WRONG_LAYER: st.sampled_from((-0.1, -0.03, 0.03, 0.1)),
    FaultKind.LATENCY: st.sampled_from((0.01, 0.02, 0.03, 0.05, 0.2)),
}
FAULTS = KINDS.flatmap(
    lambda kind: st.builds(SimulatedFault, st.integers(0, 3), st.just(kind), AMOUNTS.get(kind, st.just(0.0)))
)
ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.just("fault"), FAULTS),
        st.tuples(st.just("repair"), st.integers(0, 3)),
        st.tuples(st.just("wait"), st.integers(1, 40)),
        st.tuples(st.just("path"), st.tuples(*[st.floats(2.6, 3.9) for _ in range(4)])),
        st.tuples(st.just("path"), st.tuples(*[st.floats(2.6, 3.9) for _ in range(3)], st.floats(0.4, 6.2))),
        st.tuples(st.just("command"), st.tuples(*[st.floats(0.4, 6.2) for _ in range(4)])),
        st.tuples(st.just("jog"), st.tuples(st.sampled_from(("c1", "c3")), st.floats(-0.12, 0.12))),
        st.tuples(st.just("acknowledge"), st.none()),
        st.tuples(st.just("enable"), st.none()),
        st.tuples(st.just("disable"), st.none()),
        st.tuples(st.just("connect"), st.none()),
        st.tuples(st.just("stop"), st.none()),
    ),
    min_size=1,
    max_size=10,
)
NOTICED_WITHIN = {
    FaultKind.FREEZE: 6,
    FaultKind.HEARTBEAT: 22,
    FaultKind.EMERGENCY: 1,
    FaultKind.REBOOT: 1,
    FaultKind.REFUSED_MODE: 2,
}
"""Cycles after which a fault must have been noticed while the drives are enabled."""


class Watch:
    """Looks at every frame that leaves, with what was known when it left.

    What is wrong is kept for the test: the cycle latches any exception, an assertion's too.
    """

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.stopped_at: int | None = None
        self.frames = 0
        self.wrong: list[AssertionError] = []
        bench.bus.observer = self.observe
        bench.group._event = self.event
        bench.group.supervisor._tell = self.event

    def event(self, kind: str, data: dict) -> None:
        if kind == "stop":
            self.stopped_at = self.frames
        elif kind == "acknowledge":
            self.stopped_at = None

    def observe(self, time: float, commands: tuple) -> None:
        try:
            self.look(commands)
        except AssertionError as error:
            self.wrong.append(error)

    def look(self, commands: tuple) -> None:
        """No target outside the limits leaves, and nothing but quick stop after a stop."""
        self.frames += 1
        supervisor = self.bench.group.supervisor
        for axis, command in zip(supervisor.axes, commands, strict=True):
            assert not command.control & 0x70
            if axis.reference is None:
                continue
            low, high = axis.limits.length
            # A mark may have corrected the length of a target that was sent before it.
            slack = F("0.25") if axis.state is not ReferenceState.REFERENCED else F("0.012")
            try:
                length = axis.reference.nominal(nearest(command.target, axis.counts))
            except OffTheDrum:
                raise AssertionError(f"{axis.name}: a target off the drum left") from None
            assert low - slack <= length <= high + slack
        caller_only = all(cause.interlock == "caller" for cause in supervisor._causes)
        if self.stopped_at is not None and self.frames > self.stopped_at + 1 and not caller_only:
            state = supervisor._state
            assert state in (GroupState.STOPPED, GroupState.RESETTING)
            allowed = {cia402.QUICK_STOP}
            if state is GroupState.RESETTING:
                allowed |= {cia402.DISABLE_VOLTAGE, cia402.FAULT_RESET}
            assert {command.control for command in commands} <= allowed


def act(bench: Bench, watch: Watch, action: str, value) -> None:
    group = bench.group
    if action == "fault":
        bench.bus.inject(value)
    elif action == "repair":
        bench.drives[value].repair()
    elif action == "wait":
        group.pass_cycles(value)
    elif action == "path":
        start = [c.commanded if c.commanded is not None else 3.0 for c in group.snapshot.cables]
        way = max(abs(a - b) for a, b in zip(start, value, strict=True))
        duration = 0.02 + max(15 / 8 * way / 0.45, (7.5 * way) ** 0.5)
        group.follow(smooth_path(start, list(value), duration))
    elif action == "command":
        group.command(value)
    elif action == "jog":
        group.jog(*value)
    elif action == "stop":
        group.stop()
        assert group.snapshot.latched
    else:
        getattr(group, action)()


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
@settings(deadline=None, max_examples=40)
@given(actions=ACTIONS)
@example([("fault", SimulatedFault(0, FaultKind.FREEZE)), ("disable", None), ("connect", None)])
def test_whatever_goes_wrong(name, actions):
    """Targets stay inside, a stop is quick stop to all, and nothing but acknowledge leads out of it."""
    bench = Bench(ROBOTS[name]).enabled()
    watch = Watch(bench)
    for action, value in actions:
        latched = bench.group.snapshot.latched
        with contextlib.suppress(CdprError):
            act(bench, watch, action, value)
        if latched and action not in ("acknowledge",):
            assert bench.group.snapshot.latched, f"{action} led out of a stop"
        assert not watch.wrong, watch.wrong[0]
    if bench.group.state is GroupState.OFF:
        connected_again(bench)
    bench.group.pass_cycles(30)
    assert not watch.wrong, watch.wrong[0]


def connected_again(bench: Bench) -> None:
    """A `connect` that failed has left all off and forgot no stop; with whole drives it succeeds."""
    assert not bench.bus.connected
    causes = bench.group.snapshot.causes
    with pytest.raises(Refused, match="not connected"):
        bench.group.pass_cycles(1)
    for drive in bench.drives:
        drive.repair()
    bench.group.connect()
    assert bench.group.state is (GroupState.STOPPED if causes else GroupState.DISABLED)
    assert bench.group.snapshot.causes == causes


@settings(deadline=None, max_examples=60)
@given(
    fault=FAULTS.filter(lambda fault: fault.kind in NOTICED_WITHIN),
    after=st.integers(1, 150),
    moving=st.booleans(),
)
def test_quick_stop_reaches_every_drive_in_time(fault, after, moving):
    """From the cycle in which a fault can be seen, every drive has quick stop within two."""
    bench = Bench(ROBOTS["helical"]).enabled()
    if moving:
        path = smooth_path([float(s) for s in STARTS], [4.0, 2.8, 3.5, 3.9], 3.6)
        start = bench.bus.now()
        for time, point in path:
            bench.group.command(point, start + time)
    bench.group.pass_cycles(after)
    assert not bench.group.snapshot.latched
    bench.sent.clear()
    bench.bus.inject(fault)
    bench.group.pass_cycles(NOTICED_WITHIN[fault.kind] + 2)
    assert bench.group.state is GroupState.STOPPED
    words = [{command.control for command in commands} for _, commands in bench.sent]
    first = words.index({cia402.QUICK_STOP})
    assert first <= NOTICED_WITHIN[fault.kind] + 1
    assert all(word == {cia402.QUICK_STOP} for word in words[first:])
    noticed = bench.group.snapshot.causes[0]
    assert noticed.cable == bench.robot.cable_names[fault.drive]


@settings(deadline=None, max_examples=12)
@given(
    slip=st.floats(-0.11, 0.11).filter(lambda slip: abs(slip) > 0.005),
    goal=st.sampled_from((4.4, 1.9)),
    drive=st.integers(0, 3),
)
def test_a_slip_is_found_at_the_next_mark(slip, goal, drive):
    """More than what the tolerances allow, less than half the spacing of the marks."""
    bench = Bench(ROBOTS["helical"]).enabled()
    bench.bus.inject(SimulatedFault(drive, FaultKind.SLIP, slip))
    goals = [float(s) for s in STARTS]
    path = smooth_path(goals, [goal if i == drive else g for i, g in enumerate(goals)], 6.0)
    with pytest.raises(WinchesStopped, match=f"c{drive + 1}: mark"):
        bench.group.follow(path)
    assert bench.group.snapshot.cables[drive].state is ReferenceState.DEGRADED


@pytest.mark.slow
@settings(deadline=None, max_examples=12)
@given(
    name=st.sampled_from(tuple(ROBOTS)),
    shares=st.tuples(*[st.fractions(F(0), F(1), max_denominator=8) for _ in range(4)]),
    goals=st.lists(st.tuples(*[st.floats(2.5, 4.2) for _ in range(4)]), min_size=1, max_size=2),
)
def test_lengths_are_enclosed_whatever_the_truth_in_the_tolerances(name, shares, goals):
    bench = Bench(ROBOTS[name], shares=shares).enabled()
    for goal in goals:
        start = [c.commanded for c in bench.group.snapshot.cables]
        way = max(abs(a - b) for a, b in zip(start, goal, strict=True))
        duration = 0.05 + max(15 / 8 * way / 0.45, (7.5 * way) ** 0.5)
        bench.group.follow(smooth_path(start, list(goal), duration))
        assert bench.contains_truth()
