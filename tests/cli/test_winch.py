"""``cdpr-solve winch`` as a user calls it: dry runs, and simulated drives on a virtual bus."""

from __future__ import annotations

import json
import re
import threading
import time
from fractions import Fraction as F

import pytest
from click.testing import CliRunner

from cdpr_interval import load_robot
from cdpr_interval.driver.canopen_drive import SimulatedNetwork
from cdpr_interval.driver.simulated_drive import SimulatedDrive
from solvers import forward_kinematics
from solvers.cli import cli
from solvers.questions.pose import read_pose
from solvers.winches.session import lengths_at

SLOW = {"cycle_s": "0.1", "heartbeat_s": "0.5", "lookahead_s": "1"}
"""For real time on a busy machine, which may well stand still for a third of a second."""
WIDE = {"following_error_m: 0.01": "following_error_m: 0.05", "coherence_m: 0.02": "coherence_m: 0.1"}
"""The same for what drives lag behind."""


@pytest.fixture
def run():
    def call(*arguments):
        done = CliRunner().invoke(cli, ["winch", *map(str, arguments)])
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        return done

    return call


@pytest.fixture
def robot_file(tmp_path):
    """Write the shipped robot with a slower cycle."""
    from importlib import resources

    text = resources.files("cdpr_interval.robots").joinpath("library/four_winches.yaml").read_text()
    slow = "".join(f"  {key}: {value}\n" for key, value in SLOW.items())
    path = tmp_path / "slow.yaml"
    text = text.replace("  cycle_s: 0.01\n", slow)
    for usual, wide in WIDE.items():
        text = text.replace(usual, wide)
    path.write_text(text)
    return path


@pytest.fixture
def drives(robot_file):
    """Run simulated drives of the robot on a virtual bus."""
    robot = load_robot(robot_file)
    starts = lengths_at(robot, read_pose("2,1.5,1"))
    found = [SimulatedDrive(c.winch, s, F(4, 5)) for c, s in zip(robot.cables, starts, strict=True)]
    with SimulatedNetwork(found, "virtual", f"command {time.monotonic()}") as network:
        network.address = f"virtual:{network._options['channel']}"
        yield network


def test_status_of_a_dry_run(run):
    done = run("status", "four_winches", "--from", "2,1.5,1")
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert lines[0] == "winches disabled"
    assert lines[1].startswith("  c1  switch on disabled  0 counts  referenced, since home  3.066")


def test_where_prints_the_certified_box(run):
    done = run("where", "four_winches", "--from", "2,1.5,1", "--json")
    assert done.exit_code == 0
    root = json.loads(done.stdout)
    (pose,) = root["poses"]
    for (lo, hi), wanted in zip(pose["position_m"], (2, 1.5, 1), strict=True):
        assert lo < wanted < hi and hi - lo < 0.01
    assert pose["taut"] == ["c1", "c2", "c3", "c4"]


def test_move_is_dry_by_default(run, tmp_path):
    state = tmp_path / "state.json"
    done = run("move", "four_winches", "--from", "2,1.5,1", "--pose", "1.5,1.5,1", "--state", state)
    assert done.exit_code == 0, done.stderr
    assert "dry run on simulated drives: nothing was moved" in done.stderr
    assert "taut all along: c1,c2,c3,c4" in done.stdout
    assert not state.exists()


def test_a_path_that_is_not_proved_is_refused(run):
    done = run("move", "four_winches", "--from", "2,1.5,1", "--pose", "1,1,3.2")
    assert (done.exit_code, done.stdout) == (3, "")
    assert done.stderr.startswith("the goal is no static pose")


CAMERA = """format: cdpr-robot/1
name: camera
platform: {{mass_kg: 5}}
cables:
{cables}"""
CORNER = """  - name: {name}
    frame_anchor_m: [{x}, {y}, 6]
    platform_anchor_m: [0, 0, 0]
    tension_limits_N: [{least}, 100]
    winch:
      node: {node}
      drum: {{type: helical, groove_radius_m: 0.05, cable_diameter_m: 0.002, pitch_m: 0.003}}
      gear_ratio: "10:1"
      counts_per_turn: 65536
      sign: 1
      limits: {{length_m: [0.2, 25], velocity_m_s: 0.5, acceleration_m_s2: 1, following_error_m: 0.01}}
"""


