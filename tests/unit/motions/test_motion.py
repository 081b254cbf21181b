"""Questions about motions: files, options, budgets, and what is written."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cdpr_interval import InputError, load_robot
from cdpr_interval.engine.budget import Budget
from cdpr_interval.errors import CdprError
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from solvers import Motion, PointMass, forward_kinematics, motion
from solvers.answers.data import CableState, Certainty, Outcome, Undecided
from solvers.motions.course import read_course
from solvers.motions.motion import MotionOptions, motion_problem, solve_motion
from solvers.motions.one_pose import OVER, OnePoseMover
from solvers.motions.start import chosen, mover_of
from tests.unit.solvers.test_schemas import faults, schema

CABLES = ("c1", "c2")
UC2 = [(0, [7.5, 8]), (1, [7.5, 7.9])]


def written(folder: Path, text: str) -> Path:
    path = folder / "lengths.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_is_read_exactly(tmp_path):
    text = "notes, c2 ,t_s,x_mine,c1\nfirst,8,0,?,2690mm\n\n,8.0..8.2,100ms,,2.69+-0.01\n,8,1min,,3\n"
    course = read_course(written(tmp_path, text), "lengths.csv", CABLES)
    assert [row.time for row in course.rows] == [0, F(1, 10), 60]
    assert course.rows[1].lengths == ((F("2.68"), F("2.70")), (F("8"), F("8.2")))
    assert course.at(F(1, 20)) == ((F("2.685"), F("2.695")), (F("8"), F("8.1")))
    assert course.at(F(60)) == ((3, 3), (8, 8)) and course.middles(F(1, 10)) == (F("2.69"), F("8.1"))
    assert course.knots(F(1, 20)) == [F(k, 20) for k in range(1201)]
    assert course.knots() == [0, F(1, 10), 60]
    wide = course.widened(F(1, 1000), "tolerance")
    assert wide.at(F(0)) == ((F("2.689"), F("2.691")), (F("7.999"), F("8.001")))
    assert wide.rows[1].lengths == course.rows[1].lengths
    assert course.pace(F(0)) == 2 and wide.of_middles().at(F(0)) == course.at(F(0))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t_s,c1,c2\n0,1,x\n1,1,1\n", ["file 'f.csv' line 2[c2]: 'x' is not a number"]),
        ("t_s,c1,c2\n0,1\n1,1,1\n", ["file 'f.csv' line 2: 2 cells under 3 titles"]),
        ("t_s,c1,c2\n0,1,1\n0,1,1\n", ["file 'f.csv' line 3: t_s: must be later than 0 s, got 0"]),
        ("t_s,c1,c2\n0,1,1\n1m,1,1\n", ["file 'f.csv' line 3: t_s: '1m' is a length, not a time"]),
        (
            "t_s,c1,c2\n0,-1,1\n,1,1\n",
            ["line 2[c1]: must be positive, got -1", "line 3: t_s: '' is not a number"],
        ),
        ("t_s,c1,c2\n0,1,1\n", ["file 'f.csv': needs at least two rows, has 1"]),
        ("t_s,c1,c2\n", ["needs a head with t_s and the cables' names, and at least two rows"]),
        ("t_s;c1;c2\n0;1;1\n", ["line 1: columns are separated by ';'"]),
        ("t_s,c1,c2,c1\n0,1,1,1\n", ["line 1: column 'c1' is there twice"]),
        (
            "c1,C2,time\n0,1,1\n",
            ["unknown column 'C2' (did you mean 'c2'?)", "'time'", "no column for t_s, c2"],
        ),
    ],
)
def test_a_wrong_file_is_refused_with_its_lines(tmp_path, text, said):
    with pytest.raises(InputError) as caught:
        read_course(written(tmp_path, text), "f.csv", CABLES)
    lines = caught.value.messages
    assert len(lines) == len(said)
    assert all(
        line.startswith("file 'f.csv'") and part in line for line, part in zip(lines, said, strict=True)
    )


def test_a_file_that_is_none(tmp_path):
    for name, said in (("no.csv", "No such file"), (".", "Is a directory")):
        with pytest.raises(InputError, match=said):
            read_course(tmp_path / name, name, CABLES)
    (tmp_path / "x.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"x\.csv"):
        read_course(tmp_path / "x.csv", "x.csv", CABLES)


@pytest.mark.parametrize(
    ("rows", "options", "said"),
    [
        ([(0, [1, 2])], {}, "needs at least two rows, has 1"),
        ([(0, [1, 2]), (0, [1, 2])], {}, r"lengths\[1\]: t_s: must be later than 0 s, got 0"),
        ([(0, [1]), (1, [1, 2])], {}, r"lengths\[0\]: 1 length for 2 cables"),
        ([0, 1], {}, "must be a CSV file or pairs"),
        (7, {}, "must be a CSV file or pairs"),
        ([("x", [1, 2]), (None, [1, 2])], {}, "'x' is not a number"),
        (UC2, {"tolerance": -1}, "tolerance: must not be negative"),
        (UC2, {"tolerance": 8}, "tolerance: a length at 0 s is not longer than that"),
        (UC2, {"tolerance": "x"}, "tolerance: 'x' is not a number"),
        (UC2, {"step": 0}, "step: must be positive"),
        (UC2, {"start": (1, 2)}, "start: must hold x, y and z"),
        (UC2, {"time_limit": 0}, "time_limit: must be"),
        (UC2, {"threads": 0}, "threads: must be"),
    ],
)
def test_wrong_questions(rows, options, said):
    with pytest.raises(InputError, match=said):
        motion("uc2", rows, **options)


def with_ranges(name, width, mass=None):
    """Return a robot all of whose points are known to ``width`` m only, and its mass within bounds in kg."""
    document = load_robot(name).to_dict()
    for cable in document["cables"]:
        for point in ("frame_anchor_m", "platform_anchor_m"):
            cable[point] = [{"value": x, "tolerance": width} for x in cable[point]]
    document["platform"]["mass_kg"] = mass or document["platform"]["mass_kg"]
    return Robot.from_dict(document)


def test_a_range_of_the_mass_scales_the_tensions():
    exact, vague = motion("uc2", UC2), motion(with_ranges("uc2", 0, [1, 2]), UC2)
    assert vague.outcome is Outcome.COMPLETE
    mass = float(load_robot("uc2").platform.mass)
    for one, other in zip(exact.segments, vague.segments, strict=True):
        assert np.allclose(one.tube.position, other.tube.position, atol=1e-4)
        (lo, hi), (low, high) = np.array(one.tube.tensions).T / mass, np.array(other.tube.tensions).T
        assert (low <= hi).all() and (high >= 2 * lo).all()
        assert np.allclose(low, lo, rtol=1e-6) and np.allclose(high, 2 * hi, rtol=1e-6)


def test_ranges_of_points_a_cable_switches_once_for_every_choice():
    """Not at one time, but for each choice within the interval of the event, that of the middle, too."""
    rows = [(0, [7.5, 8, 7, 9.1]), (10, [7.5, 8, 7, 9.35])]
    vague, exact = motion(with_ranges("uc4", "1e-4"), rows), motion("uc4", rows)
    assert vague.outcome is Outcome.COMPLETE
    (event,), (sharp,) = vague.events, exact.events
    assert (event.cable, event.kind) == ("c4", "slack")
    assert event.t[0] < sharp.t[0] < sharp.t[1] < event.t[1]
    for segment in exact.segments:
        wide = [one for one in vague.segments if one.t[0] <= segment.t[0] and segment.t[1] <= one.t[1]]
        for one in wide:
            position, bounds = np.array(segment.tube.position), np.array(one.tube.position)
            assert (bounds[:, 0] <= position[:, 0]).all() and (position[:, 1] <= bounds[:, 1]).all()


def test_a_point_mass_with_ranges_of_data():
    document = load_robot("merlet_4_1").to_dict()
    document["cables"][0]["frame_anchor_m"][0] = {
        "value": document["cables"][0]["frame_anchor_m"][0],
        "tolerance": "1e-3",
    }
    rows = [(0, [3.1, 3.2, 3.3, 3.4]), (1, [3.1, 3.2, 3.3, 3.35])]
    vague, exact = motion(Robot.from_dict(document), rows), motion("merlet_4_1", rows)
    assert vague.outcome is exact.outcome is Outcome.COMPLETE
    bounds, position = np.array(vague.segments[0].tube.position), np.array(exact.segments[0].tube.position)
    assert (bounds[:, 0] <= position[:, 0]).all() and (position[:, 1] <= bounds[:, 1]).all()


def test_a_budget_ends_within_a_way():
    """The proofs of a point mass with ranges take long each: the first after the budget's end is the last."""
    robot, asked = load_robot("merlet_4_1"), []
    budget = Budget(cell_limit=3)

    def follow(lengths):
        asked.append(lengths)
        budget.cells += 1
        return PointMass(robot).solve(lengths.tolist())

    before, after = np.array([[3.1] * 2, [3.2] * 2, [3.3] * 2, [3.4] * 2]), np.array([[3.3] * 2] * 4)
    mover = OnePoseMover(follow, before)
    moved = mover.go(after, budget)
    assert moved.reason == OVER and 0.0 <= moved.share < 1.0 and len(asked) <= 5
    assert all(stretch.last <= moved.share for stretch in moved.stretches)


