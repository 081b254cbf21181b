"""Every misuse from Python is a `CdprError` that names the argument."""

import math
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import CdprError, InputError, load_robot
from solvers import (
    IkResult,
    PointMass,
    Result,
    Tracker,
    forward_kinematics,
    inverse_kinematics,
    polynomial_report,
    pose_from_tensions,
)

LENGTHS = [3.1, 3.2, 3.3, 3.4]
POSE = (5, 3, -6)


def named(value):
    """Return what stands for a value in a test's name: no address, which every process has another."""
    return type(value).__name__ if type(value) is object else repr(value)


NO_ROBOTS = [None, 3, math.nan, [1], b"uc2", np.zeros((2, 2)), object(), {"name": "r"}]
NO_NUMBERS = ["x", [1], b"x", np.zeros((2, 2)), object(), math.nan, True, 1j]


@pytest.mark.parametrize("robot", NO_ROBOTS, ids=named)
@pytest.mark.parametrize(
    "ask",
    [
        load_robot,
        Tracker,
        PointMass,
        lambda robot: forward_kinematics(robot, LENGTHS),
        lambda robot: inverse_kinematics(robot, POSE),
        lambda robot: pose_from_tensions(robot, LENGTHS),
        lambda robot: polynomial_report(robot, LENGTHS),
    ],
)
def test_what_is_no_robot(ask, robot):
    with pytest.raises(InputError, match=r"^robot: must be "):
        ask(robot)


@pytest.mark.parametrize("robot", ["uc3", "no_such_robot", "uc2\0"])
def test_names_are_read_as_robots(robot):
    with pytest.raises(InputError, match=r"2 lengths for 3 cables|no such file|cannot be read"):
        forward_kinematics(robot, [7, 8])


@pytest.mark.parametrize("value", NO_NUMBERS, ids=named)
@pytest.mark.parametrize("name", ["time_limit", "precision", "cell_limit", "threads"])
def test_budgets_that_are_no_numbers(name, value):
    with pytest.raises(InputError, match=f"^{name}: must be "):
        forward_kinematics("merlet_4_1", LENGTHS, **{name: value})


NO_LIMITS = [*NO_NUMBERS, 5, [1, 2, 3], [2, 1], [1, 1], [-1, 1], [1, math.nan], ["a", 1], {1: 2}]


@pytest.mark.parametrize("value", NO_LIMITS, ids=named)
def test_limits_that_are_no_range(value):
    with pytest.raises(InputError, match=r"^tension: "):
        forward_kinematics("merlet_4_1", LENGTHS, tension=value)


@pytest.mark.parametrize("value", NO_NUMBERS, ids=named)
@pytest.mark.parametrize("name", ["slack_margin", "wrench_tolerance"])
def test_tolerances_that_are_no_numbers(name, value):
    with pytest.raises(InputError, match=f"^{name}: must "):
        inverse_kinematics("uc2", POSE, **{name: value})


@pytest.mark.parametrize("name", ["ignore_slack", "ignore_tension_sign"])
@pytest.mark.parametrize("value", [None, "no", math.nan, 1, np.zeros(2), np.True_], ids=named)
def test_flags_that_are_neither_true_nor_false(name, value):
    with pytest.raises(InputError, match=f"^{name}: must be True or False"):
        forward_kinematics("merlet_4_1", LENGTHS, **{name: value})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"precision": None}, "precision: must be a positive number, got None"),
        ({"threads": None}, "threads: must be a whole number, got None"),
        ({"threads": 1.5}, "threads: must be a whole number, got 1.5"),
        ({"progress": "bar"}, "progress: must be a function, got 'bar'"),
        ({"method": None}, "method: must be one of auto, search, convex, got None"),
        ({"method": ["auto"]}, "method: must be one of auto, search, convex, got ['auto']"),
        ({"taut": 3}, "taut: must hold names or indices of cables, got 3"),
        ({"taut": [0.5]}, "taut[0]: 0.5 is neither a cable name nor an index"),
        ({"taut": [7]}, "taut[0]: 7 is not an index from 0 to 3"),
        ({"external_force": 3}, "external_force: must hold 3 numbers, got 3"),
    ],
)
def test_other_arguments(options, message):
    with pytest.raises(InputError) as caught:
        forward_kinematics("merlet_4_1", LENGTHS, **options)
    assert caught.value.messages == (message,)


