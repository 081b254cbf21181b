"""``cdpr-solve batch`` as a user calls it, killed and gone on with, and given nonsense."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import random
import re
import resource
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing, contextmanager

import pytest
from click.testing import CliRunner

from cdpr_interval import load_robot
from solvers import Result, forward_kinematics
from solvers.batch import campaign
from solvers.cli import cli
from tests.support.batch_workers import MONTE_CARLO, listed, write

SEED = 20261123
KILLS = 10


@pytest.fixture
def run():
    def call(*arguments):
        done = CliRunner().invoke(cli, ["batch", *map(str, arguments)])
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        return done

    return call


def process(*arguments, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "solvers", "batch", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def test_a_batch_from_file_to_tables(run, tmp_path):
    jobs, out = write(tmp_path, MONTE_CARLO.format(samples=50)), tmp_path / "out"
    done = run(jobs, "--out", out, "--threads", 2)
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("50 jobs: 50 done; nothing left open\n")
    with (out / "solutions.csv").open() as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == 50 and {row["status"] for row in table} == {"done"}
    lines = [json.loads(line) for line in (out / "results.jsonl").read_text().splitlines()]
    assert [line["job"] for line in lines] == list(range(1, 51))
    document = json.loads((out / "summary.json").read_text())
    (group,) = document["groups"]
    assert sum(group["taut_subsets"].values()) == 50
    heights = sorted(float(row["z_m"]) for row in table)
    assert group["quantities"]["z_m"]["min"] == heights[0]
    assert group["quantities"]["z_m"]["mean"] == pytest.approx(sum(heights) / 50)
    tight = [float(row["tension_c3_N"]) for row in table if float(row["tension_c3_N"])]
    assert group["quantities"]["tension_c3_N"]["count"] == len(tight) < 50
    done = run("status", out)
    assert done.stdout.startswith("50 of 50 jobs ended")
    # Once more: nothing is left to do, and the tables are the same.
    before = (out / "results.jsonl").read_bytes()
    assert run(jobs, "--out", out).exit_code == 0 and run("resume", out, "-q").exit_code == 0
    assert (out / "results.jsonl").read_bytes() == before
    document = json.loads(run("show", out, 7, "--json").stdout)
    assert document["format"] == "cdpr-result/1" and document["question"]["command"] == "fk"
    shown = run("show", out, 7)
    assert shown.stdout.startswith("merlet-4-1-k100 (point-mass, 4 cables): 1 static pose")


def test_dry_run_writes_nothing(run, tmp_path):
    jobs = write(tmp_path, MONTE_CARLO.format(samples=1000))
    done = run(jobs, "--dry-run", "--threads", 4)
    assert done.exit_code == 0
    first, last = done.stdout.splitlines()
    assert first == "problems[0]  merlet-4-1-k100  1000 jobs"
    assert last.startswith("1000 jobs, ") and last.endswith("with --threads 4")
    assert list(tmp_path.iterdir()) == [jobs]


def test_an_estimate_that_had_to_give_up_is_a_lower_bound(run, tmp_path, monkeypatch):
    monkeypatch.setattr(campaign, "ESTIMATE_SECONDS_A_JOB", 0.02)
    jobs = write(tmp_path, listed([[7.5, 8, 7, 9]], "uc4"))
    (*_, last) = run(jobs, "--dry-run").stdout.splitlines()
    assert last.startswith("1 job, ") and "more than" in last


def test_poses_csv_and_several_robots(run, tmp_path):
    (tmp_path / "robots").mkdir()
    for name, mass in (("b", 50), ("a", 80)):
        text = (
            f"format: cdpr-robot/1\nname: {name}\nplatform: {{mass_kg: {mass}}}\ncables:\n"
            "  - {name: left, frame_anchor_m: [0, 0, 3], platform_anchor_m: [0, 0, 0]}\n"
            "  - {name: right, frame_anchor_m: [4, 0, 3], platform_anchor_m: [0, 0, 0]}\n"
        )
        (tmp_path / "robots" / f"{name}.yaml").write_text(text)
    (tmp_path / "lengths.csv").write_text("right,left,x_day\n2.5,3,Monday\n\n2.6+-0.01,2.9,Tuesday\n")
    jobs = write(
        tmp_path,
        "format: cdpr-batch/1\nrobots: [{folder: robots}]\nproblems:\n"
        "  - {type: csv, file: lengths.csv}\n"
        "  - {type: poses, robots: [a], position_m: {x: {from: 1, to: 3, count: 3}, y: 0, z: 1}}\n",
    )
    out = tmp_path / "out"
    done = run(jobs, "--out", out, "--threads", 1, "--json")
    assert done.exit_code == 0, done.stderr
    document = json.loads(done.stdout)
    assert [(group["problem"], group["robot"]) for group in document["groups"]] == [
        (0, "a"),
        (0, "b"),
        (1, "a"),
    ]
    lines = [json.loads(line) for line in (out / "results.jsonl").read_text().splitlines()]
    assert [line["input"] for line in lines[:2]] == [
        {"lengths_m": ["3", "2.5"]},
        {"lengths_m": ["2.9", ["2.59", "2.61"]]},
    ]
    (solution,) = lines[-1]["answer"]["solutions"]
    assert solution["nominal"]["position_m"] == pytest.approx([3, 0, 1])


@contextmanager
def connection_to(folder):
    """Change a ledger by hand."""
    connection = sqlite3.connect(folder / "ledger.sqlite")
    with closing(connection), connection:
        yield connection


@pytest.mark.slow
def test_undecided_is_code_3_and_failed_is_code_5(run, tmp_path):
    jobs = write(
        tmp_path, listed([[2.692582403567252, 3.905124837953327, 3.354101966249685, 4.387482193696061]])
    )
    assert run(jobs, "--out", tmp_path / "a", "-q").exit_code == 3
    assert "left something undecided: job 1\n" in run("status", tmp_path / "a").stdout
    assert json.loads(run("status", tmp_path / "a", "--json").stdout)["jobs_with_undecided"] == 1
    report(tmp_path / "a", "--out", tmp_path / "a.html", code=3)
    assert "<p>job 1; to look at one" in (tmp_path / "a.html").read_text()
    jobs.write_text(MONTE_CARLO.format(samples=3))
    assert run(jobs, "--out", tmp_path / "b", "-q").exit_code == 0
    with connection_to(tmp_path / "b") as ledger:
        ledger.execute("UPDATE jobs SET status = 'pending', input = '{}' WHERE number = 2")
    assert run("resume", tmp_path / "b", "-q").exit_code == 5
    done = run("status", tmp_path / "b")
    assert "job 2 failed after 2 attempts: internal error: KeyError" in done.stdout
    assert run("resume", tmp_path / "b", "-q").exit_code == 5
    with connection_to(tmp_path / "b") as ledger:
        ledger.execute("UPDATE jobs SET input = (SELECT input FROM jobs WHERE number = 3) WHERE number = 2")
    assert run("resume", tmp_path / "b", "--retry-failed", "-q").exit_code == 0
    assert "3 of 3 jobs ended" in run("status", tmp_path / "b").stdout


CERTIFIED = """
format: cdpr-batch/1
robots: [merlet_4_1]
problems:
  - type: monte-carlo
    lengths_m: ["2.7", "3.9", "3.35", "4.4"]
    samples: 4
    seed: 3
    perturb: {frame_anchors_m: {distribution: uniform, half_width: 0.01}}
