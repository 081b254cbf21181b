"""Cables that are legs: what files and Python may say of them, and what they may not."""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction as F

import pytest

from cdpr_interval import InputError, Robot, load_robot
from cdpr_interval.robots.cable_robot import Cable
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.robots.pulley import Pulley
from solvers.batch.job import perturbed

FILE = """\
format: cdpr-robot/1
name: r
platform:
  mass_kg: 80
cables:
  - name: c1
    frame_anchor_m: [0, 0, 0]
    platform_anchor_m: [0, 0, 0]
    leg: true
  - name: c2
    frame_anchor_m: [1, 0, 0]
    platform_anchor_m: [0, 1, 0]
    leg: true
    length_limits_m: [1.1, 2]
"""


def refused(old: str, new: str) -> tuple[str, ...]:
    assert FILE.count(old) == 1
    with pytest.raises(InputError) as caught:
        parse_robot(FILE.replace(old, new), "r.yaml")
    return caught.value.messages


def test_a_file_is_read_and_written_exactly():
    robot = parse_robot(FILE)
    assert robot.has_legs and [cable.leg for cable in robot.cables] == [True, True]
    assert [cable.length_limits for cable in robot.cables] == [None, (F(11, 10), F(2))]
    blocks = robot.to_dict()["cables"]
    assert blocks[0]["leg"] is True and "length_limits_m" not in blocks[0]
    assert blocks[1]["length_limits_m"] == [Decimal("1.1"), 2]
    assert Robot.from_dict(robot.to_dict()) == robot
    changed = robot.replace(name="other")
    assert parse_robot(changed.to_yaml()) == changed


def test_cables_have_no_legs():
    robot = load_robot("six_leg_40")
    assert not robot.has_legs
    assert not {"leg", "length_limits_m"} & robot.to_dict()["cables"][0].keys()
    assert load_robot("gough_40").has_legs


def test_false_is_what_a_cable_is():
    text = FILE.replace("leg: true", "leg: false").replace("    length_limits_m: [1.1, 2]\n", "")
    assert not parse_robot(text).has_legs


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "0]\n    leg: true\n    length_limits_m: [1.1, 2]",
            "0]",
            "10:5: cables[1].leg: missing: either every cable is a leg or none is",
        ),
        (
            "leg: true\n    length_limits_m: [1.1, 2]",
            "leg: false",
            "13:10: cables[1].leg: must be true: either every cable is a leg or none is",
        ),
        ("leg: true\n    length", "leg: 1\n    length", "13:10: cables[1].leg: must be true or false, got 1"),
        (
            "[1.1, 2]",
            "[1.1, 2]\n    elasticity: {axial_stiffness_N: 9}",
            "15:17: cables[1].elasticity: a leg has none",
        ),
        (
            "[1.1, 2]",
            "[1.1, 2]\n    tension_limits_N: [0, 9]",
            "15:23: cables[1].tension_limits_N: a leg has none",
        ),
        ("[1.1, 2]", "[1.1, 2]\n    pulley: {radius_m: 1}", "15:13: cables[1].pulley: a leg has none"),
        (
            "[1.1, 2]",
            "[2, 1.1]",
            "14:22: cables[1].length_limits_m: the lower bound 2 is above the upper bound 1.1000000000000001",
        ),
        (
            "[1.1, 2]",
            "[0, 2]",
            "14:22: cables[1].length_limits_m: must be two lengths above 0, the second larger, got [0, 2]",
        ),
        (
            "[1.1, 2]",
            "[2, 2]",
            "14:22: cables[1].length_limits_m: must be two lengths above 0, the second larger, got [2, 2]",
        ),
    ],
)
def test_what_a_file_may_not_say(old, new, message):
    (found,) = refused(old, new)
    assert found == f"r.yaml:{message}"


def test_limits_of_a_length_are_of_legs_only():
    text = FILE.replace("    leg: true\n", "")
    with pytest.raises(InputError) as caught:
        parse_robot(text, "r.yaml")
    assert caught.value.messages == (
        "r.yaml:12:22: cables[1].length_limits_m: only of a leg, with leg: true",
    )


def test_a_winch_on_a_leg():
    found = refused("[1.1, 2]", "[1.1, 2]\n    winch: {node: 1}")
    assert "r.yaml:15:12: cables[1].winch: a leg has none" in found


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"leg": 1}, "leg: must be true or false, got 1"),
        ({"length_limits": (1, 2)}, "length_limits: only of a leg"),
        (
            {"leg": True, "length_limits": (2, 1)},
            "length_limits: must be two lengths above 0, the second larger",
        ),
        (
            {"leg": True, "length_limits": (0, 1)},
            "length_limits: must be two lengths above 0, the second larger",
        ),
        ({"leg": True, "length_limits": 3}, "length_limits: must be 2 numbers, got 3"),
        ({"leg": True, "tension_limits": (0, 1)}, "tension_limits: a leg has none"),
        ({"leg": True, "pulley": Pulley("0.1")}, "pulley: a leg has none"),
    ],
)
def test_what_python_may_not_say(given, message):
    with pytest.raises(InputError) as caught:
        Cable("c1", (0, 0, 0), (0, 0, 1), **given)
    assert caught.value.messages == (message,)


def test_legs_beside_cables_in_python():
    robot = load_robot("gough_40")
    with pytest.raises(InputError, match="either every cable is a leg or none is"):
        robot.replace(cables=(replace(robot.cables[0], leg=False), *robot.cables[1:]))


def test_a_robot_changed_for_a_batch_keeps_its_legs_and_pulleys():
    text = FILE.replace("[0, 1, 0]", "[0, 1.5, 0]")
    found = perturbed(
        parse_robot(text), {"mass_kg": "81", "frame_anchors_m": [["0", "0", "1"], ["1", "0", "2"]]}
    )
    assert found.has_legs and found.cables[1].length_limits == (F(11, 10), F(2))
    assert found.platform.mass == 81 and found.cables[1].frame_anchor == (1, 0, 2)
    robot = load_robot("paty_cdpr4")
    heavier = perturbed(robot, {"mass_kg": "81"})
    assert heavier.has_pulleys and heavier.cables == robot.cables
