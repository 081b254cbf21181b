"""A batch on a Dask cluster of processes, one of which is killed on the way."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from cdpr_interval.errors import InputError
from solvers.batch import dask_cluster
from solvers.batch.dask_cluster import DaskCluster
from tests.cli.test_batch import ended, process
from tests.support.batch_workers import MONTE_CARLO, write

pytest.importorskip("distributed")


@pytest.fixture
def cluster(tmp_path):
    """Run a scheduler and two workers of one thread each."""
    file = tmp_path / "scheduler.json"
    environment = {**os.environ, "PYTHONWARNINGS": "ignore"}

    def start(*arguments):
        return subprocess.Popen(
            [sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:], "--no-dashboard"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
            cwd=tmp_path,
        )

    processes = [start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))]
    place = ["--nthreads", "1", "--no-nanny", "--local-directory", str(tmp_path)]
    processes += [start("dask_worker", "--scheduler-file", str(file), *place) for _ in range(2)]
    yield file, processes
    for one in processes:
        one.kill()
        one.wait(30)


@pytest.mark.slow
def test_all_jobs_are_done_though_a_worker_is_killed(cluster, tmp_path):
    file, (_, _, victim) = cluster
    jobs, out, whole = write(tmp_path, MONTE_CARLO.format(samples=4000)), tmp_path / "out", tmp_path / "whole"
    running = process(jobs, "--out", out, "-q", "--scheduler-file", file)
    end = time.monotonic() + 100
    while not ended(out) and running.poll() is None and time.monotonic() < end:
        time.sleep(0.02)
    before = len(ended(out))
    os.kill(victim.pid, signal.SIGKILL)
    _, errors = running.communicate(timeout=200)
    assert running.returncode == 0, errors
    assert 0 < before < 4000 == len(ended(out))
    here = process(jobs, "--out", whole, "-q")
    here.communicate(timeout=200)
    assert (out / "results.jsonl").read_bytes() == (whole / "results.jsonl").read_bytes()


def test_no_scheduler(monkeypatch):
    monkeypatch.setattr(dask_cluster, "PATIENCE", 1.0)
    with pytest.raises(InputError, match=r"--scheduler: tcp://127.0.0.1:9: "):
        DaskCluster.connected("tcp://127.0.0.1:9", None)
    with pytest.raises(InputError, match="--scheduler: not together with --scheduler-file"):
        DaskCluster.connected("a", "b")