options: {certificates: true}
"""


@pytest.mark.slow
def test_certificates_of_a_batch_are_checked_as_what_they_are(run, tmp_path):
    out = tmp_path / "out"
    assert run(write(tmp_path, CERTIFIED), "--out", out, "-q").exit_code == 0
    done = run("check", out, "--threads", 2)
    assert (done.exit_code, done.stdout) == (0, "4 certificates: 4 PROVED\n"), done.stderr
    page = tmp_path / "page.html"
    report(out, "--out", page)
    assert "4 certificates: 4 PROVED" in page.read_text()
    report(out, "--out", page, "--job", 3)
    assert "certificate: PROVED: 1 static pose, and no other one" in page.read_text()
    with connection_to(out) as ledger:
        # Sound proofs, but not of these jobs: of another robot, and of a pose that is not the answer's.
        first = "(SELECT file FROM certificates WHERE number = 1)"
        ledger.execute(f"UPDATE certificates SET file = {first} WHERE number = 2")
        moved = """replace(answer, '"position_m":[[', '"position_m":[[-')"""
        ledger.execute(f"UPDATE answers SET answer = {moved} WHERE number = 3")
        ledger.execute("UPDATE certificates SET file = substr(file, 1, 500) WHERE number = 4")
    done = run("check", out, "--threads", 1)
    assert done.exit_code == 5
    assert done.stdout.splitlines() == [
        "4 certificates: 1 MALFORMED, 2 NOT PROVED, 1 PROVED",
        "job 2 NOT PROVED: the certificate is not of this result: its robot differs",
        "job 3 NOT PROVED: the certificate is not of this result: 1 of its poses is another",
        "job 4 MALFORMED: the first line is not that of a certificate with this content",
    ]
    report(out, "--out", page, code=5)
    text = page.read_text()
    assert 'class="judgement bad"' in text and "<p>4 certificates: " in text
    report(out, "--out", page, "--job", 2, code=5)
    assert "its robot differs" in page.read_text()


def test_a_batch_without_certificates_has_nothing_proved(run, tmp_path):
    assert run(write(tmp_path, MONTE_CARLO.format(samples=2)), "--out", tmp_path / "out", "-q").exit_code == 0
    done = run("check", tmp_path / "out")
    assert (done.exit_code, done.stdout) == (3, "0 certificates; 2 jobs have none\n")
    assert done.stderr == done.stdout


def report(*arguments, code=0):
    done = CliRunner().invoke(cli, ["report", *map(str, arguments)])
    assert done.exit_code == code, done.stderr


@pytest.mark.slow
def test_killed_ten_times_ends_the_same(tmp_path):
    """SIGKILL at random moments; nothing that was recorded is done again, and the results are bit for bit."""
    print(f"seed {SEED}")
    generator = random.Random(SEED)
    jobs = write(tmp_path, MONTE_CARLO.format(samples=6000))
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    done = process(jobs, "--out", whole, "-q", "--threads", 2)
    done.communicate(timeout=300)
    assert done.returncode == 0
    seen: dict[int, tuple[float, str]] = {}
    kills = 0
    for _ in range(100):
        if kills == KILLS:
            break
        victim = process(jobs, "--out", parts, "-q", "--threads", 2, start_new_session=True)
        wait_for_records(parts, len(seen), generator.random(), victim)
        if victim.poll() is None:
            # Half of the time the workers are killed too.
            (os.kill if generator.random() < 0.5 else os.killpg)(victim.pid, signal.SIGKILL)
            kills += 1
        victim.communicate(timeout=60)
        recorded = ended(parts)
        assert all(recorded[number] == entry for number, entry in seen.items())
        seen = recorded
        if len(seen) == 6000:
            break
    last = process("resume", parts, "-q")
    last.communicate(timeout=300)
    assert last.returncode == 0
    assert kills == KILLS and len(ended(parts)) == 6000
    for name in ("results.jsonl", "solutions.csv", "summary.json"):
        assert (parts / name).read_bytes() == (whole / name).read_bytes()


def ended(folder):
    """Return start and host of every job that has an outcome."""
    if not (folder / "ledger.sqlite").exists():
        return {}
    connection = sqlite3.connect(folder / "ledger.sqlite")
    rows = connection.execute("SELECT number, started, host FROM jobs WHERE status != 'pending'").fetchall()
    connection.close()
    return {number: (started, host) for number, started, host in rows}


def wait_for_records(folder, before, share, victim):
    """Wait a random while: sometimes for new records, sometimes not even for the start."""
    if share < 0.3:
        time.sleep(5 * share)
        return
    end = time.monotonic() + 60
    while len(ended(folder)) == before and victim.poll() is None and time.monotonic() < end:
        time.sleep(0.02)
    time.sleep(0.3 * share)


@pytest.mark.slow
def test_interrupt_says_how_to_go_on(tmp_path):
    jobs, out = write(tmp_path, MONTE_CARLO.format(samples=100_000)), tmp_path / "out"
    running = process(jobs, "--out", out, "-q", "--threads", 2)
    wait_for_records(out, 0, 1.0, running)
    running.send_signal(signal.SIGINT)
    _, errors = running.communicate(timeout=60)
    assert running.returncode == 130
    assert errors == f"interrupted; go on with: cdpr-solve batch resume {out}\n"
    assert 0 < len(ended(out)) < 100_000


@pytest.mark.slow
def test_a_full_disk_keeps_the_ledger(run, tmp_path):
    """No file may grow beyond 2 MB: the run ends with one line, and goes on when there is room."""
    jobs, out = write(tmp_path, MONTE_CARLO.format(samples=3000)), tmp_path / "out"

    def little_room():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))

    starved = process(jobs, "--out", out, "-q", "--threads", 1, preexec_fn=little_room)
    _, errors = starved.communicate(timeout=120)
    assert starved.returncode == 3 and len(errors.splitlines()) == 1, errors
    assert "make room, then cdpr-solve batch resume" in errors
    connection = sqlite3.connect(out / "ledger.sqlite")
    assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()
    early = ended(out)
    assert run("resume", out, "-q").exit_code == 0
    late = ended(out)
    assert len(late) == 3000 and all(late[number] == entry for number, entry in early.items())


FIVE = MONTE_CARLO.format(samples=5)
ROWS = [[1, 2, 3, 4], [1, 2, 3, 4]]
FOLDER = "format: cdpr-batch/1\nrobots: [{folder: nowhere}]\nproblems:\n  - {type: csv, file: none.csv}"


def one_problem(problem):
    return f"format: cdpr-batch/1\nrobots: [uc2]\nproblems:\n  - {problem}"


MANY_PLACES = "{type: poses, position_m: {x: PLACES, y: PLACES, z: PLACES}}".replace(
    "PLACES", "{from: 0, to: 1, count: 1000}"
)
ONE_PLACE = "{type: poses, position_m: {x: {from: 1, to: 1, count: 3}, y: 0, z: 0}}"
WRONG = {
    "must be 'cdpr-batch/1', got the text 'cdpr-batch/2'": "format: cdpr-batch/2\nrobots: [uc2]",
    "1:1: problems: missing": "format: cdpr-batch/1\nrobots: [uc2]\n",
    "problems[0]: lengths_m[0]: 3 lengths for 4 cables": listed([[1, 2, 3]]),
    "problems[0]: lengths_m[0][3]: must be positive, got -4": listed([[1, 2, 3, -4]]),
    "problems[0]: lengths_m[1]: 2 lengths for 4 cables": listed([[1, 2, 3, -4], [1, 2]]),
    "robots[0]: nobody: no such file or shipped robot": listed(ROWS[:1], "nobody"),
    "'merlet-4-1' is the name of 'merlet_4_1' in robots[0]": listed(ROWS[:1], "merlet_4_1, merlet_4_1.yaml"),
    "problems[0] job 1 is the same as problems[0] job 0": listed(ROWS),
    "problems[0].samples: 'ten' is not a number": MONTE_CARLO.format(samples="ten"),
    "problems[0].samples: duplicate key": FIVE.replace("seed: 1", "seed: 1\n    samples: 6"),
    "perturb.stiffness: needs a relative width": FIVE.replace("relative_sigma", "sigma"),
    "perturb.lengths_m: a length could become zero": FIVE.replace("0.03", "3"),
    "exactly one of half_width and relative_half_width": FIVE.replace("half_width", "sigma"),
    "options.method: must be one of auto, search, convex": FIVE + "options: {method: magic}\n",
    "taut[0]: unknown cable 'c9'": FIVE.replace("seed: 1", "seed: 1\n    taut: [c9]"),
    "'from' and 'to' differ exactly when count is above 1": one_problem(ONE_PLACE),
    "problems: 1000000000 jobs, at most 10000000": one_problem(MANY_PLACES),
    "options.split: not for poses": one_problem(MANY_PLACES) + "\noptions: {split: 4}",
    "file 'none.csv': No such file": one_problem("{type: csv, file: none.csv}"),
    "type must be one of lengths, csv, poses, monte-carlo": one_problem("{type: dreams}"),
    "folder 'nowhere': No such file": FOLDER,
}


@pytest.mark.parametrize(("message", "text"), WRONG.items())
def test_a_wrong_job_file_is_told_and_leaves_nothing(run, tmp_path, message, text):
    jobs, out = write(tmp_path, text), tmp_path / "out"
    done = run(jobs, "--out", out)
    assert done.exit_code == 2 and message in done.stderr, done.stderr
    assert not (out / "ledger.sqlite").exists()


def test_folders_that_cannot_be_used(run, tmp_path):
    jobs = write(tmp_path, MONTE_CARLO.format(samples=5))
    (tmp_path / "file").write_text("")
    done = run(jobs, "--out", tmp_path / "file")
    assert done.exit_code == 2 and "--out: " in done.stderr and "File exists" in done.stderr
    done = run(jobs, "--out", "/proc/nothing")
    assert done.exit_code == 2 and "--out: /proc/nothing" in done.stderr
    done = run(jobs)
    assert done.exit_code == 2 and done.stderr == "--out: missing, the folder of ledger and tables\n"
    done = run("status", tmp_path / "nowhere")
    assert done.exit_code == 2 and "no batch there" in done.stderr
    done = run("show", tmp_path / "nowhere", 1)
    assert done.exit_code == 2 and len(done.stderr.splitlines()) == 1


PERTURBED = """\
format: cdpr-batch/1
robots: [uc2]
problems:
  - type: monte-carlo
    lengths_m: [7.5, 8]
    samples: 3
    seed: 1
    perturb:
      mass_kg: {distribution: normal, relative_sigma: 0.05}
      centre_of_mass_m: {distribution: uniform, half_width: 0.02, axes: [x, z]}
