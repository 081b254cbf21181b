"""Everyday degenerate platforms: symmetry, equal ropes, hooks, and ends of families."""

from __future__ import annotations

import numpy as np

from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.formats.reader import parse_robot
from solvers import forward_kinematics
from solvers.answers.data import CableState, Outcome

HEAD = "format: cdpr-robot/1\nname: test\nplatform: {mass_kg: 1}\ncables:\n"


def robot(*cables: tuple[list[float], list[float]]):  # type: ignore[no-untyped-def]
    """Return a six-dof robot from pairs (exit point, platform point from the centre of mass)."""
    rows = [
        f"  - {{name: c{k + 1}, frame_anchor_m: {a}, platform_anchor_m: {b}}}\n"
        for k, (a, b) in enumerate(cables)
    ]
    return parse_robot((HEAD + "".join(rows)).encode())


def test_symmetric_four_cables_at_the_centre_are_one_entry() -> None:
    """Tensions are not unique there: one pose, all four states open, nothing else undecided."""
    corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    result = forward_kinematics(
        robot(*([[2 * x, 2 * y, 3], [0.5 * x, 0.5 * y, 0.25]] for x, y in corners)), ["2.6"] * 4
    )
    assert result.outcome is Outcome.INCOMPLETE
    assert not result.undecided and not result.pending
    (pose,) = result.solutions
    assert pose.is_proved and pose.stability is Stability.STABLE
    assert pose.cable_states == (CableState.UNDECIDED,) * 4
    assert "tensions not unique" in pose.note
    # |(1.5, 1.5, h)| = 2.6 with h the drop from exit to platform points; these lie 0.25 over the centre.
    assert np.allclose(pose.position.mean(axis=1), [0, 0, 3 - 0.25 - np.sqrt(2.6**2 - 4.5)], atol=1e-9)


def test_a_swing_with_equal_ropes_hangs_straight_down() -> None:
    """Both sphere centres coincide at the pose, where the position is searched for directly."""
    result = forward_kinematics(
        robot(([0, 0, 3], [-1, 0, 0.5]), ([2, 0, 3], [1, 0, 0.5])), ["1.5", "1.5"], taut=["c1", "c2"]
    )
    assert result.outcome is Outcome.COMPLETE
    stable = [s for s in result.solutions if s.stability is Stability.STABLE]
    assert len(stable) == 1
    assert np.allclose(stable[0].position.mean(axis=1), [1, 0, 1], atol=1e-9)


def test_two_slings_on_one_hook_turn_freely() -> None:
    """Family (a): one entry a pose, a full turn about the vertical through the hook."""
    result = forward_kinematics(
        robot(([0, 0, 3], [-1, 0, 0.5]), ([0, 0, 3], [1, 0, 0.5])), ["1.5", "1.6"], taut=["c1", "c2"]
    )
    assert result.outcome is Outcome.COMPLETE
    assert {s.stability for s in result.solutions} == {Stability.STABLE, Stability.UNSTABLE}
    for pose in result.solutions:
        assert pose.family is not None and pose.family.kind == "rotation"
        (start, end) = pose.family.angle_ranges[0]
        assert start[0] <= -np.pi <= start[1] and end[0] <= np.pi <= end[1]


def test_the_end_of_a_family_is_no_solution_of_the_larger_subset() -> None:
    """One cable just becomes tight where the turning platform ends: zero tension, already covered."""
    end = robot(
        ([0, 0, 3], [-0.4, 0.1, 0.3]), ([1, 0.3, 2.9], [0.5, -0.2, 0.1]), ([0.1, 1, 3], [0.1, 0.5, -0.1])
    )
    whole = forward_kinematics(end, ["1.5", "1.95", "3"])
    assert whole.outcome is Outcome.COMPLETE
    families = [s for s in whole.solutions if s.family is not None]
    assert any(
        s.taut == (1,) and np.ptp(s.family.angle_ranges.mean(axis=2)) < 6.2 for s in families if s.family
    )
    for pose in whole.solutions:
        assert all(pose.tensions[i, 0] > 1e-6 for i in pose.taut)
    asked = forward_kinematics(end, ["1.5", "1.95", "3"], taut=["c1", "c2"])
    assert asked.outcome is Outcome.COMPLETE


