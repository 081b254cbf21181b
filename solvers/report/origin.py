"""What a result is the answer to, and where it comes from, as rows of a report."""

from __future__ import annotations

from cdpr_interval.exact.decimals import exact_text
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.text.count import counted
from solvers.answers.result import Result
from solvers.answers.robot_data import LONGEST
from solvers.batch.duration import duration
from solvers.batch.ledger import Ledger

Row = tuple[str, str]


def asked_of(result: Result) -> list[Row]:
    """Return the question: lengths as they were given where that is known, and what narrows it."""
    question = result.question
    rows = [
        (f"length of {name}, m", text) for name, text in zip(result.cables, _lengths(result), strict=True)
    ]
    if question.tensions_given is not None:
        pairs = zip(result.cables, question.tensions_given, strict=True)
        rows = [(f"tension of {name}, N", _pair(lo, hi)) for name, (lo, hi) in pairs]
    taut = "all" if question.taut is None else ",".join(result.cables[i] for i in question.taut) + " only"
    rows.append(("taut cables asked for", taut))
    if any(question.external_force):
        force = (x if isinstance(x, tuple) else (x, x) for x in question.external_force)
        rows.append(("external force, N", ", ".join(_pair(lo, hi) for lo, hi in force)))
    if question.tension is not None:
        rows.append(("tensions asked for, N", _pair(*question.tension)))
    for name, is_set in (
        ("--ignore-slack", question.ignore_slack), ("--ignore-tension-sign", question.ignore_tension_sign)
    ):  # fmt: skip
        if is_set:
            rows.append((name, "yes"))
    rows.append(("method, precision", f"{question.method}, {question.precision:g}"))
    return rows


def origin_of(result: Result, robot: Robot) -> list[Row]:
    """Return who answered, when and with what, and the digest of the robot."""
    cost = result.statistics
    rows = [
        ("solved by", f"{result.tool.name} {result.tool.version}"),
        ("robot", f"{result.robot.name}{f' ({robot.source})' if robot.source else ''}"),
        ("SHA-256 of its file", result.robot.sha256 or "none: it is not as any file has it"),
        ("cost", f"{counted(cost.cells, 'cell')}, {counted(cost.threads, 'thread')}"),
    ]
    if result.statistics.time:
        rows.append(("time", duration(result.statistics.time)))
    provenance = result.provenance
    if provenance is not None:
        versions = ", ".join(f"{name} {version}" for name, version in provenance.versions.items())
        rows += [
            ("date", f"{provenance.date:%Y-%m-%d %H:%M:%S} UTC"),
            ("host", provenance.host),
            ("versions", versions),
        ]
    return rows


def batch_origin(ledger: Ledger) -> list[Row]:
    """Return who solved a batch, when, and the digests of its robots."""
    rows = [("solved by", f"cdpr-interval {ledger.fact('version')}"), ("begun", ledger.fact("created"))]
    rows += [(f"SHA-256 of {name}", digest) for digest, (name, _, _) in ledger.robots().items()]
    return [*rows, ("job file", ledger.fact("job_file"))]


def _lengths(result: Result) -> list[str]:
    provenance = result.provenance
    if provenance is not None and provenance.lengths:
        exact = [(exact_text(lo, LONGEST), exact_text(hi, LONGEST)) for lo, hi in provenance.lengths]
        return [lo if lo == hi else f"{lo} .. {hi}" for lo, hi in exact]
    return [_pair(lo, hi) for lo, hi in result.lengths.tolist()]


def _pair(lo: float, hi: float) -> str:
    return repr(lo) if lo == hi else f"in [{lo!r}, {hi!r}]"
