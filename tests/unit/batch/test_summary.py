"""What a batch says of its poses: by branch, and with angles that know where a turn ends."""

import io
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solvers.batch.branches import Branches
from solvers.batch.statistics import circular_statistics, deviation, mean_direction, statistics
from solvers.batch.summary_text import MOST_BRANCHES, print_summary
from solvers.batch.work import Status

SQUARE = np.array([[-0.3, -0.2, 0.1], [0.3, -0.2, 0.1], [0.3, 0.2, 0.1], [-0.3, 0.2, 0.1]])
PLACE = ("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg")


def pose(*numbers, taut="a b", stability="stable"):
    return {**dict(zip(PLACE, numbers, strict=True)), "taut": taut, "stability": stability}


def test_statistics_of_numbers():
    found = statistics([1.0, 2.0, 3.0, 6.0])
    assert (found["count"], found["mean"], found["min"], found["max"]) == (4, 3.0, 1.0, 6.0)
    assert found["p50"] == 2.5 and found["std"] == pytest.approx(np.std([1, 2, 3, 6]))


def test_angles_around_half_a_turn_have_a_mean_there():
    found = circular_statistics([179.0, -179.0, 180.0, -180.0])
    assert abs(found["mean"]) == pytest.approx(180.0)
    assert found["max"] - found["min"] == pytest.approx(2.0) and found["std"] == pytest.approx(math.sqrt(0.5))
    assert found["p5"] <= found["p50"] <= found["p95"]
    assert 0.999 < found["resultant"] <= 1.0


def test_opposite_angles_have_no_mean_direction():
    assert circular_statistics([0.0, 180.0])["resultant"] < 1e-9


@given(st.lists(st.floats(-20.0, 20.0), min_size=1, max_size=20), st.floats(-1000.0, 1000.0))
def test_a_turn_of_all_angles_turns_the_statistics(angles, turn):
    """What is said of angles does not depend on where zero is."""
    one, other = circular_statistics(angles), circular_statistics([angle + turn for angle in angles])
    assert deviation(other["mean"], one["mean"] + turn) == pytest.approx(0.0, abs=1e-6)
    for key in ("min", "max", "p5", "p50", "p95"):
        assert other[key] - other["mean"] == pytest.approx(one[key] - one["mean"], abs=1e-6)
    assert other["std"] == pytest.approx(one["std"], abs=1e-6)
    assert mean_direction(angles)[1] == pytest.approx(other["resultant"], abs=1e-9)


def numbers_of(branches, *jobs):
    return [[branch.number for branch in branches.assign(job)] for job in jobs]


def test_poses_go_to_the_nearest_of_the_first_job():
    branches = Branches(SQUARE, is_followed=True)
    first = [pose(0, 0, 1, 0, 0, 0), pose(0, 0, 1, 180, 0, 0), pose(0, 0, 3, 0, 0, 0, stability="unstable")]
    # The order within a job says nothing, nor does the sign of an angle near half a turn.
    second = [pose(0, 0, 1.01, -179, 0, 0), pose(0, 0, 0.99, 2, 0, 0)]
    assert numbers_of(branches, first, second) == [[1, 2, 3], [2, 1]]
    assert [(b.number, b.solutions, b.jobs) for b in branches.sorted()] == [(1, 2, 2), (2, 2, 2), (3, 1, 1)]


def test_a_branch_has_one_pose_of_a_job_and_what_is_left_begins_another():
    branches = Branches(SQUARE, is_followed=True)
    jobs = [
        [pose(0, 0, 1, 0, 0, 0)],
        [pose(0, 0, 2, 0, 0, 0), pose(0, 0, 1.1, 0, 0, 0)],
        [pose(0, 0, 1.9, 0, 0, 0)],
    ]
    # The third job has one pose only: it is that of the second branch, which is nearer.
    assert numbers_of(branches, *jobs) == [[1], [2, 1], [2]]


def test_other_taut_cables_are_another_branch():
    branches = Branches(SQUARE, is_followed=True)
    near = [pose(0, 0, 1, 0, 0, 0)], [pose(0, 0, 1, 0, 0, 0, taut="a c")], []
    assert numbers_of(branches, *near) == [[1], [2], []]


def test_questions_that_are_no_deviations_are_not_followed():
    branches = Branches(SQUARE, is_followed=False)
    jobs = [pose(0, 0, 1, 0, 0, 0), pose(5, 0, 1, 0, 0, 0)], [pose(9, 0, 1, 0, 0, 0)]
    assert numbers_of(branches, *jobs) == [[1, 1], [1]]
    (branch,) = branches.sorted()
    assert (branch.solutions, branch.jobs) == (3, 2)


def document(branches, per_job):
    quantities = {"z_m": statistics([1.0, 2.0])}
    group = {
        "robot": "r", "problem": 0, "solutions_per_job": per_job, "taut_subsets": {"a b": 4},
        "stability": {"stable": 4}, "quantities": quantities,
        "branches": [
            {"branch": n, "stability": "stable", "taut": "a b", "solutions": n, "jobs": 1,
             "quantities": quantities}
            for n in range(1, branches + 1)
        ],
    }  # fmt: skip
    jobs = {status.value: 2 * (status is Status.DONE) for status in Status}
    return {"name": "a study", "jobs": jobs, "jobs_with_undecided": 0, "certificates": {}, "groups": [group]}


def test_the_text_names_the_batch_and_fits_eighty_columns():
    print_summary(document(2, {"2": 2}), text := io.StringIO())
    lines = text.getvalue().splitlines()
    assert lines[0].startswith("a study: 2 jobs: 2 done; ")
    assert "  branch 1, stable, taut a b: 1 pose in 1 job" in lines
    assert max(map(len, lines)) <= 80


def test_poses_of_one_branch_are_not_pooled_with_others():
    print_summary(document(MOST_BRANCHES + 3, {"2": 2}), text := io.StringIO())
    assert text.getvalue().count("branch ") == MOST_BRANCHES and "3 more branches" in text.getvalue()
    # With one pose a job at most, all together are what a measurement scatters.
    print_summary(document(2, {"0": 1, "1": 1}), text := io.StringIO())
    assert "branch" not in text.getvalue() and "z_m" in text.getvalue()


def test_numbers_are_json():
    assert json.loads(json.dumps(circular_statistics([1.0]))) == circular_statistics([1.0])
