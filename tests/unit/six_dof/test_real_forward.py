"""Platforms on pulleys through forward kinematics: two robots of the literature, families, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.errors import CdprError, NotSupportedError
from cdpr_interval.robots.cable_robot import Elasticity, Robot
from solvers import Motion, Outcome, Tracker, forward_kinematics, inverse_kinematics, motion
from solvers.answers.data import Stability

IRMA_LENGTHS = ["1.6463246530", "1.0786153083", "1.6421042936", "2.0556154675"]


def irma4u(**pulley: Any) -> Robot:
    """Return IRMA4U: four cables over pulleys of 3 cm (numbers of its published calibration)."""
    corners = [
        ("1.065", "-1.155", 1),
        ("1.066", "1.155", 1),
        ("-1.066", "1.155", -1),
        ("-1.065", "-1.155", -1),
    ]
    anchors = [("0.075", "-0.075"), ("0.075", "0.075"), ("-0.075", "0.075"), ("-0.075", "-0.075")]
    return Robot.from_dict(
        {
            "format": "cdpr-robot/1",
            "name": "irma4u",
            "gravity_m_s2": [0, 0, "-9.80665"],
            "platform": {"mass_kg": "12.992", "centre_of_mass_m": [0, 0, "0.173"]},
            "cables": [
                {
                    "name": f"c{i + 1}",
                    "frame_anchor_m": [x, y, "1.839"],
                    "platform_anchor_m": [*anchors[i], "0.266"],
                    "pulley": {"joints": 1, "radius_m": "0.03", "axis": [k, 0, 0], **pulley},
                }
                for i, (x, y, k) in enumerate(corners)
            ],
        }
    )


def grab_33() -> Robot:
    """Return GRAB_33: three cables over pulleys (numbers of its published test case)."""
    exits = [
        ("-0.96454", "0.02418", "0.78008"),
        ("1.14503", "1.18777", "0.76763"),
        ("-0.96692", "2.33711", "0.74320"),
    ]
    anchors = [
        ("-0.15043", "-0.23664", "0.26168"),
        ("0.25829", "-0.00158", "0.26145"),
        ("-0.15069", "0.23810", "0.26141"),
    ]
    axes, radii = [[-1, 0, 0], [0, -1, 0], [-1, 0, 0]], ["0.01704", "0.02341", "0.01527"]
    return Robot.from_dict(
        {
            "format": "cdpr-robot/1",
            "name": "grab_33",
            "gravity_m_s2": ["0.069223", "-0.153450", "-9.803682"],
            "platform": {"mass_kg": "8.0064", "centre_of_mass_m": ["-0.01425", "-0.00172", "0.17325"]},
            "cables": [
                {
                    "name": f"c{i + 1}",
                    "frame_anchor_m": list(exits[i]),
                    "platform_anchor_m": list(anchors[i]),
                    "pulley": {"joints": 1, "radius_m": radii[i], "axis": axes[i]},
                }
                for i in range(3)
            ],
        }
    )


def test_the_planted_pose_of_irma4u_is_the_only_one() -> None:
    """All fifteen subsets; lengths and tensions of the pose reproduce what was planted."""
    result = forward_kinematics(irma4u(), IRMA_LENGTHS)
    assert result.outcome is Outcome.COMPLETE and len(result.subsets) == 15
    (pose,) = result.solutions
    assert pose.taut == (0, 1, 2, 3) and pose.stability is Stability.STABLE
    assert np.allclose(pose.nominal.position, (0.380319, 0.375357, 1.189340), atol=2e-6)
    assert np.allclose(pose.distances.mean(axis=1), [float(x) for x in IRMA_LENGTHS], atol=1e-9)
    weight = 12.992 * 9.80665
    assert weight < pose.tensions.sum()
    assert result.statistics.cells < 200_000


def test_the_homing_pose_of_grab_33_is_the_stable_one_of_seven() -> None:
    result = forward_kinematics(grab_33(), ["1.54832", "1.64748", "1.53246"], taut=(0, 1, 2))
    assert result.outcome is Outcome.COMPLETE and len(result.solutions) == 7
    (stable,) = (pose for pose in result.solutions if pose.stability is Stability.STABLE)
    assert np.allclose(stable.nominal.position, (-0.309944, 1.170309, -0.606982), atol=2e-5)
    assert np.allclose(stable.tensions.mean(axis=1), (37.1, 35.6, 38.1), atol=0.1)


def test_a_platform_that_may_turn_is_a_region() -> None:
    """One cable holds it, the others are long: a family, and nothing is claimed of it."""
    result = forward_kinematics(irma4u(), [1, 4, 4, 4], taut=(0,))
    assert result.outcome is Outcome.INCOMPLETE and not result.solutions
    (region,) = result.undecided
    assert "family" in region.reason
    # The centre of mass hangs below the first pulley, by rope and arm.
    assert region.position[2, 0] < 1.839 - 1.0 + 0.266 < region.position[2, 1] + 1.0


def test_two_long_cables_leave_two_poses() -> None:
    result = forward_kinematics(irma4u(), ["1.6", 4, "1.6", 4], taut=(0, 2))
    assert result.outcome is Outcome.COMPLETE
    assert [pose.stability for pose in result.solutions] == [Stability.STABLE, Stability.UNSTABLE]


def test_a_pulley_without_a_radius_is_an_exit_point_behind_its_lead_in() -> None:
    """Ropes that are longer by what lies before the exit point have the poses of straight ones."""
    pulleys = forward_kinematics(
        irma4u(radius_m=0, lead_in_m="0.5"), ["2.2", "2.3", "2.2", "2.3"], taut=(0, 2)
    )
    plain = Robot.from_dict(
        {
            **irma4u().to_dict(),
            "cables": [
                {key: value for key, value in cable.items() if key != "pulley"}
                for cable in irma4u().to_dict()["cables"]
            ],
        }
    )
    straight = forward_kinematics(plain, ["1.7", "1.8", "1.7", "1.8"], taut=(0, 2))
    assert pulleys.outcome is straight.outcome is Outcome.COMPLETE
    assert len(pulleys.solutions) == len(straight.solutions)
    for one, other in zip(pulleys.solutions, straight.solutions, strict=True):
        assert np.allclose(one.nominal.position, other.nominal.position, atol=1e-7)
        assert np.allclose(one.tensions, other.tensions, rtol=1e-6)
        assert one.stability is other.stability


@pytest.mark.parametrize(
    ("pulley", "text"),
    [
        ({"joints": 2, "lead_in_m": 1, "balance": "bisector"}, "c1: a platform needs balance: exact"),
        ({"joints": 2, "lead_in_m": "0.18"}, "c1: a platform on two joints needs a lead-in above"),
        ({"radius_m": [0.02, 0.03]}, "uncertain scalars"),
    ],
)
def test_what_is_refused_by_name(pulley: dict[str, Any], text: str) -> None:
    with pytest.raises(NotSupportedError, match=text):
        forward_kinematics(irma4u(**pulley), IRMA_LENGTHS)


def on_two_joints(**pulley: Any) -> Robot:
    """Return GRAB_33 with ropes that arrive over 1 m at pulleys on two joints."""
    block = grab_33().to_dict()
    for cable in block["cables"]:
        cable["pulley"] = {**cable["pulley"], "joints": 2, "lead_in_m": 1, **pulley}
    return Robot.from_dict(block)


LONGER = ["2.54832", "2.64748", "2.53246"]
"""The homing pose's lengths of GRAB_33 and what lies before the pulleys."""


