"""Files of Deltas: what they say, and every error in them."""

from __future__ import annotations

import pytest

from cdpr_interval import InputError, NotSupportedError, load_robot
from cdpr_interval.files.document import parse_document
from cdpr_interval.robots.delta import DeltaRobot
from cdpr_interval.robots.formats.delta_reader import delta
from cdpr_interval.robots.formats.reader import load_delta
from cdpr_interval.robots.shipped import shipped_machines, shipped_robots
from cdpr_interval.text.writing import yaml_text

PLAIN = "format: delta-robot/1\nname: small\nbase_radius_m: 0.15\nplatform_radius_m: 0.025\nbar_m: 0.38\n"
ARMS = PLAIN + "arm_m: 0.2\n"


def read(text: str) -> DeltaRobot:
    return delta(parse_document(text, "d.yaml"))


def errors(text: str) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        read(text)
    return caught.value.messages


def test_every_shipped_delta_is_read_and_written_again():
    names = [name for name in shipped_machines() if name not in shipped_robots()]
    assert len(names) == 27
    for name in names:
        robot = load_delta(name)
        again = read(yaml_text(robot.to_dict()))
        assert again == robot and robot.sha256 != again.sha256
        with pytest.raises(NotSupportedError, match="is a Delta, which has no cables"):
            load_robot(name)


def test_all_keys():
    text = ARMS + (
        "bar_spacing_m: 0.05\narm_angles_rad: [0, 120deg, -2.1]\ntool_offset_m: [0, 0, -0.05]\n"
        "gamma_max_rad: 40deg\nelbow_min_rad: 0.5\nelbow_max_rad: 170 deg\nsource: here\nnotes: there\n"
    )
    robot = read(text)
    assert list(map(str, robot.arm_angles)) == ["0rad", "120deg", "-2.1rad"]
    assert {name: str(angle) for name, angle in robot.limits.items()} == {
        "gamma_max": "40deg",
        "elbow_min": "0.5rad",
        "elbow_max": "170deg",
    }
    linear = PLAIN + "drives: linear\nrail_directions: [[0, 0, -1], [0, 1, -1], [0, [-1, -0.9], -1]]\n"
    assert read(linear).is_linear and read(linear).uncertain == ("rail_directions[2][1]",)


@pytest.mark.parametrize(
    ("text", "place", "rule"),
    [
        (PLAIN, "1:1: arm", "missing: rotary drives turn arms"),
        (
            ARMS + "gamma_max_rad: -40deg\n",
            "7:16: gamma_max",
            "must be an angle from 0 to a whole turn, got -40deg",
        ),
        (
            ARMS + "gamma_max_rad: 40\n",
            "7:16: gamma_max",
            "must be an angle from 0 to a whole turn, got 40rad",
        ),
        (
            ARMS + "elbow_min_rad: 90deg\nelbow_max_rad: 1\n",
            "7:16: elbow_min",
            "must not be above elbow_max, got 90deg and 1rad",
        ),
        (ARMS.replace("0.38", "0"), "5:8: bar_m", "must be greater than 0, got 0"),
        (ARMS.replace("0.15", "-1"), "3:16: base_radius_m", "must be at least 0, got -1"),
        (PLAIN + "drives: linear\n", "1:1: rail_directions", "missing: linear drives need three"),
        (ARMS + "drives: hydraulic\n", "7:9: drives", "must be one of rotary, linear"),
        (ARMS + "arm_angles_rad: [0, 1]\n", "7:17: arm_angles_rad", "must be a list of 3 angles"),
        (ARMS + "gamma_max_rad: wide\n", "7:16: gamma_max_rad", "must be a number in rad, or a text such"),
        (ARMS + "gamma_max_deg: 40\n", "7:1: gamma_max_deg", "write 'gamma_max_rad'"),
    ],
)
def test_errors_say_where_and_what(text: str, place: str, rule: str):
    (line,) = errors(text)
    assert line.startswith(f"d.yaml:{place}") and rule in line


def test_from_python_the_same_rules_hold():
    with pytest.raises(InputError, match="bar: must be greater than 0"):
        DeltaRobot("x", 1, 0, 0, 1)
    with pytest.raises(InputError, match="arm: missing"):
        DeltaRobot("x", 1, 0, 1)
    with pytest.raises(InputError, match=r"rail_directions\[1\]: must not be the zero vector"):
        DeltaRobot("x", 1, 0, 1, drives="linear", rail_directions=[(0, 0, 1), (0, 0, 0), (0, 0, 1)])
