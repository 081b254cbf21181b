"""The check of a whole certificate, and its verdict."""

from __future__ import annotations

import random
import secrets
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from certificates import clock
from certificates.apart import is_decided, require_apart
from certificates.certificate import Certificate, about
from certificates.container import load
from certificates.lots import Lot, in_turn, lots
from certificates.verdicts import Malformed, NotProved, Report, Verdict, counted, reasons

TWICE, SHARE = 32, 100
"""So many cells, and one of so many, are checked in both arithmetics."""
Results = Iterator[tuple[int, int]]
"""How many cells were checked, in how many parts."""


def check(
    path: str | Path | bytes,
    *,
    sample: int | None = None,
    seed: int | None = None,
    threads: int = 1,
    time_limit: float | None = None,
    size_limit: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Report:
    """Check a certificate file.

    Parameters
    ----------
    path
        The file, or its bytes.
    sample
        Check so many cells, chosen at random, instead of all.
    seed
        Draws the same cells again, to be checked at all or in both arithmetics; without one the system draws.
    threads
        Number of processes. With more than one a script must call this under ``if __name__ == "__main__"``.
    time_limit
        Seconds.
    size_limit
        Most bytes of the file and of the document in it; default 64 MiB.
    progress
        Called with the numbers of cells checked and to be checked, the second as far as it is known.

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C, with a text that says how far the check was.

    Examples
    --------
    >>> from solvers import forward_kinematics
    >>> path = forward_kinematics("uc2", ["7.5", "8"]).certificate("uc2.cert")
    >>> report = check(path)
    >>> str(report.verdict), report.complete, report.solutions
    ('PROVED', True, 8)
    """
    start = time.monotonic()
    drawn = secrets.randbits(32) if seed is None else seed
    report = Report(Verdict.NOT_PROVED, "", False, 0, 0, 0, 0, 0, 0, 0, 0.0, drawn, chosen=sample)
    try:
        with clock.seconds(time_limit):
            content = path if isinstance(path, bytes) else load(path, size_limit)
            certificate = Certificate(content, size_limit)
            report = replace(report, question=certificate.question, subsets=len(certificate.subsets))
            run = partial(in_turn, certificate)
            if threads > 1:
                # It takes a tenth of a second to import what starts processes.
                from certificates.processes import together

                run = partial(together, certificate, content, size_limit, count=threads)
            for current in reports(certificate, report, run):
                report = current
                if progress is not None and report.leaves:
                    progress(report.checked, report.wanted)
    except clock.OutOfTime:
        text = f"the time limit has passed: {report.extent}"
        report = replace(report, verdict=Verdict.OUT_OF_TIME, message=text)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(report.extent) from None
    except Malformed as error:
        report = replace(report, verdict=Verdict.MALFORMED, message=str(error))
    except Exception as error:
        report = replace(report, verdict=Verdict.NOT_PROVED, message=str(error) or type(error).__name__)
    return replace(report, seconds=time.monotonic() - start)


def reports(
    certificate: Certificate, report: Report, run: Callable[[Iterator[Lot]], Results]
) -> Iterator[Report]:
    """Yield what has been checked, again and again; the last report has the verdict."""
    solutions, cells = certificate.solutions, []
    report = replace(report, solutions=len(solutions))
    backed: set[int] = set()
    for k in range(report.subsets):
        clock.in_time()
        with about(certificate.name(k)):
            found, count, pending, undecided = certificate.check_entry(k)
        backed |= found
        cells.append(count)
        pending, undecided = report.pending + pending, report.undecided + undecided
        report = replace(
            report, leaves=report.leaves + count, pending=pending, undecided=undecided, examined=k + 1
        )
        yield report
    for k in sorted({*range(len(solutions))} - backed):
        raise NotProved(f"solution {k + 1} is backed by no proof")
    require_apart(certificate.problem, solutions)
    generator = random.Random(report.seed)
    chosen = sorted(generator.sample(range(report.leaves), report.wanted))
    twice = generator.sample(chosen, min(len(chosen), max(TWICE, len(chosen) // SHARE)))
    report = replace(report, twice=len(twice))
    yield report
    for checked, parts in run(lots(certificate, cells, chosen, set(twice))):
        report = replace(report, checked=report.checked + checked, parts=report.parts + parts)
        yield report
        clock.in_time()
    why = reasons(certificate.entries, certificate.left_out, report.pending, report.undecided)
    report = replace(report, reasons=tuple(why))
    text, complete = summary(certificate, report.pending, report.undecided)
    if report.checked == report.leaves:
        yield replace(report, verdict=Verdict.PROVED, message=text, complete=complete)
    else:
        of_all = f"{report.checked} of {counted(report.leaves, 'cell')}"
        text = f"{of_all} confirmed; all of them would prove: {text}"
        yield replace(report, verdict=Verdict.SAMPLED, message=text)


def summary(certificate: Certificate, pending: int, undecided: int) -> tuple[str, bool]:
    """Return what the certificate claims, and whether it leaves nothing open.

    ``pending`` and ``undecided`` count the subsets and cells of which it claims nothing. Poses are counted
    only where every cable of all of them is decided: an entry with an undecided cable may stand for several
    poses of several subsets, or for none at some lengths.
    """
    problem, solutions = certificate.problem, certificate.solutions
    open_entries = sum(not is_decided(s) for s in solutions)
    is_open = bool(pending or undecided or certificate.left_out)
    left = f"{pending} pending, {undecided} undecided, {len(certificate.left_out)} not certified"
    asked = f" of {certificate.name(0)}" if problem.taut is not None else ""
    asked += " (slackness ignored)" * problem.ignore_slack + " (signs ignored)" * problem.ignore_tension_sign
    if open_entries:
        others = f"; others may exist: {left}" if is_open else ""
        entries = f"the entries{asked} hold, {open_entries} of {len(solutions)} with an undecided cable"
        return f"{entries}: how many static poses there are is not proved{others}", False
    text = counted(len(solutions), "static pose") if solutions or is_open else "no static pose"
    if any(s.family for s in solutions):
        text += f" ({sum(s.family is not None for s in solutions)} with a family)"
    if is_open:
        return f"{text}{asked}; others may exist: {left}", False
    return text + asked + (", and no other one" if solutions else ""), True
