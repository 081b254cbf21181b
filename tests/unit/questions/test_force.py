"""External forces as users write them: numbers and ranges."""

from __future__ import annotations

from fractions import Fraction as F

import pytest

from cdpr_interval import InputError
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers.questions.force import MAY_CANCEL, NO_LOAD, no_load, read_force, read_force_ranges

RANGE = Range(F("0.9"), F("1.1"))


@pytest.mark.parametrize(
    "text",
    [
        "1N+-0.1N,2,3",
        "0.9 N .. 1.1 N 2N 3",
        "[0.9N, 0.0011 kN],2,3",
        "[1+-0.1,2,3]",
        "0.9..1.1, 2, 3",
        "[0.9,1.1],2,3",
        "[0.9, 1.1] 2 3",
        "1 +/- 0.1, 2, 3",
        "0.9 .. 1.1 2 3",
    ],
)
def test_a_range_is_written_as_those_of_lengths_are(text: str) -> None:
    assert read_force_ranges(text) == (RANGE, 2, 3)


def test_python_gives_pairs() -> None:
    assert read_force_ranges([("0.9", "1.1"), 2, (3, 3)]) == (RANGE, 2, 3)
    assert read_force([1, "2", 0.5]) == (1, 2, F(1, 2)) == read_force("1, 2, 0.5")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1+--0.1,2,3", "--external-force[0]: the tolerance of '1+--0.1' is negative"),
        ("3..1,2,3", "--external-force[0]: the lower bound 3 is above the upper bound 1"),
        ("1,2", "--external-force: must hold 3 numbers, got 2"),
        ("1,[2,3,4],5", "--external-force[1]: '[2,3,4]' is not a range [lo,hi]"),
        ("1,a..b,5", "--external-force[1]: 'a' is not a number"),
    ],
)
def test_what_is_no_range_is_said(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_force_ranges(text, "--external-force")
    assert caught.value.messages == (message,)


def test_what_takes_numbers_only_names_the_range() -> None:
    with pytest.raises(InputError, match=r"^f\[1\]: must be one number here, got a range$"):
        read_force("1,2..3,4", "f")


def test_a_load_may_vanish_within_its_ranges() -> None:
    robot = Robot("r", Platform(1), [Cable("c1", (0, 0, 3), (0, 0, 0))], (0, 0, -10))
    assert no_load(loaded(robot)) is None
    assert no_load(loaded(robot, (F(0), F(0), F(10)))) == NO_LOAD
    assert no_load(loaded(robot, (F(0), F(0), Range(F(9), F(11))))) == MAY_CANCEL
    assert no_load(loaded(robot, (F(0), F(1), Range(F(9), F(11))))) is None
