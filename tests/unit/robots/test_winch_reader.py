"""Winches in robot files: exact values, defaults, and every error with its place."""

from __future__ import annotations

import re
from fractions import Fraction as F
from pathlib import Path

import pytest

from cdpr_interval.errors import InputError
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.robots.winch import (
    HelicalDrum,
    LinearDrum,
    Mark,
    MultilayerDrum,
    TableDrum,
    WinchGroupSettings,
)

HEAD = """format: cdpr-robot/1
name: test
platform: {mass_kg: 1}
"""
RADIUS = "{value: 0.05, tolerance: 2e-5}"
HELICAL = f"{{type: helical, groove_radius_m: {RADIUS}, cable_diameter_m: 0.002, pitch_m: 0.0025}}"
LIMITS = "{length_m: [0.5, 6], velocity_m_s: 0.5, acceleration_m_s2: 1, following_error_m: 0.01}"
GEAR = "gear_ratio: 156:7, counts_per_turn: 65536"


def winch(node: int = 1, drum: str = HELICAL, rest: str = GEAR, limits: str = LIMITS) -> str:
    comma = ", " if rest else ""
    return f"{{node: {node}, drum: {drum}{comma}{rest}, limits: {limits}}}"


def text(*winches: str | None, head: str = HEAD) -> str:
    lines = [head + "cables:"]
    for i, one in enumerate(winches):
        lines += [
            f"  - name: c{i + 1}",
            f"    frame_anchor_m: [{i}, 0, 1]",
            "    platform_anchor_m: [0, 0, 0]",
        ]
        lines += [] if one is None else [f"    winch: {one}"]
    return "\n".join(lines) + "\n"


def read(one: str):
    return parse_robot(text(one)).cables[0].winch


