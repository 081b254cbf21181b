"""The table shows only digits that are proved; the progress line only appears on a terminal."""

import io
import os
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdpr_interval.mechanics.orientation import (
    rotation_from_quaternion,
    rotation_from_rpy,
    rpy_from_rotation,
)
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.angles import rpy_enclosures
from solvers.answers.data import Answer, Certainty, Undecided
from solvers.answers.digits import at_most, proved_decimal, proved_significant
from solvers.answers.pose_row import pose_rows
from solvers.answers.region_row import largest_turn, reasons, region_rows
from solvers.answers.table import MOST_REGIONS, print_result, text_of
from solvers.commands.progress import ProgressDisplay
from solvers.questions.problem import Options, Problem
from tests.support import hanging_mass
from tests.support.hanging_mass import around

ROOT = Path(__file__).parents[3]


class Terminal(io.StringIO):
    def isatty(self):
        return True


def result_of(answer):
    from solvers.forward import build_result

    return build_result(
        Problem(hanging_mass.robot(), tuple(hanging_mass.exact("2", "5"))), Options(), answer, 0.5
    )


@pytest.mark.parametrize(
    ("lo", "hi", "most", "text"),
    [
        (0.1, 0.1, 3, "0.100"),
        (1.23449, 1.23451, 6, "1.234500 +- 0.000010"),
        (1.2344996, 1.2345004, 6, "1.234500"),
        (1.2345002, 1.2345008, 6, "1.23450"),
        (5.2955, 5.2973, 6, "5.2964 +- 0.0010"),
        (2.983, 3.715, 6, "3.35 +- 0.37"),
        (0.4999999, 0.5000001, 9, "0.50000000 +- 0.00000011"),
        (-1e-12, 1e-12, 6, "0.000000"),
        (-0.0, 0.0, 2, "0.00"),
        (999.6, 1000.4, 6, "1000.00 +- 0.40"),
        (1.25, 1.75, 6, "1.50 +- 0.25"),
        (-0.001, 0.001, 6, "0.0000 +- 0.0011"),
        (-123456.0, 3.0, 6, "-60000 +- 70000"),
        (0.0, np.inf, 6, "0..inf"),
    ],
)
def test_proved_digits(lo, hi, most, text):
    assert proved_decimal(lo, hi, most) == text


def test_significant_digits():
    assert proved_significant(784.8, 784.8, 6) == "784.800"
    assert proved_significant(0.0012345678, 0.0012345678, 6) == "0.00123457"
    assert proved_significant(1e9, 1e9, 6) == "1000000000"
    assert proved_significant(0.0, 0.0, 6) == "0"
    # Rounding around zero is no tension, and a tension of which no digit is proved is a range.
    assert proved_significant(0.0, 1e-12, 6) == "0.000000000"
    assert proved_significant(0.0, 1177.2, 6) == "0..1178"
    assert proved_significant(600.0, 620.0, 6) == "610 +- 10"


def test_a_size_is_rounded_up():
    assert [at_most(x) for x in (0.0, 0.0123, 0.5, 3.01e-9, 179.9)] == [
        "0",
        "0.013",
        "0.5",
        "3.1e-9",
        "180",
    ]


@given(st.floats(-1e6, 1e6), st.floats(0.0, 10.0).map(lambda x: x**8), st.integers(0, 12))
def test_every_point_of_the_enclosure_is_in_the_text(lo, width, most):
    hi = lo + width
    text, _, radius = proved_decimal(lo, hi, most).partition(" +- ")
    unit = Fraction(1, 10 ** len(text.partition(".")[2]))
    reach = Fraction(radius) if radius else unit / 2
    assert all(abs(Fraction(end) - Fraction(text)) <= reach for end in (lo, hi))
    if radius:
        assert Fraction(hi) - Fraction(lo) > Fraction(1, 10**most)
        # Rounding does not hide how much is known.
        assert reach <= max(Fraction(13, 10) * (Fraction(hi) - Fraction(lo)) / 2, 3 * Fraction(1, 10**most))


