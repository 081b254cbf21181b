"""Pulleys as data and as a block of a robot file."""

from __future__ import annotations

import dataclasses
import json
from fractions import Fraction as F
from importlib import resources
from typing import Any

import pytest

from cdpr_interval import InputError, Robot
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.robots.pulley import Pulley

TEXT = """\
format: cdpr-robot/1
name: r
platform: {mass_kg: 80}
cables:
  - name: c1
    frame_anchor_m: [0, 0, 3]
    platform_anchor_m: [0, 0, 0]
    pulley: %s
"""
BLOCK = "r.yaml:8:13: cables[0].pulley"
TWO_LEGS = "must be above 0 with two joints: the arm hangs between two legs of the rope"
ABOVE = "must be above 0 where there is an arm or a range, got 0"


def robot_with(block: str) -> Robot:
    """Return the robot of a file with a block of a pulley."""
    return parse_robot(TEXT % block, "r.yaml")


@pytest.mark.parametrize(
    ("block", "lines"),
    [
        ("{radius_m: -0.01}", [f"{BLOCK}: radius_m must not be negative, got -0.01"]),
        (
            "{radius_m: {value: 0.1, tolerance: 0.2}}",
            [f"{BLOCK}: radius_m must not be negative, got -0.1"],
        ),
        ("{radius_m: 0, arm_m: 0.1}", [f"{BLOCK}: radius_m {ABOVE}"]),
        ("{radius_m: [0, 0.1]}", [f"{BLOCK}: radius_m {ABOVE}"]),
        ("{radius_m: 0.1, arm_m: 0.05}", [f"{BLOCK}: arm_m must be at least the radius 0.1, got 0.05"]),
        (
            "{radius_m: [0.1, 0.2], arm_m: 0.15}",
            [f"{BLOCK}: arm_m must be at least the radius 0.2, got 0.15"],
        ),
        ("{radius_m: 0.1, arm_m: -0.1}", [f"{BLOCK}: arm_m must not be negative, got -0.1"]),
        ("{radius_m: 0.1, axis: [0, 0, 0]}", [f"{BLOCK}: axis must not be the zero vector"]),
        ("{radius_m: 0.1, axis: [[-1, 1], 0, 0]}", [f"{BLOCK}: axis must not be the zero vector"]),
        (
            "{radius_m: 0.1, axis: [0, 1]}",
            ["r.yaml:8:35: cables[0].pulley.axis: must be a list of 3 numbers, got a list of 2"],
        ),
        (
            "{radius_m: 0.1, joints: 3}",
            ["r.yaml:8:37: cables[0].pulley.joints: must be an integer from 1 to 2, got 3"],
        ),
        (
            "{radius_m: 0.1, joints: 1.5}",
            ["r.yaml:8:37: cables[0].pulley.joints: must be an integer from 1 to 2, got 1.5"],
        ),
        (
            "{radius_m: 0.1, balance: bisector}",
            [f"{BLOCK}: balance only with two joints: one joint leaves the arm no choice"],
        ),
        (
            "{radius_m: 0.1, joints: 2, lead_in_m: 1, balance: exakt}",
            [
                "r.yaml:8:63: cables[0].pulley.balance: must be one of exact, bisector, got the text 'exakt'",
            ],
        ),
        ("{radius_m: 0.1, lead_in_m: -1}", [f"{BLOCK}: lead_in_m must not be negative, got -1"]),
        ("{radius_m: 0.1, joints: 2}", [f"{BLOCK}: lead_in_m {TWO_LEGS}"]),
        ("{radius_m: 0.1, joints: 2, lead_in_m: [0, 1]}", [f"{BLOCK}: lead_in_m {TWO_LEGS}"]),
        (
            "{radius_m: -1, lead_in_m: -1}",
            [f"{BLOCK}: radius_m must not be negative, got -1; lead_in_m must not be negative, got -1"],
        ),
        ("{}", [f"{BLOCK}.radius_m: missing"]),
        ("[]", [f"{BLOCK}: must be a mapping, got a list of 0"]),
        ("{radius_m: x}", ["r.yaml:8:24: cables[0].pulley.radius_m: 'x' is not a number"]),
        ("{radius_m: null}", ["r.yaml:8:24: cables[0].pulley.radius_m: must be a number, got nothing"]),
        (
            "{raduis_m: 0.1}",
            [
                f"{BLOCK}.radius_m: missing",
                "r.yaml:8:14: cables[0].pulley.raduis_m: unknown key (did you mean 'radius_m'?)",
            ],
        ),
        (
            "{radius_m: 0.1, arm: 0.2}",
            ["r.yaml:8:29: cables[0].pulley.arm: unknown key (did you mean 'arm_m'?)"],
        ),
        (
            "{radius_m: 0.1, axes: [0, 0, 1]}",
            ["r.yaml:8:29: cables[0].pulley.axes: unknown key (did you mean 'axis'?)"],
        ),
        # "in" is no inch here.
        (
            "{radius_m: 0.1, lead_in: 0.2}",
            ["r.yaml:8:29: cables[0].pulley.lead_in: unknown key (did you mean 'lead_in_m'?)"],
        ),
        (
            "{radius_mm: 100}",
            [
                f"{BLOCK}.radius_m: missing",
                "r.yaml:8:14: cables[0].pulley.radius_mm: unknown key: write 'radius_m', and divide by 1000",
            ],
        ),
        (
            "{radius_m: 0.1}\n    elasticity: {stiffness_N_per_m: 1, axial_stiffness_N: 1}",
            [
                "r.yaml:9:17: cables[0].elasticity: must hold exactly one of "
                "'stiffness_N_per_m' and 'axial_stiffness_N'",
            ],
        ),
    ],
)
def test_a_wrong_block_is_one_line_with_its_place(block: str, lines: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        robot_with(block)
    assert list(caught.value.messages) == lines


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"radius": -1}, "radius: must not be negative, got -1"),
        ({"radius": "x"}, "radius: 'x' is not a number"),
        ({"radius": float("nan")}, "radius: nan is not a finite number"),
        ({"radius": (2, 1)}, "radius: the lower bound 2 is above the upper bound 1"),
        ({"radius": 0, "arm": 1}, f"radius: {ABOVE}"),
        ({"radius": "0.1", "arm": "0.05"}, "arm: must be at least the radius 0.1, got 0.05"),
        ({"radius": "0.1", "axis": (0, 0, 0)}, "axis: must not be the zero vector"),
        ({"radius": "0.1", "axis": (0, 1)}, "axis: must be 3 numbers, got (0, 1)"),
        ({"radius": "0.1", "lead_in": -1}, "lead_in: must not be negative, got -1"),
        ({"radius": "0.1", "joints": 2}, f"lead_in: {TWO_LEGS}"),
        ({"radius": "0.1", "joints": 3}, "joints: must be 1 or 2, got 3"),
        ({"radius": "0.1", "joints": "2"}, "joints: must be 1 or 2, got '2'"),
        # These are equal to 1, but a file with them could not be read.
        ({"radius": "0.1", "joints": True}, "joints: must be 1 or 2, got True"),
        ({"radius": "0.1", "joints": 1.0}, "joints: must be 1 or 2, got 1.0"),
        (
            {"radius": "0.1", "balance": "bisector"},
            "balance: only with two joints: one joint leaves the arm no choice",
        ),
        ({"radius": "0.1", "balance": None}, "balance: must be one of exact, bisector, got None"),
    ],
)
def test_a_wrong_pulley_in_memory_is_one_line(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Pulley(**given)
    assert caught.value.messages == (message,)


BLOCKS = (
    "{radius_m: 0.1}",
    "{radius_m: 0}",
    "{radius_m: 0, joints: 2}",
    "{radius_m: 0.03, arm_m: 0.03, joints: 1, axis: [0, 0, -2], lead_in_m: 0}",
    "{radius_m: 0.0665, arm_m: 0.1, joints: 2, lead_in_m: 5, axis: [0.1, -3, 1e-3]}",
    "{radius_m: 0.0665, arm_m: 0.1, joints: 2, lead_in_m: 5, balance: bisector}",
    "{radius_m: {value: 0.1, tolerance: 0.01}, arm_m: [0.2, 0.3], axis: [0, [-1, 1], 1], lead_in_m: [1, 2]}",
)


@pytest.mark.parametrize("block", BLOCKS)
def test_a_pulley_goes_through_every_form(block: str) -> None:
    read = robot_with(block)
    again = Robot.from_dict(read.to_dict())
    assert again == read and hash(again) == hash(read)
    # Written anew, not the bytes of the file.
    written = again.to_yaml()
    assert written != read.to_yaml() and parse_robot(written) == read
    assert Robot.from_dict(json.loads(json.dumps(again.to_dict(), default=str))) == read
    as_json = json.dumps(again.to_dict(), default=float)
    assert parse_robot(as_json) == read


def test_what_the_file_says_is_what_is_kept() -> None:
    pulley = robot_with(BLOCKS[4]).cables[0].pulley
    assert pulley == Pulley("0.0665", "0.1", 2, ("0.1", -3, "1e-3"), 5)
    assert (pulley.radius, pulley.arm_length, pulley.lead_in) == (F(665, 10000), F(1, 10), 5)
    assert pulley.axis == (F(1, 10), -3, F(1, 1000)) and pulley.balance == "exact" and not pulley.is_plain
    bare = robot_with("{radius_m: 0.1}").cables[0].pulley
    assert bare == Pulley(F(1, 10))
    assert (bare.arm, bare.arm_length, bare.axis, bare.lead_in, bare.joints) == (None, F(1, 10), None, 0, 1)
    assert robot_with("{radius_m: 0}").cables[0].pulley.is_plain


def test_every_number_may_be_a_range() -> None:
    robot = robot_with(BLOCKS[-1])
    assert [(u.path, u.lo, u.hi) for u in robot.uncertain] == [
        ("cables[0].pulley.radius_m", F(9, 100), F(11, 100)),
        ("cables[0].pulley.arm_m", F(1, 5), F(3, 10)),
        ("cables[0].pulley.axis[1]", -1, 1),
        ("cables[0].pulley.lead_in_m", 1, 2),
    ]
    middle = robot.middle()
    assert middle.is_exact and not robot.is_exact
    assert middle.cables[0].pulley == Pulley("0.1", "0.25", 1, (0, 0, 1), "1.5")
    # The default of the arm is the radius, whatever that is: there is one range only.
    assert [u.path for u in robot_with("{radius_m: [0.1, 0.2]}").uncertain] == ["cables[0].pulley.radius_m"]
    assert Pulley(Range(F(1), F(2))).middle() == Pulley("1.5")


def test_a_changed_pulley_is_another_robot() -> None:
    robot = robot_with(BLOCKS[4])
    cable = robot.cables[0]
    assert cable.pulley is not None
    changed = cable.pulley.replace(radius="0.05")
    assert changed == dataclasses.replace(cable.pulley, radius=F(1, 20)) != cable.pulley
    assert len({cable.pulley, changed, cable.pulley.replace()}) == 2
    other = robot.replace(cables=(cable.replace(pulley=changed),))
    assert other != robot and other.sha256 != robot.sha256
    assert "radius_m: 0.05" in other.to_yaml()
    with pytest.raises(InputError, match="Pulley has no radus, only radius, arm, joints, axis, lead_in, bal"):
        cable.pulley.replace(radus=1)
    with pytest.raises(InputError, match=r"arm: must be at least the radius 0\.2, got 0\.1"):
        cable.pulley.replace(radius="0.2")


def test_a_cable_without_a_pulley_has_none_in_its_block() -> None:
    cable = Cable("c", (0, 0, 1), (0, 0, 0), Elasticity(stiffness=1))
    assert "pulley" not in cable.to_dict() and not Robot("r", Platform(1), (cable,)).has_pulleys
    assert robot_with("{radius_m: 0.1}").has_pulleys


SCHEMA = json.loads(
    resources.files("cdpr_interval.robots").joinpath("schemas/cdpr-robot-1.schema.json").read_text("utf-8")
)


def test_the_json_schema_knows_the_block() -> None:
    """The whole text is compared with the models elsewhere."""
    block = SCHEMA["$defs"]["PulleyBlock"]
    assert block["required"] == ["radius_m"] and not block["additionalProperties"]
    keys = block["properties"]
    assert list(keys) == ["radius_m", "joints", "arm_m", "axis", "lead_in_m", "balance"]
    assert (keys["joints"]["minimum"], keys["joints"]["maximum"]) == (1, 2)
    assert keys["balance"]["enum"] == ["exact", "bisector"]
    assert all("description" in key for key in keys.values())
