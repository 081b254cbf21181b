"""The floor of a valley: the identities behind it, and neighbourhoods that hold one pose or two."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb

from cdpr_interval import load_robot
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.energy import quadratic_form, to_matrix
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.mechanics.six_dof.frame import Pose, cayley
from cdpr_interval.robots.formats.reader import parse_robot
from solvers import forward_kinematics
from solvers.forward import pose_problem
from solvers.questions.problem import Options
from solvers.six_dof.open_entries import neighbourhood, tight_cables
from solvers.six_dof.solution import geometry
from solvers.six_dof.valley import Neighbourhood, floor_of

HEAD = "format: cdpr-robot/1\nname: test\nplatform: {mass_kg: 1}\ncables:\n"


def robot(*cables):
    rows = [
        f"  - {{name: c{k + 1}, frame_anchor_m: {a}, platform_anchor_m: {b}}}\n"
        for k, (a, b) in enumerate(cables)
    ]
    return parse_robot((HEAD + "".join(rows)).encode())


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


@pytest.mark.parametrize("seed", range(20))
def test_the_identities_hold_for_any_two_poses(seed):
    rng = np.random.default_rng(seed)
    first, second = (rotation_from_quaternion(rng.normal(size=4)) for _ in range(2))
    p, q, a, b = rng.normal(size=(4, 3))
    relative = second @ first.T
    omega = 2 * np.array([relative[2, 1] - relative[1, 2], relative[0, 2] - relative[2, 0],
                          relative[1, 0] - relative[0, 1]]) / (1 + np.trace(relative))  # fmt: skip
    r1, r2 = first @ b, second @ b
    e1, e2 = a - p - r1, a - q - r2
    mean = (r1 + r2) / 2
    delta = np.concatenate([q - p, omega])
    way = q - p + np.cross(omega, mean)
    gain = (e1 + e2) @ way / 2
    assert e2 @ e2 - e1 @ e1 == pytest.approx(-2 * gain, abs=1e-9)
    turned = np.cross(omega, np.cross(omega, mean))
    for e, r, sign in ((e1, r1, 1.0), (e2, r2, -1.0)):
        form = way @ way - e @ turned
        work = e @ (q - p) + np.cross(r, e) @ omega
        assert work == pytest.approx(gain + sign * form / 2, abs=1e-8 * (1 + omega @ omega))
        with balls.precision():
            matrix = quadratic_form([to_matrix(e[:, None])], [to_matrix(mean[:, None])], [arb(1)])
        assert delta @ balls.middle(matrix) @ delta == pytest.approx(form, abs=1e-8 * (1 + omega @ omega))


def test_inside_and_apart_never_contradict_a_pose():
    rng = np.random.default_rng(5)
    problem = pose_problem(load_robot("uc3"), ["7.5", "8", "7"], None, None, Options())
    with balls.precision():
        up = balls.vector([0, 0, 1])
        for k in range(300):
            base = to_matrix(rng.normal(size=(3, 1)))
            start = cayley([arb(float(x)) for x in rng.normal(size=3)])
            axis = None if k % 2 else up
            where = Neighbourhood(problem, Pose(start, base, ()), 1e-3, 1.0, axis)
            u = rng.uniform(-1, 1, 3) * 1e-3 * rng.choice([0.5, 0.99, 1.01, 5.0])
            if axis is not None:
                u[2] = 0.0
            moved = rng.uniform(-1, 1, 3) * 1e-3 * rng.choice([0.5, 0.99, 1.01, 5.0])
            rotation = cayley([arb(float(x)) for x in u]) * start
            centre = base + to_matrix(moved[:, None])
            if axis is not None:
                turn = balls.turn(up, arb(float(rng.uniform(-3, 3))))
                point = where.point_of(rotation, centre)
                rotation, centre = turn * rotation, point + turn * (centre - point)
            inside = bool(np.all(np.abs(u) <= 1e-3) and np.all(np.abs(moved) <= 1e-3))
            assert where.holds(rotation, centre) == inside
            assert not (where.is_apart(rotation, centre) and inside)
            if axis is None:
                assert where.is_apart(rotation, centre) or inside or np.all(np.abs(moved) <= 1e-3)


def floor_at(robot, lengths, entry, reach):
    problem = pose_problem(robot, lengths, None, None, Options())
    with balls.precision():
        where = neighbourhood(problem, entry, reach)
        return floor_of(where, tight_cables(problem, where.everywhere()))


BOX = robot(
    *(([0.3 * x, 0.3 * y, 2], [0.3 * x, 0.3 * y, 0.2]) for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1)))
)


def test_a_box_on_four_equal_cables_is_a_valley():
    (entry,) = forward_kinematics(BOX, ["0.5"] * 4, taut=["c1", "c3"]).solutions
    for reach in (3e-4, 3e-5):
        floor = floor_at(BOX, ["0.5"] * 4, entry, reach)
        assert floor.unique and floor.exists


@pytest.mark.parametrize(
    "name, lengths", [("uc2", ["7.5", "8"]), ("uc3", ["7.5", "8", "7"]), ("uc4", ["7.5", "8", "7", "7.5"])]
)
def test_only_stable_poses_are_valleys(name, lengths):
    solved = forward_kinematics(load_robot(name), lengths)
    for entry in solved.solutions:
        if entry.family is None:
            floor = floor_at(load_robot(name), lengths, entry, 1e-5)
            assert not floor.unique or entry.stability == "stable"
            if entry.stability == "stable":
                assert floor.unique


def test_two_poses_near_a_fold_are_not_one():
    """Two poses 2 mm apart: no neighbourhood that holds both may be said to hold one."""
    near = parse_robot(
        b"format: cdpr-robot/1\nname: near-fold\nplatform: {mass_kg: 1}\ncables:\n"
        b"  - {name: c1, frame_anchor_m: [8.69, 6.73, -0.9], platform_anchor_m: [-0.85, -0.28, -0.03]}\n"
        b"  - {name: c2, frame_anchor_m: [3.58, 1.32, 0.55], platform_anchor_m: [1.33, 0.83, 0.15]}\n"
    )
    lengths = ["8.47", "11.6719199729"]
    solved = forward_kinematics(near, lengths, taut=["c1", "c2"], cell_limit=200_000)
    places = np.array([s.nominal.position for s in solved.solutions])
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2) + 10 * np.eye(len(places))
    one = int(np.argmin(gaps.min(axis=1)))
    assert gaps[one].min() < 4e-3
    for reach in (4e-3, 1e-2, 3e-2):
        assert not floor_at(near, lengths, solved.solutions[one], reach).unique


def test_a_neighbourhood_without_balance_claims_nothing():
    problem = pose_problem(BOX, ["0.5"] * 4, None, None, Options())
    with balls.precision():
        pose = Pose(balls.identity(), to_matrix(np.array([[0.2], [0.0], [1.4]])), ())
        where = Neighbourhood(problem, pose, 1e-4, 1.0)
        tight = tight_cables(problem, geometry(problem, pose))
        floor = floor_of(where, tight)
    assert not floor.unique and not floor.exists
