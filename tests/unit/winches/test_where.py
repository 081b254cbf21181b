"""Where the platform is, for measured lengths; and paths that are proved before they are run."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.mechanics.statics import Pose
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import parse_robot
from scripts import winch_controller
from solvers import forward_kinematics, inverse_kinematics
from solvers.commands.winch_output import print_where
from solvers.questions.pose import read_pose
from solvers.winches.path import PathRefused, half_widths_of, plan
from solvers.winches.where import whereabouts
from tests.support import hanging_mass
from tests.support.winch_robots import Bench, smooth_path

ROBOT = load_robot("four_winches")
LIMITS = [cable.winch.limits for cable in ROBOT.cables]
HELD = inverse_kinematics(ROBOT, (2, 1.5, 1)).lengths
NEAR = F("0.001")


def around(lengths, by=NEAR):
    return [(float(F(length) - by), float(F(length) + by)) for length in lengths]


def true_pose(robot, bench):
    """Return the position of the stable pose for the simulator's true lengths."""
    solutions = forward_kinematics(robot, bench.true_lengths).solutions
    (pose,) = [one for one in solutions if one.stability is Stability.STABLE]
    return pose.position


def assert_box_holds_the_truth(robot, bench):
    found = bench.group.where(lambda ranges: whereabouts(robot, ranges))
    truth = true_pose(robot, bench)
    (box,) = [pose.position for pose in found.poses]
    assert (box[:, 0] <= truth[:, 0]).all() and (truth[:, 1] <= box[:, 1]).all()
    return float((box[:, 1] - box[:, 0]).max())


def test_the_box_holds_the_true_pose_before_and_after_a_mark():
    """A four-cable point mass: homes wrong by most of their tolerance, a move, then a move over marks."""
    starts = tuple(F(length) for length in HELD)
    bench = Bench(ROBOT, starts)
    bench.group.connect()
    bench.group.home([Range(s - F("0.019"), s + F("0.001")) for s in starts])
    bench.group.enable()
    commanded = [cable.commanded for cable in bench.group.snapshot.cables]
    bench.group.follow(smooth_path(commanded, [length + 0.02 for length in commanded], 1.0))
    assert all(cable.reference.source == "home" for cable in bench.group.snapshot.cables)
    before = assert_box_holds_the_truth(ROBOT, bench)
    path = plan(ROBOT, LIMITS, HELD, around(HELD), read_pose("1.6,1.8,1.45"))
    commanded = [cable.commanded for cable in bench.group.snapshot.cables]
    bench.group.follow(smooth_path(commanded, path.lengths[-1].tolist(), 4.0))
    sources = [cable.reference.source for cable in bench.group.snapshot.cables]
    assert sum(source.startswith("mark") for source in sources) >= 2, sources
    after = assert_box_holds_the_truth(ROBOT, bench)
    assert after < before


def test_the_box_of_a_platform_holds_the_true_pose():
    robot = winch_controller.uc4_with_winches()
    starts = tuple(F(length) for length in winch_controller.START)
    bench = Bench(robot, starts)
    bench.group.connect()
    bench.group.home([Range(s - F(1, 4000), s + F(1, 10000)) for s in starts])
    bench.group.enable()
    assert_box_holds_the_truth(robot, bench)
    commanded = [cable.commanded for cable in bench.group.snapshot.cables]
    bench.group.follow(smooth_path(commanded, list(winch_controller.GOAL), 3.0))
    assert assert_box_holds_the_truth(robot, bench) < 0.01


def test_a_pose_that_is_not_enclosed_is_told_for_the_middles(monkeypatch, capsys):
    monkeypatch.setattr("solvers.winches.where.MOST_PIECES", 1)
    robot = winch_controller.uc4_with_winches()
    ranges = [(float(length) - 0.001, float(length) + 0.001) for length in winch_controller.START]
    found = whereabouts(robot, ranges)
    assert found.poses == () and not found.is_complete and len(found.lost) == 1
    print_where(robot, ranges, found, as_json=False)
    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith("for the middles of the lengths only: (") and last.endswith("deg)")
    print_where(robot, ranges, found, as_json=True)
    (pose,) = json.loads(capsys.readouterr().out)["at_the_middles_only"]
    (only,) = found.lost
    assert pose["position_m"] == list(only.nominal.position) and pose["rpy_rad"] == list(only.nominal.rpy)


def test_a_path_is_between_all_limits_and_ends_at_the_goal():
    path = plan(ROBOT, LIMITS, HELD, around(HELD), read_pose("1,1,0.6"))
    assert path.taut == (0, 1, 2, 3)
    assert (path.margins > 0).all()
    for i, limits in enumerate(LIMITS):
        assert path.speeds[i] <= 0.8001 * limits.velocity
        assert path.accelerations[i] <= limits.acceleration
    assert (path.tensions[:, 0] >= 1).all() and (path.tensions[:, 1] <= 500).all()
    (end,) = forward_kinematics(ROBOT, path.lengths[-1].tolist()).solutions
    assert end.nominal.position == pytest.approx((1, 1, 0.6), abs=1e-9)
    rows = path.points
    assert [len(row) for _, row in rows] == [4] * len(rows)
    assert np.diff([time for time, _ in rows]) == pytest.approx(0.01)


