"""Angles that need a unit, lengths that may have one, and lists with commas or spaces."""

import math
import re
from fractions import Fraction as F

import numpy as np
import pytest

from cdpr_interval import InputError, load_robot
from cdpr_interval.mechanics.orientation import rotation_from_rpy
from solvers import inverse_kinematics
from solvers.questions.force import read_force
from solvers.questions.pose import read_pose
from solvers.questions.units import entries_of, read_metres, read_radians, read_seconds


@pytest.mark.parametrize(
    ("text", "angle"),
    [
        ("0", 0.0),
        ("-0", 0.0),
        ("0.000", 0.0),
        ("0e3", 0.0),
        ("5deg", math.radians(5)),
        ("-40.6631deg", math.radians(-40.6631)),
        ("5°", math.radians(5)),
        ("5 deg", math.radians(5)),
        ("1e1deg", math.radians(10)),
        ("0.1rad", 0.1),
        (".5 rad", 0.5),
        ("5.deg", math.radians(5)),
    ],
)
def test_angles(text, angle):
    assert read_radians(text) == angle


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("5", "'5' has no unit: write 5deg or 5rad"),
        ("-1e-30", "'-1e-30' has no unit: write -1e-30deg or -1e-30rad"),
        ("0.10000000000000000000001", "write 0.1deg or 0.1rad"),
        ("5m", "'5m' is a length, not an angle"),
        ("5degrees", "'5degrees' is not a number (units are deg, °, rad)"),
        ("deg", "'deg' is not a number"),
        ("", "'' is not a number"),
        ("5 5deg", "'5 5' is not a number"),
        ("nandeg", "'nandeg' is not a number"),
    ],
)
def test_angles_that_could_be_misread(text, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        read_radians(text)


def test_lengths_are_exact_in_every_unit():
    for text in ("7.5", "7.5m", "750cm", "7500mm", "7500 mm", "7.5e3mm"):
        assert read_metres(text) == F("7.5")
    assert read_metres("0.1mm") == F(1, 10000)
    assert read_metres("0x1f") == 31
    for text, message in (
        ("7.5deg", "is an angle"),
        ("7.5in", r"\(units are m, cm, mm\)"),
        ("7.5um", "is not a number"),
        ("mm", "is not a number"),
        ("1e-100mm", "out of range"),
    ):
        with pytest.raises(ValueError, match=message):
            read_metres(text)


@pytest.mark.parametrize(
    ("text", "entries"),
    [
        ("1,2,3", ["1", "2", "3"]),
        ("1 2  3", ["1", "2", "3"]),
        (" 1, 2 3 ", ["1", "2", "3"]),
        ("1,2 deg,3", ["1", "2deg", "3"]),
        ("1 2 deg 3 °", ["1", "2deg", "3°"]),
        ("1,,3", ["1", "", "3"]),
        ("1,deg", ["1", "deg"]),
        ("", [""]),
        ("[1,2,3]", ["1", "2", "3"]),
        (" (1 2 3) ", ["1", "2", "3"]),
        ("0, 0, -10 N", ["0", "0", "-10N"]),
        ("[1],[2]", ["[1]", "[2]"]),
    ],
)
def test_entries(text, entries):
    assert entries_of(text, "--pose") == entries


@pytest.mark.parametrize("text", ["0,5 0,0 0,0", "0,3 -0,2 1,5", "1,5deg 2 3"])
def test_decimal_commas_are_no_entries(text):
    with pytest.raises(InputError, match="--pose: decimals have a point"):
        entries_of(text, "--pose")


def test_forces_and_times_have_their_units():
    assert read_force("0,0,-10N") == read_force("[0 0 -10 N]") == read_force((0, 0, "-0.01kN")) == (0, 0, -10)
    assert [read_seconds(text) for text in ("10", "10s", "1.5min", "500 ms", "2h")] == [
        10,
        10,
        90,
        F(1, 2),
        7200,
    ]
    for text, message in (
        ("0,0,-10kg", r"\[2\]: '-10kg' is not a number \(units are N, kN\)"),
        ("0,0,10m", r"\[2\]: '10m' is a length, not a force"),
        ("1,2", "must hold 3 numbers, got 2"),
    ):
        with pytest.raises(InputError, match=f"--external-force.*{message}"):
            read_force(text, "--external-force")
    for text, message in (("10N", "is a force, not a time"), ("10sec", r"units are s, min, h, ms")):
        with pytest.raises(ValueError, match=message):
            read_seconds(text)
    with pytest.raises(ValueError, match="is a time, not an angle"):
        read_radians("10s")
    with pytest.raises(ValueError, match="is a force, not a length"):
        read_metres("10N")


def test_a_row_of_a_table_is_a_pose():
    row = "4.000000  0.730498  3.600291    39.5703deg     0.0000deg  180.0000deg"
    pose = read_pose(row)
    assert pose.position.tolist() == [4.0, 0.730498, 3.600291]
    assert (pose.rotation == rotation_from_rpy([math.radians(39.5703), 0.0, math.pi])).all()
    assert (read_pose("0.3 -0.2 1.5").position == [0.3, -0.2, 1.5]).all()
    with pytest.raises(InputError) as caught:
        read_pose(row.replace("deg", ""), label="--from")
    assert caught.value.messages == (
        "--from[3]: '39.5703' has no unit: write 39.5703deg or 39.5703rad",
        "--from[5]: '180.0000' has no unit: write 180.0000deg or 180.0000rad",
    )


def test_roll_pitch_yaw_from_python():
    robot = load_robot("uc3")
    by_matrix = inverse_kinematics(robot, (5, 3, -7), rotation_from_rpy([0.1, -0.2, math.radians(30)]))
    by_angles = inverse_kinematics(robot, (5, 3, -7), rpy=(0.1, np.float64(-0.2), "30deg"))
    assert by_angles.rotation == by_matrix.rotation
    for rpy, message in (
        (("0.1", 0, 0), r"rpy\[0\]: '0.1' has no unit"),
        ((1, 2), "rpy: must hold roll, pitch and yaw"),
        (7, "rpy: must hold roll, pitch and yaw"),
        ("1deg", "rpy: must hold roll, pitch and yaw"),
        ((math.nan, 0, 0), r"rpy\[0\]: nan is not a finite number"),
        ((0, None, 0), r"rpy\[1\]: None is not a number"),
    ):
        with pytest.raises(InputError, match=message):
            inverse_kinematics(robot, (5, 3, -7), rpy=rpy)
    with pytest.raises(InputError, match="rpy: not together"):
        inverse_kinematics(robot, (5, 3, -7), rpy=(0, 0, 0), quaternion=(1, 0, 0, 0))