@pytest.fixture
def camera(tmp_path):
    """Write a camera on four ropes, one more than it needs."""

    def write(least=0):
        corners = zip(("NE", "NW", "SW", "SE"), (10, -10, -10, 10), (8, 8, -8, -8), range(1, 5), strict=True)
        cables = "".join(CORNER.format(name=n, x=x, y=y, node=k, least=least) for n, x, y, k in corners)
        path = tmp_path / f"camera{least}.yaml"
        path.write_text(CAMERA.format(cables=cables))
        return path

    return write


def test_a_camera_on_four_ropes_moves_whichever_of_them_are_taut(run, camera):
    where = run("where", camera(), "--from", "2,1,1.5")
    assert where.exit_code == 0 and "NE,SE taut, NW,SW taut or just slack, stable" in where.stdout
    done = run("move", camera(), "--from", "2,1,1.5", "--pose", "2 1 1600mm")
    assert done.exit_code == 0, done.stderr
    goal, path, _, *rows = done.stdout.splitlines()
    assert goal == "goal (2.000000, 1.000000, 1.600000) m"
    assert "taut all along: NE,SE; taut or just slack, the position is proved either way: NW,SW" in path
    # A pose whose load can be shared otherwise has cables that may carry nothing.
    least = {row.split()[0]: float(row.split()[5]) for row in rows[:4]}
    assert least["NE"] > 0 and least["SE"] > 0 and least["NW"] == least["SW"] == 0
    (box,) = (row for row in rows if row.startswith("position"))
    for (lo, hi), wanted in zip(re.findall(r"\[(\S+), (\S+)\]", box), (2, 1, 1.6), strict=True):
        assert float(lo) < wanted < float(hi) < float(lo) + 0.01


def test_a_rope_that_may_be_slack_keeps_to_its_tension_limits(run, camera):
    done = run("move", camera(least=1), "--from", "2,1,1.5", "--pose", "2,1,1.6")
    assert done.exit_code == 3 and done.stdout == ""
    assert "NW may carry 0 to" in done.stderr and "limits 1 to 100 N" in done.stderr


def test_jog_needs_no_reference(run):
    done = run("jog", "four_winches", "--cable", "c1", "--by", "-5mm")
    assert done.exit_code == 0 and "nothing was moved" in done.stderr
    first, c1, c2, *_ = done.stdout.splitlines()
    assert first == "winches holding" and c1.endswith("unreferenced  length unknown")
    assert int(c1.split(" counts")[0].split()[-1]) < -1000 and " 0 counts" in c2
    assert run("move", "four_winches", "--pose", "2,1.5,1").exit_code == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["move", "four_winches", "--from", "2,1.5,1,5,0,0", "--pose", "1,1,1"],
            "--from[3]: '5' has no unit: write 5deg or 5rad",
        ),
        (
            ["move", "four_winches", "--from", "2,1.5,1", "--pose", "1,1,1,0,0,0.1"],
            "--pose[5]: '0.1' has no unit: write 0.1deg or 0.1rad",
        ),
        (["move", "four_winches", "--pose", "1,1,1"], "--from: missing"),
        (["move", "four_winches", "--pose", "1,1,1", "--live"], "--live: needs --bus"),
        (["move", "four_winches", "--pose", "1,1,1", "--bus", "virtual:x"], "--bus: only with --live"),
        (["move", "four_winches", "--pose", "1,1,1", "--live", "--bus", "virtual:x"], "--arm four-winches"),
        (
            [
                "jog",
                "four_winches",
                "--cable",
                "c1",
                "--by",
                "1",
                "--live",
                "--bus",
                "virtual:x",
                "--arm",
                "no",
            ],
            "--live: type the robot's name",
        ),
        (["jog", "four_winches", "--cable", "c9", "--by", "0.01", "--from", "2,1.5,1"], "no cable 'c9'"),
        (["jog", "four_winches", "--cable", "c1", "--by", "0.5", "--from", "2,1.5,1"], "at most 0.1 m"),
        (
            ["move", "four_winches", "--from", "2,1.5,1", "--pose", "1,1,1", "--time", "0"],
            "--time: must be positive",
        ),
        (["status", "four_winches", "--from", "9,9,9"], "--from: the pose is not static"),
        (["status", "four_winches", "--from", "9,x,9"], "--from[1]: 'x' is not a number"),
        (
            ["jog", "four_winches", "--from", "2,1.5,1", "--cable", "c1", "--by", "0.01", "--log", "/"],
            "log /: cannot",
        ),
        (["status", "uc4", "--from", "1,1,1"], "robot 'uc4' has no winches"),
        (["status", "four_winches", "--bus", "nothing"], "--bus: must be INTERFACE:CHANNEL"),
        (["home", "four_winches", "--pose", "2,1.5,1"], "home: needs --bus and --state"),
        (["simulate", "four_winches", "--pose", "2,1.5,1", "--bus", "virtual:x", "--share", "2"], "--share"),
    ],
)
def test_wrong_calls_are_one_line(run, arguments, message):
    done = run(*arguments)
    assert done.exit_code == 2
    assert message in done.stderr and len(done.stderr.splitlines()) == 1


