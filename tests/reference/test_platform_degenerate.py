"""Everyday degenerate platforms: symmetry, equal ropes, hooks, and ends of families."""

from __future__ import annotations

import numpy as np

from cdpr_interval.robots.reader import parse_robot
from solvers import forward_kinematics
from solvers.result import CableState, Outcome, Stability

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
