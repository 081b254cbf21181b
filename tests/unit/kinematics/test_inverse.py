"""Inverse kinematics: distances, tensions, lengths, and settling to a static pose."""

import json
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from cdpr_interval import InputError, NotSupportedError, load_robot
from cdpr_interval.exact.range import Range
from cdpr_interval.kernels.nonnegative import nonnegative_least_squares, smallest_nonnegative_solution
from cdpr_interval.mechanics.orientation import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_rpy,
    rotation_from_vector,
    rpy_from_rotation,
    vector_from_rotation,
)
from cdpr_interval.mechanics.statics import Pose, static_model
from cdpr_interval.robots.cable_robot import Elasticity
from solvers import IkResult, inverse_kinematics
from solvers.questions.pose import read_pose

UC3_LOWEST = (
    (4.980166136652, 3.159526873789, -7.16948323259),
    (0.985728121774, -0.031537885465, -0.160306325946, 0.040587111076),
)
ZERO = (F(0), F(0), F(0))


def random_poses(count):
    rng = np.random.default_rng(7)
    for _ in range(count):
        quaternion = rng.normal(size=4)
        yield rng.normal(size=3), rotation_from_quaternion(quaternion)


def test_orientations_convert_into_each_other():
    for _, rotation in random_poses(50):
        assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-14) and np.linalg.det(rotation) > 0.0
        assert np.allclose(rotation_from_quaternion(quaternion_from_rotation(rotation)), rotation, atol=1e-14)
        assert np.allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation, atol=1e-14)
        assert np.allclose(rotation_from_vector(vector_from_rotation(rotation)), rotation, atol=1e-14)


@pytest.mark.parametrize(
    "quarters", [(1, 0, 0), (0, 1, 0), (0, -1, 0), (2, 0, 0), (0, 2, 1), (1, 1, 1), (0, 0, 2)]
)
def test_orientations_at_multiples_of_a_quarter_turn(quarters):
    rotation = rotation_from_rpy([np.pi / 2 * q for q in quarters])
    assert np.allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation, atol=1e-12)
    assert np.allclose(rotation_from_quaternion(quaternion_from_rotation(rotation)), rotation, atol=1e-12)


def test_the_convention_of_roll_pitch_yaw():
    assert np.allclose(rotation_from_rpy([0, 0, np.pi / 2]) @ [1, 0, 0], [0, 1, 0])
    assert np.allclose(rotation_from_rpy([np.pi / 2, 0, np.pi / 2]) @ [0, 1, 0], [0, 0, 1])


def test_poses_are_read_from_text():
    pose = read_pose("1, -2,3e-1,0,0,90deg")
    assert pose.position.tolist() == [1.0, -2.0, 0.3] and np.allclose(pose.rotation @ [1, 0, 0], [0, 1, 0])
    assert np.allclose(read_pose("0,0,0", "2,0,0,2").rotation, pose.rotation)
    assert (read_pose("0,0,0").rotation == np.eye(3)).all()


@pytest.mark.parametrize(
    ("pose", "quaternion", "message"),
    [
        ("1,2", None, "--pose: must hold x,y,z or x,y,z,roll,pitch,yaw, got 2 entries"),
        ("1,2,x", None, "--pose[2]: 'x' is not a number"),
        ("1,2,nan", None, "--pose[2]: 'nan' is not a finite number"),
        ("1,2deg,3", None, "--pose[1]: '2deg' is an angle, not a length"),
        ("1,2,3,a,0,0", None, "--pose[3]: 'a' is not a number"),
        ("1,2,3,0,0,0", "1,0,0,0", "--quaternion: not together with roll, pitch and yaw in --pose"),
        ("1,2,3", "1,0,0", "--quaternion: must hold w,x,y,z, got 3 entries"),
        ("1,2,3", "0,0,0,0", "--quaternion: must not be zero"),
        ("1,2,3", "1,0,0,9deg", "--quaternion[3]: '9deg' is not a number"),
    ],
)
def test_wrong_poses(pose, quaternion, message):
    with pytest.raises(InputError) as caught:
        read_pose(pose, quaternion)
    assert caught.value.messages == (message,)


