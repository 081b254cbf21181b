"""The loop of a batch with real processes, some of which die."""

from __future__ import annotations

import json
import sqlite3
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from importlib.resources import files
from multiprocessing import active_children

import pytest

from cdpr_interval import load_robot
from cdpr_interval.errors import InputError
from certificates import check
from solvers.answers.provenance import versions
from solvers.answers.result import Result
from solvers.answers.tool import this_tool
from solvers.batch import pool as pool_module
from solvers.batch import work
from solvers.batch.campaign import begin, proceed, result_of, robot_of
from solvers.batch.executor import ExecutorError
from solvers.batch.job import Settings
from solvers.batch.job_file import read_job_file
from solvers.batch.ledger import Ledger
from solvers.batch.ledger_file import FILE, LedgerError
from solvers.batch.pool import ProcessPool
from solvers.batch.work import Chunk, JobOutcome, Status, Task, solve_chunk
from solvers.forward import forward_kinematics
from tests.support import batch_workers
from tests.support.batch_workers import DEADLY, MONTE_CARLO, listed, write

VERSION = this_tool().version


def solve(folder, batch, work=solve_chunk, workers=2):
    reports = []
    pool = ProcessPool(workers, work)
    with begin(batch, folder) as ledger:
        try:
            document = proceed(ledger, pool, reports.append)
        finally:
            pool.close()
    return document, reports


def jobs_of(folder):
    with Ledger.peek(folder) as ledger:
        return list(ledger.recorded())


def test_every_answer_is_that_of_the_solver(tmp_path):
    batch = read_job_file(write(tmp_path, MONTE_CARLO.format(samples=30)))
    document, reports = solve(tmp_path / "out", batch)
    assert document["jobs"]["done"] == 30
    assert reports[-1].done == reports[-1].total == 30 and reports[-1].bad == 0
    with Ledger.peek(tmp_path / "out") as ledger:
        for number in (1, 17, 30):
            found = result_of(ledger, number)
            job = ledger.job(number)
            robot, asked = by_hand(job)
            wanted = forward_kinematics(robot, asked["lengths_m"]).to_dict()
            for timed in (wanted["statistics"], *wanted["subsets"]):
                timed["time_s"] = 0.0
            ended = datetime.fromtimestamp(job.started + job.seconds, UTC).replace(microsecond=0)
            assert datetime.fromisoformat(found["provenance"].pop("date")) == ended
            assert datetime.fromisoformat(wanted["provenance"].pop("date")) >= ended
            assert found == wanted


RANGES = """
format: cdpr-batch/1
robots: [vague.yaml, merlet_4_1]
problems:
  - type: lengths
    lengths_m:
      - [2.69+-0.001, "[3.8, 3.9]", 3.35, 4.38]
      - [2.96, 3.05..3.06, 3.14+-0.01, 3.23]
"""


def test_jobs_with_ranges_are_answered_as_single_calls_are(tmp_path):
    document = load_robot("merlet_4_1").to_dict() | {"name": "vague"}
    document["platform"]["mass_kg"] = {"value": 80, "tolerance": 1}
    document["cables"][0]["frame_anchor_m"][2] = [-0.01, 0.01]
    (tmp_path / "vague.yaml").write_text(json.dumps(document, default=float))
    rows = [["2.69+-0.001", "[3.8,3.9]", "3.35", "4.38"], ["2.96", "3.05..3.06", "3.14+-0.01", "3.23"]]
    solve(tmp_path / "out", read_job_file(write(tmp_path, RANGES)))
    wanted = [
        forward_kinematics(robot, row).to_dict()
        for robot in (load_robot(tmp_path / "vague.yaml"), load_robot("merlet_4_1"))
        for row in rows
    ]
    found = [result_of_job(tmp_path / "out", number) for number in range(1, 5)]
    assert all(len(document["solutions"]) == 1 for document in wanted)
    assert list(map(timeless, found)) == list(map(timeless, wanted))


def result_of_job(folder, number):
    with Ledger.peek(folder) as ledger:
        return result_of(ledger, number)


def timeless(document):
    """Return a result without what says when it was found, and in how long."""
    for timed in (document["statistics"], *document["subsets"]):
        timed["time_s"] = 0.0
    document["provenance"].pop("date")
    return document


def by_hand(job):
    """Build the perturbed robot by hand."""
    import json
    from dataclasses import replace
    from fractions import Fraction

    asked, robot = json.loads(job.input), load_robot("merlet_4_1_k100")
    cables = [
        replace(cable, elasticity=replace(cable.elasticity, stiffness=Fraction(k)))
        for cable, k in zip(robot.cables, asked["stiffness"], strict=True)
    ]
    return replace(robot, cables=tuple(cables)), asked


