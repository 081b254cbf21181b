"""Tension limits on answers made by hand: kept, left out or open, and never left out in doubt."""

import json
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from solvers.answers.data import Answer, CableState, Certainty, Outcome, SubsetReport
from solvers.answers.limits import within_limits
from solvers.answers.result import Result
from solvers.forward import build_result
from solvers.questions.problem import Options, Problem
from tests.support import hanging_mass

TAUT, SLACK, SWITCHING, OPEN = CableState.TAUT, CableState.SLACK, CableState.SWITCHING, CableState.UNDECIDED


def entry(states, tensions, **changes):
    """Return an entry of the hanging mass with other cables and tensions."""
    taut = tuple(i for i, state in enumerate(states) if state is TAUT)
    respected = None if OPEN in states else True
    return replace(
        hanging_mass.solution(),
        taut=taut,
        cable_states=states,
        tensions=np.array(tensions, dtype=np.float64),
        slack_respected=respected,
        **changes,
    )


def asked(answer, lo, hi):
    """Return the result of an answer and limits, as `fk` makes it."""
    limits = (F(lo), F(hi))
    robot = hanging_mass.robot()
    problem = Problem(robot, tuple(hanging_mass.exact("2", "5")), tension=limits)
    return build_result(problem, Options(), within_limits(answer, limits), 0.5)


@pytest.mark.parametrize(
    ("states", "tensions", "limits", "expected"),
    [
        ((TAUT, SLACK), [(2, 3), (0, 0)], ("1", "4"), "kept"),
        ((TAUT, SLACK), [(2, 3), (0, 0)], ("2", "3"), "kept"),
        ((TAUT, SLACK), [(2, 3), (0, 0)], ("4", "5"), "out"),
        ((TAUT, SLACK), [(2, 3), (0, 0)], ("0", "1"), "out"),
        # The end itself is allowed: bounds that touch a limit from outside may hold a pose on it.
        ((TAUT, SLACK), [(2, 3), (0, 0)], ("3", "5"), "open"),
        ((TAUT, SLACK), [(2, 3), (0, 0)], ("0", "2"), "open"),
        ((TAUT, SLACK), [(2, 3), (0, 0)], ("2.5", "2.6"), "open"),
        ((TAUT, SLACK), [(2, np.inf), (0, 0)], ("1", "5"), "open"),
        ((TAUT, SLACK), [(6, np.inf), (0, 0)], ("1", "5"), "out"),
        # One cable inside, one outside.
        ((TAUT, TAUT), [(2, 3), (7, 8)], ("1", "4"), "out"),
        ((TAUT, TAUT), [(2, 5), (7, 8)], ("1", "4"), "out"),
        ((TAUT, TAUT), [(2, 5), (1, 2)], ("1", "4"), "open"),
        # A switching cable is slack for some choices, and then it has no tension.
        ((TAUT, SWITCHING), [(2, 3), (0, 1)], ("1", "4"), "open"),
        ((TAUT, SWITCHING), [(2, 3), (0, 0.5)], ("1", "4"), "open"),
        ((TAUT, SWITCHING), [(2, 3), (0, 1)], ("0", "4"), "kept"),
        ((TAUT, SWITCHING), [(7, 8), (0, 1)], ("0", "4"), "out"),
        # Nothing is known of an open cable, but the taut one decides.
        ((TAUT, OPEN), [(2, 3), (0, 1)], ("1", "4"), "open"),
        ((TAUT, OPEN), [(7, 8), (0, 1)], ("0", "4"), "out"),
        ((OPEN, OPEN), [(7, 8), (7, 8)], ("0", "4"), "open"),
        # A limit between the doubles 0.1 and its neighbours.
        ((TAUT, SLACK), [(0.1, 0.1), (0, 0)], ("0", "0.1"), "out"),
        ((TAUT, SLACK), [(0.1, 0.1), (0, 0)], ("0.1", "1"), "kept"),
    ],
)
def test_an_entry_is_kept_left_out_or_open(states, tensions, limits, expected):
    """0.1 as a double is above 1/10, as exact comparison knows."""
    answer = within_limits(Answer((entry(states, tensions),)), (F(limits[0]), F(limits[1])))
    if expected == "out":
        assert not answer.solutions
        assert answer.outcome is Outcome.COMPLETE
        assert answer.message == "no static pose within the tension limits; 1 static pose found outside them"
        return
    (solution,) = answer.solutions
    assert solution.tension_respected is (True if expected == "kept" else None)
    is_closed = expected == "kept" and OPEN not in states
    assert answer.outcome is (Outcome.COMPLETE if is_closed else Outcome.INCOMPLETE)