def test_nonnegative_fits_satisfy_their_optimality_conditions():
    rng = np.random.default_rng(3)
    for trial in range(200):
        rows, columns = int(rng.integers(1, 7)), int(rng.integers(1, 9))
        matrix, target = rng.normal(size=(rows, columns)), rng.normal(size=rows)
        x = nonnegative_least_squares(matrix, target)
        gradient = matrix.T @ (target - matrix @ x)
        assert (x >= 0.0).all() and (gradient <= 1e-9).all() and abs(gradient @ x) < 1e-9, trial


def test_the_smallest_solution_is_the_smallest():
    rng = np.random.default_rng(4)
    for trial in range(200):
        rows, columns = int(rng.integers(1, 7)), int(rng.integers(2, 9))
        matrix = rng.normal(size=(rows, columns))
        planted = np.maximum(rng.normal(size=columns), 0.0)
        x = smallest_nonnegative_solution(matrix, matrix @ planted)
        assert (x >= 0.0).all() and np.allclose(matrix @ x, matrix @ planted, atol=1e-9), trial
        # Optimal: x . (y - x) >= 0 for every feasible y, so for the planted one.
        assert x @ (planted - x) >= -1e-8, trial


def test_the_smallest_solution_of_an_infeasible_system_is_the_best_fit():
    matrix = np.array([[1.0, 2.0], [0.0, 0.0]])
    assert np.allclose(smallest_nonnegative_solution(matrix, np.array([-1.0, 1.0])), 0.0)


@pytest.mark.parametrize("name", ["uc3", "cogiro", "merlet_4_1"])
def test_the_wrench_derivative_is_that_of_finite_differences(name):
    robot = load_robot(name)
    model = static_model(robot, ZERO)
    for position, rotation in random_poses(5):
        pose = Pose(position - [0, 0, 20], np.eye(3) if robot.is_point_mass else rotation)
        tensions = np.linspace(1.0, 2.0, len(robot.cables))
        derivative = model.wrench_derivative(pose, tensions)
        size = derivative.shape[0]
        for column in range(size):
            step = np.eye(size)[column] * 1e-6
            ahead, behind = (model.wrenches(model.moved(pose, s)) @ tensions for s in (step, -step))
            assert np.allclose((ahead - behind) / 2e-6, derivative[:, column], atol=1e-6)
            assert np.allclose(model.displacement(pose, model.moved(pose, step)), step, atol=1e-14)


def test_a_static_pose_of_three_cables():
    result = inverse_kinematics(load_robot("uc3"), UC3_LOWEST[0], quaternion=UC3_LOWEST[1])
    assert np.allclose(result.distances, [7.5, 8.0, 7.0], atol=1e-9) and result.lengths == result.distances
    assert np.allclose(result.tensions, [0.292608, 0.514194, 0.415789], atol=1e-5) and result.is_static
    assert result.message == "the pose is static"


def test_a_pose_that_is_not_static():
    result = inverse_kinematics(load_robot("uc3"), (5, 3, -6))
    assert not result.is_static and result.lengths == result.distances
    assert min(result.tensions) >= 0.0 and np.linalg.norm(result.residual_force) > 1e-3
    assert result.message.startswith("the pose is not static: ")


def test_redundant_tensions_are_the_smallest():
    robot = load_robot("merlet_4_1")
    result = inverse_kinematics(robot, (2, 2, -2))
    weight = 80 * 9.81
    assert np.allclose(result.tensions, weight / 4 * np.sqrt(3.0), rtol=1e-12)


def test_slack_margin_lengthens_the_others_only():
    result = inverse_kinematics(load_robot("merlet_4_1"), (1, 1.5, -2), taut="c1,c3,c2", slack_margin=0.1)
    ratios = np.array(result.lengths) / result.distances
    assert np.allclose(ratios, [1, 1, 1, 1.1]) and result.tensions[3] == 0.0
    assert result.question.taut == ("c1", "c2", "c3")