options: {certificates: true}
"""


def test_a_perturbed_robot_is_written_and_is_what_the_result_is_about(run, tmp_path):
    jobs, out, file = write(tmp_path, PERTURBED), tmp_path / "out", tmp_path / "robot.yaml"
    assert run(jobs, "--out", out, "--threads", 1).exit_code == 0
    shown = run("show", out, 2, "--json", "--robot", file, "--certificate", tmp_path / "c.cert")
    document, robot, nominal = json.loads(shown.stdout), load_robot(file), load_robot("uc2")
    assert robot.sha256 == document["robot"]["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    assert robot.platform.mass != nominal.platform.mass
    (x, y, z), centre = robot.platform.centre_of_mass, nominal.platform.centre_of_mass
    assert x != centre[0] and y == centre[1] and z != centre[2]
    assert robot.cables == nominal.cables
    result = Result.from_json(json.dumps(document))
    assert result.verify(robot) == []
    again = forward_kinematics(robot, ["7.5", "8"])
    assert [s.position.tolist() for s in again.solutions] == [s.position.tolist() for s in result.solutions]
    assert run("check", out).exit_code == 0


def test_an_unperturbed_robot_is_written_as_its_file(run, tmp_path):
    jobs, out, file = write(tmp_path, listed(ROWS[:1])), tmp_path / "out", tmp_path / "robot.yaml"
    run(jobs, "--out", out, "--threads", 1)
    assert run("show", out, 1, "--robot", file).exit_code == 0
    assert file.read_bytes() == load_robot("merlet_4_1").file
    refused = run("show", out, 1, "--robot", tmp_path)
    assert refused.exit_code == 2 and "--robot: " in refused.stderr


@pytest.mark.parametrize(
    ("perturb", "message"),
    [
        ("mass_kg: {distribution: uniform, half_width: 1}", "perturb.mass_kg: could become zero"),
        ("mass_kg: {distribution: normal, relative_sigma: 0.25}", "perturb.mass_kg: could become zero"),
        ("centre_of_mass_m: {distribution: normal, relative_sigma: 0.1}", "needs an absolute width"),
    ],
)
def test_a_perturbation_that_cannot_be_is_refused(run, tmp_path, perturb, message):
    text = re.sub(r"    perturb:(.|\n)*axes.*\n", f"    perturb: {{{perturb}}}\n", PERTURBED)
    done = run(write(tmp_path, text), "--out", tmp_path / "out")
    assert done.exit_code == 2 and message in done.stderr


def test_the_centre_of_a_point_mass_cannot_be_moved(run, tmp_path):
    text = PERTURBED.replace("uc2", "merlet_4_1").replace("[7.5, 8]", "[2.69, 3.9, 3.35, 4.38]")
    done = run(write(tmp_path, text), "--out", tmp_path / "out")
    assert done.exit_code == 2 and "perturb.centre_of_mass_m: 'merlet-4-1' is a point mass" in done.stderr


def table_of(run, tmp_path, text, *options):
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    jobs = write(tmp_path, "format: cdpr-batch/1\nrobots: [uc2]\nproblems: [{type: csv, file: t.csv}]\n")
    return run(jobs, *options)


HEADS = [
    ("c1;c2\n1;2\n", ["columns are separated by ';': write commas, and decimals with a point"]),
    ("c1\tc2\n1\t2\n", ["columns are separated by tabs: write commas, and decimals with a point"]),
    (
        "time,c1,c2\n" + "0,7.5,8\n" * 9,
        ["unknown column 'time': a column of your own begins with x_ ('x_time')"],
    ),
    (",c1,c2\n0,7.5,8\n", ["column 1 has no title: a column of your own begins with x_"]),
    ("C1,c2\n7.5,8\n", ["no column for c1", "unknown column 'C1' (did you mean 'c1'?)"]),
    ("c1,length_c1_m,c2\n7,7,8\n", ["column 'length_c1_m' is the second one of cable 'c1'"]),
    ("length_c1_m,x_m\n7,7\n", ["no column for c2"]),
    ("c1,c2,job\n7,7,1\n", ["unknown column 'job': a column of your own begins with x_ ('x_job')"]),
]


@pytest.mark.parametrize(("text", "messages"), HEADS)
def test_a_wrong_head_is_refused_once_in_its_own_line(run, tmp_path, text, messages):
    done = table_of(run, tmp_path, text, "--dry-run")
    said = [f"problems[0]: file 't.csv' line 1: {message}" for message in messages]
    assert done.exit_code == 2
    assert [line.partition(": ")[2] for line in done.stderr.splitlines()] == said


def test_lengths_of_a_table_of_solutions_are_read_again(run, tmp_path):
    done = table_of(run, tmp_path, "x_t,c1,c2\n0,7.5,8\n1,7.25,8\n", "--out", tmp_path / "a", "--threads", 1)
    assert done.exit_code == 0
    solutions = (tmp_path / "a" / "solutions.csv").read_text(encoding="utf-8")
    assert len(solutions.splitlines()) > 3
    again = table_of(run, tmp_path, solutions, "--out", tmp_path / "b", "--threads", 1)
    assert again.exit_code == 0 and again.stdout.startswith("2 jobs: 2 done")
    assert (tmp_path / "b" / "solutions.csv").read_text(encoding="utf-8") == solutions
