"""Spellings of cable lengths, and every way they can be wrong."""

import time
from decimal import Decimal
from fractions import Fraction as F

import numpy as np
import pytest

from cdpr_interval import InputError
from solvers.questions.lengths import read_lengths

NAMES = ("c1", "c2", "c3")


def messages(given: object) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        read_lengths(given, NAMES, "--lengths")
    return caught.value.messages


@pytest.mark.parametrize(
    ("text", "lo", "hi"),
    [
        ("2.69", F(269, 100), F(269, 100)),
        ("0.1", F(1, 10), F(1, 10)),
        ("1e-3", F(1, 1000), F(1, 1000)),
        (".5E1", F(5), F(5)),
        ("2.69+-0.01", F(268, 100), F(270, 100)),
        ("2.69 ± 0.01", F(268, 100), F(270, 100)),
        ("2.69+/-0.01", F(268, 100), F(270, 100)),
        ("2690mm", F(269, 100), F(269, 100)),
        ("2.69 m +- 10 mm", F(268, 100), F(270, 100)),
        ("268cm..2700mm", F(268, 100), F(270, 100)),
        ("[2680mm,2.7m]", F(268, 100), F(270, 100)),
        ("1e-1+-1e-2", F(9, 100), F(11, 100)),
        ("2.68..2.70", F(268, 100), F(270, 100)),
        ("[2.68,2.70]", F(268, 100), F(270, 100)),
        ("[ 2.68 , 2.70 ]", F(268, 100), F(270, 100)),
    ],
)
def test_every_spelling_is_read_exactly_in_each_form(text, lo, hi):
    assert read_lengths(f"{text},1,{text}", NAMES) == ((lo, hi), (F(1), F(1)), (lo, hi))
    assert read_lengths(f"c3={text},c1 = {text}, c2=1", NAMES) == ((lo, hi), (F(1), F(1)), (lo, hi))
    assert read_lengths([text, 1, text], NAMES)[2] == (lo, hi)


def test_the_whole_list_may_stand_in_brackets():
    lengths = read_lengths("1,2,3..4", NAMES)
    for text in ("[1,2,3..4]", " [1, 2, [3,4]] ", "(1,2,3..4)", "[c1=1,c3=3..4,c2=2]"):
        assert read_lengths(text, NAMES) == lengths
    assert read_lengths("[1,2]", NAMES[:2]) == read_lengths("1,2", NAMES[:2])
    assert read_lengths("[1,2],[3,4]", NAMES[:2]) == ((1, 2), (3, 4))
    assert read_lengths("[1,2]", NAMES[:1]) == ((1, 2),), "of one cable it is a range"


@pytest.mark.parametrize(
    ("value", "lo", "hi"),
    [
        (0.1, F(0.1), F(0.1)),
        (3, F(3), F(3)),
        (Decimal("0.1"), F(1, 10), F(1, 10)),
        (F(1, 3), F(1, 3), F(1, 3)),
        (np.float64(0.1), F(0.1), F(0.1)),
        (np.float32(0.5), F(1, 2), F(1, 2)),
        (np.int64(2), F(2), F(2)),
        ((1, "1.5"), F(1), F(3, 2)),
        ([0.5, F(2, 3)], F(1, 2), F(2, 3)),
        (np.array([0.5, 0.75]), F(1, 2), F(3, 4)),
    ],
)
def test_python_values_are_the_exact_numbers_they_are(value, lo, hi):
    assert read_lengths([value, 1, 1], NAMES)[0] == (lo, hi)
    assert read_lengths({"c2": value, "c1": 1, "c3": 1}, NAMES)[1] == (lo, hi)


def test_arrays_are_sequences():
    assert read_lengths(np.array([1.0, 2.0, 0.1]), NAMES) == tuple((F(x), F(x)) for x in (1.0, 2.0, 0.1))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2,abc", "--lengths[2]: 'abc' is not a number"),
        ("1,,3", "--lengths[1]: '' is not a number"),
        ("1,0,3", "--lengths[1]: must be positive, got 0"),
        ("1,-2.5,3", "--lengths[1]: must be positive, got -2.5"),
        ("1,nan,3", "--lengths[1]: 'nan' is not a finite number"),
        ("1,inf,3", "--lengths[1]: 'inf' is not a finite number"),
        ("1,-.inf,3", "--lengths[1]: '-.inf' is not a finite number"),
        ("1,2_0,3", "--lengths[1]: '2_0' is not a number"),
        ("1,1/3,3", "--lengths[1]: '1/3' is not a number"),
        ("1,2+-3,3", "--lengths[1]: must be positive over its whole range, got -1"),
        ("1,2+--0.1,3", "--lengths[1]: the tolerance of '2+--0.1' is negative"),
        ("1,2+/--0.1,3", "--lengths[1]: the tolerance of '2+/--0.1' is negative"),
        ("1,2000+-1mm,3", "--lengths[1]: in '2000+-1mm' one number has a unit: give both one, or none"),
        ("1,2.6..2.7m,3", "--lengths[1]: in '2.6..2.7m' one number has a unit: give both one, or none"),
        ("1,20in,3", "--lengths[1]: '20in' is not a number (units are m, cm, mm)"),
        ("1,20deg,3", "--lengths[1]: '20deg' is an angle, not a length"),
        ("1,2.7..2.6,3", "--lengths[1]: the lower bound 2.7 is above the upper bound 2.6"),
        ("1,[2.7,2.6],3", "--lengths[1]: the lower bound 2.7 is above the upper bound 2.6"),
        ("1,[2.7],3", "--lengths[1]: '[2.7]' is not a range [lo,hi]"),
        ("1,2", "--lengths: 2 lengths for 3 cables (c1, c2, c3)"),
        ("1", "--lengths: 1 length for 3 cables (c1, c2, c3)"),
        ("1,2,3,4", "--lengths: 4 lengths for 3 cables (c1, c2, c3)"),
        ("c1=1,c2=x,c3=3", "--lengths[c2]: 'x' is not a number"),
        ("c1=1,c2=2", "--lengths: no length for c3"),
        ("c1=1,c2=2,c3=3,c1=1", "--lengths: cable 'c1' is given twice"),
        ("c1=1,2,c2=2,c3=3", "--lengths[1]: '2' has no name although others have"),
    ],
)
def test_the_message_names_option_entry_and_value(text, message):
    assert messages(text) == (message,)


def test_unknown_cable():
    assert messages("c1=1,c2=2,c33=3") == (
        "--lengths: unknown cable 'c33' (did you mean 'c3'?)",
        "--lengths: no length for c3",
    )


def test_all_errors_are_reported_at_once():
    assert len(messages("abc,-1,nan,7")) == 4


@pytest.mark.parametrize("text", ["1e999999999", "1e-999999999", "9" * 5000, "0x" + "f" * 5000])
def test_absurd_numbers_are_refused_at_once(text):
    start = time.process_time()
    (message,) = messages(f"1,2,{text}")
    assert message.startswith("--lengths[2]: ") and len(message) < 200
    # Not a measurement: building 10**999999999 would take minutes.
    assert time.process_time() - start < 20.0


@pytest.mark.parametrize(
    "value", [Decimal("1e999999999"), float("nan"), float("inf"), True, None, (1, 2, 3), object()]
)
def test_python_values_that_are_no_lengths(value):
    (message,) = messages([1, 2, value])
    assert message.startswith("--lengths[2]: ")


@pytest.mark.parametrize("given", [3.0, None])
def test_not_a_list(given):
    assert messages(given) == (f"--lengths: must be a list with one length per cable, got {given!r}",)