@pytest.mark.slow
def test_small_pulleys_on_two_joints_have_the_poses_of_exit_points() -> None:
    """All seven, and nearer to them as the radius is."""
    plain = forward_kinematics(on_two_joints(radius_m=0, joints=1), LONGER, taut=(0, 1, 2))
    places = np.array(sorted(pose.nominal.position for pose in plain.solutions))
    for radius in ("1e-3", "1e-5"):
        result = forward_kinematics(on_two_joints(radius_m=radius), LONGER, taut=(0, 1, 2))
        assert result.outcome is plain.outcome is Outcome.COMPLETE
        found = np.array(sorted(pose.nominal.position for pose in result.solutions))
        assert np.abs(found - places).max() < float(radius)


def test_a_platform_on_two_joints_is_found_followed_and_tracked() -> None:
    robot = on_two_joints(arm_m="0.04")
    result = forward_kinematics(robot, LONGER, taut=(0, 1, 2))
    assert result.outcome is Outcome.COMPLETE and len(result.solutions) == 7
    (stable,) = (pose for pose in result.solutions if pose.stability is Stability.STABLE)
    pose = inverse_kinematics(robot, stable.nominal.position, stable.rotation.mean(axis=2))
    assert pose.static and np.allclose(pose.lengths, [float(x) for x in LONGER], atol=1e-8)
    end = ["2.65", "2.60", "2.56"]
    moved = motion(robot, [(0, LONGER), (5, end)])
    assert moved.outcome is Outcome.COMPLETE and not moved.events
    tracker = Tracker(robot)
    first = tracker.update([float(x) for x in LONGER])
    assert first.tracked and np.allclose(first.point, stable.nominal.position, atol=1e-9)
    last = tracker.update([float(x) for x in end])
    tube = moved.segments[-1].tube
    assert last.tracked
    assert ((tube.position[:, 0] <= last.point) & (last.point <= tube.position[:, 1])).all()


