"""Estimates of lost poses: near what the search proves, never taken for a proof, and a way back to track."""

from __future__ import annotations

import pickle
import sys
import threading
from dataclasses import replace

import numpy as np
import pytest

from cdpr_interval import CdprError, InputError, load_robot
from cdpr_interval.mechanics.orientation import rotation_from_vector
from solvers import Tracker, forward_kinematics
from solvers.six_dof.estimate import Body, Estimate, Guess, _equations, _newton
from solvers.six_dof.tracked_pose import TrackStatus

UC4 = [7.5, 8.0, 7.0, 9.0]


@pytest.fixture(scope="module")
def stable():
    found = forward_kinematics("uc4", UC4, taut=range(4)).solutions
    return next(pose for pose in found if pose.stability == "stable")


@pytest.mark.parametrize(("step", "taut"), [(0.01, (0, 1, 2, 3)), (0.5, (0, 1, 2))])
def test_a_lost_pose_is_estimated_through_a_switch(stable, step, taut):
    """The second step makes a cable slack: the search proves where the platform hangs then."""
    tracker = Tracker("uc4", stable, follow=False)
    lengths = [UC4[0] + step, *UC4[1:]]
    pose = tracker.update(lengths)
    assert pose.status is TrackStatus.LOST
    found = pose.estimate
    assert found.status == "estimate" and found.converged and found.taut == taut
    assert found is pose.estimate
    (proved,) = [
        s
        for s in forward_kinematics("uc4", lengths, taut=taut).solutions
        if np.allclose(s.nominal.position, found.position, atol=1e-6)
    ]
    assert proved.taut == taut and proved.stability == "stable"
    assert np.abs(proved.rotation.mean(axis=-1) - found.rotation).max() < 1e-8
    assert np.abs(proved.tensions.mean(axis=-1) - found.tensions).max() < 1e-6
    tracker.reset(found)
    again = tracker.update(lengths)
    assert again.tracked and again.taut == taut
    assert (again.position[:, 0] <= found.point).all() or np.allclose(again.point, found.point, atol=1e-9)


def test_estimates_go_on_from_each_other(stable):
    tracker = Tracker("uc4", stable, follow=False)
    for k in range(1, 6):
        pose = tracker.update([7.5 + 0.4 * k, 8.0, 7.0, 9.0])
        assert not pose.tracked and pose.estimate.converged
    # The reference stays where it was proved.
    assert tracker.update(UC4).tracked


def test_a_tracked_pose_is_its_own_estimate(stable):
    pose = Tracker("uc4", stable).update(UC4)
    found = pose.estimate
    assert found.point == pose.point and found.taut == pose.taut and found.converged
    assert np.allclose(found.rpy, stable.nominal.rpy)
    assert len(repr(pose)) < 200 and len(repr(found)) < 200 and "not certified" in repr(found)


def test_poses_travel_between_processes(stable):
    tracker = Tracker("uc4", stable, follow=False)
    for pose in (tracker.update(UC4), tracker.update([7.8, 8.0, 7.0, 9.0])):
        again = pickle.loads(pickle.dumps(pose))
        assert (again.status, again.reason, again.tried) == (pose.status, pose.reason, pose.tried)
        assert again.estimate.position == pose.estimate.position and repr(again) == repr(pose)
    assert not again.tracked


def test_nothing_is_known_without_a_start():
    tracker = Tracker("uc4")
    pose = tracker.update([1.0, 1.0, 1.0, 1.0])
    assert not pose.tracked and pose.estimate is None
    with pytest.raises(CdprError, match="no pose is proved: there is no last pose"):
        _ = pose.position


def test_where_there_is_no_pose_the_best_one_says_so(stable):
    """The lengths together are too short to reach the platform at all."""
    found = Tracker("uc4", stable).update([1.0, 1.0, 1.0, 1.0]).estimate
    assert not found.converged and found.residual > 0.1 and "not converged" in repr(found)
    with pytest.raises(InputError, match="start: the estimate has not converged"):
        Tracker("uc4", found)


def test_the_lengths_of_six_cables_fix_the_pose():
    """Whatever carries: the tensions follow, of any sign."""
    robot = load_robot("cogiro")
    body = Body(robot)
    assert body.names == robot.cable_names
    centre, rotation = np.array([0.1, 0.2, 2.0]), rotation_from_vector([0.05, -0.03, 0.1])
    lengths = body.distances(centre, rotation)
    start = Guess(centre + np.array([0.01, -0.02, 0.03]), np.eye(3), tuple(range(6)), np.zeros(6))
    found, converged, residual = _newton(body, start, lengths, np.array([0.0, 0.0, -1000.0]))
    assert converged and residual < 1e-9
    assert np.allclose(found.centre, centre) and np.allclose(found.rotation, rotation)


def test_the_derivatives():
    rng = np.random.default_rng(0)
    n, size, h = 4, 2.0, 1e-6
    exits, arms, lengths = 3.0 * rng.normal(size=(n, 3)), rng.normal(size=(n, 3)), rng.uniform(2.0, 4.0, n)
    centre, turned, t = rng.normal(size=3), rotation_from_vector(rng.normal(size=3)), rng.uniform(0.1, 1.0, n)

    def at(step):
        rotation = rotation_from_vector(step[:3]) @ turned
        where = centre + size * step[3:6]
        return _equations(exits, arms, lengths, np.array([0, 0, -1.0]), where, rotation, t + step[6:], size)

    wanted = [(at(h * row)[0] - at(-h * row)[0]) / (2.0 * h) for row in np.eye(n + 6)]
    assert np.abs(np.array(wanted).T - at(np.zeros(n + 6))[1]).max() < 1e-8


def test_a_start_is_a_pose_of_this_robot(stable):
    tracker = Tracker("uc4", stable)
    result = forward_kinematics("uc4", UC4, taut=range(4))
    elsewhere = replace(stable, nominal=replace(stable.nominal, position=(5.3, 3.3, -7.1)))
    for bad, message in (
        (np.zeros(3), "start: must be a Solution of forward_kinematics or an Estimate, got ndarray"),
        (result, "got Result: take one of its solutions"),
        (None, "got NoneType"),
        (elsewhere, "start: is a pose of another robot: the distance of cable c1 is 7.5 m there"),
    ):
        with pytest.raises(InputError) as caught:
            tracker.reset(bad)
        assert message in str(caught.value)
    assert tracker.update(UC4).tracked
    estimated = tracker.update(UC4).estimate
    with pytest.raises(InputError, match="start: has 4 cables, the robot 8"):
        Tracker("cogiro", estimated)


def test_two_threads_on_one_tracker_are_told(stable):
    tracker, errors = Tracker("uc4", stable), []
    entered, leave = threading.Event(), threading.Event()

    class Slow(list):
        """Lengths that take their time to be read."""

        def __iter__(self):
            entered.set()
            leave.wait(20.0)
            return super().__iter__()

    first = threading.Thread(target=lambda: errors.append(tracker.update(Slow(UC4)).tracked))
    first.start()
    assert entered.wait(20.0)
    for call in (lambda: tracker.update(UC4), lambda: tracker.reset(stable)):
        with pytest.raises(CdprError, match="is in use by another thread; make one tracker for each"):
            call()
    leave.set()
    first.join()
    assert errors == [True]
    assert tracker.update(UC4).tracked
    assert sys.exc_info() == (None, None, None)


def test_an_estimate_is_public():
    import solvers

    assert solvers.Estimate is Estimate