def test_documents_follow_their_schema():
    rules = schema("cdpr-motion-1")
    lost = motion("uc2", [(0, [7.5, 8]), (5, [2, 2])])
    for result in (
        motion("uc4", [(0, [7.5, 8, 7, 9]), (1, [7.5, 8, 7, 9.3])]),
        lost,
        motion("uc2", [(0, [1, 1]), (1, [1, 1])]),
    ):
        document = json.loads(result.to_json())
        assert list(faults(document, rules, rules)) == []
        assert list(document) == list(rules["properties"])
        again = Motion.from_json(result.to_json())
        assert again.to_json() == result.to_json() and str(again) == str(result)
    document["segments"] = {}
    assert list(faults(document, rules, rules)) != []
    with pytest.raises(InputError, match=r"motion\.segments: must be a list"):
        Motion.from_json(document)


def test_rows_of_tubes():
    result = motion("uc4", [(0, [7.5, 8, 7, 9]), (1, [7.5, 8, 7, 9.3])])
    rows = list(csv.DictReader(io.StringIO(result.to_csv())))
    assert [row["taut"] for row in rows] == ["c1 c2 c3 c4", "c1 c2 c3", "c1 c2 c3"]
    assert rows[1]["switching"] == "c4" and rows[2]["tension_c4_hi_N"] == "0.0"
    for row, one in zip(rows, result.segments, strict=True):
        assert float(row["z_lo_m"]) == one.tube.position[2, 0]
        assert float(row["r23_hi"]) == one.tube.rotation[1, 2, 1]