@pytest.mark.parametrize(
    "lengths",
    [None, 3, "x", b"x", {1, 2, 3, 4}, {1: 1, 2: 2}, np.zeros((4, 3)), [1, 2, 3, 1j], [1, 2, 3, -math.inf]],
    ids=named,
)
def test_lengths_that_are_none(lengths):
    """A set has no order: its entries would be given to any cables."""
    with pytest.raises(InputError, match=r"^lengths"):
        forward_kinematics("merlet_4_1", lengths)
    with pytest.raises(InputError, match=r"^lengths"):
        PointMass("merlet_4_1").solve(lengths)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (("x",), {}, "position: must be 3 finite numbers, got 'x'"),
        (((5, 3, math.nan),), {}, "position: must be 3 finite numbers"),
        ((object(),), {}, "position: must be 3 finite numbers, got object"),
        ((POSE, "x"), {}, "rotation: must be an orthogonal 3 x 3 matrix"),
        ((POSE, np.ones((3, 3))), {}, "rotation: must be an orthogonal 3 x 3 matrix"),
        ((POSE,), {"quaternion": 3}, "quaternion: must be 4 finite numbers, not all zero, got 3"),
        ((POSE,), {"quaternion": (0, 0, 0, 0)}, "quaternion: must be 4 finite numbers, not all zero"),
        ((POSE,), {"quaternion": "wxyz"}, "quaternion: must be 4 finite numbers, not all zero"),
        ((POSE,), {"settle": "no"}, "settle: must be True or False, got 'no'"),
    ],
)
def test_poses_that_are_none(arguments, options, message):
    with pytest.raises(InputError) as caught:
        inverse_kinematics("uc2", *arguments, **options)
    assert any(line.startswith(message) for line in caught.value.messages), caught.value


@pytest.mark.parametrize("document", [None, 3, [1], object(), "x", b"\xff", np.zeros(2), {}], ids=named)
def test_documents_that_are_none(document):
    for kind in (Result, IkResult):
        with pytest.raises(InputError, match="result"):
            kind.from_json(document)


@pytest.fixture(scope="module")
def result():
    return forward_kinematics("merlet_4_1", LENGTHS)


@pytest.mark.parametrize("path", [None, 3, "", "a\0b", [1], b"x"], ids=named)
def test_files_that_are_none(result, path):
    pytest.importorskip("plotly")
    for write in (result.report, result.certificate):
        with pytest.raises(InputError, match="path: must be the name of a file"):
            write(path)


def test_folders_are_no_files(result, tmp_path):
    pytest.importorskip("plotly")
    for write in (result.report, result.certificate):
        with pytest.raises(InputError, match="cannot be written: Is a directory"):
            write(tmp_path)
    with pytest.raises(InputError, match=r"certificate: .*: No such file"):
        result.report(tmp_path / "r.html", certificate=tmp_path / "none.cert")
    assert list(tmp_path.iterdir()) == []


def test_another_robot_is_refused(result, tmp_path):
    pytest.importorskip("plotly")
    for draw in (result.plot, lambda robot: result.report(tmp_path / "r.html", robot=robot)):
        with pytest.raises(InputError, match="robot: has cables c1, c2, the result c1, c2, c3, c4"):
            draw("uc2")
    heavier = load_robot("merlet_4_1")
    heavier = heavier.replace(platform=heavier.platform.replace(mass=Fraction(81)))
    with pytest.raises(InputError, match="robot: is not the robot of the result: its data differ"):
        result.plot(heavier)


def test_misuse_is_one_kind_of_error():
    assert issubclass(InputError, CdprError)
