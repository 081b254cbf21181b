"""Claims of an entry, counts of a message and of subsets: written, read, contradicted if they are wrong."""

import json
from dataclasses import replace

import numpy as np
import pytest

from solvers.answers.data import Answer, CableState, Certainty, Outcome, Proof, SubsetReport
from solvers.answers.message import message_of
from solvers.answers.result import Result
from solvers.batch.answer import answer_text, result_document
from tests.support import hanging_mass
from tests.support.hanging_mass import around
from tests.unit.answers.test_result import result_of

OPEN = {"existence": Certainty.UNDECIDED, "note": "for some lengths there may be no pose"}


def switching(**changes):
    entry = hanging_mass.solution()
    tensions = entry.tensions.copy()
    tensions[1] = 0.0, 1e-9
    distances = entry.distances.copy()
    distances[1] = 5.0 - 1e-9, 5.0 + 1e-9
    states = (CableState.TAUT, CableState.SWITCHING)
    return replace(entry, cable_states=states, tensions=tensions, distances=distances, **changes)


def answer_of(*solutions, **more):
    return Answer(solutions, **more)


def test_claims_round_trip():
    entry = replace(switching(), existence=Certainty.UNDECIDED, uniqueness=Certainty.UNDECIDED, note="why")
    text = result_of(answer_of(entry)).to_json()
    document = json.loads(text)["solutions"][0]
    assert document["existence"] == document["uniqueness"] == "undecided"
    assert document["cable_states"] == ["taut", "switching"]
    (again,) = Result.from_json(text).solutions
    assert (again.existence, again.uniqueness) == (Certainty.UNDECIDED, Certainty.UNDECIDED)
    assert again.cable_states == (CableState.TAUT, CableState.SWITCHING)
    assert not again.is_proved and not again.is_decided and not again.has_open_cable
    assert Result.from_json(text).to_json() == text


def test_a_switching_cable_leaves_nothing_open():
    answer = answer_of(switching())
    assert answer.outcome is Outcome.COMPLETE
    assert result_of(answer).message == "1 static pose, proved to be all"
    assert not switching().is_strict and switching().is_decided


@pytest.mark.parametrize(
    ("entries", "more", "text"),
    [
        ([{}], {}, "1 static pose, proved to be all"),
        ([OPEN], {}, "finished: 0 static poses proved; besides, 1 open entry"),
        ([{}, OPEN, OPEN], {}, "finished: 1 static pose proved; besides, 2 open entries"),
        (
            [{}, OPEN, {"slack_respected": None}],
            {"pending": 3},
            "finished: 2 static poses proved, 1 of them with an undecided cable; besides, 1 open entry, "
            "3 cells not looked at",
        ),
        ([{}], {"message": "and more"}, "1 static pose, proved to be all; and more"),
    ],
)
def test_the_message_counts_proved_poses_and_open_entries_apart(entries, more, text):
    solutions = [replace(hanging_mass.solution(), **changes) for changes in entries]
    answer = answer_of(*solutions, **more)
    assert message_of(answer) == text
    assert not any("message" in found for found in result_of(answer).verify())


@pytest.mark.parametrize(
    ("message", "complaint"),
    [
        ("2 static poses, proved to be all", "counts 2 proved poses, the entries 1"),
        ("0 static poses, proved to be all", "counts 0 proved poses, the entries 1"),
        (
            "finished: 1 static pose proved",
            "says that something is open although the outcome is complete",
        ),
    ],
)
def test_a_wrong_count_of_a_complete_result(message, complaint):
    result = result_of(hanging_mass.answer())
    assert replace(result, message=message).verify() == [f"message: {complaint}"]
    assert replace(result, message="other words").verify() == []


@pytest.mark.parametrize(
    ("message", "complaint"),
    [
        ("finished: 2 static poses proved", "counts 2 proved poses, the entries 1"),
        ("finished: 1 static pose proved", "counts 0 open entries, there are 1"),
        ("finished: 1 static pose proved; besides, 3 open entries", "counts 3 open entries, there are 1"),
        # As it was worded before.
        ("finished: 1 static pose proved, 3 open entries", "counts 3 open entries, there are 1"),
        ("2 static poses, proved to be all", "says 'proved to be all' although the outcome is incomplete"),
    ],
)
def test_a_wrong_count_of_an_open_result(message, complaint):
    other = replace(hanging_mass.solution(), position=around([0.0, 0.0, -1.9999999]), **OPEN)
    result = result_of(answer_of(hanging_mass.solution(), other))
    assert replace(result, message=message).verify() == [f"message: {complaint}"]


