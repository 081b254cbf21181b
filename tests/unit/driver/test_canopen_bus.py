"""The CANopen bus against simulated CiA 402 nodes on python-can's virtual bus, in real time.

Times are only bounded from above, generously: this machine may be busy.
"""

from __future__ import annotations

import itertools
import logging
import subprocess
import sys
import threading
import time
from dataclasses import replace
from fractions import Fraction as F

import can
import canopen
import pytest

from cdpr_interval import InputError, load_robot
from cdpr_interval.driver import canopen_objects as objects
from cdpr_interval.driver import cia402
from cdpr_interval.driver.bus import PROBE_OFF, BusError, Command, DriveBus
from cdpr_interval.driver.canopen_bus import CanOpenBus
from cdpr_interval.driver.canopen_drive import CanOpenDrive, SimulatedNetwork, eds_of
from cdpr_interval.driver.cia402 import DriveState, Goal, Mode
from cdpr_interval.driver.group import WinchesStopped, WinchGroup
from cdpr_interval.driver.requests import Refused
from cdpr_interval.driver.simulated_drive import FaultKind, SimulatedDrive
from cdpr_interval.driver.snapshot import GroupState
from cdpr_interval.driver.violation import Interlock
from cdpr_interval.robots.winch import WinchGroupSettings
from tests.support.winch_robots import smooth_path

CHANNELS = (f"winch test {k}" for k in itertools.count())
SLOW = WinchGroupSettings(cycle=F(1, 20), heartbeat=F(1, 4), lookahead=F(1, 2))
"""Data may be 150 ms old before the winches stop: a busy machine is no fault here."""
ROBOT = replace(load_robot("four_winches"), winches=SLOW)
STARTS = (3.0, 3.0, 3.0, 3.0)
GOAL = [3.2, 2.9, 3.1, 2.8]
PATIENCE = 5.0
"""s; far more than anything here takes on a machine that is not stuck."""

logging.getLogger("canopen").setLevel(logging.CRITICAL)


