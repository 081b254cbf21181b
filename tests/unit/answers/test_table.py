"""The table shows only digits that are proved; the progress line only appears on a terminal."""

import io
import logging
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
from numba import njit

from cdpr_interval.mechanics.orientation import rotation_from_rpy, rpy_from_rotation
from solvers.answers.angles import rpy_enclosures
from solvers.answers.data import Answer
from solvers.answers.digits import proved_decimal, proved_significant
from solvers.answers.table import print_result, table
from solvers.commands.progress import ProgressDisplay
from solvers.questions.problem import Options, Problem, Progress
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
        (1.23449, 1.23451, 6, "1.2345"),
        (0.4999999, 0.5000001, 9, "0.500000"),
        (-1e-12, 1e-12, 6, "0.000000"),
        (-0.0, 0.0, 2, "0.00"),
        (999.6, 1000.4, 6, "1000"),
        (1.25, 1.75, 6, "1.25..1.75"),
        (0.1, 3.0, 6, "0.1..3"),
        (1 / 3, 7.0, 6, "0.3333..7"),
        (-123456.0, 3.0, 6, "-123500..3"),
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


@given(st.floats(-1e6, 1e6), st.floats(0.0, 1.0).map(lambda x: x**8), st.integers(0, 12))
def test_every_point_of_the_enclosure_rounds_to_the_text(lo, width, most):
    hi = lo + width
    text = proved_decimal(lo, hi, most)
    if ".." in text:
        low, high = (Fraction(end) for end in text.split(".."))
        assert low <= Fraction(lo) and Fraction(hi) <= high
    else:
        half = Fraction(1, 2 * 10 ** len(text.partition(".")[2]))
        assert all(abs(Fraction(end) - Fraction(text)) <= half for end in (lo, hi))


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
    head, rows = table(replace(result_of(hanging_mass.answer()), model="six-dof"))
    assert head[6:9] == ["roll deg", "pitch deg", "yaw deg"] and rows[0][6:9] == ["0.0000"] * 3


def test_remarks():
    odd = replace(hanging_mass.solution(), slack_respected=False, note="a note")
    head, rows = table(result_of(Answer((odd,))))
    assert head[-1] == "remarks" and rows[0][-1] == "other cables are not slack; a note"


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


REPORT = Progress(1000, 5, 0.25, 1, 2, 4)


def test_the_progress_line(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("COLUMNS", "120")
    stream = Terminal()
    with ProgressDisplay(stream) as display:
        display(REPORT)
        shown = stream.getvalue()
    assert (
        "subset 3/4  25 % of the volume left" in shown
        and "cells/s  1 solution" in shown
        and "\x1b[36m" in shown
    )
    assert stream.getvalue().endswith("\r\x1b[K")
    monkeypatch.setenv("NO_COLOR", "1")
    with ProgressDisplay(stream := Terminal()) as display:
        display(REPORT)
    assert "\x1b[36m" not in stream.getvalue()


def test_no_progress_line_in_a_file():
    stream = io.StringIO()
    with ProgressDisplay(stream) as display:
        display(REPORT)
    assert stream.getvalue() == ""


COMPILING = "compiling kernels for six-dof platforms, once per machine, about 45 s\n"
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


def test_what_is_logged_is_shown_below_the_progress_line(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    with ProgressDisplay(stream) as display:
        display(REPORT)
        logging.getLogger("cdpr_interval").warning(COMPILING.strip())
    assert f"\r\x1b[K{COMPILING}" in stream.getvalue()


def test_a_log_that_nobody_reads_ends_nothing():
    tried = []

    class Closed(io.StringIO):
        def write(self, text):
            tried.append(text)
            raise BrokenPipeError

    with ProgressDisplay(Closed()) as display:
        display._say("told")
    assert tried