@pytest.mark.slow
def test_a_job_that_kills_its_worker_is_tried_alone_and_marked(tmp_path):
    rows = [[2.7 + 0.01 * k, 3.9, 3.35, 4.4] for k in range(40)]
    rows[23][0] = DEADLY
    batch = read_job_file(write(tmp_path, listed(rows)))
    document, reports = solve(tmp_path / "out", batch, batch_workers.deadly)
    assert document["jobs"] == {
        "pending": 0, "done": 39, "no-pose": 0, "none-found": 0, "failed": 0, "crashed": 1
    }  # fmt: skip
    assert reports[-1].bad == 1
    (bad,) = [job for job in jobs_of(tmp_path / "out") if job.status is Status.CRASHED]
    assert bad.item == 23 and bad.attempts >= 2 and "SIGKILL" in bad.message


def test_a_worker_that_died_idle_is_no_jobs_crash():
    pool = ProcessPool(1)
    robot = (files("cdpr_interval") / "robots" / "library" / "merlet_4_1.yaml").read_bytes()
    task = Task(1, '{"lengths_m":["2.7","3.9","3.35","4.4"]}')
    chunk = Chunk(robot, Settings().to_json(), (task,), is_retry=True)
    try:
        for _ in range(2):
            pool.submit(chunk)
            while not (found := pool.wait(1.0)):
                pass
            assert found[0].outcomes[0].status is Status.DONE
            (child,) = [child for child in active_children() if child.name == "batch worker"]
            child.kill()
            child.join()
    finally:
        pool.close()


@pytest.mark.slow
def test_crashed_jobs_can_be_tried_again(tmp_path):
    for name, text, dead in (("listed", listed([[DEADLY, 3.9, 3.35, 4.4]]), batch_workers.deadly),
                             ("split", SPLIT, batch_workers.deadly_part)):  # fmt: skip
        batch = read_job_file(write(tmp_path, text))
        document, _ = solve(tmp_path / name, batch, dead)
        assert document["jobs"]["crashed"] == 1
        with begin(batch, tmp_path / name) as ledger:
            assert ledger.reopen() == (1 if name == "listed" else 2)
        document, reports = solve(tmp_path / name, batch)
        assert document["jobs"]["crashed"] == 0 and reports[-1].bad == 0
        again = jobs_of(tmp_path / name)[-1]
        assert again.status is Status.DONE and again.message == "" and again.answer is not None
        solve(tmp_path / f"{name} at once", batch)
        assert again.answer == jobs_of(tmp_path / f"{name} at once")[-1].answer


def test_threads_of_one_worker_take_turns(monkeypatch):
    inside, most = [], []

    def solver(data, settings):
        inside.append(1)
        most.append(len(inside))
        time.sleep(0.01)
        inside.pop()
        return None

    monkeypatch.setattr(work, "_solver", solver)
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(solve_chunk, [Chunk(b"", Settings().to_json(), ())] * 8)) == [[]] * 8
    assert most == [1] * 8


@pytest.mark.slow
def test_jobs_that_are_in_bad_company_only_are_done(tmp_path):
    batch = read_job_file(write(tmp_path, MONTE_CARLO.format(samples=60)))
    document, _ = solve(tmp_path / "out", batch, batch_workers.deadly_in_company)
    assert document["jobs"]["done"] == 60


def test_a_first_job_that_kills_is_no_obstacle(tmp_path):
    rows = [[DEADLY, 3.9, 3.35, 4.4], [2.7, 3.9, 3.35, 4.4]]
    batch = read_job_file(write(tmp_path, listed(rows)))
    document, _ = solve(tmp_path / "out", batch, batch_workers.deadly)
    assert (document["jobs"]["done"], document["jobs"]["crashed"]) == (1, 1)


def test_what_the_solver_refuses_has_failed_with_its_reason(tmp_path):
    text = listed([[2.7, 3.9, 3.35, 4.4], [2.7, 3.9, 3.35, 4.5]])
    batch = read_job_file(write(tmp_path, text))
    with begin(batch, tmp_path / "out") as ledger:
        ledger._connection.execute('UPDATE jobs SET input = \'{"lengths_m": ["1"]}\' WHERE number = 2')
        pool = ProcessPool(2, solve_chunk)
        try:
            document = proceed(ledger, pool, [].append)
        finally:
            pool.close()
    assert (document["jobs"]["done"], document["jobs"]["failed"]) == (1, 1)
    bad = jobs_of(tmp_path / "out")[1]
    assert bad.status is Status.FAILED and "1 length for 4 cables" in bad.message