CORNERS = [(1, -1), (1, 1), (-1, 1), (-1, -1)]


def test_a_box_on_four_equal_cables_hangs_in_one_pose() -> None:
    """Drones or winches over the corners of a box: all cables parallel, tensions not unique."""
    result = forward_kinematics(
        robot(*([[0.3 * x, 0.3 * y, 2], [0.3 * x, 0.3 * y, 0.23]] for x, y in CORNERS)), ["0.5"] * 4
    )
    assert not result.undecided and not result.pending
    (pose,) = result.solutions
    assert pose.is_proved and pose.stability is Stability.STABLE
    assert np.allclose(pose.position.mean(axis=1), [0, 0, 1.27], atol=1e-6)
    assert np.all(pose.tensions[:, 0] == 0.0) and np.allclose(pose.tensions[:, 1], 9.81 / 2, atol=1e-4)


def test_four_equal_slings_on_one_hook() -> None:
    """Level and upside down, each once; the first is proved to be one orbit whichever slings carry."""
    cables = [([0, 0, 10], [x, 0.6 * y, 0.3]) for x, y in CORNERS]
    result = forward_kinematics(robot(*cables), ["2"] * 4)
    assert not result.undecided and not result.pending
    loose = [s for s in result.solutions if not s.is_strict]
    assert [s.is_proved for s in loose] == [True, False]
    assert all(s.family is not None and s.family.kind == "rotation" for s in loose)
    assert loose[0].stability is Stability.STABLE
    assert np.allclose(loose[0].position.mean(axis=1), [0, 0, 10 - 0.3 - np.sqrt(4 - 1.36)], atol=1e-9)


def test_lengths_of_a_planar_pose_that_no_tensions_hold() -> None:
    """From ``ik`` at a level pose of a planar square: no pose, at most tiny regions around it."""
    planar = robot(
        ([3, 0, 0], [0.15, 0, -0.15]),
        ([3, 0, 3], [0.15, 0, 0.15]),
        ([0, 0, 3], [-0.15, 0, 0.15]),
        ([0, 0, 0], [-0.15, 0, -0.15]),
    )
    lengths = ["2.19658826364888", "2.0700241544484452", "1.6324827717314507", "1.7902513789968157"]
    result = forward_kinematics(planar, lengths, cell_limit=2_000_000)
    assert not result.solutions and not result.pending
    for region in result.undecided:
        assert np.all(np.abs(region.position - np.array([1.2, 0, 1.6])[:, None]) < 1e-4)
        assert "continuum" not in region.reason


def test_prestress_leaves_tensions_without_upper_bound() -> None:
    """Four cables of a planar robot, all just tight, that can pull against each other."""
    text = (
        "format: cdpr-robot/1\nname: t\ngravity_m_s2: [0, -9.81, 0]\nplatform: {mass_kg: 1.2}\ncables:\n"
        "  - {name: w1, frame_anchor_m: [-0.756, -0.4181, 0], platform_anchor_m: [-0.025, -0.01, 0]}\n"
        "  - {name: w2, frame_anchor_m: [-0.756, 0.4181, 0], platform_anchor_m: [-0.075, 0.01, 0]}\n"
        "  - {name: w3, frame_anchor_m: [0.756, 0.4181, 0], platform_anchor_m: [0.075, 0.01, 0]}\n"
        "  - {name: w4, frame_anchor_m: [0.756, -0.4181, 0], platform_anchor_m: [0.025, -0.01, 0]}\n"
    )
    lengths = ["0.9489028453956706", "0.859183688159872", "0.6824929376923985", "0.7797541984497423"]
    result = forward_kinematics(parse_robot(text.encode()), lengths)
    (pose,) = result.solutions
    assert np.all(np.isinf(pose.tensions[:, 1]))
    held = np.array([0.0, 18.0674547652, 14.1459, 5.41389])
    assert np.all(pose.tensions[:, 0] <= held + 1e-3) and np.all(pose.tensions[1:, 0] > 0.9 * held[1:])
    assert "prestress" in pose.note