def test_drum_tolerances_add_up_along_a_path():
    """The proofs of a point mass allow for what the drums may do on the way, not only for the start."""
    bench = Bench(ROBOT, tuple(F(length) for length in HELD)).homed()
    references = [cable.reference for cable in bench.group.snapshot.cables]
    widths = half_widths_of(references)
    path = plan(ROBOT, LIMITS, HELD, around(HELD), read_pose("1,1,0.6"), half_widths=widths)
    assert (path.uncertainty > 0.001).all() and (path.uncertainty < 0.002).all()
    constant = plan(ROBOT, LIMITS, HELD, around(HELD), read_pose("1,1,0.6"))
    assert (path.uncertainty > constant.uncertainty).all()
    assert (path.tensions[:, 0] <= constant.tensions[:, 0]).all()


def test_a_path_of_a_platform_goes_on_from_its_pose():
    robot = winch_controller.uc4_with_winches()
    limits = [cable.winch.limits for cable in robot.cables]
    ranges = around(winch_controller.START, F(1, 10000))
    (here,) = whereabouts(robot, ranges).poses
    goal = Pose(np.add(here.point, (0.1, 0.05, 0.1)), here.rotation.mean(axis=-1))
    path = plan(robot, limits, winch_controller.START, ranges, goal, settle=True)
    assert path.taut == (0, 1, 2, 3) and path.pieces > 50
    end = whereabouts(robot, around(path.lengths[-1], F(1, 10000)))
    assert np.abs(np.array(end.poses[0].point) - goal.position).max() < 0.1


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        ("2,1.5,3.5", "no static pose"),
        ("3.9,2.9,2.5", "c3: the path needs 0.3"),
        ("2,1.5,-3", "c[1-4]: the path needs 6"),
    ],
)
def test_goals_that_cannot_be_are_refused(pose, message):
    with pytest.raises(PathRefused, match=message):
        plan(ROBOT, LIMITS, HELD, around(HELD), read_pose(pose))


def test_too_little_time_is_refused():
    with pytest.raises(PathRefused, match="give it more time"):
        plan(ROBOT, LIMITS, HELD, around(HELD), read_pose("1,1,0.6"), duration=2.0)


def test_a_cable_that_would_be_overloaded_is_refused():
    cables = (replace(ROBOT.cables[0], tension_limits=(F(1), F(100))), *ROBOT.cables[1:])
    weak = replace(ROBOT, cables=cables)
    with pytest.raises(PathRefused, match=r"c1 may carry .* N, limits 1 to 100 N"):
        plan(weak, LIMITS, HELD, around(HELD), read_pose("1,1,1.6"))


def test_a_cable_that_may_become_slack_is_refused():
    """Lengths known to 30 mm only: a cable's tension is not proved positive."""
    with pytest.raises(PathRefused, match=r"the start is not|is taut at the start|may carry|proved|decided"):
        plan(ROBOT, LIMITS, HELD, around(HELD, F("0.03")), read_pose("1,1,0.6"))


def test_the_example_controller_proves_every_cycle(capsys):
    assert winch_controller.main() == 0
    assert "305 cycles, 0 not proved" in capsys.readouterr().out


def test_what_switches_and_what_nothing_bounds_is_plain_json():
    robot = parse_robot(hanging_mass.TEXT, "hanging.yaml")
    just = whereabouts(robot, [(2.0, 2.0), (4.4, 4.5)])
    (pose,) = just.poses
    assert just.is_complete and not pose.is_decided
    assert pose.to_json(robot.cable_names)["cable_states"] == ["taut", "switching"]
    below = hanging_mass.TEXT.replace("[4, 0, 0]", "[0, 0, -4]")
    held = whereabouts(parse_robot(below, "below.yaml"), [(2.0, 2.0), (2.0, 2.0)])
    ((_, most), (least, _)) = held.poses[0].to_json(robot.cable_names)["tensions_N"]
    assert most is None and least == 0.0
    assert "Infinity" not in json.dumps(held.poses[0].to_json(robot.cable_names))


@pytest.mark.slow
@pytest.mark.parametrize("more", [{}, {"joints": 2, "lead_in_m": 1}], ids=["one joint", "two joints"])
def test_a_platform_over_pulleys_is_enclosed_and_moved(more):
    """GRAB_33 known to a millimetre: poses of sampled lengths lie in the box; a path to a settled goal."""
    document = load_robot("grab33").to_dict()
    winch = {key: value for key, value in ROBOT.to_dict()["cables"][0]["winch"].items() if key != "marks"}
    for node, cable in enumerate(document["cables"], 1):
        cable["winch"] = {**winch, "node": node}
        cable["pulley"] = {**cable["pulley"], **more}
    robot = Robot.from_dict(document)
    lengths = [F(length) + more.get("lead_in_m", 0) for length in ("1.54832", "1.64748", "1.53246")]
    found = whereabouts(robot, around(lengths))
    assert found.is_complete
    (here,) = found.poses
    rng = np.random.default_rng(0)
    for _ in range(3):
        chosen = [float(length) + 1e-3 * rng.choice([-1.0, 1.0]) for length in lengths]
        result = forward_kinematics(robot, chosen, taut=(0, 1, 2))
        (pose,) = (one for one in result.solutions if one.stability is Stability.STABLE)
        assert (here.position[:, 0] <= pose.position[:, 1]).all()
        assert (pose.position[:, 0] <= here.position[:, 1]).all()
    limits = [cable.winch.limits for cable in robot.cables]
    goal = read_pose("-0.28,1.19,-0.6")
    path = plan(robot, limits, [float(x) for x in lengths], around(lengths), goal, settle=True)
    assert path.taut == (0, 1, 2) and path.pieces >= 1
