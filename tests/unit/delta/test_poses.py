"""Poses and drives of Deltas: enclosures, both branches, ranges, limits, and where nothing is proved."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

from cdpr_interval import InputError, NotSupportedError
from cdpr_interval.exact import balls
from cdpr_interval.exact.angle import Angle
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.delta import delta_of, elbow, lean
from cdpr_interval.robots.delta import LINEAR, DeltaRobot
from cdpr_interval.robots.formats.reader import load_delta
from solvers import Delta, delta_drives, delta_poses
from solvers.delta.result import DeltaIkResult, DeltaResult

SEED = 20261201


def random_delta(generator: np.random.Generator, is_linear: bool = False) -> DeltaRobot:
    """Return a Delta with legs long enough to get somewhere."""

    def drawn(lo: float, hi: float) -> str:
        return f"{generator.uniform(lo, hi):.4f}"

    arm, bar = drawn(0.5, 1.5), drawn(1.6, 3)
    common = {"bar": bar, "tool_offset": (drawn(-1, 1), "0", drawn(-1, 0))}
    if is_linear:
        rails = [(drawn(-1, 1), drawn(-1, 1), "-1") for _ in range(3)]
        return DeltaRobot("rails", drawn(0.2, 1), "0.1", drives=LINEAR, rail_directions=rails, **common)
    return DeltaRobot("arms", drawn(0.2, 1), "0.1", arm=arm, **common)


def contains(bounds: np.ndarray, values: np.ndarray, slack: float = 1e-12) -> bool:
    return bool(((bounds[:, 0] - slack <= values) & (values <= bounds[:, 1] + slack)).all())


@pytest.mark.parametrize("is_linear", [False, True])
def test_drives_and_poses_invert_each_other(is_linear: bool):
    """Enclosures of drives put back in: the pose is one of the two, on every combination of branches."""
    generator, seen = np.random.default_rng(SEED), 0
    while seen < 400:
        robot = random_delta(generator, is_linear)
        position = [f"{x:.5f}" for x in generator.uniform(-1.5, 1.5, 3)]
        there = delta_drives(robot, position)
        if not there.reachable:
            assert there.outcome == "complete" and (there.angles, there.positions) == (None, None)
            continue
        branches = np.array(
            [there.positions, there.other_positions] if is_linear else [there.angles, there.other_branch]
        )
        choice = generator.integers(0, 2, 3)
        drives = [tuple(map(Fraction, branches[choice[i], i].tolist())) for i in range(3)]
        back = delta_poses(robot, positions=drives) if is_linear else delta_poses(robot, drives)
        if not back.solutions:
            # Both poses are nearly one.
            assert back.outcome == "incomplete"
            continue
        seen += 1
        wanted = np.array([float(x) for x in position])
        assert sum(contains(pose.position, wanted, 0.0) for pose in back.solutions) >= 1
        assert all(pose.position[:, 1].max() < 1e9 for pose in back.solutions)
        if back.outcome == "complete":
            heights = [pose.position[2] for pose in back.solutions]
            assert heights[0][1] < heights[1][0]


def test_ranges_enclose_every_choice():
    """Random choices of angles and dimensions within their tolerances: each pose lies in its box."""
    generator = np.random.default_rng(SEED)
    wide = DeltaRobot("wide", ("0.149", "0.151"), "0.025", ("0.379", "0.381"), ("0.1995", "0.2005"))
    angles = [("0.19", "0.21"), ("0.3", "0.31"), ("0.5", "0.5")]
    boxes = delta_poses(wide, angles)
    assert boxes.outcome == "complete" and len(boxes.solutions) == 2
    widths = [np.ptp(pose.position, axis=1).max() for pose in boxes.solutions]
    reached = []
    for _ in range(200):
        size = [
            f"{generator.uniform(*map(float, pair)):.6f}" for pair in (wide.base_radius, wide.bar, wide.arm)
        ]
        one = DeltaRobot("one", size[0], "0.025", size[1], size[2])
        chosen = [f"{generator.uniform(*map(float, pair)):.6f}rad" for pair in angles]
        found = delta_poses(one, chosen)
        for box, pose in zip(boxes.solutions, found.solutions, strict=True):
            assert contains(box.position, pose.position.mean(axis=1))
        reached.append([pose.position.mean(axis=1) for pose in found.solutions])
    spread = np.ptp(np.array(reached), axis=0).max(axis=1)
    # First-order tubes: not much wider than what the choices reach.
    assert (np.array(widths) < 2.5 * spread).all()
    there = delta_drives(wide, ("0", "0.1", ("-0.451", "-0.449")))
    assert there.outcome == "complete" and (np.ptp(there.angles, axis=1) > 1e-3).all()


def test_knees_above_each_other_are_no_exception():
    """H_2 = 0: seen from above the knees lie on a line, where the printed elimination divides by 0."""
    # The carriages: (1, 0, 0), and from (-1/2, +-sqrt(3)/2, 0) along (1, +-1/2, -1) / 1.5 until x = 1.
    rails = [(0, 0, -1), (2, 1, -2), (2, -1, -2)]
    robot = DeltaRobot("flat", "1", "0", "3", drives=LINEAR, rail_directions=rails)
    found = delta_poses(robot, positions=["0", "2.25", "2.25"])
    assert len(found.solutions) == 2
    for pose in found.solutions:
        assert np.isfinite(pose.position).all()


def test_spheres_that_do_not_meet_and_that_just_meet():
    short = DeltaRobot("short", "2", "0", "1", "0.5")
    none = delta_poses(short, ("0deg", "0deg", "0deg"))
    assert (none.solutions, none.outcome) == ((), "complete") and none.message.startswith("no pose")
    # Knees on a circle of radius 5 / 2, bars as long: one pose, which balls do not tell from two or none.
    just = DeltaRobot("just", "2", "0", "2.5", "0.5")
    open_ = delta_poses(just, ("0deg", "0deg", "0deg"))
    assert open_.outcome == "incomplete" and "may just meet" in open_.message


def test_a_pose_at_the_end_of_the_reach_is_not_decided_by_balls():
    stretched = DeltaRobot("stretched", "0.5", "0", "0.7", "0.6")
    at = delta_drives(stretched, (0, 0, "-1.2"))
    assert (at.reachable, at.outcome) == (None, "incomplete")
    assert delta_drives(stretched, (0, 0, "-1.199999")).reachable is True
    assert delta_drives(stretched, (0, 0, "-1.200001")).reachable is False


def test_limits_are_reported_and_filter_nothing():
    robot = DeltaRobot("small", "0.15", "0.025", "0.38", "0.2")
    free = delta_drives(robot, ("0.1", "0.1", "-0.45"))
    leans = free.bar_angles
    for limit, kept in ((leans[:, 1].max() + 0.01, True), (leans[:, 0].max() - 0.01, False)):
        angle = Angle(Range.exact(Fraction(float(limit))), False)
        found = delta_drives(robot.replace(gamma_max=angle), ("0.1", "0.1", "-0.45"))
        assert found.limits_respected is kept and found.reachable
        assert (found.angles == free.angles).all()
    low = Angle.degrees(170)
    assert delta_drives(robot.replace(elbow_min=low), ("0.1", "0.1", "-0.45")).limits_respected is False


def test_the_elbow_says_the_branch():
    found = delta_poses("delta_580", ("10deg", "20deg", "30deg"))
    below, above = (pose.elbow_angles for pose in found.solutions)
    assert (below[:, 1] < math.pi).all() and (above[:, 0] > math.pi).all()


def test_controllers_get_the_same_bounds():
    delta, generator = Delta("delta_580"), np.random.default_rng(SEED)
    for _ in range(50):
        drives = generator.uniform(-0.3, 1.2, 3).tolist()
        quick, whole = delta.solve(drives), delta_poses("delta_580", drives)
        if not whole.solutions:
            assert quick.lower is None and quick.proved is (whole.outcome == "complete")
            continue
        assert (quick.lower == whole.solutions[0].position).all()
        middle = quick.lower.mean(axis=1).tolist()
        back, there = delta.drives(middle), delta_drives("delta_580", middle)
        assert (back.useful == there.angles).all() and (back.other == there.other_branch).all()
    assert delta.drives((0, 0, -9)) == (None, None, True)
    with pytest.raises(InputError, match="3 finite numbers"):
        delta.solve((0, math.nan, 0))


def test_documents_restore_every_double():
    found = delta_poses("delta_580", ("10deg+-0.1deg", "20deg", "30deg"))
    assert DeltaResult.from_json(found.to_json()).to_json() == found.to_json()
    assert found.provenance.asked == ("9.9deg..10.1deg", "20deg", "30deg")
    there = delta_drives("delta_580", (0, 0, "-0.4"))
    assert DeltaIkResult.from_json(there.to_json()).to_json() == there.to_json()


def test_questions_that_are_none():
    for given, message in (
        (("1deg", "2deg"), "must hold three angles, got 2"),
        (("1", "2deg", "3deg"), r"angles\[0\]: '1' has no unit"),
        (("1m", "2deg", "3deg"), r"angles\[0\]: .*is a length"),
        (None, "angles: missing"),
    ):
        with pytest.raises(InputError, match=message):
            delta_poses("delta_580", given)
    with pytest.raises(InputError, match="this Delta has arms"):
        delta_poses("delta_580", positions=(0, 0, 0))
    with pytest.raises(NotSupportedError, match="is no Delta"):
        delta_poses("uc2", (0, 0, 0))
    with pytest.raises(InputError, match="must be a Delta"):
        delta_poses(3, (0, 0, 0))


def test_elbows_about_a_stretched_or_folded_chain_are_enclosed():
    """At half a turn and at 0 the angle is cut: enclosures of ranges hold what their members have."""
    with balls.precision():
        delta = delta_of(load_delta("delta_580"))
        x, _, z = delta.knee(0, arb(0.5))
        for sign in (1, -1):
            reach = sign * delta.bar
            centre = [x + reach * arb(0.5).cos(), arb(0), z - reach * arb(0.5).sin()]
            around = elbow(delta, 0, centre, arb(0.5, 0.25))
            for turn in (0.3, 0.4, 0.6, 0.7):
                assert around.contains(elbow(delta, 0, centre, arb(turn)))


def test_bars_that_lean_as_far_as_they_can_are_bounded_by_a_quarter_turn():
    with balls.precision():
        delta = delta_of(load_delta("delta_580"))
        knee = delta.knee(0, arb(0))
        out = lean(delta, 0, [knee[0], knee[1] + delta.bar * arb(1, 0.01), knee[2]], arb(0))
        assert out.is_finite() and out.contains(arb.pi() / 2) and out < 1.58 and out > 1.4
