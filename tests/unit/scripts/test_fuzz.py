"""`make fuzz`: rounds with new seeds, what reproduces a failure, an end in time."""

from __future__ import annotations

import shlex
import subprocess
import sys

import pytest

from scripts import fuzz
from scripts.fuzz import STAGES, OutOfTime, Stage

FAILS_AT_3 = Stage(
    "odd", ("-c", "import sys; print('drawn', sys.argv[1]); sys.exit(sys.argv[1] == '3')", "{seed}")
)
PASSES = Stage("even", ("-c", "pass"))
SLEEPS = Stage("long", ("-c", "import time; time.sleep(600)"))


@pytest.fixture
def until_4(monkeypatch):
    """The time is over when the round of seed 4 begins."""
    run = fuzz.run

    def limited(stage, seed, seconds):
        if seed == 4:
            raise OutOfTime
        return run(stage, seed, seconds)

    monkeypatch.setattr(fuzz, "run", limited)


@pytest.mark.usefixtures("until_4")
def test_a_failure_is_printed_with_the_command_that_reproduces_it(capsys):
    (failure,) = fuzz.fuzz((FAILS_AT_3, PASSES), 600, 2)
    printed = capsys.readouterr().out
    assert "seed 2: odd: passed" in printed and "seed 3: odd: FAILED" in printed
    assert "drawn 3" in printed and f"reproduce: {failure.command}" in printed
    assert "seed 3: even: passed" in printed and "seed 4: odd: the time is over" in printed
    again = subprocess.run(shlex.split(failure.command), capture_output=True, text=True, check=False)
    assert again.returncode == 1 and again.stdout == "drawn 3\n"


@pytest.mark.usefixtures("until_4")
@pytest.mark.parametrize(("stages", "code"), [((PASSES, FAILS_AT_3), 1), ((PASSES,), 0)])
def test_the_exit_code_tells(stages, code, monkeypatch, capsys):
    monkeypatch.setattr(fuzz, "STAGES", stages)
    assert fuzz.main(["--seed", "3"]) == code
    assert capsys.readouterr().out.startswith("first seed 3, 600 s\n")


def test_what_runs_when_the_time_is_over_counts_as_nothing(capsys):
    assert fuzz.fuzz((SLEEPS,), 1, 7) == []
    assert "seed 7: long: the time is over" in capsys.readouterr().out


def test_a_seed_is_chosen_and_printed(monkeypatch, capsys):
    monkeypatch.setattr(fuzz, "STAGES", (SLEEPS,))
    firsts = []
    for _ in range(2):
        assert fuzz.main(["--seconds", "0"]) == 0
        firsts.append(capsys.readouterr().out.splitlines()[0])
    assert firsts[0] != firsts[1] and all(first.startswith("first seed ") for first in firsts)


def test_every_stage_uses_the_seed():
    for stage in STAGES:
        one, other = stage.command(1), stage.command(2)
        assert one != other and one[0] == sys.executable