class Rig:
    """Four simulated nodes and a bus to them on a channel of their own."""

    def __init__(self, **others) -> None:
        self.channel = next(CHANNELS)
        self.drives = [
            SimulatedDrive(cable.winch, F(start), first_reading=1000 * i, **others)
            for i, (cable, start) in enumerate(zip(ROBOT.cables, STARTS, strict=True))
        ]
        self.network = SimulatedNetwork(self.drives, "virtual", self.channel)
        self.bus = CanOpenBus.of(ROBOT, "virtual", self.channel)

    def __enter__(self) -> Rig:
        self.network.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.bus.close()
        self.network.stop()

    def cycle(self, commands=()):
        self.bus.write_all(commands)
        heard = self.bus.read_all()
        time.sleep(0.002)
        return heard

    def enabled(self):
        """Lead all drives to OPERATION ENABLED where they are."""
        heard = self.cycle()
        for _ in range(500):
            commands = [self.towards(Goal.ENABLED, one) for one in heard]
            heard = self.cycle(commands)
            if all(state_of(one) is DriveState.ENABLED for one in heard):
                return heard
        raise AssertionError("not enabled")

    @staticmethod
    def towards(goal, one):
        return Command(cia402.controlword(state_of(one), goal), Mode.CYCLIC_POSITION, one.position)

    def until(self, condition, commands=None):
        """Run cycles until something is heard."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            heard = self.cycle(commands or ())
            if condition(heard):
                return heard
        raise AssertionError("never heard")


def slow_path(duration):
    return smooth_path(list(STARTS), GOAL, duration, cycle=0.05)


def state_of(one):
    return cia402.state_of(one.status)


def hold(heard):
    return [Command(cia402.ENABLE_OPERATION, Mode.CYCLIC_POSITION, one.position) for one in heard]


@pytest.fixture
def rig():
    before = set(threading.enumerate())
    with Rig() as found:
        yield found
    end = time.monotonic() + PATIENCE
    while set(threading.enumerate()) - before and time.monotonic() < end:
        time.sleep(0.01)
    assert not set(threading.enumerate()) - before, "threads are left"


@pytest.fixture
def group(rig):
    found = WinchGroup(ROBOT, rig.bus)
    found.connect()
    found.home([(2.999, 3.001)] * 4)
    yield found
    found.close()


def test_enable_home_follow_and_read_back(rig, group):
    group.enable()
    assert [drive.motor for drive in rig.drives] == [0, 0, 0, 0]
    group.follow(slow_path(4.0))
    assert group.state is GroupState.HOLDING
    group.wait(lambda snapshot: all(cable.following_error == 0 for cable in snapshot.cables), PATIENCE)
    for cable, drive, goal in zip(group.snapshot.cables, rig.drives, GOAL, strict=True):
        assert cable.counts == cable.target == drive.reading
        assert cable.length == pytest.approx(goal, abs=1e-5)
        lo, hi = cable.length_range()
        assert F(lo) <= drive.true_length <= F(hi)


def test_one_node_dies_and_all_others_are_stopped(rig, group):
    group.enable()
    now = rig.bus.now()
    for time_, point in slow_path(6.0):
        group.command(point, now + time_)
    time.sleep(0.5)
    rig.network.kill(3)
    assert group.wait(lambda snapshot: snapshot.state is GroupState.STOPPED, PATIENCE)
    causes = {(cause.interlock, cause.cable) for cause in group.snapshot.causes}
    assert (Interlock.DATA_AGE, "c3") in causes
    assert "c3: data-age: process data are" in str(group.snapshot.causes[0])
    others = [drive for drive in rig.drives if drive.winch.node != 3]
    end = time.monotonic() + PATIENCE
    while any(drive.state is not DriveState.DISABLED for drive in others) and time.monotonic() < end:
        time.sleep(0.01)
    assert {drive.state for drive in others} == {DriveState.DISABLED}
    with pytest.raises(Refused, match="c3: data-age"):
        group.enable()


def test_the_protocol_is_kept(rig):
    bus: DriveBus = rig.bus
    assert bus.count == 4
    bus.quick_stop_all()
    with pytest.raises(BusError, match="not connected"):
        bus.write_all([])


def test_probe_values_come_with_their_cycle(rig):
    rig.bus.connect()
    heard = rig.enabled()
    goal = [one.position + 40000 for one in heard]
    # One mark of node 1 is at 3 m of cable and 0.15 m before the sensor: 2.85 m.
    target = heard[0].position - round(0.3 / 2.1944e-7)
    sent = [Command(cia402.ENABLE_OPERATION, 8, target, 0x11), *hold(heard)[1:]]
    caught = rig.until(lambda now: now[0].probe & 2, sent)
    assert goal and caught[0].probe_position != 0
    rig.until(lambda now: not now[0].probe & 1, [Command(0x0F, 8, target, PROBE_OFF), *hold(heard)[1:]])


def test_everything_that_is_missing_is_listed(rig):
    dictionary = rig.network.nodes[1]._local.object_dictionary
    for index in (0x1016, 0x605A, 0x60B8):
        del dictionary[index]
    rig.drives[3].inject(FaultKind.REFUSED_MODE)
    with pytest.raises(BusError) as caught:
        rig.bus.connect()
    lines = str(caught.value).splitlines()
    for wanted in (
        "node 2: 0x1016:1 consumer heartbeat time: missing",
        "node 2: 0x605a quick stop option code: missing",
        "node 2: 0x60b8 touch probe function: missing",
        "node 4: 0x6061 modes of operation display: is 0, must be 8",
    ):
        assert any(line.startswith(wanted) for line in lines), lines
    assert all(drive.state is DriveState.DISABLED for drive in rig.drives)


def test_a_value_that_is_not_kept_is_listed(rig):
    local = rig.network.nodes[0]._local
    local.add_read_callback(lambda index, subindex, od, **rest: 1 if index == 0x6007 else None)
    with pytest.raises(BusError, match="node 1: 0x6007 abort connection option code: is 1, must be 3"):
        rig.bus.connect()


def test_a_node_that_does_not_answer_is_named(rig):
    rig.network.kill(2)
    with pytest.raises(BusError, match="node 2: no answer"):
        rig.bus.connect()


def test_quick_stop_reaches_all(rig):
    rig.bus.connect()
    rig.enabled()
    rig.bus.quick_stop_all()
    rig.until(lambda heard: all(state_of(one) is DriveState.DISABLED for one in heard))


def test_emergency_and_reset(rig):
    rig.bus.connect()
    heard = rig.enabled()
    rig.drives[1].inject(FaultKind.EMERGENCY)
    heard = rig.until(lambda now: now[1].emergency == 0x2310, hold(heard))
    assert heard[0].emergency == 0
    rig.until(lambda now: state_of(now[1]) is DriveState.FAULT, hold(heard))
    stop = [Command(cia402.DISABLE_VOLTAGE, 8, one.position) for one in heard]
    reset = [Command(cia402.FAULT_RESET, 8, one.position) for one in heard]
    rig.cycle(stop)
    rig.until(lambda now: now[1].emergency == 0 and state_of(now[1]) is DriveState.DISABLED, reset)


def test_a_reboot_is_seen(rig):
    rig.bus.connect()
    rig.enabled()
    rig.drives[0].inject(FaultKind.REBOOT)
    heard = rig.until(lambda now: now[0].boots == 1)
    assert not heard[0].operational


def test_the_master_dies_and_the_drives_stop(rig):
    """The heartbeat is sent by the cycle: when the cycle hangs, and nothing else, the drives notice."""
    rig.bus.connect()
    rig.enabled()
    end = time.monotonic() + PATIENCE
    while any(drive.state is not DriveState.DISABLED for drive in rig.drives) and time.monotonic() < end:
        time.sleep(0.01)
    assert {drive.state for drive in rig.drives} == {DriveState.DISABLED}


def test_trap_1_a_raising_callback_hides_nothing(rig):
    rig.bus.connect()

    def fail(*message):
        raise RuntimeError("in a callback")

    for node in (1, 2, 3, 4):
        for cob in (*(cob + node for cob in objects.TPDO_COBS), 0x700 + node, 0x80 + node):
            rig.bus._network.subscribe(cob, fail)
    heard = rig.enabled()
    rig.drives[1].inject(FaultKind.EMERGENCY)
    rig.until(lambda now: now[1].emergency == 0x2310, hold(heard))


def test_trap_2_a_lost_heartbeat_is_an_age(rig):
    rig.bus.connect()
    rig.enabled()
    rig.drives[2].inject(FaultKind.HEARTBEAT)
    rig.until(lambda now: rig.bus.now() - now[2].heartbeat_at > 0.75)
    heard = rig.cycle()
    assert heard[2].operational and rig.bus.now() - heard[2].heard_at < PATIENCE


def test_trap_3_before_the_first_data_nothing_is_claimed(rig):
    assert [one.heard_at for one in rig.bus.read_all()] == [None] * 4
    rig.bus.connect()
    assert [one.heard_at for one in rig.bus.read_all()] == [None] * 4
    heard = rig.until(lambda now: all(one.heard_at is not None for one in now))
    assert [state_of(one) for one in heard] == [DriveState.DISABLED] * 4


def test_trap_4_the_boot_message_may_have_been_sent_before_the_master_came(rig):
    time.sleep(0.2)
    rig.bus.connect()
    assert [one.boots for one in rig.bus.read_all()] == [0] * 4


def test_trap_5_a_mode_that_was_not_taken_is_seen(rig, group):
    rig.drives[0].inject(FaultKind.REFUSED_MODE)
    with pytest.raises(WinchesStopped, match="c1: not-enabled"):
        group.enable()
    # The others had come along, and hear of the stop in threads of their own.
    end = time.monotonic() + PATIENCE
    while any(drive.state is DriveState.ENABLED for drive in rig.drives) and time.monotonic() < end:
        time.sleep(0.01)
    assert all(drive.state is not DriveState.ENABLED for drive in rig.drives)


def listened(channel):
    """Return a bus that hears every frame of a channel."""
    return can.Bus(interface="virtual", channel=channel)


def test_traps_6_7_10_what_is_sent_in_operation(rig, group):
    """No SDO in the cycle, bits 4 to 6 of the controlword never set, no fault reset unasked."""
    listener = listened(rig.channel)
    group.enable()
    group.follow(slow_path(4.0))
    rig.drives[1].inject(FaultKind.EMERGENCY)
    group.wait(lambda snapshot: snapshot.latched, PATIENCE)
    time.sleep(0.3)
    frames = []
    while (frame := listener.recv(0)) is not None:
        frames.append(frame)
    listener.shutdown()
    identifiers = {frame.arbitration_id for frame in frames}
    assert not any(0x580 <= identifier <= 0x67F for identifier in identifiers)
    words = [int.from_bytes(f.data[:2], "little") for f in frames if 0x200 <= f.arbitration_id <= 0x27F]
    assert len(words) > 300
    assert not any(word & 0xF0 for word in words)
    group.acknowledge()
    assert rig.drives[1].state is DriveState.DISABLED


def test_trap_8_operational_is_believed_from_heartbeats_only(rig):
    rig.network.nodes[3]._on_nmt = lambda data: None
    node = rig.network.nodes[3]
    for callbacks in node._network.subscribers.values():
        callbacks[:] = [c for c in callbacks if getattr(c, "__closure__", None) is None or not holds(c, node)]
    with pytest.raises(BusError, match=r"node 4: no (answer|heartbeat)"):
        rig.bus.connect()


def holds(callback, node):
    """Return whether a callback belongs to a simulated node."""
    return any(cell.cell_contents is node for cell in callback.__closure__ or ())


def test_trap_9_times_are_monotonic(rig, monkeypatch):
    """Wall clock time may jump; ages must not."""
    rig.bus.connect()
    monkeypatch.setattr(time, "time", lambda: 0.0)
    heard = rig.until(lambda now: all(one.heard_at is not None for one in now))
    assert all(abs(rig.bus.now() - one.heard_at) < PATIENCE for one in heard)


def test_trap_10_a_dead_node_never_blocks_the_cycle(rig):
    rig.bus.connect()
    rig.enabled()
    rig.network.kill(1)
    start = time.monotonic()
    for _ in range(20):
        rig.bus.write_all([])
        rig.bus.read_all()
    assert time.monotonic() - start < PATIENCE
    heard = rig.bus.read_all()
    assert heard[0].heard_at < heard[1].heard_at


def test_trap_11_the_simulated_node_is_a_whole_device(rig):
    """Reset: boot-up message, settings lost, PRE-OPERATIONAL; heartbeats again after set-up."""
    rig.bus.connect()
    rig.bus._network.send_message(0, [objects.RESET_NODE, 2])
    rig.until(lambda now: now[1].boots >= 1)
    rig.bus.connect()
    heard = rig.enabled()
    assert heard[1].operational and heard[1].boots == 0


def test_trap_12_the_fields_of_a_cycle_belong_together(rig):
    """The second PDO of a cycle is lost: the whole cycle is old, not half of it."""
    rig.bus.connect()
    heard = rig.until(lambda now: all(one.heard_at is not None for one in now))
    node = rig.network.nodes[0]
    send = node._send
    node._send = lambda cob, data: None if cob == objects.TPDO_COBS[1] + 1 else send(cob, data)
    old = rig.bus.read_all()[0]
    for _ in range(5):
        heard = rig.cycle()
    assert heard[0].heard_at <= old.heard_at + 0.1
    assert heard[1].heard_at > old.heard_at


def test_data_of_a_wrong_length_are_no_data(rig):
    rig.bus.connect()
    rig.until(lambda now: all(one.heard_at is not None for one in now))
    node = rig.network.nodes[0]
    send = node._send
    node._send = lambda cob, data: send(cob, data[:5] if cob == objects.TPDO_COBS[0] + 1 else data)
    heard = rig.until(lambda now: now[0].heard_at is None)
    assert heard[1].heard_at is not None


def test_the_shipped_eds_has_every_object_the_driver_uses():
    dictionary = eds_of(canopen)
    settings = objects.drive_settings(0.01, 0.05, 1, 1) + objects.pdo_settings(1)
    entries = [setting.entry for setting in settings]
    entries += [entry for pdo in (*objects.RPDOS, *objects.TPDOS) for entry in pdo]
    for entry in entries:
        variable = dictionary.get_variable(entry.index, entry.sub)
        assert variable is not None and len(variable) == 8 * entry.size, str(entry)
    assert all(sum(entry.size for entry in pdo) <= 8 for pdo in (*objects.RPDOS, *objects.TPDOS))


def test_without_the_extra_the_error_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "canopen", None)
    with pytest.raises(InputError, match=r"pip install '\.\[driver\]'"):
        CanOpenBus.of(ROBOT, "virtual", "none").connect()
    with pytest.raises(InputError, match=r"pip install '\.\[driver\]'"):
        SimulatedNetwork([], "virtual", "none").start()


def test_importing_the_driver_imports_no_can():
    code = (
        "import sys, cdpr_interval.driver.canopen_bus; print('can' in sys.modules, 'canopen' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def test_an_unknown_interface_is_an_error():
    with pytest.raises(BusError, match="no bus"):
        CanOpenBus.of(ROBOT, "no-such-interface", "x").connect()


def test_nodes_are_made_of_drives(rig):
    assert all(isinstance(node, CanOpenDrive) for node in rig.network.nodes)
    assert [node.node for node in rig.network.nodes] == [1, 2, 3, 4]
