"""``cdpr-solve ik`` of robots whose cables run over pulleys."""

import json
import math

import pytest
from click.testing import CliRunner

from solvers.cli import cli

CORNERS = ((-2.5, -2.5), (2.5, -2.5), (2.5, 2.5), (-2.5, 2.5))
SINGLE = "radius_m: 0.0665, arm_m: 0.1, lead_in_m: 5"
DOUBLE = f"{SINGLE}, joints: 2"
# Computed independently of this package, three ways that agree, for the geometry of Paty and others 2021
# and the point (0.5, -0.75, 2).
LENGTHS = [9.66758648854228, 9.104849888092424, 9.926104963854888, 10.407264022482067]


def robot_file(folder, pulley, corners=CORNERS, rest="", anchor="[0, 0, 0]"):
    """Write a robot of 300 kg with a pulley at each corner."""
    lines = [
        f"  - {{name: c{i}, frame_anchor_m: [{x}, {y}, 5], platform_anchor_m: {anchor}, "
        f"pulley: {{{pulley}}}{rest}}}"
        for i, (x, y) in enumerate(corners, 1)
    ]
    head = "format: cdpr-robot/1\nname: hung\nplatform: {mass_kg: 300}\ncables:\n"
    path = folder / "hung.yaml"
    path.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def run(*args):
    return CliRunner().invoke(cli, ["ik", *(str(arg) for arg in args)])


def answer(*args):
    result = run(*args, "--json", "-", "-q")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_lengths_over_pulleys_are_the_independent_ones(tmp_path):
    found = answer(robot_file(tmp_path, SINGLE), "--pose", "0.5,-0.75,2")
    assert found["lengths_m"] == pytest.approx(LENGTHS, abs=1e-9)
    assert found["distances_m"] == found["lengths_m"]
    table = run(robot_file(tmp_path, SINGLE), "--pose", "0.5,-0.75,2")
    *_, last = table.stdout.splitlines()
    assert [float(x) for x in last.removeprefix("--lengths ").split(",")] == pytest.approx(LENGTHS, abs=1e-9)


def test_unstretched_lengths_are_of_the_whole_rope(tmp_path):
    """Lead-in and wrap stretch too. Tension and length: as `LENGTHS`, one case at rest under three ropes."""
    corners = ((-2.5, -2.5 / math.sqrt(3)), (2.5, -2.5 / math.sqrt(3)), (0.0, 5 / math.sqrt(3)))
    axial = 102.2e9 * math.pi * 0.004**2 / 4
    rest = f", elasticity: {{axial_stiffness_N: {axial!r}}}"
    path = robot_file(tmp_path, SINGLE, corners, rest)
    found = answer(path, "--pose", "0.30165540122118745,0.20123957467299503,2.6024509182206996")
    assert found["lengths_m"] == pytest.approx(
        [9.097643664659357, 8.713580967546413, 8.682204882261995], abs=1e-8
    )
    tensions = [1179.3547292855592, 1593.8000331887304, 1621.3103798820707]
    assert found["tensions_N"] == pytest.approx(tensions, abs=1e-5)
    for i in range(3):
        wanted = found["lengths_m"][i] * (1 + found["tensions_N"][i] / axial)
        assert found["distances_m"][i] == pytest.approx(wanted, rel=1e-12)


def test_springs_over_two_joints(tmp_path):
    rest = ", elasticity: {stiffness_N_per_m: 1e5}"
    exact = answer(robot_file(tmp_path, DOUBLE, rest=rest), "--pose", "0.5,-0.75,2")
    for length, distance, tension in zip(
        exact["lengths_m"], exact["distances_m"], exact["tensions_N"], strict=True
    ):
        assert distance - length == pytest.approx(tension / 1e5, rel=1e-9)
    bisector = answer(robot_file(tmp_path, f"{DOUBLE}, balance: bisector"), "--pose", "0.5,-0.75,2")
    gaps = [b - e for b, e in zip(bisector["distances_m"], exact["distances_m"], strict=True)]
    assert all(0 < gap < 2e-5 for gap in gaps)


