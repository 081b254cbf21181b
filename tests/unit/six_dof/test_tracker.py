"""What a tracker takes, refuses, remembers and says."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.errors import CdprError, InputError, NotSupportedError
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Elasticity, Robot
from solvers import forward_kinematics, inverse_kinematics
from solvers.answers.data import Answer, CableState, Certainty, Family, Solution
from solvers.answers.result import Result
from solvers.six_dof.tracked_pose import TrackedPose, TrackStatus
from solvers.six_dof.tracker import Tracker
from tests.support import hanging_mass
from tests.support.tracked_region import check_alone, depth, is_finite, moved, same_pose, start_at

UC4 = [7.5, 8.0, 7.0, 9.0]
NEAR = [7.501, 8.0, 7.0, 9.0]


@cache
def uc4() -> tuple[Robot, Result]:
    robot = load_robot("uc4")
    return robot, forward_kinematics(robot, UC4)


def stable() -> Solution:
    return next(s for s in uc4()[1].solutions if s.stability is Stability.STABLE)


def tracker(**options: float) -> Tracker:
    return Tracker(uc4()[0], stable(), **options)


def refused(*arguments: Any, **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        Tracker(*arguments, **options)
    return str(caught.value)


def identical(a: TrackedPose, b: TrackedPose) -> bool:
    assert a.tracked and b.tracked and a.fields is not None and b.fields is not None
    return a.region == b.region and all(np.array_equal(x, y) for x, y in zip(a.fields, b.fields, strict=True))


def test_a_tracked_pose_says_all_about_itself() -> None:
    pose = tracker().update(NEAR)
    assert pose.tracked and pose.status is TrackStatus.TRACKED == "tracked" and pose.reason == ""
    assert pose.taut == (0, 1, 2, 3) and pose.states == (CableState.TAUT,) * 4
    assert pose.stability is Stability.STABLE and is_finite(pose)
    shapes = (pose.position, pose.rotation, pose.height, pose.tensions, pose.distances)
    assert [x.shape for x in shapes] == [(3, 2), (3, 3, 2), (2,), (4, 2), (4, 2)]
    assert np.allclose(pose.point, pose.position.mean(axis=-1), rtol=1e-15)
    assert np.allclose(rotation_from_quaternion(pose.quaternion), pose.rotation.mean(axis=-1), atol=1e-14)
    assert np.all(pose.distances[:, 0] <= NEAR) and np.all(pose.distances[:, 1] >= NEAR)
    assert np.all(pose.tensions[:, 0] > 0.0)


def test_the_region_is_around_the_reference() -> None:
    own = tracker()
    centre = stable().position.mean(axis=-1)  # uc4's centre of mass is its origin.
    for lengths in (NEAR, UC4, NEAR):
        pose = own.update(lengths)
        region = pose.region
        assert region is not None
        assert np.allclose(region.centre, centre, atol=1e-9)
        assert 0.0 < region.radius <= own.size / 8 and region.angle <= region.radius / own.size
        assert region.angle > 0.999 * region.radius / own.size
        centre = pose.position.mean(axis=-1)


def test_a_pose_in_a_corner_of_the_bounds_is_not_in_the_region() -> None:
    """The bounds of u and p around a region also hold poses outside: a tracked one is in the region."""
    robot, result = uc4()
    depths = []
    for turn, shift in (([0.0] * 3, [1.0] * 3), ([1.0] * 3, [0.0] * 3), ([1.0, -1, 1], [1.0, 1, -1])):
        for share in (0.5, 0.8, 0.9, 0.95, 1.0, 1.2, 1.5):
            for radius in (1e-3, 1e-4):
                by = ([share * radius / 2 * x for x in turn], [share * radius * x for x in shift])
                start = moved(robot, stable(), *by)
                own = Tracker(robot, start, radius=radius, least_radius=radius, follow=False)
                pose = own.update(UC4)
                if pose.tracked:
                    assert pose.region is not None
                    where = pose.rotation.mean(axis=-1), pose.position.mean(axis=-1)
                    depths.append(depth(robot, pose.region, *where))
                    check_alone(robot, pose, result)
                else:
                    assert share > 0.55 and "does not lie within" in pose.reason
    assert depths and max(depths) <= 1.0


def test_lost_poses_claim_nothing() -> None:
    pose = tracker().update([1.0, 1.0, 1.0, 1.0])
    assert not pose.tracked and pose.status is TrackStatus.LOST == "lost-track" and pose.fields is None
    assert pose.reason and pose.tried is not None
    for name in (
        "taut",
        "region",
        "position",
        "rotation",
        "height",
        "tensions",
        "distances",
        "stability",
        "states",
        "point",
        "quaternion",
    ):
        with pytest.raises(CdprError, match="no pose is proved: "):
            getattr(pose, name)


def test_the_reference_stays_where_track_is_lost() -> None:
    own, other = tracker(), tracker()
    own.update(NEAR)
    other.update(NEAR)
    assert not own.update([1.0, 1.0, 1.0, 1.0]).tracked
    assert not own.update([50.0, 8.0, 7.0, 9.0]).tracked
    a, b = own.update(UC4), other.update(UC4)
    assert a.tracked and b.tracked and a.region is not None and b.region is not None
    assert a.region.centre == b.region.centre and a.region.quaternion == b.region.quaternion


SPELLINGS: list[Any] = [
    tuple(NEAR),
    np.array(NEAR),
    [np.float64(x) for x in NEAR],
    {"c1": 7.501, "c2": 8.0, "c3": 7.0, "c4": 9.0},
    [Fraction(x) for x in NEAR],
    [7.501, 8, 7, 9],
    [(x, x) for x in NEAR],
    np.array([[x, x] for x in NEAR]),
    np.array([NEAR, NEAR]).T,
]


@pytest.mark.parametrize("spelling", range(len(SPELLINGS)))
def test_the_same_lengths_give_the_same_pose(spelling: int) -> None:
    assert identical(tracker().update(SPELLINGS[spelling]), tracker().update(NEAR))
    # Also where the load is known already.
    one, two = tracker(), tracker()
    one.update(UC4)
    two.update(UC4)
    assert identical(one.update(SPELLINGS[spelling]), two.update(NEAR))


@pytest.mark.parametrize("lengths", ["7.501, 8, 7, 9", ["7.501", "8", "7", "9"], [Decimal("7.501"), 8, 7, 9]])
def test_decimals_are_exact(lengths: Any) -> None:
    """7.501 is no double: the bounds hold the decimal's pose, up to the last digits that of the double."""
    pose, double = tracker().update(lengths), tracker().update(NEAR)
    assert pose.tracked
    assert Fraction(pose.distances[0, 0]) <= Fraction("7.501") <= Fraction(pose.distances[0, 1])
    assert np.allclose(pose.position, double.position, atol=1e-12)