def test_marks_lists_where_they_are_seen(run):
    done = run("marks", "four_winches", "--json")
    rows = json.loads(done.stdout)["marks"]
    assert len(rows) == 36 and rows[0]["length_m"] == pytest.approx([0.8495, 0.8505])


def test_home_move_where_on_a_bus(run, robot_file, drives, tmp_path):
    """The whole way of a first motion; the certified box holds the simulator's true pose at the end."""
    state, log = tmp_path / "state.json", tmp_path / "audit.jsonl"
    bus = ["--bus", drives.address, "--state", state]
    done = run("where", robot_file, *bus)
    assert done.exit_code == 3 and "c1 is unreferenced" in done.stderr
    done = run("home", robot_file, *bus, "--pose", "2,1.5,1")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("home (2.000000, 1.500000, 1.000000) m: the pose is static\n")
    live = ["--live", "--arm", "four-winches"]
    done = run("move", robot_file, *bus, *live, "--pose", "1.8,1.55,1.15", "--time", 6, "--log", log)
    assert done.exit_code == 0, done.stderr
    assert [json.loads(line)["event"] for line in log.read_text().splitlines()].count("stop") == 0
    done = run("where", robot_file, *bus, "--json")
    (pose,) = json.loads(done.stdout)["poses"]
    true = [node.drive.true_length for node in drives.nodes]
    (truth,) = forward_kinematics(load_robot(robot_file), true).solutions
    for (lo, hi), (below, above), wanted in zip(
        pose["position_m"], truth.position.tolist(), (1.8, 1.55, 1.15), strict=True
    ):
        assert lo <= below <= above <= hi and abs(0.5 * (lo + hi) - wanted) < 0.01
    done = run("jog", robot_file, *bus, *live, "--cable", "c2", "--by", "-0.01")
    assert done.exit_code == 0, done.stderr
    assert float(true[1] - drives.nodes[1].drive.true_length) == pytest.approx(0.01, rel=0.01)
    other = tmp_path / "other.yaml"
    other.write_text(robot_file.read_text() + "\nnotes: changed\n")
    done = run("where", other, *bus)
    assert done.exit_code == 2 and "is of another robot file (four-winches): home again" in done.stderr


