"""A search in parts finds what the whole search finds, and says what it left."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from cdpr_interval import load_robot
from solvers.answers.data import Outcome, StopReason
from solvers.forward import answer_question, pose_problem
from solvers.questions.problem import Options
from solvers.six_dof.forward import subsets
from solvers.six_dof.parts import Part, PartFound, part_cells, parts_of, solve_part
from solvers.six_dof.prepared import lengths_of
from solvers.six_dof.reduction import reduced_problems

CASES = {"uc3": ["7.5", "8", "7"], "uc4": ["7.5", "8", "7", "9"]}


def question(name, options):
    return pose_problem(load_robot(name), CASES[name], None, None, options)


def in_parts(problem, options, count):
    found = {}
    for taut in subsets(problem):
        for part in parts_of(problem, options, taut, count):
            part = Part.from_json(json.loads(json.dumps(part.to_json())))
            text = json.dumps(solve_part(problem, options, part).to_json())
            found.setdefault((part.taut, part.frame), []).append(PartFound.from_json(json.loads(text)))
    return found


@pytest.mark.parametrize("count", [1, 3, 4, 7, 32])
def test_parts_cover_the_charts_once(count):
    options = Options()
    problem = question("uc3", options)
    (reduced,) = reduced_problems(problem.loaded, lengths_of(problem), options, (0, 1, 2))
    every = [part_cells(reduced.reduction, Part((0, 1, 2), 0, k, count)) for k in range(count)]
    cells = np.concatenate(every)
    assert len(cells) >= count and all(len(some) for some in every) == (count <= len(cells))
    for chart in range(4):
        of_chart = cells[cells[:, 6] == chart]
        assert np.prod(of_chart[:, 1:6:2] - of_chart[:, 0:5:2], axis=1).sum() == 8.0
        for k, one in enumerate(of_chart):
            for other in of_chart[:k]:
                overlap = np.minimum(one[1:6:2], other[1:6:2]) - np.maximum(one[0:5:2], other[0:5:2])
                assert overlap.min() <= 0.0
    assert cells[:, -1].sum() == pytest.approx(1.0)


@pytest.mark.parametrize(("name", "count"), [("uc3", 2), ("uc3", 19), ("uc4", 6)])
def test_put_together_they_are_the_whole(name, count):
    options = Options()
    problem = question(name, options)
    whole = answer_question(problem, options)
    parts = in_parts(problem, options, count)
    assert all(len(some) == count for some in parts.values())
    put = answer_question(problem, replace(options, parts=parts))
    assert put.outcome is whole.outcome is Outcome.COMPLETE
    assert len(put.solutions) == len(whole.solutions)
    for one, other in zip(put.solutions, whole.solutions, strict=True):
        assert (one.taut, one.stability, one.cable_states) == (
            other.taut,
            other.stability,
            other.cable_states,
        )
        for mine, theirs in ((one.position, other.position), (one.tensions, other.tensions)):
            assert np.all(np.maximum(mine[:, 0], theirs[:, 0]) <= np.minimum(mine[:, 1], theirs[:, 1]))


def test_a_part_that_is_missing_leaves_out_poses():
    """The guarantee rests on every part: this is what one of them holds."""
    options = Options()
    problem = question("uc3", options)
    whole = answer_question(problem, options)
    parts = in_parts(problem, options, 4)
    some = {key: found[:1] for key, found in parts.items()}
    assert len(answer_question(problem, replace(options, parts=some)).solutions) < len(whole.solutions)


def test_what_a_part_left_is_pending():
    options = Options(cell_limit=50)
    problem = question("uc3", options)
    parts = in_parts(problem, options, 4)
    put = answer_question(problem, replace(options, cell_limit=None, parts=parts))
    assert put.outcome is Outcome.INCOMPLETE and put.stop_reason is StopReason.CELL_LIMIT
    assert put.pending >= sum(found.pending for some in parts.values() for found in some)