@pytest.mark.parametrize(
    ("taut", "count", "complaint"),
    [
        ((0,), 0, "solutions: 0, but 1 entry with exactly these taut"),
        ((0,), 2, "solutions: 2, but only 1 entry with these taut"),
        ((1,), 1, "solutions: 1, but no entry with these cables taut"),
        ((0, 1), -1, "solutions: -1, but no entry with these cables taut"),
    ],
)
def test_wrong_counts_of_subsets(taut, count, complaint):
    report = SubsetReport(taut, Outcome.COMPLETE, count, 0, 0.0)
    result = result_of(answer_of(hanging_mass.solution(), subsets=(report,)))
    assert result.verify() == [f"subsets[0]: {complaint}"]
    twice = result_of(
        answer_of(hanging_mass.solution(), subsets=(replace(report, taut=(0,), solutions=1),) * 2)
    )
    assert twice.verify() == ["subsets[1]: listed before"]


def test_subsets_that_share_an_entry_contradict_nothing():
    rows = tuple(SubsetReport(taut, Outcome.COMPLETE, 1, 0, 0.0) for taut in ((0,), (0, 1)))
    assert result_of(answer_of(switching(), subsets=rows)).verify() == []


def test_one_pose_listed_twice():
    one = hanging_mass.solution()
    wider = replace(one, position=around([0.0, 0.0, -2.0], 1e-8))
    result = result_of(answer_of(one, wider))
    assert result.verify() == [
        "solutions[0] and [1]: one lies in the other's box, which is said to hold one pose"
    ]
    alone = replace(result, question=replace(result.question, ignore_slack=True))
    assert alone.verify() == []
    assert result_of(answer_of(one, replace(wider, **OPEN))).verify() == []


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        (
            {"existence": Certainty.UNDECIDED, "note": "why"},
            "cable_states[1]: 'switching' although exactly one pose is not proved",
        ),
        (
            {"tensions": np.array([[98.0, 99.0], [0.5, 1.0]])},
            "tensions_N[1]: positive for all lengths although the cable is switching",
        ),
        (
            {"distances": around([2.0, 4.0])},
            "distances_m[1]: shorter than the cable for all lengths although it is switching",
        ),
    ],
)
def test_a_switch_that_is_none(changes, complaint):
    assert result_of(answer_of(replace(switching(), **changes))).verify() == [f"solutions[0]: {complaint}"]


def test_an_open_entry_says_why():
    entry = replace(hanging_mass.solution(), uniqueness=Certainty.UNDECIDED)
    assert result_of(answer_of(entry)).verify() == [
        "solutions[0]: existence, uniqueness: undecided without a reason in the note"
    ]
    assert result_of(answer_of(replace(entry, note="there may be two"))).verify() == []


def test_a_root_over_ranges_is_a_pose_only_where_its_cables_are_decided():
    states = (CableState.TAUT, CableState.UNDECIDED)
    entry = replace(hanging_mass.solution(), cable_states=states, proof=Proof.INTERVAL_NEWTON)
    exact = replace(result_of(answer_of(entry)), model="six-dof")
    result = replace(exact, lengths=np.array([[1.9, 2.1], [5.0, 5.0]]))
    complaint = "existence, uniqueness: proved although cable_states[1] is undecided over ranges"
    assert result.verify() == [f"solutions[0]: {complaint}"]
    assert replace(result, model="point-mass").verify() == []
    assert exact.verify() == []


def test_a_ledger_keeps_claims_that_are_not_the_usual_ones():
    for entry in (hanging_mass.solution(), switching(), replace(hanging_mass.solution(), **OPEN)):
        result = result_of(answer_of(entry))
        document = result.to_dict()
        kept = json.loads(answer_text(result))
        again = result_document(
            kept, hanging_mass.robot(), *(document[key] for key in ("question", "tool", "provenance"))
        )
        assert again["solutions"] == document["solutions"]
        assert ("existence" in kept["solutions"][0]) is (not entry.is_proved)