def test_ranges_hold_the_poses_of_all_their_lengths() -> None:
    half = 2e-5
    wide = tracker().update([(x - half, x + half) for x in NEAR])
    assert wide.tracked
    for signs in ((1, 1, 1, 1), (-1, 1, -1, 1), (0.3, -0.9, 0, -1), (-1, -1, -1, -1)):
        pose = tracker().update([x + s * half for x, s in zip(NEAR, signs, strict=True)])
        assert pose.tracked
        for inner, outer in (
            (pose.position, wide.position),
            (pose.rotation, wide.rotation),
            (pose.tensions, wide.tensions),
            (pose.height, wide.height),
        ):
            assert np.all(outer[..., 0] <= inner[..., 1]) and np.all(inner[..., 0] <= outer[..., 1])
            middle = inner.mean(axis=-1)
            assert np.all(outer[..., 0] < middle) and np.all(middle < outer[..., 1])
    assert not tracker().update([(x - 0.5, x + 0.5) for x in NEAR]).tracked


BAD_LENGTHS: list[tuple[Any, str]] = [
    ([7.5, 8.0, 7.0], "3"),
    ([7.5, 8.0, 7.0, float("nan")], "nan"),
    ([7.5, 8.0, 7.0, float("inf")], "inf"),
    ([7.5, 8.0, 7.0, -1.0], "lengths[3]: must be positive"),
    ([7.5, 8.0, 7.0, 0.0], "lengths[3]: must be positive"),
    ([7.5, 8.0, 7.0, (9.1, 9.0)], "lengths[3]: the lower bound"),
    ([7.5, 8.0, 7.0, "long"], "long"),
    ({"c1": 7.5}, "c2"),
    (np.array(NEAR)[:2], "2"),
    (np.full((4, 3), 7.0), ""),
]


@pytest.mark.parametrize("case", range(len(BAD_LENGTHS)))
@pytest.mark.parametrize("known", [False, True])
def test_wrong_lengths_are_refused_and_change_nothing(case: int, known: bool) -> None:
    lengths, part = BAD_LENGTHS[case]
    own = tracker()
    if known:
        own.update(UC4)
    with pytest.raises(InputError) as caught:
        own.update(lengths)
    assert part in str(caught.value)
    assert own.update(NEAR).tracked


def test_robots_that_are_refused() -> None:
    assert "is a point mass; use PointMass" in refused(hanging_mass.robot())
    robot = uc4()[0]
    spring = Elasticity(stiffness=Fraction(1000))
    elastic = replace(robot, cables=tuple(replace(c, elasticity=spring) for c in robot.cables))
    with pytest.raises(NotSupportedError, match="elastic"):
        Tracker(elastic, follow=False)