@pytest.mark.parametrize(
    ("elasticity", "length"),
    [
        (Elasticity(stiffness=F(10_000)), lambda rho, tau: rho - tau / 10_000),
        (Elasticity(axial_stiffness=F(10_000)), lambda rho, tau: rho / (1 + tau / 10_000)),
    ],
)
def test_unstretched_lengths(elasticity, length):
    inextensible = load_robot("merlet_4_1")
    robot = replace(
        inextensible, cables=tuple(replace(c, elasticity=elasticity) for c in inextensible.cables)
    )
    result = inverse_kinematics(robot, (1, 1.5, -2))
    expected = [length(rho, tau) for rho, tau in zip(result.distances, result.tensions, strict=True)]
    assert result.lengths == pytest.approx(expected, rel=1e-14)
    assert inverse_kinematics(robot, (1, 1.5, 2)).lengths is None


def test_a_cable_too_soft_for_the_pose_has_no_length():
    base = load_robot("merlet_4_1")
    soft = Elasticity(stiffness=F(1))
    result = inverse_kinematics(
        replace(base, cables=tuple(replace(c, elasticity=soft) for c in base.cables)), (1, 1, -2)
    )
    assert result.lengths is None and "the stretch exceeds the distance: c1" in result.message


@pytest.mark.parametrize("name", ["uc2", "uc3", "uc4"])
def test_settling_restores_a_static_pose(name):
    robot = load_robot(name)
    rng = np.random.default_rng(5)
    static = inverse_kinematics(robot, (4.8, 3.1 * (name != "uc2"), -6.9), settle=True)
    assert static.settling is not None and static.settling.succeeded
    for _ in range(5):
        shift, turn = 1e-3 * rng.normal(size=3), rotation_from_vector(1e-3 * rng.normal(size=3))
        start = np.array(static.position) + shift
        moved = inverse_kinematics(robot, start, turn @ static.rotation, settle=True, wrench_tolerance=1e-10)
        assert moved.settling is not None and moved.settling.succeeded and moved.is_static
        # The nearest static pose is at most as far as the one the start was taken from.
        centre = (
            (np.eye(3) - turn) @ np.array(static.rotation) @ [float(x) for x in robot.platform.centre_of_mass]
        )
        size = static_model(robot, ZERO).radius
        given = np.hypot(np.linalg.norm(shift - centre), size * np.linalg.norm(vector_from_rotation(turn)))
        assert np.hypot(moved.settling.distance, size * moved.settling.angle) <= given * (1 + 1e-9)


def test_settling_under_one_cable_hangs_straight_down():
    result = inverse_kinematics(load_robot("merlet_4_1"), (0.1, 0.2, -2), taut=["c1"], settle=True)
    assert np.allclose(result.position, (0, 0, -2), atol=1e-9) and result.is_static
    assert result.settling is not None and result.settling.distance == pytest.approx(np.hypot(0.1, 0.2))


def test_settling_that_fails_says_so():
    # Above its exit points no cable can carry the mass.
    result = inverse_kinematics(load_robot("merlet_4_1"), (2, 2, 30), settle=True)
    assert result.settling is not None and not result.settling.succeeded
    assert "no static pose of these cables was found within 3.01 m" in result.message
    assert result.lengths is None and result.position == (2, 2, 30) and not result.settling.found


def test_settling_goes_no_further_than_asked():
    cables = {"taut": "c1,c3,c5,c7", "settle": True}
    robot = load_robot("cogiro")
    refused = inverse_kinematics(robot, (0, 0, 2), **cables)
    settling = refused.settling
    assert not settling.succeeded and settling.found and refused.lengths is None
    assert refused.position == (0, 0, 2) and refused.question.settle_within == pytest.approx(0.979, abs=1e-3)
    assert "nearest found is 1.2 m away, moved by 0.163 m and 95.6 deg" in refused.message
    # The limit is on the point that moves most: just below it refused, just above it done.
    for share, succeeded in ((1 - 1e-12, False), (1 + 1e-12, True)):
        within = settling.travel * share
        result = inverse_kinematics(robot, (0, 0, 2), **cables, settle_within=within)
        assert result.settling.succeeded is succeeded and (result.lengths is not None) is succeeded
    assert result.is_static and result.settling.travel == settling.travel
    assert inverse_kinematics(robot, result.position, result.rotation, **cables).settling.travel < 1e-6