def test_no_pose_at_the_start_is_proved():
    result = motion("uc2", [(0, [1, 1]), (1, [7.5, 8])])
    assert result.start is None and result.segments == () and result.outcome == "complete"
    assert "no stable pose at the start" in result.message


def test_what_counts_as_a_complete_start():
    found = forward_kinematics("uc2", [7.5, 8])
    (stable,) = chosen(found, None).poses
    assert stable is found.solutions[0] and chosen(found, None).is_complete
    open_one = replace(found.solutions[1], stability=Stability.UNDECIDED)
    vague = replace(found, solutions=(open_one,))
    assert chosen(vague, None).poses == () and not chosen(vague, None).is_complete
    only = replace(found, solutions=found.solutions[1:])
    assert chosen(only, None).poses == () and chosen(only, (0, 0, 0)).is_complete
    assert not chosen(replace(only, pending=1), (0, 0, 0)).is_complete
    doubtful = replace(stable, existence=Certainty.UNDECIDED)
    assert not chosen(replace(found, solutions=(doubtful,)), None).is_complete


def test_a_pose_that_cannot_be_followed_is_lost_at_once():
    robot = load_robot("uc2")
    among = forward_kinematics(robot, [7.5, 8]).solutions
    # These lengths are not those of the pose.
    with pytest.raises(CdprError, match="there"):
        mover_of(robot, among[0], among, np.array([[2.0, 2.0], [2.0, 2.0]]))
    bounds = np.array([[7.5, 7.5], [8.0, 8.0]])
    assert mover_of(robot, among[0], among, bounds).here.taut == (0, 1)
    for others in (among[1:], (*among, among[0])):
        with pytest.raises(CdprError, match="cannot be told from another one"):
            mover_of(robot, among[0], others, bounds)
    wide = motion(robot, [(0, [(6, 9), (7, 9)]), (1, [7.5, 8])])
    (event,) = wide.events
    assert (
        wide.segments == ()
        and event.kind == "lost"
        and event.reason.startswith("for all choices in the first")
    )