@pytest.mark.parametrize("radius", [0.0, -1.0, 1.01, float("nan"), float("inf"), "x"])
def test_a_radius_that_is_refused(radius: float) -> None:
    assert refused(uc4()[0], radius=radius).startswith("radius: must be positive and at most 1 m, got ")
    if radius != 1.01:
        assert refused(uc4()[0], least_radius=radius).startswith(
            "least_radius: must be positive and at most "
        )
    assert refused(uc4()[0], radius=0.1, least_radius=0.2).endswith("at most 0.1 m, got 0.2")


def test_radii_bound_the_region() -> None:
    for radius in (1.0, 1e-3, 1e-6):
        pose = tracker(radius=radius).update(UC4)
        assert pose.tracked and pose.region is not None and pose.region.radius <= radius
    near = [7.5 + 1e-5, 8.0, 7.0, 9.0]
    assert "does not lie within 1e-06 m" in tracker(radius=1e-6, follow=False).update(near).reason
    pose = tracker(radius=1.0, least_radius=0.5, follow=False).update(UC4)
    assert not pose.tracked and pose.tried is not None and pose.tried.radius >= 0.5


def test_starts_that_are_refused() -> None:
    robot, one = uc4()[0], stable()
    undecided = replace(one, cable_states=(*one.cable_states[:3], CableState.UNDECIDED))
    family = replace(one, family=Family("rotation", None, None, np.zeros((1, 2, 2))))
    switching = replace(one, cable_states=(*one.cable_states[:3], CableState.SWITCHING))
    unproved = replace(one, uniqueness=Certainty.UNDECIDED)
    for start in (undecided, family, switching, unproved):
        assert "start: must be one pose, with every cable proved taut or slack" in refused(robot, start)
    other = load_robot("uc3")
    assert "start: has 4 cables, the robot 3" in refused(other, one)
    own = tracker()
    with pytest.raises(InputError):
        own.reset(undecided)
    assert own.update(UC4).tracked


def test_a_wrong_start_is_lost_or_led_to_a_true_pose() -> None:
    robot, result = uc4()
    for turn, shift in (([0.5, 0, 0], [1.0, 0, 0]), ([0, 0, 3.0], [0, 0, 0]), ([0, 0, 0], [0, 0, 9.0])):
        pose = Tracker(robot, moved(robot, stable(), turn, shift)).update(UC4)
        if pose.tracked and pose.region is not None:
            check_alone(robot, pose, result)
        elif pose.tracked:
            assert any(same_pose(pose, s) for s in result.solutions)
    # One cable alone, or three, cannot hold the platform here.
    for taut in ((0,), (0, 1, 2)):
        states = tuple([CableState.TAUT if i in taut else CableState.SLACK for i in range(4)])
        pose = Tracker(robot, replace(stable(), taut=taut, cable_states=states)).update(UC4)
        assert not pose.tracked and pose.reason


def test_one_cable_leaves_a_turn_free() -> None:
    robot = uc4()[0]
    single = replace(robot, cables=robot.cables[:1])
    own = Tracker(single)
    pose = own.update([7.5])
    assert not pose.tracked and pose.tried is None
    assert "there is no last pose" in pose.reason


def test_the_first_update_searches_for_the_one_stable_pose() -> None:
    robot, result = uc4()
    own = Tracker(robot)
    pose = own.update(UC4)
    assert pose.tracked and pose.stability is Stability.STABLE
    check_alone(robot, pose, result)
    assert own.update(NEAR).tracked
    own = Tracker(load_robot("uc2"))
    assert own.update("7.5, 8", external_force=[0, 0, Fraction(-1, 10)]).tracked


def test_no_start_without_a_stable_pose_or_with_several() -> None:
    own = Tracker(uc4()[0])
    pose = own.update([1.0, 1.0, 1.0, 1.0])
    assert not pose.tracked and pose.tried is None and "0 stable ones" in pose.reason
    assert own.update(UC4).tracked


def test_no_start_where_the_search_ends_without_a_choice(monkeypatch: pytest.MonkeyPatch) -> None:
    robot, result = uc4()
    answers = [
        (Answer((stable(), stable())), "2 stable ones for these lengths: choose one by reset"),
        (Answer(result.solutions, pending=1), "the search for one is not complete"),
    ]
    for answer, part in answers:
        monkeypatch.setattr("solvers.six_dof.tracker.solve", lambda *_, answer=answer: answer)
        own = Tracker(robot)
        pose = own.update(UC4)
        assert not pose.tracked and pose.tried is None and part in pose.reason
        own.reset(stable())
        assert own.update(UC4).tracked