@pytest.mark.parametrize("name", ["existence", "uniqueness"])
def test_an_entry_that_is_not_proved_is_never_left_out(name):
    unproved = entry((TAUT, SLACK), [(7, 8), (0, 0)], note="why", **{name: Certainty.UNDECIDED})
    answer = within_limits(Answer((unproved,)), (F(1), F(4)))
    assert len(answer.solutions) == 1 and answer.outcome is Outcome.INCOMPLETE


def test_what_is_left_open_stays():
    """Regions, cells not looked at and reasons to stop are not touched."""
    before = hanging_mass.open_answer()
    after = within_limits(before, (F(1), F(2)))
    assert not after.solutions
    assert (after.undecided, after.pending, after.stop_reason) == (
        before.undecided,
        before.pending,
        before.stop_reason,
    )
    assert after.outcome is Outcome.INCOMPLETE


def test_subsets_say_what_is_open_of_them():
    reports = tuple(SubsetReport(taut, Outcome.COMPLETE, int(taut == (0,)), 7, 0.25) for taut in ((0,), (1,)))
    doubt = within_limits(Answer((entry((TAUT, SLACK), [(2, 3), (0, 0)]),), subsets=reports), (F(0), F(2)))
    assert [r.outcome for r in doubt.subsets] == [Outcome.INCOMPLETE, Outcome.COMPLETE]
    open_before = tuple(replace(r, outcome=Outcome.INCOMPLETE) for r in reports)
    gone = within_limits(Answer((entry((TAUT, OPEN), [(2, 3), (0, 9)]),), subsets=open_before), (F(0), F(1)))
    assert [r.outcome for r in gone.subsets] == [Outcome.COMPLETE, Outcome.COMPLETE]


def test_the_document_round_trips_and_is_in_agreement_with_itself():
    inside, doubt, out = (
        entry((TAUT, SLACK), [(lo, hi), (0, 0)], height=hanging_mass.around(-2.0 + k))
        for k, (lo, hi) in enumerate([(2, 3), (4, 6), (7, 8)])
    )
    reports = (SubsetReport((0,), Outcome.COMPLETE, 3, 7, 0.25),)
    result = asked(Answer((inside, doubt, out), subsets=reports), "1", "5")
    document = json.loads(result.to_json())
    assert document["question"]["tension_N"] == [1.0, 5.0]
    assert [s.get("tension_respected") for s in document["solutions"]] == [None, "undecided"]
    again = Result.from_json(result.to_json())
    assert [s.tension_respected for s in again.solutions] == [True, None]
    assert again.to_json() == result.to_json()
    mechanical = ("nominal", "listed twice", "one lies in the other's box")
    assert [c for c in again.verify() if not any(word in c for word in mechanical)] == []
    assert "tensions within 1..5 N only" in str(again)
    assert "within the tension limits undecided: c1" in str(again)
    assert "what helps: other --tension limits" in str(again)
    assert again.message == (
        "finished: 2 static poses proved; whether one pose is within the tension limits is open;"
        " 1 more pose found outside the tension limits"
    )


@pytest.mark.parametrize(
    ("tensions", "text"),
    [
        ((7.0, 8.0), "tensions_N[0]: outside the limits that were asked for"),
        ((4.0, 6.0), "tensions_N[0]: not proved to be within the limits that were asked for"),
    ],
)
def test_an_entry_that_breaks_the_limits_is_contradicted(tensions, text):
    wrong = entry((TAUT, SLACK), [tensions, (0, 0)])
    problem = Problem(hanging_mass.robot(), tuple(hanging_mass.exact("2", "5")), tension=(F(1), F(5)))
    result = build_result(problem, Options(), Answer((wrong,)), 0.5)
    assert any(text in line for line in result.verify())


def test_without_limits_nothing_is_said_of_them():
    document = asked(Answer((entry((TAUT, SLACK), [(2, 3), (0, 0)]),)), "1", "5").to_dict()
    del document["question"]["tension_N"]
    old = Result.from_json(document)
    assert old.question.tension is None and "limits" not in str(old)
