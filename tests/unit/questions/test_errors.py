"""Errors are shown all at once; those that say the same of different entries are counted."""

import pytest

from cdpr_interval import InputError
from solvers.questions.errors import InputErrors
from solvers.questions.lengths import read_lengths

NAMES = tuple(f"c{k}" for k in range(1, 9))


def shown(*messages: str) -> tuple[str, ...]:
    errors = InputErrors()
    for message in messages:
        errors.add(message)
    with pytest.raises(InputError) as caught:
        errors.require_none()
    return caught.value.messages


def test_five_of_a_kind_are_shown_and_the_rest_is_counted():
    errors = InputErrors()
    assert errors.read(read_lengths, ",".join("abcdefgh"), NAMES, "--lengths") is None
    with pytest.raises(InputError) as caught:
        errors.require_none()
    *first, last = caught.value.messages
    assert first == [f"--lengths[{k}]: '{'abcde'[k]}' is not a number" for k in range(5)]
    assert last == "--lengths: and 3 more like it"


def test_five_are_not_too_many_and_other_kinds_are_not_touched():
    alike = [f"--pose[{k}]: '{k}' has no unit: write {k}deg or {k}rad" for k in range(6)]
    other = ["--taut[0]: unknown cable 'c9'", "--lengths[1]: must be positive, got -1"]
    assert shown(*alike[:5], *other) == (*alike[:5], *other)
    assert shown(other[0], *alike, other[1]) == (
        other[0],
        *alike[:5],
        "--pose: and 1 more like it",
        other[1],
    )


def test_what_was_counted_before_is_not_counted_again():
    counted = [f"robot.yaml: and {k} more like it" for k in range(2, 9)]
    assert shown(*counted) == tuple(counted)


def test_errors_of_different_options_are_of_different_kinds():
    messages = [f"--{name}: must be a positive number, got -1" for name in "abcdefg"]
    assert shown(*messages) == tuple(messages)