def test_reset_chooses_another_pose() -> None:
    robot, result = uc4()
    own = tracker()
    for s in result.solutions:
        own.reset(s)
        pose = own.update(UC4)
        if pose.tracked:
            assert pose.taut == s.taut
            check_alone(robot, pose, result)


def test_an_external_force_moves_the_pose() -> None:
    robot = uc4()[0]
    own = tracker()
    for force in (
        [0.0, 0.0, -0.001],
        ["0.001", 0, 0],
        None,
        (0.0, 0.0005, 0.0),
        [0, 0, 0],
        "0,0,-0.001",
        None,
    ):
        pose = own.update(UC4, force)
        assert pose.tracked
        given = force.split(",") if isinstance(force, str) else force
        check_alone(robot, pose, forward_kinematics(robot, UC4, taut=range(4), external_force=given))
    with pytest.raises(InputError, match="cancel"):
        own.update(UC4, [0, 0, 1])
    for bad in ([0, 0], [0, 0, "x"], 1.0, [0.0, 0.0, float("nan")]):
        with pytest.raises(InputError, match="external_force"):
            own.update(UC4, bad)  # type: ignore[arg-type]
    again = own.update(UC4)
    assert again.tracked
    check_alone(robot, again, uc4()[1])


def test_the_tensions_of_six_cables_feel_the_force() -> None:
    """With six taut cables the force changes nothing but the tensions."""
    cogiro = load_robot("cogiro")
    taut = (0, 1, 2, 4, 5, 7)
    pose = inverse_kinematics(
        cogiro, (2.1, 2.3, 0.9), quaternion=(1, 0.2, 0.3, -0.1), taut=taut, settle=True, slack_margin=0.05
    )
    rotation = np.asarray(pose.rotation, dtype=np.float64)
    own = Tracker(cogiro, start_at(cogiro, taut, rotation, np.array(pose.position), list(pose.tensions)))
    lengths = [float(x) for x in pose.lengths]
    first = own.update(lengths)
    second = own.update(lengths, [0.0, 0.0, -10.0])
    assert first.tracked and second.tracked and is_finite(first) and is_finite(second)
    assert np.allclose(first.position, second.position, atol=1e-9)
    for result, force in ((first, 0.0), (second, -10.0)):
        rotation = result.rotation.mean(axis=-1)
        pull = np.array([0.0, 0.0, float(cogiro.platform.mass) * float(cogiro.gravity[2]) + force])
        for i, cable in enumerate(cogiro.cables):
            point = result.position.mean(axis=-1) + rotation @ np.array(
                [float(x) for x in cable.platform_anchor]
            )
            spoke = np.array([float(x) for x in cable.frame_anchor]) - point
            pull += result.tensions[i].mean() / np.linalg.norm(spoke) * spoke
        assert np.abs(pull).max() < 1e-6


def test_warm_up_changes_nothing() -> None:
    own = tracker()
    own.warm_up()
    assert identical(own.update(NEAR), tracker().update(NEAR))
    empty = Tracker(uc4()[0])
    empty.warm_up()
    assert empty.robot is uc4()[0] and empty.size == 2.0


def test_tensions_that_are_not_bounded_are_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Six tensions are solved for once more in the pose's box; should that fail, nothing is claimed."""
    own = tracker(follow=False)
    honest = own._fields

    def failing(*given: Any) -> Any:
        fields = honest(*given)
        fields.tensions[0, 1] = np.nan
        return fields

    monkeypatch.setattr(own, "_fields", failing)
    pose = own.update(UC4)
    assert pose.status is TrackStatus.LOST and "tensions are not bounded" in pose.reason
    monkeypatch.undo()
    assert own.update(UC4).tracked


def test_a_weightless_platform_is_warmed_up_and_tracked_under_a_force() -> None:
    robot = uc4()[0]
    light = replace(robot, platform=replace(robot.platform, mass=Fraction(0)))
    weight = [float(robot.platform.mass * g) for g in robot.gravity]
    own = Tracker(light, stable())
    own.warm_up()
    assert own.update(UC4, weight).tracked
    with pytest.raises(InputError, match="cancel"):
        own.update(UC4)


def test_a_start_under_quite_another_force_is_lost_not_another_pose() -> None:
    """Newton's method goes from there to an unstable pose 4.7 m away, turned by 164 degrees."""
    lengths, force = [7.5, 8.0, 7.0], [-2.321, -2.393, -3.607]
    (start,) = [s for s in forward_kinematics("uc3", lengths).solutions if str(s.stability) == "stable"]
    pose = Tracker("uc3", start).update(lengths, force)
    assert not pose.tracked or np.linalg.norm(np.array(pose.point) - start.nominal.position) < 1.0