def test_a_budget_ends_as_pending() -> None:
    result = forward_kinematics(irma4u(), IRMA_LENGTHS, cell_limit=500)
    assert result.outcome is Outcome.INCOMPLETE and result.pending


def test_legs_that_push_are_straight() -> None:
    with pytest.raises(CdprError):
        forward_kinematics(irma4u(), IRMA_LENGTHS, ignore_tension_sign=True)


def test_stretch_moves_the_poses_of_straight_cables_a_little() -> None:
    """UC4 with 0.002 m/N and a load of 1 N: three poses as without, each tension what its stretch says.

    The fourth is upside down, its cables stretched by many times the load.
    """
    robot = load_robot("uc4")
    spring = Elasticity(stiffness=500)
    stretchy = robot.replace(cables=[cable.replace(elasticity=spring) for cable in robot.cables])
    lengths = [7.5, 8, 7, 9]
    stiff = forward_kinematics(robot, lengths, taut=(0, 1, 2, 3))
    result = forward_kinematics(stretchy, lengths, taut=(0, 1, 2, 3))
    assert len(stiff.solutions) == 3 and result.outcome is Outcome.COMPLETE
    low = [pose for pose in result.solutions if pose.tensions.max() < 20]
    (high,) = [pose for pose in result.solutions if pose.tensions.max() >= 20]
    assert len(low) == 3 and high.tensions[:, 0].min() > 10
    for pose in low:
        near = [np.abs(np.subtract(pose.nominal.position, p.nominal.position)).max() for p in stiff.solutions]
        assert min(near) < 0.01
        stretch = pose.distances - np.array(lengths)[:, None]
        assert np.allclose(pose.tensions, 500 * stretch, atol=1e-6)


def stretched_cogiro(stiffness: int) -> tuple[Robot, list[float]]:
    """Return CoGiRo on elastic cables, and unstretched lengths that reach (0.5, 0.3, 1.5) upright."""
    robot = load_robot("cogiro")
    spring = Elasticity(axial_stiffness=stiffness)
    stretchy = robot.replace(cables=[cable.replace(elasticity=spring) for cable in robot.cables])
    way = [
        np.subtract(c.frame_anchor, c.platform_anchor).astype(float) - (0.5, 0.3, 1.5) for c in robot.cables
    ]
    return stretchy, [round(float(np.linalg.norm(v)), 9) for v in way]


@pytest.mark.parametrize("stiffness", [100_000, 1_000_000])
def test_eight_elastic_cables_carry_together(stiffness: int) -> None:
    """All eight share the load: one pose, upright, a little below where the lengths reach unstretched."""
    robot, lengths = stretched_cogiro(stiffness)
    result = forward_kinematics(robot, lengths, taut=range(8))
    assert result.outcome is Outcome.COMPLETE and len(result.solutions) == 1
    (pose,) = result.solutions
    assert pose.stability is Stability.STABLE and len(pose.taut) == 8
    assert np.allclose(pose.nominal.position, (0.5, 0.3, 1.5), atol=0.1 * 100_000 / stiffness)

    assert pose.tensions[:, 0].min() > 280 and pose.tensions[:, 1].max() < 365
    stretch = pose.tensions * (np.array(lengths) / stiffness)[:, None]
    assert np.allclose(pose.distances, np.array(lengths)[:, None] + stretch, atol=1e-9)


