"""The report of a Delta: what is drawn has the lengths of the robot, and the command writes one page."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from cdpr_interval.robots.delta import LINEAR, DeltaRobot
from cdpr_interval.robots.formats.reader import load_delta
from solvers import delta_poses
from solvers.cli import cli
from solvers.report.delta_page import lines


def segments(points: np.ndarray) -> list[np.ndarray]:
    """Return the pieces of a line with gaps."""
    pieces, start = [], 0
    for k in [*np.flatnonzero(np.isnan(points).any(axis=1)), len(points)]:
        if k > start:
            pieces.append(points[start:k])
        start = k + 1
    return pieces


@pytest.mark.parametrize("which", [0, 1])
def test_arms_and_bars_have_their_lengths(which: int):
    robot = load_delta("delta_580")
    result = delta_poses(robot, ("10deg", "20deg", "30deg"))
    tool = result.solutions[which].position.mean(axis=1)
    drawn = {name: segments(points) for name, points, _, _ in lines(robot, result, tool)}
    arms = drawn["arms"][:3]
    assert [np.linalg.norm(a[1] - a[0]) for a in arms] == pytest.approx([0.2] * 3)
    assert [np.linalg.norm(b[1] - b[0]) for b in drawn["bars"]] == pytest.approx([0.38] * 6)
    assert np.linalg.norm(drawn["base"][0][:3], axis=1) == pytest.approx([0.15] * 3)
    assert arms[0][1][2] < 0 < arms[0][1][0]


def test_carriages_run_along_their_rails():
    robot = DeltaRobot("columns", "0.3", "0.1", "0.5", drives=LINEAR, rail_directions=[(0, 0, -1)] * 3,
                       tool_offset=(0, 0, "-0.1"))  # fmt: skip
    result = delta_poses(robot, positions=("0.1", "0.2", "0.3"))
    tool = result.solutions[0].position.mean(axis=1)
    drawn = {name: segments(points) for name, points, _, _ in lines(robot, result, tool)}
    assert [p[1][2] for p in drawn["rails"][:3]] == pytest.approx([-0.1, -0.2, -0.3])
    assert [np.linalg.norm(b[1] - b[0]) for b in drawn["bars"]] == pytest.approx([0.5] * 6)
    assert drawn["platform"][1][0] - drawn["platform"][1][1] == pytest.approx([0, 0, 0.1])


def test_the_page(tmp_path):
    def run(*args):
        return CliRunner().invoke(cli, [str(arg) for arg in args])

    found, page = tmp_path / "r.json", tmp_path / "r.html"
    assert run("fk", "delta_580", "--angles", "10deg,20deg,30deg", "--json", found, "-q").exit_code == 0
    assert run("report", found, "--out", page).exit_code == 0
    text = page.read_text()
    assert "0.033955, 0.020772, -0.281754 m" in text and "two poses, and no other one" in text
    refused = run("report", found, "--out", page, "--robot", "delta_580")
    assert (refused.exit_code, refused.stderr) == (2, "--robot: not for the result of a Delta\n")