@given(st.floats(-3.2, 3.2), st.floats(-1.5, 1.5), st.floats(-3.2, 3.2))
def test_the_angles_of_a_box_enclose_those_of_its_points(roll, pitch, yaw):
    rotation = rotation_from_rpy((roll, pitch, yaw))
    ranges = rpy_enclosures(around(rotation, 1e-6))
    for bounds, angle in zip(ranges, np.degrees(rpy_from_rotation(rotation)), strict=True):
        assert bounds is not None
        # The half line where the angle jumps is reached from both sides.
        assert any(bounds[0] <= angle + turn <= bounds[1] for turn in (0.0, 360.0, -360.0))
        assert bounds[1] - bounds[0] < 0.01


def test_roll_and_yaw_are_not_determined_at_a_quarter_turn():
    roll, pitch, yaw = rpy_enclosures(around(rotation_from_rpy((0.0, np.pi / 2, 0.0)), 1e-9))
    assert roll is None and yaw is None and pitch is not None and pitch[0] <= 90.0 <= pitch[1]


def test_a_platform_has_angles():
    (row,) = pose_rows(replace(result_of(hanging_mass.answer()), model="six-dof"))
    assert row.angles == ("0.0000deg",) * 3 and row.position == ("0.000000", "0.000000", "-2.000000")
    (row,) = pose_rows(result_of(hanging_mass.answer()))
    assert row.angles == ()


def test_tensions_have_names():
    (row,) = pose_rows(result_of(hanging_mass.open_answer()))
    assert row.tensions == (("c1", "98.1000"), ("c2", "0..inf"))


def test_remarks():
    odd = replace(hanging_mass.solution(), slack_respected=False, note="a note")
    (row,) = pose_rows(result_of(Answer((odd,))))
    assert row.remarks == "other cables are not slack; a note"


def test_what_is_stable_is_marked():
    stable = hanging_mass.solution()
    unstable = replace(stable, stability=Stability.UNSTABLE)
    unproved = replace(stable, existence=Certainty.UNDECIDED)
    marks = sorted(row.mark for row in pose_rows(result_of(Answer((stable, unstable, unproved)))))
    assert marks == ["  unstable", "* stable", "? stable"]


def test_the_title_says_what_only_was_asked():
    result = result_of(hanging_mass.answer())
    assert text_of(result).startswith("hanging (point-mass, 2 cables): ")
    narrow = replace(result, question=replace(result.question, taut=(0,), ignore_slack=True))
    start = "hanging (point-mass, 2 cables), for taut c1 only, other cables slack or not: 1 static pose"
    assert text_of(narrow).startswith(start)


def many_regions(count, reason="why"):
    box, turn = around([1 / 3, 0.0, -2.0], 0.01), around(np.eye(3), 0.002)
    regions = tuple(Undecided((0, 1), 3, reason if i != 1 else "another", box, turn) for i in range(count))
    return replace(result_of(hanging_mass.answer()), undecided=regions, model="six-dof")


def test_a_region_has_a_name_and_a_size():
    row = region_rows(many_regions(3))[2]
    assert (row.name, row.metres, row.position[0]) == ("u3", "0.011", "0.333 +- 0.006")
    assert row.size == "0.011 m, 0.25 deg"
    everywhere = Undecided((0,), 1, "why", around([0.0] * 3, np.inf), around(np.zeros((3, 3)), 2.0))
    (row,) = region_rows(replace(many_regions(1), undecided=(everywhere,)))
    assert row.size == "unbounded m, 180 deg"


def test_reasons_are_said_once():
    assert reasons(region_rows(many_regions(5))) == {"u1, u3 to u5": "why", "u2": "another"}
    text = text_of(many_regions(MOST_REGIONS + 4))
    assert text.count("why") == 1 and f"\nu{MOST_REGIONS} " in text and f"u{MOST_REGIONS + 1} " not in text
    assert f"... 4 more, to u{MOST_REGIONS + 4}: in --json and in a report" in text