def test_stop_stops_what_another_program_moves(run, robot_file, drives, tmp_path):
    state = tmp_path / "state.json"
    bus = ["--bus", drives.address, "--state", state]
    assert run("home", robot_file, *bus, "--pose", "2,1.5,1").exit_code == 0
    moving = [robot_file, *bus, "--live", "--arm", "four-winches", "--pose", "1.2,1.2,1", "--time", "30"]
    found = []
    mover = threading.Thread(target=lambda: found.append(run("move", *moving)))
    mover.start()
    end = time.monotonic() + 30
    while all(abs(node.drive.motor) < 1000 for node in drives.nodes) and time.monotonic() < end:
        time.sleep(0.02)
    # Nobody may configure drives that another program moves.
    done = run("status", robot_file, *bus)
    assert done.exit_code == 3 and "another master is on the bus" in done.stderr
    assert run("stop", robot_file, "--bus", drives.address).exit_code == 0
    mover.join(timeout=30)
    assert not mover.is_alive() and found[0].exit_code == 3
    assert "not-operational" in found[0].stderr or "enable-lost" in found[0].stderr
    assert all(node.drive.velocity == 0 for node in drives.nodes)


def test_a_bus_without_drives_is_refused(run):
    done = run("status", "four_winches", "--bus", "virtual:nobody here")
    assert done.exit_code == 3
    assert done.stderr.splitlines() == [f"node {k}: no answer" for k in (1, 2, 3, 4)]


def test_a_move_of_many_metres_takes_few_proofs(run, camera):
    done = run("move", camera(), "--from", "-2,1,1.5", "--pose", "2,1,1.5", "-q")
    assert done.exit_code == 0, done.stderr
    (seconds, pieces) = re.search(r"path of (\S+) s proved in (\d+) pieces", done.stdout).groups()
    # A proof for every four cycles of 10 ms were 25 a second.
    assert int(pieces) < 8 * float(seconds)


def test_a_time_limit_ends_the_proof_of_a_path(run, camera):
    done = run("move", camera(), "--from", "-2,1,1.5", "--pose", "2,1,1.5", "--time-limit", "0.001")
    assert (done.exit_code, done.stdout) == (3, "")
    assert re.fullmatch(
        r"stopped at the time limit: the path is proved for \d+\.\d\d of \d+\.\d\d s, \d+ % of the way; "
        r"nothing was moved",
        done.stderr.splitlines()[-1],
    )
    assert run("move", camera(), "--from", "2,1,1.5", "--pose", "2,1,1", "--time-limit", "0").exit_code == 2


def test_an_interrupt_says_how_far_the_path_is_proved(run, monkeypatch):
    def interrupt(self, progress):
        assert progress.cells == 1 and 0 < progress.done < 1
        raise KeyboardInterrupt

    monkeypatch.setattr("solvers.commands.progress.ProgressDisplay.__call__", interrupt)
    done = run("move", "four_winches", "--from", "2,1.5,1", "--pose", "1.5,1.5,1")
    assert (done.exit_code, done.stdout) == (130, "")
    assert re.fullmatch(
        r"interrupted: the path is proved for 0\.\d\d of \d\.\d\d s, \d+ % of the way; nothing was moved",
        done.stderr.splitlines()[-1],
    )


def test_where_that_was_interrupted_is_130(run, monkeypatch):
    from solvers.winches.where import Whereabouts

    found = Whereabouts((), "0 stable poses; interrupted, there may be more", False, is_interrupted=True)
    monkeypatch.setattr("solvers.winches.where.whereabouts", lambda *_: found)
    done = run("where", "four_winches", "--from", "2,1.5,1")
    assert done.exit_code == 130 and done.stderr == f"{found.message}\n"


def test_a_printed_pose_with_tolerances_is_a_goal(run):
    done = run(
        "move", "four_winches", "--from", "2 +- 0.1 1.5 1", "--pose", "1.9 +- 0.0010  1.5 +- 1e-3, 1.0"
    )
    assert done.exit_code == 0 and done.stdout.startswith("goal (1.900000, 1.500000, 1.000000) m\n")
    assert "--pose: without its tolerances, read as 1.9  1.5, 1.0\n" in done.stderr
    assert "--from: without its tolerances, read as 2 1.5 1\n" in done.stderr