def test_workers_that_cannot_start_are_no_jobs_fault(tmp_path, monkeypatch):
    batch = read_job_file(write(tmp_path, MONTE_CARLO.format(samples=4)))
    monkeypatch.setattr(pool_module, "_serve", batch_workers.stillborn)
    with pytest.raises(ExecutorError, match="no worker process can start: the worker ended with code 7"):
        solve(tmp_path / "out", batch)
    assert {job.status for job in jobs_of(tmp_path / "out")} == {Status.PENDING}


def test_going_on_does_only_what_is_pending(tmp_path):
    batch = read_job_file(write(tmp_path, MONTE_CARLO.format(samples=20)))
    with begin(batch, tmp_path / "out") as ledger:
        early = [JobOutcome(n, Status.DONE, '{"fake": 1}', "", 5.0, 1.0, "x") for n in (3, 4)]
        ledger.record(early)
        ledger.record([JobOutcome(3, Status.FAILED, "{}", "late", 9.0, 1.0, "y")])
    with begin(batch, tmp_path / "out") as ledger:
        assert ledger.counts()[Status.PENDING] == 18
        assert [entry.task.number for entry in ledger.pending()][:3] == [1, 2, 5]
        kept = ledger.job(3)
        assert kept.status is Status.DONE and kept.answer == '{"fake": 1}' and kept.host == "x"


# What can be wrong with a ledger.


@pytest.fixture
def folder(tmp_path):
    begin(read_job_file(write(tmp_path, MONTE_CARLO.format(samples=5))), tmp_path / "out").close()
    return tmp_path / "out"


def changed(folder, statement, *values):
    connection = sqlite3.connect(folder / FILE)
    with connection:
        connection.execute(statement, values)
    connection.close()


def test_no_ledger(tmp_path):
    with pytest.raises(LedgerError, match="no batch there"):
        Ledger.open(tmp_path, VERSION)


def test_ledger_of_another_version(folder):
    changed(folder, "UPDATE meta SET value = '0.0.1' WHERE key = 'version'")
    before = (folder / FILE).read_bytes()
    with pytest.raises(LedgerError, match=r"written by version 0\.0\.1, this is .*: use|must not be mixed"):
        Ledger.open(folder, VERSION)
    assert (folder / FILE).read_bytes() == before


def test_ledger_of_another_format(folder):
    changed(folder, "UPDATE meta SET value = 'cdpr-ledger/9' WHERE key = 'format'")
    with pytest.raises(LedgerError, match="format cdpr-ledger/9, this version reads cdpr-ledger/2"):
        Ledger.peek(folder)


@pytest.mark.parametrize("content", [b"", b"not a database, but long enough to look like one" * 40])
def test_what_is_no_ledger(folder, content):
    (folder / FILE).write_bytes(content)
    with pytest.raises(LedgerError, match=r"not a database|is no ledger"):
        Ledger.open(folder, VERSION)
    assert not content or (folder / FILE).read_bytes() == content


def test_another_batch_in_the_folder(folder, tmp_path):
    other = read_job_file(write(tmp_path, MONTE_CARLO.format(samples=6)))
    with pytest.raises(InputError, match="holds another batch"):
        begin(other, folder)


def test_a_table_that_was_changed_is_another_batch(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("c1,c2\n4.5,4.5\n4.51,4.49\n")
    text = "format: cdpr-batch/1\nrobots: [uc2]\nproblems:\n  - {type: csv, file: t.csv}\n"
    begin(read_job_file(write(tmp_path, text)), tmp_path / "out").close()
    begin(read_job_file(write(tmp_path, text)), tmp_path / "out").close()
    for changed_table in (
        "c1,c2\n4.5,4.5\n4.51,4.48\n",
        "c1,c2\n4.5,4.5\n",
        "c1,c2\n4.5,4.5\n4.51,4.49\n5,5\n",
    ):
        table.write_text(changed_table)
        with pytest.raises(InputError, match=r"holds another batch \(the jobs differ\)"):
            begin(read_job_file(write(tmp_path, text)), tmp_path / "out")
    table.write_text("c2,c1,notes\n4.50,4.5,x\n4.49,4.51,\n")
    begin(read_job_file(write(tmp_path, text)), tmp_path / "out").close()


def test_one_writer(folder):
    with Ledger.open(folder, VERSION):
        with pytest.raises(LedgerError, match="another process is running this batch"):
            Ledger.open(folder, VERSION)
        with Ledger.peek(folder) as reader:
            assert reader.counts()[Status.PENDING] == 5
    Ledger.open(folder, VERSION).close()


def test_full_disk(folder):
    """A ledger that cannot grow keeps what it has, and is whole."""
    with Ledger.open(folder, VERSION) as ledger:
        ledger.record([JobOutcome(1, Status.DONE, "{}", "", 0.0, 1.0, "x")])
        (pages,) = ledger._connection.execute("PRAGMA page_count").fetchone()
        ledger._connection.execute(f"PRAGMA max_page_count = {pages}")
        with pytest.raises(LedgerError, match=r"full.*make room, then cdpr-solve batch resume"):
            ledger.record([JobOutcome(2, Status.DONE, "x" * 100_000, "", 0.0, 1.0, "x")])
    with Ledger.open(folder, VERSION) as ledger:
        assert ledger.job(1).status is Status.DONE
        assert ledger.job(2).status is Status.PENDING and ledger.job(2).answer is None
        assert ledger._connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)