def test_more_than_eight_elastic_cables_are_not_passed_over() -> None:
    robot, lengths = stretched_cogiro(100_000)
    more = robot.cables[0].replace(name="ninth", frame_anchor=(0, 0, 6))
    result = forward_kinematics(robot.replace(cables=[*robot.cables, more]), [*lengths, 8], cell_limit=2_000)
    assert result.outcome is Outcome.INCOMPLETE
    assert any("more than eight" in region.reason for region in result.undecided)


def test_uc3_on_soft_cables_has_sixteen_poses() -> None:
    """Those a multistart found from 3 000 starts, also the one with 123 to 157 times the load."""
    robot = load_robot("uc3")
    stretchy = robot.replace(cables=[c.replace(elasticity=Elasticity(stiffness=500)) for c in robot.cables])
    result = forward_kinematics(stretchy, ["7.5", 8, 7])
    assert result.outcome is Outcome.COMPLETE and len(result.solutions) == 16
    most = sorted(pose.tensions.max() for pose in result.solutions)
    assert most[-1] == pytest.approx(157.20, abs=0.01) and most[-2] < 2.1
    assert sum(pose.stability is Stability.STABLE for pose in result.solutions) == 1


def test_a_tracker_searches_for_its_start() -> None:
    """The one stable pose of the first call's lengths, then what it becomes."""
    tracker = Tracker(irma4u())
    first = tracker.update([float(x) for x in IRMA_LENGTHS])
    assert first.tracked and first.taut == (0, 1, 2, 3), first.reason
    assert np.allclose(first.point, (0.380319, 0.375357, 1.189340), atol=2e-6)
    longer = tracker.update([float(x) + 1e-4 for x in IRMA_LENGTHS])
    assert longer.tracked and not np.allclose(longer.point, first.point, atol=1e-5)


@pytest.mark.parametrize(
    ("pulley", "text"),
    [
        ({"joints": 2, "lead_in_m": 1, "balance": "bisector"}, "balance: exact"),
        ({"radius_m": [0.02, 0.03]}, "uncertain scalars"),
    ],
)
def test_motions_and_trackers_refuse_by_name(pulley: dict[str, Any], text: str) -> None:
    courses = [(0, [1.7, 1.7, 1.7, 1.7]), (1, [1.71, 1.7, 1.7, 1.7])]
    for ask in (lambda robot: motion(robot, courses), Tracker):
        with pytest.raises(NotSupportedError, match=text) as caught:
            ask(irma4u(**pulley))
        assert "\n" not in str(caught.value)


def test_a_motion_of_irma4u_goes_through_a_slack_cable_and_back() -> None:
    """Where cable c4 lets go and takes hold again."""
    first, second, third, fourth = IRMA_LENGTHS
    paid_out = [first, str(float(second) + 0.05), third, str(float(fourth) + 0.02)]
    result = motion(irma4u(), [(0, IRMA_LENGTHS), (5, paid_out), (8, IRMA_LENGTHS)])
    assert result.outcome is Outcome.COMPLETE and not result.others
    assert [(event.cable, event.kind) for event in result.events] == [("c4", "slack"), ("c4", "taut")]
    assert all(event.t[1] - event.t[0] < 0.02 for event in result.events)
    start, end = result.segments[0].tube, result.segments[-1].tube
    assert result.segments[-1].taut == (0, 1, 2, 3)
    assert ((start.position[:, 0] <= end.position[:, 1]) & (end.position[:, 0] <= start.position[:, 1])).all()
    assert Motion.from_json(result.to_json()).segments[0].t == result.segments[0].t


@pytest.mark.slow
def test_a_motion_of_grab_33_ends_where_its_cables_are_too_short() -> None:
    """Proved: they reach the platform together until then, and no longer."""
    result = motion(grab_33(), [(0, ["1.54832", "1.64748", "1.53246"]), (5, [1, 1, 1])])
    (end,) = result.events
    assert end.kind == "fold" and not end.poses and end.t[1] - end.t[0] < 1e-3
    # Until 4 s, and after it not any more.
    before, after = ([x + time / 5 * (1 - x) for x in (1.54832, 1.64748, 1.53246)] for time in (3.9, 4.1))
    assert forward_kinematics(grab_33(), before, taut=(0, 1, 2)).solutions and end.t[0] > 3.9
    assert not forward_kinematics(grab_33(), after, taut=(0, 1, 2)).solutions and end.t[1] < 4.1
