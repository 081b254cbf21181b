"""Robots made, changed and written in memory: exact, and never with the digest of a file they are not."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import json
import pickle
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdpr_interval import CdprError, InputError, Robot, load_robot
from cdpr_interval.exact.decimals import decimal_text, rounded_down
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.robots.shipped import shipped_robots
from solvers import forward_kinematics

LAMP = {
    "format": "cdpr-robot/1",
    "name": "lamp",
    "platform": {"mass_kg": "2.5"},
    "cables": [
        {"name": "c1", "frame_anchor_m": [0, 0, 3], "platform_anchor_m": [0, 0, 0]},
        {"name": "c2", "frame_anchor_m": (4, "1e-1", 3), "platform_anchor_m": np.zeros(3)},
    ],
}
TWICE = "is the name of cables[0] already"
CABLE = Cable("c", (0, 0, 1), (0, 0, 0))


def lamp(**platform: object) -> dict:
    return {**LAMP, "platform": platform}


@pytest.mark.parametrize("name", shipped_robots())
def test_every_shipped_robot_survives_dictionaries_and_yaml(name: str):
    robot = load_robot(name)
    again, written = Robot.from_dict(robot.to_dict()), robot.replace().to_yaml()
    assert again == robot == parse_robot(written)
    assert again.sha256 == parse_robot(written).sha256 == hashlib.sha256(written.encode()).hexdigest()
    as_json = json.dumps(robot.to_dict(), default=str)
    assert Robot.from_dict(json.loads(as_json, parse_float=Decimal)) == robot


def test_an_unchanged_robot_is_its_file_with_comments(tmp_path: Path):
    text = "# mine\r\n" + load_robot("uc2").replace().to_yaml() + "x_own: [1, 2]  # kept\n"
    path, copied = tmp_path / "r.yaml", tmp_path / "copy.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    robot = load_robot(path)
    robot.save(copied)
    assert copied.read_bytes() == path.read_bytes() == robot.to_yaml().encode()
    assert load_robot(copied).sha256 == robot.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    "change",
    [
        lambda robot: robot.replace(platform=robot.platform.replace(mass=7)),
        lambda robot: dataclasses.replace(robot, platform=Platform(7)),
        lambda robot: robot.replace(name="other"),
        lambda robot: robot.replace(gravity=(0, 0, -1)),
        lambda robot: robot.replace(cables=robot.cables[:2]),
        lambda robot: robot.replace(source=None, notes="changed"),
        lambda robot: robot.replace(winches=dataclasses.replace(robot.winches, armed=True)),
    ],
)
def test_a_changed_robot_has_the_digest_of_what_it_is(change, tmp_path: Path):
    robot = load_robot("uc4")
    before = robot.sha256
    changed = change(robot)
    assert changed.sha256 != before and changed.file is None and "file" not in repr(changed)
    changed.save(tmp_path / "r.yaml")
    again = load_robot(tmp_path / "r.yaml")
    assert again == changed and again.sha256 == changed.sha256
    assert robot.sha256 == before


def test_copies_keep_the_digest_and_changed_copies_do_not():
    robot = load_robot("uc2")
    for same in (copy.copy(robot), copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):
        assert same == robot and same.sha256 == robot.sha256 and same.to_yaml() == robot.to_yaml()
        assert dataclasses.replace(same, name="b").sha256 != robot.sha256
    with pytest.raises(TypeError):
        Robot(robot.name, robot.platform, robot.cables, sha256=robot.sha256)
    with pytest.raises(ValueError):
        dataclasses.replace(robot, file=b"")


def test_a_result_is_about_the_robot_that_was_solved():
    robot = load_robot("merlet_4_1")
    heavier = robot.replace(platform=robot.platform.replace(mass="80.5"))
    result = forward_kinematics(heavier, ["2.69", "3.9", "3.35", "4.38"])
    assert result.robot.sha256 == parse_robot(heavier.to_yaml()).sha256 != robot.sha256
    assert result.verify(heavier) == [] and result.verify(robot) != []


@pytest.mark.parametrize(
    ("mass", "value"),
    [
        (2, 2), ("0.1", Fraction(1, 10)), (" 1e-1 ", Fraction(1, 10)), (Decimal("0.1"), Fraction(1, 10)),
        (Fraction(1, 3), Fraction(1, 3)), (0.1, Fraction(0.1)), (np.float64(0.1), Fraction(0.1)),
        (np.int64(3), 3),
        ([1, "1.5"], Range(Fraction(1), Fraction(3, 2))), ((1.0, 1), 1),
        ({"value": 2, "tolerance": "0.1"}, Range(Fraction(19, 10), Fraction(21, 10))),
    ],
)  # fmt: skip
def test_numbers_of_a_dictionary_are_exact(mass: object, value: object):
    assert Robot.from_dict(lamp(mass_kg=mass)).platform.mass == value
    if not isinstance(mass, dict):
        assert Platform(mass).mass == value


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ([], "robot: must be a mapping, got 'list'"),
        ({}, "robot: format: missing: write 'format: cdpr-robot/1'"),
        (
            {**LAMP, "format": "x/2"},
            "robot: format: must be 'cdpr-robot/1' or 'delta-robot/1', got the text 'x/2'",
        ),
        ({**LAMP, 3: 4}, "robot: a key must be a text, got '3'"),
        ({**LAMP, "cables": LAMP["cables"][:1] * 2}, f"robot: cables[1].name: 'c1' {TWICE}"),
        (lamp(mass_kg=-1), "robot: platform.mass_kg: must be greater than 0, got -1"),
        (lamp(mass_kg=float("nan")), "robot: platform.mass_kg: nan is not a finite number"),
        (lamp(mass_kg="heavy"), "robot: platform.mass_kg: 'heavy' is not a number"),
        (lamp(mass_kg=None), "robot: platform.mass_kg: must be a number, got nothing"),
        (lamp(mass_kg=object), f"robot: platform.mass_kg: {object!r} is not a number"),
        (lamp(mass_kg=1e101), "robot: platform.mass_kg: 1e+101 is out of range"),
        (lamp(mass_g=1), "robot: platform.mass_g: unknown key: write 'mass_kg', and divide by 1000"),
    ],
)  # fmt: skip
def test_a_wrong_dictionary_has_the_errors_of_a_file(data: object, message: str):
    with pytest.raises(InputError) as caught:
        Robot.from_dict(data)
    assert message in caught.value.messages


def test_a_dictionary_that_holds_itself_is_refused():
    data = {**LAMP}
    data["x_loop"] = data
    with pytest.raises(InputError, match="nested deeper"):
        Robot.from_dict(data)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Platform(None), "mass: None is not a number"),
        (lambda: Platform(-1), "mass: must not be negative, got -1"),
        (lambda: Platform(1, (1, 2)), r"centre_of_mass: must be 3 numbers, got \(1, 2\)"),
        (lambda: Platform(1, "123"), "centre_of_mass: must be 3 numbers, got '123'"),
        (lambda: Platform((2, 1)), "mass: the lower bound 2 is above the upper bound 1"),
        (lambda: Cable("c", (0, 0, "x"), (0, 0, 0)), r"frame_anchor\[2\]: 'x' is not a number"),
        (lambda: CABLE.replace(tension_limits=(1,)), "tension_limits: must be 2 numbers"),
        (lambda: Elasticity("soft"), "stiffness: 'soft' is not a number"),
        (lambda: Robot("r", Platform(1), ()), "cables: must be one Cable or more"),
        (lambda: Robot("r", 5.0, (CABLE,)), "platform: must be a Platform, got 5.0"),
        (lambda: Robot("r", Platform(1), (CABLE, CABLE)), "cables: names must differ, got c, c"),
        (lambda: load_robot("uc2").replace(masse=1), "replace: Robot has no masse, only name, platform, "),
    ],
)  # fmt: skip
def test_misuse_is_an_error_with_words(make, message: str):
    with pytest.raises(CdprError, match=message):
        make()


def test_a_number_that_is_no_decimal_has_a_digest_and_no_file(tmp_path: Path):
    robot = Robot.from_dict(lamp(mass_kg=Fraction(1, 3)))
    assert Robot.from_dict(robot.to_dict()) == robot
    assert len(robot.sha256) == 64 != Robot.from_dict(lamp(mass_kg=Fraction(2, 3))).sha256
    for write in (robot.to_yaml, lambda: robot.save(tmp_path / "r.yaml")):
        with pytest.raises(InputError, match="robot 'lamp': 1/3 cannot be written"):
            write()
    assert not (tmp_path / "r.yaml").exists()


def test_a_file_that_cannot_be_written_says_so(tmp_path: Path):
    with pytest.raises(InputError, match="cannot be written: Is a directory"):
        load_robot("uc2").save(tmp_path)


TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1, max_size=20)
NUMBERS = st.one_of(
    st.integers(-(10**20), 10**20),
    st.floats(-1e30, 1e30).filter(lambda x: x == 0 or abs(x) > 1e-60),
    st.decimals(-1000, 1000, places=30),
)


@given(TEXTS, st.lists(NUMBERS, min_size=3, max_size=3), st.one_of(st.none(), TEXTS))
def test_whatever_is_written_is_read_again(name: str, anchor: list, notes: str | None):
    cables = [{"name": "no", "frame_anchor_m": anchor, "platform_anchor_m": [0, 0, 0]}]
    data = {**LAMP, "cables": cables, "source": name, **({} if notes is None else {"notes": notes})}
    try:
        robot = Robot.from_dict(data)
    except InputError:
        assert not name.strip()
        return
    again = parse_robot(robot.to_yaml())
    assert again == robot and again.sha256 == robot.sha256


@given(st.fractions(min_value="1e-9", max_value="1e9"))
def test_rounding_down_keeps_three_digits(value: Fraction):
    below = Fraction(rounded_down(value))
    assert below <= value < below * Fraction(101, 100)


@pytest.mark.parametrize(
    ("value", "text"), [("1/8", "0.125"), ("-3/2", "-1.5"), ("7", "7"), ("-1/50", "-0.02")]
)
def test_decimals(value: str, text: str):
    assert decimal_text(Fraction(value)) == text
