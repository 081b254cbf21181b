"""The CiA 402 state machine, without any bus."""

from __future__ import annotations

import pytest

from cdpr_interval.driver import cia402
from cdpr_interval.driver.cia402 import Control, DriveState, Goal, NoTransition, answer, controlword, state_of

DONT_CARE = (0x0000, 0xFF90, 0x1234 & 0xFF90)
"""Bits of a statusword that say nothing about the state."""


@pytest.mark.parametrize(
    ("word", "state"),
    [
        (0x0000, DriveState.NOT_READY),
        (0x0040, DriveState.DISABLED),
        (0x0060, DriveState.DISABLED),
        (0x0021, DriveState.READY),
        (0x0023, DriveState.SWITCHED_ON),
        (0x0027, DriveState.ENABLED),
        (0x0007, DriveState.QUICK_STOP),
        (0x000F, DriveState.FAULT_REACTION),
        (0x002F, DriveState.FAULT_REACTION),
        (0x0008, DriveState.FAULT),
        (0x0028, DriveState.FAULT),
    ],
)
def test_statuswords_of_the_standard(word, state):
    for extra in DONT_CARE:
        assert state_of(word | extra) is state


def test_every_statusword_is_one_state_or_none():
    shown = {}
    for word in range(256):
        try:
            shown[word & 0x6F] = state_of(word)
        except NoTransition:
            shown[word & 0x6F] = None
    assert set(DriveState) <= set(shown.values())
    assert shown[0x01] is None and shown[0x03] is None


def test_the_states_show_themselves():
    for state in DriveState:
        assert state_of(cia402.statusword_of(state)) is state


def test_the_way_to_enabled():
    """0x06, 0x07, 0x0F: shutdown, switch on, enable operation, one step an answer."""
    state, previous, sent = DriveState.DISABLED, 0, []
    while state is not DriveState.ENABLED:
        word = controlword(state, Goal.ENABLED)
        sent.append(word)
        state, previous = answer(state, word, previous), word
    assert sent == [0x06, 0x07, 0x0F]


@pytest.mark.parametrize("state", [DriveState.FAULT, DriveState.FAULT_REACTION, DriveState.QUICK_STOP])
def test_no_way_from_a_fault_or_quick_stop_to_enabled(state):
    with pytest.raises(NoTransition, match="acknowledgement"):
        controlword(state, Goal.ENABLED)


def test_trap_7_no_controlword_without_the_edge_leaves_a_fault():
    """Nothing but a rising edge of bit 7 leaves FAULT, and it leads to DISABLED, never to ENABLED."""
    for word in range(256):
        for previous in (0x00, 0x80):
            state = answer(DriveState.FAULT, word, previous)
            rising = bool(word & 0x80) and not previous & 0x80
            assert state is (DriveState.DISABLED if rising else DriveState.FAULT)
    for state in DriveState:
        for goal in Goal:
            try:
                assert not controlword(state, goal) & Control.FAULT_RESET
            except NoTransition:
                assert goal is Goal.ENABLED


def test_every_state_stops_and_disables():
    for state in DriveState:
        assert controlword(state, Goal.STOPPED) == cia402.QUICK_STOP == 0x02
        assert controlword(state, Goal.DISABLED) == cia402.DISABLE_VOLTAGE == 0
    assert answer(DriveState.ENABLED, cia402.QUICK_STOP, 0x0F) is DriveState.QUICK_STOP
    # In quick stop, and after it, ENABLE OPERATION alone does nothing.
    assert answer(DriveState.QUICK_STOP, cia402.ENABLE_OPERATION, cia402.QUICK_STOP) is DriveState.QUICK_STOP
    assert answer(DriveState.DISABLED, cia402.ENABLE_OPERATION, cia402.QUICK_STOP) is DriveState.DISABLED


def test_trap_6_no_word_sets_the_bits_of_a_mode():
    """Bit 4 is "new set-point" in profile position and "start homing" in homing: it must never be sent."""
    for state in DriveState:
        for goal in Goal:
            try:
                assert not controlword(state, goal) & 0x70
            except NoTransition:
                continue
