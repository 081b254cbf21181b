"""The check of a whole certificate."""

from __future__ import annotations

import math
import multiprocessing
import random
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain, zip_longest
from pathlib import Path

from flint import ctx

from certificates.balls import BITS
from certificates.container import HEAD, load, unpack
from certificates.families import check_one_point_family
from certificates.literals import entry_of, list_of, text_of
from certificates.point_mass import check_point
from certificates.problem import Listed, needed, read_left_out, read_problem, read_solutions, read_taut
from certificates.searches import Searches
from certificates.subsets import Kind, classify, examined
from certificates.verdicts import Malformed, NotProved, Report, Verdict

CHUNK = 16
"""Cells that are checked in one go."""
DIGEST = slice(len(HEAD), len(HEAD) + 64)
"""Where a file has its digest."""
Chunk = tuple[int, Sequence[int]]
"""A subset, and which of its cells."""


class OutOfTime(Exception):
    """The time limit has passed."""


class Certificate:
    """A certificate that was read, but for the proofs in it."""

    def __init__(self, content: bytes) -> None:
        document = unpack(content)
        self.problem = read_problem(document)
        self.solutions = read_solutions(document, self.problem)
        self.left_out = read_left_out(document, self.problem)
        self.entries = list_of(document["subsets"], "subsets")
        needed(all(isinstance(v, dict) and "taut" in v for v in self.entries), "a subset without taut cables")
        self.subsets = [read_taut(v["taut"], len(self.problem.names)) for v in self.entries]
        if any(a != b for a, b in zip_longest(self.subsets, examined(self.problem))):
            raise NotProved("the subsets are not those to be examined, in their order")
        self.kept: tuple[int, Searches] | None = None

    def name(self, k: int) -> str:
        """Return what a subset is called."""
        return "subset " + ",".join(self.problem.names[i] for i in self.subsets[k])

    def searches(self, k: int, kind: Kind) -> Searches:
        """Return the searches of a subset; those of one are kept."""
        if self.kept is None or self.kept[0] != k:
            entry = self.entries[k]["searches"]
            self.kept = k, Searches(self.problem, self.subsets[k], kind, entry, self.solutions)
        return self.kept[1]

    def check_entry(self, k: int) -> tuple[set[int], int, int, int]:
        """Check a subset but for its cells; return solutions, numbers of cells, pending, undecided."""
        entry, taut = self.entries[k], self.subsets[k]
        kind = None if self.problem.is_point_mass else classify(self.problem, taut)
        place = "point" if kind in (None, Kind.FREE, Kind.ONE_POINT) else "searches"
        entry_of(entry, "entry", ("taut", *(key for key in ("pending", place) if key in entry)))
        pending = int("pending" in entry)
        text_of(entry.get("pending", ""), "pending")
        if place not in entry:
            if not pending and (kind is not Kind.DEPENDENT or self.problem.taut is not None):
                raise NotProved("there is no proof")
            return set(), 0, pending, 0
        needed(kind is not Kind.DEPENDENT, "dependent wrenches are not searched")
        if kind is None or place == "point":
            check = check_point if kind is None else check_one_point_family
            return check(self.problem, taut, entry["point"], self.solutions), 0, pending, 0
        searches = self.searches(k, kind)
        return searches.check_roots(), len(searches.leaves), pending + searches.open[0], searches.open[1]

    def check_cells(self, chunk: Chunk) -> int:
        """Check cells; return the number of parts it took."""
        k, places = chunk
        parts = 0
        with about(self.name(k)):
            searches = self.searches(k, classify(self.problem, self.subsets[k]))
            for place in places:
                with about(f"cell {place + 1}"):
                    parts += searches.check(searches.leaves[place])
        return parts


@contextmanager
def about(what: str) -> Iterator[None]:
    """Compute precisely and say what a failure is about: one of any kind proves nothing."""
    try:
        with ctx.workprec(BITS):
            yield
    except (Malformed, NotProved) as error:
        raise type(error)(f"{what}: {error}") from None
    except Exception as error:
        raise NotProved(f"{what}: {type(error).__name__}: {error}") from None


