"""``cdpr-solve fk`` of point masses whose cables run over pulleys."""

import json

import pytest
from click.testing import CliRunner

from solvers.cli import cli

CORNERS = ((-2.5, -2.5), (2.5, -2.5), (2.5, 2.5), (-2.5, 2.5))
SINGLE = "radius_m: 0.0665, arm_m: 0.1, lead_in_m: 5"
TIGHT = "9.66758648854228,9.104849888092424,9.926104963854888,10.407264022482067"
"""At (0.5, -0.75, 2), computed independently of this package."""
OVER_THREE = "9.66758648854228,9.104849888092424,9.926104963854888,10.6"


@pytest.fixture
def robot(tmp_path):
    lines = [
        f"  - {{name: c{i}, frame_anchor_m: [{x}, {y}, 5], platform_anchor_m: [0, 0, 0], "
        f"pulley: {{{SINGLE}}}}}"
        for i, (x, y) in enumerate(CORNERS, 1)
    ]
    head = "format: cdpr-robot/1\nname: hung\nplatform: {mass_kg: 300}\ncables:\n"
    path = tmp_path / "hung.yaml"
    path.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def run(robot, lengths, *args):
    return CliRunner().invoke(cli, ["fk", str(robot), "--lengths", lengths, *args])


def found(robot, lengths, *args, code=0):
    result = run(robot, lengths, *args, "--json", "-", "-q")
    assert result.exit_code == code, result.stderr
    return json.loads(result.stdout)


def middles(bounds):
    return [0.5 * (lo + hi) for lo, hi in bounds]


def test_three_cables_hold_the_mass_where_they_were_measured(robot):
    answer = found(robot, OVER_THREE)
    (pose,) = answer["solutions"]
    assert middles(pose["position_m"]) == pytest.approx([0.5, -0.75, 2], abs=1e-9)
    assert pose["cable_states"] == ["taut", "taut", "taut", "slack"]
    assert pose["stability"] == "stable" and pose["proof"] == "convexity"


def test_four_tight_cables_leave_the_tensions_open(robot):
    answer = found(robot, TIGHT, code=3)
    (pose,) = answer["solutions"]
    for (lo, hi), x in zip(pose["position_m"], [0.5, -0.75, 2], strict=True):
        assert lo - 1e-12 <= x <= hi + 1e-12
        assert hi - lo < 1e-10
    assert "tensions may not be unique" in pose["note"]


def test_other_taut_cables_are_other_questions(robot):
    assert len(found(robot, OVER_THREE, "--taut", "c1,c2,c3")["solutions"]) == 1
    result = run(robot, OVER_THREE, "--taut", "c1,c2")
    assert result.exit_code == 4
    assert "the robot has other cables taut than those asked for at every pose" in result.stdout


def test_one_pulley_alone_gives_a_circle(robot):
    answer = found(robot, "9,30,30,30")
    (pose,) = answer["solutions"]
    family = pose["family"]
    assert family["kind"] == "rotation"
    assert middles(family["axis_point_m"])[:2] == [-2.5, -2.5]
    x, y, _ = middles(pose["position_m"])
    assert (x + 2.5) ** 2 + (y + 2.5) ** 2 == pytest.approx(0.1665**2)
    assert middles(pose["tensions_N"]) == pytest.approx([2943, 0, 0, 0])


def test_ropes_that_meet_nowhere_hold_nothing(robot):
    result = run(robot, "7,7,30,30")
    assert result.exit_code == 4
    assert "no position is in reach of all cables" in result.stdout


@pytest.mark.parametrize(
    ("option", "line"),
    [
        (["--ignore-slack"], "--ignore-slack is not supported with pulleys or with cables of two kinds yet"),
        (["--method", "search"], "--method search is for straight cables that all stretch or all do not"),
    ],
)
def test_what_is_not_treated_is_said(robot, option, line):
    result = run(robot, OVER_THREE, *option)
    assert result.exit_code == 2 and not result.stdout
    assert result.stderr.splitlines() == [f"robot 'hung': {line}"]