def test_a_time_limit_keeps_what_is_proved():
    problem = motion_problem(load_robot("uc2"), [(0, [7.5, 8]), (1, [7.5, 7.9])], step="0.001")
    options = MotionOptions()
    told = []

    def stop(progress):
        told.append(progress.done)
        if len(told) == 20:
            options.budget.interrupt()

    options.progress = stop
    result = solve_motion(problem, options)
    assert result.stop_reason == "interrupted" and result.outcome == "incomplete"
    assert 0 < len(result.segments) < 1000 and told == sorted(told)
    (event,) = result.events
    assert event.kind == "lost" and event.reason == "interrupted" and event.t[1] == 1.0
    assert result.segments[-1].t[1] == pytest.approx(event.t[0])
    late = motion("uc2", [(0, [7.5, 8]), (1, [7.5, 7.9])], time_limit=1e-9)
    assert late.stop_reason == "time_limit" and late.segments == () and "time limit" in late.message


def test_pictures(tmp_path):
    pytest.importorskip("matplotlib")
    result = motion("uc4", [(0, [7.5, 8, 7, 9]), (1, [7.5, 8, 7, 9.3])], step=0.25)
    for name in ("m.png", "m.svg", "m.pdf"):
        assert result.plot(tmp_path / name).stat().st_size > 1000
    empty = motion("uc2", [(0, [1, 1]), (1, [1, 1])])
    assert empty.plot(tmp_path / "empty.png").exists()
    with pytest.raises(InputError, match=r"must end in \.png"):
        result.plot(tmp_path / "m.txt")
    with pytest.raises(InputError, match="No such file"):
        result.plot(tmp_path / "no" / "m.png")


def test_of_ranges_the_middles_alone_do_not_rule_out_a_start():
    """At the middles UC2 has no stable pose; for other lengths of the first row it has one."""
    found = motion("uc2", [(0, ["3.29", "3.41"]), (1, ["3.28", "3.40"])], tolerance="0.05")
    assert forward_kinematics("uc2", ["3.34", "3.46"]).solutions[0].stability == "stable"
    assert found.outcome is Outcome.INCOMPLETE and "middles of the first lengths" in found.message


def test_the_nearest_start_is_not_known_where_a_region_is_nearer():
    result = forward_kinematics("uc2", "7.5,8")
    (stable,) = [s for s in result.solutions if s.stability == "stable"]
    place = stable.nominal.position
    assert chosen(result, place).is_complete
    near = np.array([place, place]).T
    region = Undecided((0, 1), 1, "why", near + [[-0.1, 0.1]] * 3, stable.rotation)
    for changed in (replace(result, undecided=(region,)), replace(result, pending=9)):
        assert not chosen(changed, place).is_complete
    far = replace(region, position=near + [[4.0, 5.0]] * 3)
    assert chosen(replace(result, undecided=(far,)), place).is_complete


def test_a_pose_is_where_its_last_stretch_ends_even_if_it_is_not_proved_again():
    def follow(lengths):
        wide, most = np.ptp(lengths, axis=1).max(), lengths.max()
        proved = most <= 2.5 and not (most > 2.2 and wide < 1e-9)
        states, bounds = [CableState.TAUT], np.repeat(lengths, 3, axis=0)
        return SimpleNamespace(
            proved=proved, reason="why", states=states, position=bounds, tensions=np.array([[1.0, 2.0]])
        )

    mover = OnePoseMover(follow, np.array([[1.0, 1.0]]))
    moved = mover.go(np.array([[3.0, 3.0]]))
    low, high = mover.here.position[0]
    assert 0.7 < moved.share < 0.76 and low <= 1.0 + 2.0 * moved.share <= high + 1e-12