def errors(content: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        parse_robot(content, "r.yaml")
    return list(caught.value.messages)


def test_a_helical_winch_is_read_exactly():
    found = read(winch())
    assert found.drum == HelicalDrum(
        Range(F("0.04998"), F("0.05002")), Range(F("0.002"), F("0.002")), Range(F("0.0025"), F("0.0025"))
    )
    assert found.gear_ratio == F(156, 7) and found.counts_per_turn == 65536
    assert (found.sign, found.encoder_error, found.sensor) == (1, 1, None)
    limits = found.limits
    assert limits.length == (F("0.5"), 6) and limits.following_error == F("0.01") and limits.torque is None


def test_tolerances_of_winches_are_no_uncertain_scalars():
    assert parse_robot(text(winch())).uncertain == ()


@pytest.mark.parametrize("ratio", ["'156:7'", "156:7"])
def test_gear_ratios_are_rational(ratio):
    assert read(winch(rest=f"gear_ratio: {ratio}, counts_per_turn: 1")).gear_ratio == F(156, 7)
    assert read(winch(rest="gear_ratio: 25, counts_per_turn: 1")).gear_ratio == 25


def test_the_other_drums():
    layers = (
        "{type: multilayer, core_radius_m: 0.03, cable_diameter_m: 0.003, turns_per_layer: 10, layers: 6,"
        " cable_length_m: 12}"
    )
    found = read(winch(drum=layers)).drum
    assert isinstance(found, MultilayerDrum)
    assert found.packing.lo**2 < F(3, 4) < (found.packing.lo + F(1, 10**6)) ** 2 and found.packing.hi == 1
    assert (found.layers, found.turns_per_layer, found.transition_turns) == (6, 10, F(1, 2))
    table = "{type: table, points_turns_m: [[0, 0], [10, 3.1], [20, 6.3]], error_m: 0.0005}"
    assert read(winch(drum=table)).drum == TableDrum(((0, 0), (10, F("3.1")), (20, F("6.3"))), F("0.0005"))
    linear = "{type: linear, metres_per_count: {value: 5.90e-8, tolerance: 1e-11}}"
    found = read(winch(drum=linear, rest=""))
    assert found.drum == LinearDrum(Range(F("5.899e-8"), F("5.901e-8")))
    assert (found.gear_ratio, found.counts_per_turn) == (1, 1)


def test_marks_and_settings():
    marks = (
        "marks: {sensor_offset_m: 0.1, hysteresis_m: 0.001, latency_s: 0.002,"
        " at: [{distance_m: 1}, {name: b, distance_m: 2, tolerance_m: 0.5}]}"
    )
    sensor = read(winch(rest=f"{GEAR}, sign: -1, encoder_error_counts: 2.5, {marks}")).sensor
    assert sensor.marks == (Mark("1", Range(F(1), F(1))), Mark("b", Range(F("1.5"), F("2.5"))))
    assert (sensor.offset, sensor.hysteresis, sensor.latency) == (F("0.1"), F("0.001"), F("0.002"))
    head = HEAD + "winches: {cycle_s: 0.02, coherence_m: 0.03, armed: true}\n"
    settings = parse_robot(text(winch(), head=head)).winches
    assert settings == WinchGroupSettings(cycle=F("0.02"), coherence=F("0.03"), armed=True)
    assert parse_robot(text(winch())).winches == WinchGroupSettings()


@pytest.mark.parametrize(
    ("one", "message"),
    [
        (winch(node=0), "winch.node: must be an integer from 1 to 127, got 0"),
        (winch(rest=f"{GEAR}, sign: 2"), "winch.sign: must be 1 or -1, got 2"),
        (
            winch(rest="gear_ratio: 22.3, counts_per_turn: 1"),
            "winch.gear_ratio: must be two positive integers 'a:b'",
        ),
        (
            winch(rest="gear_ratio: 5:0, counts_per_turn: 1"),
            "winch.gear_ratio: must be two positive integers",
        ),
        (winch(rest="counts_per_turn: 1"), "winch: gear_ratio is missing"),
        (winch(rest="gear_ratio: 2"), "winch: counts_per_turn is missing"),
        (
            winch(drum="{type: linear, metres_per_count: 1e-8}"),
            "winch: gear_ratio is in metres_per_count already",
        ),
        (winch(drum="{type: square}"), "winch.drum: type must be one of helical, multilayer, table, linear"),
        (winch(drum="{pitch_m: 1}"), "winch.drum: type is missing"),
        (winch(drum="3"), "winch.drum: must be a mapping, got 3"),
        (winch(drum="{type: linear}", rest=""), "winch.drum.metres_per_count: missing"),
        (
            winch(drum=HELICAL.replace("pitch_m", "pich_m: 1, pitch_m")),
            "winch.drum.pich_m: unknown key (did you mean 'pitch_m'?)",
        ),
        (
            winch(drum=HELICAL.replace("0.002,", "-0.002,")),
            "winch.drum.cable_diameter_m: must be greater than 0",
        ),
        (winch(drum=HELICAL.replace("0.0025", "-1")), "winch.drum.pitch_m: must not be negative"),
        (
            winch(drum="{type: table, points_turns_m: [[0, 0], [1, 3], [2, 3]], error_m: 0}"),
            "winch.drum.points_turns_m: turns and lengths must ascend, point 2 does not",
        ),
        (
            winch(drum="{type: table, points_turns_m: [[0, 1], [1, 3]], error_m: 0}"),
            "winch: limits.length_m is beyond what the drum can do: 1 to 3 m",
        ),
        (
            winch(
                drum="{type: multilayer, core_radius_m: 0.03, cable_diameter_m: 0.003, turns_per_layer: 10,"
                " layers: 2, cable_length_m: 12}"
            ),
            "winch: limits.length_m is beyond what the drum can do: 7.8",
        ),
        (
            winch(limits=LIMITS.replace("[0.5, 6]", "[6, 0.5]")),
            "winch.limits.length_m: the lower bound 6 is above",
        ),
        (
            winch(limits=LIMITS.replace("[0.5, 6]", "[0, 6]")),
            "winch.limits.length_m: must be two lengths above 0",
        ),
        (
            winch(limits=LIMITS.replace("0.01", "0")),
            "winch.limits.following_error_m: must be greater than 0, got 0",
        ),
        (
            winch(rest=f"{GEAR}, marks: {{at: [{{distance_m: 1}}, {{distance_m: 0.5}}]}}"),
            "winch.marks: marks must ascend and stay apart: at[0] and at[1] do not",
        ),
        (
            winch(rest=f"{GEAR}, marks: {{at: [{{name: '2', distance_m: 1}}, {{distance_m: 2}}]}}"),
            "winch.marks: two marks have the name '2'",
        ),
        (winch(rest=f"{GEAR}, marks: {{at: []}}"), "winch.marks.at: must hold at least 1 entry"),
    ],
)
def test_every_rule_has_its_message(one, message):
    found = errors(text(one))
    assert len(found) == 1, found
    place, _, said = found[0].partition(": ")
    assert place.startswith("r.yaml:8:") and said.startswith(f"cables[0].{message}")


def test_all_winches_or_none_and_nodes_are_unique():
    assert errors(text(winch(), None, winch())) == [
        "r.yaml:9:5: cables[1].winch: missing: either every cable has a winch or none has",
        "r.yaml:15:19: cables[2].winch.node: 1 is the node of cables[0] already",
    ]


def test_every_error_at_once():
    found = errors(
        text(winch(node=200), winch(node=2, rest=f"{GEAR}, sign: 0"), head=HEAD + "winches: {armed: 1}\n")
    )
    assert [line.partition(": ")[2].partition(":")[0] for line in found] == [
        "winches.armed",
        "cables[0].winch.node",
        "cables[1].winch.sign",
    ]


def test_the_shipped_robot_has_winches():
    from cdpr_interval import load_robot

    robot = load_robot("four_winches")
    assert [cable.winch.node for cable in robot.cables] == [1, 2, 3, 4]
    assert all(len(cable.winch.sensor.marks) == 9 for cable in robot.cables)


def test_the_block_of_the_page_is_valid():
    page = (Path(__file__).parents[3] / "docs" / "winches.md").read_text(encoding="utf-8")
    block = re.search(r"^```yaml\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[1]
    found = parse_robot(text(None) + block).cables[0].winch
    assert found.limits.torque == F("1.2") and len(found.sensor.marks) == 2