def test_four_parallel_cables_that_cannot_all_carry_are_decided() -> None:
    """Nearly equal parallel cables under a slanted load: excluded, not a continuum."""
    exits = [(4.941497, 5.654625, -0.132864), (4.291257, 3.60028, 0.306571), (5.093158, 3.525753, -1.079626),
             (6.315023, 5.645676, -0.835948)]  # fmt: skip
    points = [(-0.058502551, 0.654625199, -0.132863822), (-0.708743378, -1.399720415, 0.306571356),
              (0.093157927, -1.474247484, -1.079626232), (1.31502346, 0.645675982, -0.835948282)]  # fmt: skip
    result = forward_kinematics(
        robot(*((list(a), list(b)) for a, b in zip(exits, points, strict=True))),
        ["8.0728"] * 4,
        taut=["c1", "c2", "c3", "c4"],
        external_force=["1.04", "0.941", "-5.596"],
        cell_limit=3_000_000,
    )
    assert result.outcome is Outcome.COMPLETE


def test_a_rod_on_a_vertical_is_listed_once() -> None:
    """Two axes: a pose and its half turn about the vertical are one family."""
    text = (
        "format: cdpr-robot/1\nname: rod\ngravity_m_s2: [0, -9.81, 0]\nplatform: {mass_kg: 1}\ncables:\n"
        "  - {name: c1, frame_anchor_m: [0.761, 2.116, 1.386], platform_anchor_m: [0.2, -0.4, 0.4]}\n"
        "  - {name: c2, frame_anchor_m: [0.761, 2.329, 1.386], platform_anchor_m: [-0.1, 0.2, -0.2]}\n"
    )
    result = forward_kinematics(parse_robot(text.encode()), ["2.1953", "2.7377"])
    assert result.outcome is Outcome.COMPLETE
    assert sum(s.family is not None and s.family.kind == "torus" for s in result.solutions) == 1


def test_a_family_whose_slack_angles_lie_behind() -> None:
    """Exits and platform points in one plane: the middle of the slack angles is exactly half a turn away."""
    turning = robot(([0, 0, 3], [0, 0, 1]), ([1, 0, 3], [-1, 0, 1]))
    result = forward_kinematics(turning, ["1", "1.5"])
    assert result.outcome is Outcome.COMPLETE and result.verify(turning) == []
    for pose in result.solutions:
        if pose.taut == (0,):
            assert pose.distances[1, 1] < 1.5
            (start, end), *_ = pose.family.angle_ranges  # type: ignore[union-attr]
            assert np.allclose(end.mean() - start.mean(), 2 * 1.186, atol=1e-2)


def test_slack_angles_that_only_touch_leave_open_poses() -> None:
    """One cable leaves the half turn in front, another the one behind: two angles are left, if any."""
    half = robot(([0, 0, 3], [0, 0, 1]), ([1, 0, 1.5], [1, 0, 0]), ([-1, 0, 1.5], [1, 0, 0]))
    result = forward_kinematics(half, ["1", "1.5", "1.5"], cell_limit=500_000)
    touching = [s for s in result.solutions if s.taut == (0,) and s.height.mean() < 2]
    assert len(touching) == 2
    for pose in touching:
        assert not pose.is_proved and pose.family is None
        assert pose.cable_states[1:] == (CableState.UNDECIDED,) * 2
        assert abs(abs(pose.rotation[1, 0].mean()) - 1.0) < 1e-9
    assert result.outcome is Outcome.INCOMPLETE and result.verify(half) == []
