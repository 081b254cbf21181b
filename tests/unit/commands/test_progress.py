"""What is shown while a command works: on a terminal, in a log, where nobody reads."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
import threading
import time

import pytest

from certificates.progress import ProgressLine
from solvers.batch.duration import duration
from solvers.batch.run import BatchProgress
from solvers.commands import progress as module
from solvers.commands.progress import ProgressDisplay, in_notebook, shown
from solvers.questions.problem import Progress

HALF = Progress(1000, 5, 0.5, 1, 2, 4)
CODES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
HIDDEN, SHOWN = "\x1b[?25l", "\x1b[?25h"


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture(autouse=True)
def environment(monkeypatch):
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setattr(module, "PATIENCE", 0.0)


def drawn(display, stream, *reports):
    """Return what is on the screen once a bar is there and some reports came."""
    deadline = time.monotonic() + 20.0
    while display._bar is None and time.monotonic() < deadline:
        time.sleep(0.01)
    for report in reports:
        report()
    display._bar.refresh()
    return CODES.sub("", stream.getvalue().rsplit("\r", 1)[-1])


def test_a_search_on_a_terminal():
    with ProgressDisplay(stream := Terminal()) as display:
        line = drawn(display, stream, lambda: display(HALF))
        assert re.match(r"search \S+ 62 %, subset 3/4, 1 solution, \S+ cells/s", line), line
        assert "\x1b[" in stream.getvalue()
    assert stream.getvalue().count(HIDDEN) == stream.getvalue().count(SHOWN) == 1
    assert stream.getvalue().endswith("\x1b[2K"), "the line is taken off the terminal"


def test_the_time_that_is_left(monkeypatch):
    with ProgressDisplay(stream := Terminal(), "check") as display:
        for done in (0, 100, 200, 300, 400):
            line = drawn(display, stream, lambda done=done: display.cells(done, 1000))
            time.sleep(0.02)
    assert re.match(r"check \S+ 40 %, \S+ s left, 400/1000 cells", line), line


def test_a_batch_and_a_stage_of_unknown_length():
    with ProgressDisplay(stream := Terminal(), "batch") as display:
        line = drawn(display, stream, lambda: display.jobs(BatchProgress(5, 20, 2.5, 6.0, 1)))
        assert "25 %" in line and "5/20 jobs, 2.5 jobs/s, 1 failed" in line
        line = drawn(display, stream, lambda: display.stage("report"))
        assert re.match(r"report \S+ [\d.]+ s", line), line


def test_a_work_that_ends_at_once_draws_nothing(monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 60.0)
    with ProgressDisplay(stream := Terminal()) as display:
        display(HALF)
    display._thread.join(20.0)
    assert stream.getvalue() == "" and not display._thread.is_alive() and display._bar is None


def test_no_colours(monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    with ProgressDisplay(stream := Terminal()) as display:
        drawn(display, stream, lambda: display(HALF))
    assert re.findall(r"\x1b\[[\d;]*3\d[\d;]*m", stream.getvalue()) == []


@pytest.mark.parametrize("terminal", ["dumb", ""])
def test_no_bar_without_a_terminal_that_can_redraw(monkeypatch, terminal):
    stream = io.StringIO() if not terminal else Terminal()
    monkeypatch.setenv("TERM", terminal or "xterm")
    with ProgressDisplay(stream) as display:
        display(HALF)
        time.sleep(0.05)
    assert stream.getvalue() == "" and display._bar is None


def next_line(stream):
    """Return the next line that a log gets."""
    before, deadline = len(stream.getvalue()), time.monotonic() + 20.0
    while stream.getvalue().count("\n", before) < 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    # The first of the two may have been begun before.
    return stream.getvalue()[before:].splitlines()[1]


def test_a_log_has_a_line_now_and_then(monkeypatch):
    """Also while nothing is told."""
    monkeypatch.setattr(module, "SECONDS_BETWEEN", 0.01)
    with ProgressDisplay(stream := io.StringIO(), "batch") as display:
        assert re.fullmatch(r"batch after \S+ s", next_line(stream))
        display.jobs(BatchProgress(5, 20, 2.5, 6.0, 1))
        line = next_line(stream)
        assert re.fullmatch(r"batch after \S+ s: 25 %, \S+ s left, 5/20 jobs, 2.5 jobs/s, 1 failed", line)
        display.cells(0, 0)
        assert re.fullmatch(r"batch after \S+ s: 0/0 cells", next_line(stream))
        display.stage("report")
        assert re.fullmatch(r"report after \S+ s", next_line(stream))
    length = len(stream.getvalue())
    display._thread.join(20.0)
    assert not display._thread.is_alive() and len(stream.getvalue()) == length


def test_a_terminal_that_has_gone_ends_nothing():
    class Gone(Terminal):
        def write(self, text):
            raise OSError(5, "Input/output error")

    with ProgressDisplay(Gone()) as display:
        while display._bar is None:
            time.sleep(0.01)
        display(HALF)
        display._say("compiling kernels")


def test_what_stays_is_written_above_the_bar():
    with ProgressDisplay(stream := Terminal()) as display:
        drawn(display, stream, lambda: display(HALF))
        display._say("compiling kernels")
        assert "compiling" in drawn(display, stream) or "compiling" in stream.getvalue()
    lines = re.split(r"[\r\n]+", CODES.sub("", stream.getvalue()))
    assert any(line.startswith("compiling kernels") for line in lines), lines


def test_quiet_and_notebooks():
    with shown("search", quiet=True) as display:
        assert display is None
    assert not in_notebook()


@pytest.mark.parametrize(
    ("seconds", "text"), [(4.21, "4.2 s"), (42.4, "42 s"), (190, "3 min 10 s"), (7500, "2 h 5 min")]
)
def test_durations(seconds, text):
    assert duration(seconds) == text


def test_the_line_of_the_checker(monkeypatch):
    line = ProgressLine(stream := Terminal())
    line.begun -= 10.0
    line(50, 100)
    line(51, 100)
    line(100, 100)
    line.erase()
    assert stream.getvalue().split("\r\x1b[K") == ["", "50/100 cells, 10 s left", "100/100 cells", ""]
    monkeypatch.setenv("TERM", "dumb")
    ProgressLine(stream := Terminal())(50, 100)
    assert stream.getvalue() == ""


def test_a_real_terminal_shows_the_certificate_while_it_is_written(tmp_path):
    """The answer is on standard output, everything that moves on the terminal, and it is gone at the end."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    command = [sys.executable, "-m", "solvers", "fk", "uc3", "--lengths", "7.5,8,7"]
    command += ["--certificate", str(tmp_path / "out.cert")]
    environment = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "NO_COLOR")}
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, env=environment)
    os.close(theirs)
    said: list[bytes] = []
    reader = threading.Thread(target=lambda: said.append(running.stdout.read()))
    reader.start()
    seen = b""
    while True:
        try:
            seen += os.read(ours, 65536)
        except OSError:
            break
    reader.join()
    running.stdout.close()
    assert running.wait() == 0
    os.close(ours)
    text = CODES.sub("", seen.decode())
    assert re.search(r"certificate \S+ \d+ %.*subset 7/7", text)
    assert text.splitlines()[-1].endswith(
        "out.cert: complete: 15 static poses, and no other one; checked: PROVED"
    )
    assert max(map(len, re.split(r"[\r\n]+", text))) <= max(80, len(str(tmp_path)) + 80)
    assert b"15 static poses" in said[0] and b"\x1b" not in said[0] and b"certificate" not in said[0]