def test_a_plain_exit_point_and_its_lead_in(tmp_path):
    found = answer(robot_file(tmp_path, "radius_m: 0, lead_in_m: 5"), "--pose", "0.5,-0.75,2")
    wanted = [5 + math.dist((x, y, 5), (0.5, -0.75, 2)) for x, y in CORNERS]
    assert found["lengths_m"] == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize("pulley", [SINGLE, DOUBLE, f"{DOUBLE}, balance: bisector"])
@pytest.mark.parametrize("settle", [[], ["--settle"]], ids=["", "settle"])
@pytest.mark.parametrize(
    "pose",
    [
        pytest.param("-2.5,-2.5,2", id="axis"),
        pytest.param("-2.5,-2.5,5", id="A"),
        pytest.param("-2.4388,-2.4388,4.95", id="pulley"),
    ],
)
def test_an_anchor_without_a_rope_is_one_line(tmp_path, pulley, settle, pose):
    path = robot_file(tmp_path, pulley)
    result = run(path, "--pose", pose, *settle)
    assert (result.exit_code, result.stdout) == (2, "")
    where = "inside its pulley or on its swivel axis"
    assert result.stderr == f"pose: the anchor of cable 'c1' is {where} at this pose\n"


@pytest.mark.parametrize("pulley", [SINGLE, DOUBLE, f"{DOUBLE}, balance: bisector"])
@pytest.mark.parametrize("cables", [2, 3])
def test_a_pose_settles(tmp_path, pulley, cables):
    """Two ropes leave one point of the plane through both, three hold every point between them."""
    corners = ((-2.5, 0), (2.5, 0), (0, 3))[:cables]
    path = robot_file(tmp_path, pulley, corners)
    pose = "0.5,0.02,2" if cables == 2 else "0.3,0.5,2"
    found = answer(path, "--pose", pose, "--settle", "--static")
    assert found["static"] and (found["settled"]["distance_m"] > 0.01) == (cables == 2)
    again = answer(path, "--pose", ",".join(map(repr, found["pose"]["position_m"])), "--static")
    assert again["lengths_m"] == pytest.approx(found["lengths_m"], abs=1e-9)


def test_a_platform_on_pulleys_settles(tmp_path):
    path = robot_file(tmp_path, DOUBLE, CORNERS)
    text = path.read_text(encoding="utf-8")
    for i, place in enumerate(
        ("[-0.3, -0.3, 0.1]", "[0.3, -0.3, 0.1]", "[0.3, 0.3, 0.1]", "[-0.3, 0.3, 0.1]")
    ):
        text = text.replace("platform_anchor_m: [0, 0, 0]", f"platform_anchor_m: {place}", 1)
        assert place in text, i
    path.write_text(text, encoding="utf-8")
    found = answer(path, "--pose", "0.2,0.1,2,1deg,0deg,0deg", "--settle", "--static")
    assert found["static"] and len(found["lengths_m"]) == 4


def test_the_forward_problem_is_refused_not_answered_without_them(tmp_path):
    path = robot_file(tmp_path, f"{DOUBLE}, balance: bisector", anchor="[0.1, 0, 0]")
    result = CliRunner().invoke(cli, ["fk", str(path), "--lengths", "9,9,9,9"])
    assert (result.exit_code, result.stdout) == (2, "")
    assert "a platform needs balance: exact" in result.stderr


def test_ranges_are_refused(tmp_path):
    path = robot_file(tmp_path, "radius_m: [0.06, 0.07]", CORNERS[:1])
    result = run(path, "--pose", "0.5,-0.75,2")
    assert result.exit_code == 2
    assert "not supported by ik yet: cables[0].pulley.radius_m" in result.stderr
