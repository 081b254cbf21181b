"""Lengths in millimetres that were typed as metres are noticed, others are not."""

from dataclasses import replace
from fractions import Fraction as F

from click.testing import CliRunner

from cdpr_interval import load_robot
from cdpr_interval.exact.range import Range
from solvers.cli import cli
from solvers.questions.lengths import read_lengths
from solvers.questions.scale import ABSURD, absurd_lengths

ROBOT = load_robot("uc2")


def said(text, robot=ROBOT):
    return absurd_lengths(robot, read_lengths(text, robot.cable_names))


def test_the_factor_is_named():
    text = said("7500,8000")
    assert text.startswith("c1 (and 1 more) is 7500 m long, ") and text.endswith("as in 7500mm")
    factor = float(text.split(" times")[0].split()[-1])
    (size,) = (float(word.strip("()")) for word in text.split() if word.startswith("(") and "." in word)
    assert abs(factor * size / 7500 - 1) < 0.01 and factor > ABSURD
    assert said("7.5,8000").startswith("c2 is 8000 m long")


def test_what_may_be_meant_is_not_noticed():
    assert said("7500mm,8000mm") is None and said("7.5,300") is None
    # The lower end counts: a range that begins small says nothing about units.
    assert said("7.5..9000,8") is None


def test_a_robot_without_size_and_one_with_ranges():
    cables = tuple(
        replace(c, frame_anchor=(F(0), F(0), F(3)), platform_anchor=(F(0),) * 3) for c in ROBOT.cables
    )
    assert said("7500,8000", replace(ROBOT, cables=cables)) is None
    cables = tuple(replace(c, frame_anchor=(Range(F(0), F(9)), F(0), F(3))) for c in ROBOT.cables)
    assert said("7500,8000", replace(ROBOT, cables=cables)) is not None


def test_fk_warns_and_goes_on():
    done = CliRunner().invoke(cli, ["fk", "uc2", "--lengths", "7500,8000", "-q"])
    (line,) = (line for line in done.stderr.splitlines() if line.startswith("warning: "))
    assert line.startswith("warning: --lengths: c1 (and 1 more) is 7500 m long") and done.exit_code in (
        0,
        3,
        4,
    )
    done = CliRunner().invoke(cli, ["ik", "uc2", "--pose", "4000,0,-7000"])
    assert done.exit_code == 0 and done.stderr.startswith("warning: --pose: c1 (and 1 more) is 80")
    done = CliRunner().invoke(cli, ["fk", "uc2", "--lengths", "7500mm,8m", "-q"])
    assert (done.exit_code, done.stderr) == (0, "")
