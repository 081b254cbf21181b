"""The reader of problem files."""

from fractions import Fraction as F

import pytest

from cdpr_interval import InputError
from cdpr_interval.exact.range import Range
from solvers.questions.problem_file import read_problem_file

NAMES = ("c1", "c2")


def read(tmp_path, text):
    path = tmp_path / "p.yaml"
    path.write_text(text, encoding="utf-8")
    return read_problem_file(path, NAMES)


@pytest.mark.parametrize(
    "lengths",
    [
        "[1.5, 2.68..2.70]",
        "[1.5, [2.68, 2.70]]",
        "['1.5', 2.69+-0.01]",
        "{c2: 2.69+-0.01, c1: 1.5}",
        "{c1: 1.5, c2: {value: 2.69, tolerance: 0.01}}",
    ],
)
def test_spellings(tmp_path, lengths):
    text = f"format: cdpr-problem/1\nlengths_m: {lengths}\nexternal_force_N: [0, 1e-1, -3]\nx_note: 7\n"
    ranges, force = read(tmp_path, text)
    assert ranges == ((F(3, 2), F(3, 2)), (F(268, 100), F(27, 10)))
    assert force == (F(0), F(1, 10), F(-3))


def test_a_force_may_have_ranges(tmp_path):
    entries = "[[1, 2], {value: 1, tolerance: 0.5}, 3+-1]"
    force = read(tmp_path, f"format: cdpr-problem/1\nlengths_m: [1, 2]\nexternal_force_N: {entries}\n")[1]
    assert force == ((F(1), F(2)), (F(1, 2), F(3, 2)), (F(2), F(4)))
    assert all(isinstance(entry, Range) for entry in force)


def test_json_without_a_force(tmp_path):
    ranges, force = read(tmp_path, '{"format": "cdpr-problem/1", "lengths_m": [1, 2]}')
    assert ranges == ((F(1), F(1)), (F(2), F(2))) and force is None


def test_a_cable_may_be_called_like_a_free_key(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("format: cdpr-problem/1\nlengths_m: {x_1: 1, notes: 2..3}\n", encoding="utf-8")
    assert read_problem_file(path, ("x_1", "notes"))[0] == ((F(1), F(1)), (F(2), F(3)))
    path.write_text("format: cdpr-problem/1\nlengths_m: {x_1: 1, notes: -2}\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"2:28: lengths_m.notes: must be positive, got -2"):
        read_problem_file(path, ("x_1", "notes"))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("lengths_m: [1, abc]", "2:16: lengths_m[1]: 'abc' is not a number"),
        ("lengths_m: [1, -1]", "2:16: lengths_m[1]: must be positive, got -1"),
        ("lengths_m: [1]", "2:12: lengths_m: 1 length for 2 cables (c1, c2)"),
        ("lengths_m: {c1: 1, c3: 2, c2: 3}", "2:12: lengths_m: unknown cable 'c3'"),
        ("lengths_m: {c1: 1}", "2:12: lengths_m: no length for c2"),
        ("lengths_m: {c1: 1, c2: 0}", "2:24: lengths_m.c2: must be positive, got 0"),
        ("lengths_m: 3", "2:12: lengths_m: must be a list, or a mapping from cable to length, got 3"),
        ("lengths_m: [1, 2]\nlenghts: 3", "3:1: lenghts: unknown key"),
        ("external_force_N: [0, 0, 1]", "1:1: lengths_m: missing"),
        (
            "lengths_m: [1, 2]\nexternal_force_N: [0, 1]",
            "3:19: external_force_N: must be a list of 3 numbers",
        ),
        ("lengths_m: [1, 2]\nexternal_force_N: [0, 1, x]", "3:26: external_force_N[2]: 'x' is not a number"),
        (
            "lengths_m: [1, 2]\nexternal_force_N: [0, [3, 1], 1]",
            "3:23: external_force_N[1]: the lower bound 3 is above the upper bound 1",
        ),
        (
            "lengths_m: [1, 2]\nexternal_force_N: [{value: 1, tolerance: -1}, 0, 1]",
            "3:20: external_force_N[0]: the tolerance is negative",
        ),
        (
            "lengths_m: [1, 2]\nexternal_force_N: [0, 1, {value: 1}]",
            "3:26: external_force_N[2]: must be a number or a range such as [4, 6], got a mapping",
        ),
        ("lengths_m: [1, .nan]", "2:16: lengths_m[1]: '.nan' is not a finite number"),
        (
            "lengths_m: [1, [1, 2, 3]]",
            "2:16: lengths_m[1]: must be a length such as 2.69, 2.69+-0.01 or [2.68, 2.70], got a list of 3",
        ),
    ],
)
def test_errors_name_place_and_rule(tmp_path, body, message):
    with pytest.raises(InputError) as caught:
        read(tmp_path, "format: cdpr-problem/1\n" + body + "\n")
    assert any(line.startswith(f"{tmp_path / 'p.yaml'}:{message}") for line in caught.value.messages), (
        caught.value
    )


@pytest.mark.parametrize("text", ["format: cdpr-robot/1\nname: r\n", "lengths_m: [1, 2]\n", "[1, 2]\n"])
def test_another_format(tmp_path, text):
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert len(caught.value.messages) == 1


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_problem_file(tmp_path / "none.yaml", NAMES)