def test_two_jobs_that_are_the_same(tmp_path):
    rows = [[2.7, 3.9, 3.35, 4.4], [2.8, 3.9, 3.35, 4.4], [2.70, 3.9, 3.350, 4.4]]
    batch = read_job_file(write(tmp_path, listed(rows)))
    with pytest.raises(InputError, match=r"problems\[0\] job 2 is the same as problems\[0\] job 0"):
        begin(batch, tmp_path / "out")
    assert not (tmp_path / "out").exists()


# One problem on several workers.

SPLIT = """
format: cdpr-batch/1
robots: [uc3]
problems:
  - {type: lengths, lengths_m: [[7.5, 8, 7], [7.6, 8, 7]]}
options: {split: 6}
"""


def test_a_split_job_is_put_together(tmp_path):
    batch = read_job_file(write(tmp_path, SPLIT))
    document, reports = solve(tmp_path / "out", batch)
    assert document["jobs"]["done"] == 2 and reports[-1].total == 2 + 12
    with Ledger.peek(tmp_path / "out") as ledger:
        first, second = ledger.recorded()
        assert [len(ledger.parts(job.number)) for job in (first, second)] == [6, 6]
        found = result_of(ledger, first.number)
        part = ledger.parts(second.number)[0].number
        with pytest.raises(
            InputError, match=f"job {part}: is a part of job {second.number}, which has the result"
        ):
            result_of(ledger, part)
    wanted = forward_kinematics(load_robot("uc3"), ["7.5", "8", "7"]).to_dict()
    assert found["outcome"] == "complete" and len(found["solutions"]) == len(wanted["solutions"]) == 15
    for one, other in zip(found["solutions"], wanted["solutions"], strict=True):
        assert one["taut"] == other["taut"]
        assert one["nominal"]["position_m"] == pytest.approx(other["nominal"]["position_m"], abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("lost", [0, 2, 5])
def test_a_job_with_a_part_missing_is_no_result(tmp_path, lost):
    batch = read_job_file(write(tmp_path, SPLIT))
    begin(batch, tmp_path / "out").close()
    changed(tmp_path / "out", "DELETE FROM jobs WHERE number = ?", 2 + lost)
    document, _ = solve(tmp_path / "out", batch)
    assert (document["jobs"]["done"], document["jobs"]["failed"]) == (1, 1)
    assert jobs_of(tmp_path / "out")[0].message == f"part {lost} of 6 is missing"


@pytest.mark.slow
def test_a_part_that_crashes_takes_its_job_with_it(tmp_path):
    batch = read_job_file(write(tmp_path, SPLIT))
    document, _ = solve(tmp_path / "out", batch, batch_workers.deadly_part)
    assert (document["jobs"]["done"], document["jobs"]["crashed"]) == (1, 1)
    first, second = jobs_of(tmp_path / "out")
    assert first.status is Status.DONE
    assert second.status is Status.CRASHED and "part " in second.message and "SIGKILL" in second.message


def test_a_batch_keeps_certificates(tmp_path):
    text = "format: cdpr-batch/1\nrobots: [uc2]\nproblems:\n  - {type: lengths, lengths_m: [[4.5, 4.5]]}\n"
    batch = read_job_file(write(tmp_path, text + "options: {certificates: true}\n"))
    solve(tmp_path / "out", batch)
    with Ledger.peek(tmp_path / "out") as ledger:
        assert ledger.certified() == [1]
        (tmp_path / "proof").write_bytes(ledger.certificate(1))
    report = check(tmp_path / "proof")
    assert report.verdict == "PROVED" and report.complete


def test_a_result_of_a_batch_says_where_it_comes_from(tmp_path):
    batch = read_job_file(write(tmp_path, MONTE_CARLO.format(samples=2)))
    solve(tmp_path / "out", batch)
    with Ledger.peek(tmp_path / "out") as ledger:
        document, job, robot = result_of(ledger, 2), ledger.job(2), robot_of(ledger, 2)
    result = Result.from_json(document)
    origin = result.provenance
    assert origin.host == job.host and origin.versions == versions()
    assert origin.robot == robot and result.verify(robot) == []
    again = forward_kinematics(origin.robot, origin.lengths)
    assert again.to_dict()["solutions"] == document["solutions"]
    assert "provenance" not in job.answer and job.host not in job.answer
