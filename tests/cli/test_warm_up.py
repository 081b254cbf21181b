"""``cdpr-solve warm-up``, and what is said where kernels are compiled without it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from cdpr_interval.errors import CdprError
from cdpr_interval.kernels.announcement import text_of
from solvers.cli import cli
from solvers.commands import kernel_units, warm_up

ROOT = Path(__file__).resolve().parents[2]
COUNTED = """
from numba.core import event
class Compiled(event.Listener):
    def on_start(self, event): print("compiles", event.data["dispatcher"])
    def on_end(self, event): pass
import cdpr_interval.kernels
from cdpr_interval import load_robot
from solvers import PointMass, Tracker, forward_kinematics
"""
TRACKER = """
robot = load_robot("uc4")
tracker = Tracker(robot)
tracker.warm_up()
event.register("numba:compile", Compiled())
print(tracker.update([7.5, 8.0, 7.0, 9.0]).status.value)
poses = forward_kinematics(robot, [7.5, 8.0, 7.0, 9.0], taut=range(4)).solutions
tracker.reset(next(pose for pose in poses if pose.stability == "stable"))
for robot, ranges in (("uc4", ["7.5+-0.001", "8+-0.001", "7", "9"]), ("uc2", ["7.5+-0.001", "8"])):
    found = forward_kinematics(robot, ranges, taut=range(len(ranges)))
    assert found.outcome.value == "complete", found
for lengths in ([7.501, 8.0, 7.0, 9.0], [(7.5, 7.50001), 8.0, 7.0, 9.0], [17.0, 8.0, 7.0, 9.0], [1.0] * 4):
    print(tracker.update(lengths).status.value)
"""
POINT = """
solver = PointMass(load_robot("merlet_4_1_k100"))
solver.warm_up()
event.register("numba:compile", Compiled())
for width in (0.0, 1e-6, 0.1, 1.0):
    print(solver.solve([(x - width, x + width) for x in (2.9, 2.9, 4.1, 4.1)]).status.value)
"""


def run(*arguments, **variables):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    return subprocess.run(
        [sys.executable, *arguments], cwd=ROOT, env=environment, capture_output=True, text=True, timeout=500
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "said"), [(TRACKER, "lost-track tracked tracked tracked lost-track"), (POINT, "proved " * 4)]
)
def test_after_warming_up_an_empty_cache_nothing_is_compiled(tmp_path, code, said):
    done = run("-c", COUNTED + code, NUMBA_CACHE_DIR=str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "compiles" not in done.stdout
    assert done.stdout.split()[1:] == said.split()[1:]


@pytest.mark.slow
def test_an_empty_cache_is_filled_and_then_there_is_nothing_to_do(tmp_path):
    first = run("-m", "solvers", "warm-up", "--threads", "2", NUMBA_CACHE_DIR=str(tmp_path))
    assert first.returncode == 0 and first.stdout == ""
    assert len(re.findall(r"^\[\d/4\] .*: \d+ compiled, \d+ s$", first.stderr, re.MULTILINE)) == 4
    again = run("-m", "solvers", "warm-up", NUMBA_CACHE_DIR=str(tmp_path))
    assert again.returncode == 0 and again.stderr.count("nothing to compile") == 4
    asked = run("-m", "solvers", "fk", "uc2", "--lengths", "7.5,8", NUMBA_CACHE_DIR=str(tmp_path))
    assert asked.returncode == 0 and "compiling" not in asked.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_ends_all_processes(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "solvers", "warm-up", "--threads", "2"], cwd=ROOT, stderr=subprocess.PIPE,
        text=True, env={**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path)},
    )  # fmt: skip
    time.sleep(3.0)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors.splitlines()[-1] == "interrupted"


def test_wrong_usage():
    for arguments in (["lines"], ["all", "--threads", "0"]):
        result = CliRunner().invoke(cli, ["warm-up", *arguments])
        assert result.exit_code == 2


def test_units_wait_for_those_they_call(monkeypatch):
    run = warm_up.WarmUp(list(kernel_units.UNITS), 2, quiet=True)
    monkeypatch.setattr(warm_up.subprocess, "Popen", lambda *given, **more: None)
    for name in ("searches", "points"):
        assert run._next() == name
        run._start(name)
    assert run._next() is None
    del run._running[0]
    assert run._next() == "certificates"


def test_a_unit_that_fails_is_named(monkeypatch):
    monkeypatch.setattr(warm_up.sys, "executable", "/bin/false")
    with pytest.raises(CdprError, match="kernels for point masses could not be compiled"):
        warm_up.WarmUp(["points"], 1, quiet=True).run()


@pytest.mark.parametrize(
    ("module", "words"),
    [
        ("solvers.point_mass.one_call", "point masses"),
        ("solvers.six_dof.cells.root_search", "six-dof platforms"),
        ("solvers.six_dof.track", "trackers of platforms"),
        ("solvers.six_dof.cells.certified_pose_cells", "certificates of platforms"),
    ],
)
def test_each_part_has_its_own_words(module, words):
    text = text_of(module)
    assert re.fullmatch(
        rf"compiling kernels for {words}, for the first question of a kind, up to \d+ s", text
    )


def test_small_kernels_and_those_of_others_are_not_worth_a_word():
    assert text_of("cdpr_interval.kernels.interval") is None and text_of("numba.np.arrayobj") is None