def check(
    path: str | Path | bytes,
    *,
    sample: int | None = None,
    jobs: int = 1,
    time_limit: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Report:
    """Check a certificate file.

    Parameters
    ----------
    path
        The file, or its bytes.
    sample
        Check so many cells, chosen at random, instead of all.
    jobs
        Number of processes. With more than one a script must call this under ``if __name__ == "__main__"``.
    time_limit
        Seconds.
    progress
        Called with the numbers of cells checked and to be checked.
    """
    start = time.monotonic()
    end = math.inf if time_limit is None else start + time_limit
    report = Report(Verdict.NOT_PROVED, "", False, 0, 0, 0, 0, 0, 0, 0, 0.0)
    try:
        content = path if isinstance(path, bytes) else load(path)
        for current in reports(content, report, sample, jobs, end):
            report = current
            if progress is not None and report.leaves:
                progress(report.checked, report.leaves if sample is None else min(sample, report.leaves))
    except OutOfTime:
        report = replace(report, verdict=Verdict.OUT_OF_TIME, message="the time limit has passed")
    except Malformed as error:
        report = replace(report, verdict=Verdict.MALFORMED, message=str(error))
    except Exception as error:
        report = replace(report, verdict=Verdict.NOT_PROVED, message=str(error) or type(error).__name__)
    return replace(report, seconds=time.monotonic() - start)


def reports(content: bytes, report: Report, sample: int | None, jobs: int, end: float) -> Iterator[Report]:
    """Yield what has been checked, again and again; the last report has the verdict."""
    certificate = Certificate(content)
    solutions, cells = certificate.solutions, []
    report = replace(report, solutions=len(solutions), subsets=len(certificate.subsets))
    backed: set[int] = set()
    for k in range(report.subsets):
        in_time(end)
        with about(certificate.name(k)):
            found, count, pending, undecided = certificate.check_entry(k)
        backed |= found
        cells.append(count)
        pending, undecided = report.pending + pending, report.undecided + undecided
        report = replace(report, leaves=report.leaves + count, pending=pending, undecided=undecided)
        yield report
    for k in sorted({*range(len(solutions))} - backed):
        raise NotProved(f"solution {k + 1} is backed by no proof")
    require_apart(solutions)
    starts = ((k, n, i) for k, n in enumerate(cells) for i in range(0, n, CHUNK))
    chunks: list[Chunk] = [(k, range(n)[i : i + CHUNK]) for k, n, i in starts]
    if sample is not None and sample < report.leaves:
        single: list[Chunk] = [(k, (i,)) for k, n in enumerate(cells) for i in range(n)]
        chunks = sorted(random.Random(content[DIGEST]).sample(single, sample))
    for checked, parts in results(certificate, content, chunks, jobs):
        report = replace(report, checked=report.checked + checked, parts=report.parts + parts)
        yield report
        in_time(end)
    text, complete = summary(certificate, report)
    if report.checked == report.leaves:
        yield replace(report, verdict=Verdict.PROVED, message=text, complete=complete)
    else:
        text = f"{report.checked} of {report.leaves} cells are confirmed; all of them would prove: {text}"
        yield replace(report, verdict=Verdict.SAMPLED, message=text)


def in_time(end: float) -> None:
    """Raise OutOfTime after the end of the time."""
    if time.monotonic() > end:
        raise OutOfTime


def require_apart(solutions: list[Listed]) -> None:
    """Raise NotProved where two boxes of solutions meet, those of families excepted."""
    single = ((k, s) for k, s in enumerate(solutions, 1) if s.family is None)
    boxes = sorted(([*s.position, *chain(*s.rotation)], k) for k, s in single)
    for n, (a, k) in enumerate(boxes):
        for b, j in boxes[n + 1 :]:
            if b[0][0] > a[0][1]:
                break
            if all(x[0] <= y[1] and y[0] <= x[1] for x, y in zip(a, b, strict=True)):
                raise NotProved(f"solutions {min(j, k)} and {max(j, k)} may be the same")


def summary(certificate: Certificate, report: Report) -> tuple[str, bool]:
    """Return what the certificate claims, and whether it leaves nothing open."""
    problem, solutions = certificate.problem, certificate.solutions
    is_open = bool(report.pending or report.undecided or certificate.left_out)
    number = str(len(solutions)) if solutions or is_open else "no"
    text = f"{number} static pose{'s' * (len(solutions) != 1 and number != 'no')}"
    if any(s.family for s in solutions):
        text += f" ({sum(s.family is not None for s in solutions)} with a family)"
    if problem.taut is not None:
        text += f" of {certificate.name(0)}"
    text += " (slackness ignored)" * problem.ignore_slack + " (signs ignored)" * problem.ignore_tension_sign
    if is_open:
        left = f"{report.pending} pending, {report.undecided} undecided, {certificate.left_out} not certified"
        return f"{text}; others may exist: {left}", False
    text += ", and no other one" if solutions else ""
    if any("undecided" in s.states or s.slack_respected is None for s in solutions):
        return f"{text}; undecided is whether every cable is slack or taut", False
    return text, True


def results(
    certificate: Certificate, content: bytes, chunks: list[Chunk], jobs: int
) -> Iterator[tuple[int, int]]:
    """Yield the size of each chunk, and the number of parts, once it is checked."""
    if jobs < 2 or len(chunks) < 2:
        yield from ((len(chunk[1]), certificate.check_cells(chunk)) for chunk in chunks)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(chunks)), context, initializer=start_worker, initargs=(content,))
    try:
        sizes = {pool.submit(work, chunk): len(chunk[1]) for chunk in chunks}
        for future in as_completed(sizes):
            yield sizes[future], future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


worker: list[Certificate] = []
"""What this process checks, if it is a worker."""


def start_worker(content: bytes) -> None:
    """Read the certificate in a worker, which leaves interrupts to its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    worker.append(Certificate(content))


def work(chunk: Chunk) -> int:
    """Check a chunk in a worker."""
    return worker[0].check_cells(chunk)