def test_tension_limits_are_reported():
    base = load_robot("merlet_4_1")
    limited = replace(base, cables=(replace(base.cables[0], tension_limits=(F(0), F(100))), *base.cables[1:]))
    result = inverse_kinematics(limited, (1, 1.5, -2))
    assert result.outside_tension_limits == ("c1",) and result.tensions[0] > 100.0


def test_an_external_force_counts():
    robot = load_robot("merlet_4_1")
    with pytest.raises(InputError, match="cancel"):
        inverse_kinematics(robot, (2, 2, -2), external_force=[0, 0, "784.8"])
    doubled = inverse_kinematics(robot, (2, 2, -2), external_force=[0, 0, "-784.8"])
    assert np.allclose(doubled.tensions, 2 * np.array(inverse_kinematics(robot, (2, 2, -2)).tensions))


@pytest.mark.parametrize("options", [{}, {"settle": True, "taut": [0, 1], "settle_within": 9}])
def test_round_trip(options):
    result = inverse_kinematics(load_robot("uc3"), (5, 3, -6), rotation_from_rpy([0.1, 0.2, 0.3]), **options)
    assert IkResult.from_json(result.to_json()) == result
    document = json.loads(result.to_json())
    assert [float(x) for x in document["lengths_option"].split(",")] == list(result.lengths)
    again = read_pose(result.pose_option)
    assert again.position.tolist() == list(result.position)
    assert np.allclose(again.rotation, result.rotation, rtol=0, atol=1e-13)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "cdpr-ik-result/1"}', '{"format": "x"}'])
def test_not_an_ik_result(text):
    with pytest.raises(InputError):
        IkResult.from_json(text)


def test_wrong_arguments():
    robot = load_robot("uc3")
    for arguments, options, message in (
        ([(1, 2)], {}, "position: must be 3 finite numbers"),
        ([(1, 2, np.nan)], {}, "position: must be 3 finite numbers"),
        ([(1, 2, 3), 2 * np.eye(3)], {}, "rotation: must be an orthogonal 3 x 3 matrix"),
        ([(1, 2, 3), np.diag([1, 1, -1])], {}, "rotation: is a reflection"),
        ([(1, 2, 3)], {"quaternion": (0, 0, 0, 0)}, "quaternion: must be 4 finite numbers"),
        ([(1, 2, 3)], {"slack_margin": -0.1}, "slack_margin: must not be negative"),
        ([(1, 2, 3)], {"wrench_tolerance": 0.0}, "wrench_tolerance: must be a positive number"),
        ([(1, 2, 3)], {"settle_within": 1.0}, "settle_within: only with settle"),
        ([(1, 2, 3)], {"settle": True, "settle_within": 0.0}, "settle_within: must be a positive number"),
        ([(1, 2, 3)], {"taut": "c9"}, "taut[0]: unknown cable"),
        ([(1.5, 1, -1.2)], {}, "pose: the length of cable"),
    ):
        with pytest.raises(InputError) as caught:
            inverse_kinematics(robot, *arguments, **options)
        (found,) = caught.value.messages
        assert found.startswith(message)


def test_a_point_mass_has_no_orientation():
    with pytest.raises(InputError, match="no orientation"):
        inverse_kinematics(load_robot("merlet_4_1"), (1, 1, -1), quaternion=(1, 1, 0, 0))


def test_uncertain_robots_are_refused():
    robot = load_robot("uc3")
    robot = replace(robot, platform=replace(robot.platform, mass=Range(F(1), F(2))))
    with pytest.raises(NotSupportedError, match="not supported by ik yet"):
        inverse_kinematics(robot, (1, 2, -3))