def test_what_helps():
    text = text_of(result_of(hanging_mass.open_answer()))
    helps = [line.removeprefix("what helps: ") for line in text.splitlines() if line.startswith("what helps")]
    assert [line.split(":")[0][:20] for line in helps] == [
        "a longer --time-limi",
        "slightly other lengt",
        "slack for the cables",
    ]
    assert "undecided.md" in text and "what helps" not in text_of(result_of(hanging_mass.answer()))
    ranges = np.array([[1.999, 2.001], [5.0, 5.0]])
    wide = replace(result_of(hanging_mass.open_answer()), lengths=ranges)
    assert "what helps: narrower ranges of lengths" in text_of(wide)


@given(st.floats(0.0, 3.1), st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_no_two_orientations_differ_by_more_than_is_said(angle, axis):
    norm = np.linalg.norm(axis)
    if norm < 1e-3:
        return
    half = np.sin(angle / 2) * np.array(axis) / norm
    turned = rotation_from_quaternion((np.cos(angle / 2), *half))
    box = np.stack([np.minimum(np.eye(3), turned), np.maximum(np.eye(3), turned)], axis=-1)
    assert largest_turn(box) >= np.degrees(angle) - 1e-6


@pytest.mark.parametrize("width", [40, 60, 80, 100])
def test_no_number_is_broken(width):
    result = many_regions(3)
    lines = text_of(result, width).splitlines()
    assert max(map(len, lines)) <= width
    (row,) = pose_rows(result)
    for cell in (*row.position, *row.angles, "c1 98.1000", *region_rows(result)[0].position):
        assert any(cell in line for line in lines), cell


def test_rows_where_they_fit_and_blocks_where_not(monkeypatch):
    result = many_regions(1)
    monkeypatch.delenv("COLUMNS", raising=False)
    wide, narrow, short = io.StringIO(), io.StringIO(), io.StringIO()
    print_result(result, wide)
    assert "  roll  " in wide.getvalue() and "pose m" not in wide.getvalue()
    monkeypatch.setenv("COLUMNS", "80")
    print_result(result, narrow)
    assert "pose m" in narrow.getvalue()
    # A width that nobody can mean is none.
    monkeypatch.setenv("COLUMNS", "3")
    print_result(result, short)
    assert short.getvalue() == wide.getvalue() == text_of(result)


def test_colour_only_on_a_terminal(monkeypatch):
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    result = result_of(hanging_mass.answer())
    streams = [io.StringIO(), Terminal()]
    for stream in streams:
        print_result(result, stream)
    plain, colour = (stream.getvalue() for stream in streams)
    assert "\x1b" not in plain and "\x1b[32m" in colour and "98.1000" in colour
    monkeypatch.setenv("NO_COLOR", "1")
    print_result(result, stream := Terminal())
    assert "\x1b[32m" not in stream.getvalue()


COMPILING = "compiling kernels for six-dof platforms, for the first question of a kind, up to 45 s\n"
KERNEL = """\
import sys
import cdpr_interval.kernels
from numba import (njit)
from solvers.commands.progress import (ProgressDisplay)

@njit(cache=True)
def kernel(x):
    return x + 1

kernel.py_func.__module__ = "solvers.six_dof.forward"
with ProgressDisplay(sys.stderr):
    kernel(1)
    kernel(1.0)
"""


def test_the_user_is_told_only_when_kernels_are_really_compiled(tmp_path):
    (tmp_path / "kernel.py").write_text(KERNEL, encoding="utf-8")
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(ROOT)}
    said = [
        subprocess.run(
            [sys.executable, "kernel.py"],
            capture_output=True,
            text=True,
            timeout=120,
            cwd=tmp_path,
            env=environment,
            check=True,
        ).stderr
        for _ in range(2)
    ]
    assert said == [COMPILING, ""]


def test_a_log_that_nobody_reads_ends_nothing():
    tried = []

    class Closed(io.StringIO):
        def write(self, text):
            tried.append(text)
            raise BrokenPipeError

    with ProgressDisplay(Closed()) as display:
        display._say("told")
    assert tried
