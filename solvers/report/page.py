"""The report as one HTML file that needs nothing else: no request leaves it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import Any

from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import parse_robot
from certificates.verdicts import Verdict
from solvers.answers.data import Outcome
from solvers.answers.result import Result
from solvers.answers.table import table
from solvers.answers.tool import this_tool
from solvers.batch.ledger import Ledger, Recorded
from solvers.batch.duration import duration
from solvers.batch.tables import job_rows
from solvers.batch.work import Status
from solvers.proofs.check import REFUSED, Proof
from solvers.report import plots
from solvers.report.scene import frame_points
from solvers.report.source import ResultSource

MOST_ROWS = 500
"""Of a table of solutions or failed jobs; what is left out is said."""
LEGEND = (
    "Straight cables are coloured by tension, slack ones hang in grey; dashed: just taut or just slack, "
    "one pose either way; dashed red: neither taut nor slack is proved. Red boxes hold what the "
    "search left undecided. Drawn are floats near the certified poses."
)
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:"
)
"""Browsers refuse every request of the page."""
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 1120px; margin: 2em auto;
  padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: 0.2em; } h2 { font-size: 1.2em; margin: 1.6em 0 0.4em; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 0.92em; }
th, td { padding: 0.25em 0.7em; border-bottom: 1px solid #ddd; text-align: left; }
.scroll { overflow-x: auto; }
.good, .open, .bad { padding: 0.5em 0.8em; border-left: 5px solid; margin: 0.6em 0; }
.good { border-color: #2ca02c; background: #f1faf1; } .open { border-color: #ff9d00; background: #fff8eb; }
.bad { border-color: #d62728; background: #fdf0f0; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 0.5em; }
footer { color: #777; margin-top: 2em; font-size: 0.85em; }
"""


def result_page(source: ResultSource) -> str:
    """Return the report of one result."""
    result = source.result
    left = left_open(result)
    parts = [
        f"<h1>{escape(result.robot.name)}</h1>",
        f"<p>{escape(result.model)}, {len(result.cables)} cables</p>",
        _banner("good" if result.outcome is Outcome.COMPLETE else "open", result.message),
        _banner("open" if left else "good", left or "Nothing is undecided, nothing was left out."),
        _proof(source.proof),
        "<h2>Cable lengths</h2>",
        _table(["cable", "length m"], list(zip(result.cables, _lengths(result), strict=True))),
        "<h2>The robot</h2>",
        _figure(plots.robot_figure(source.robot, result)),
        f"<p>{LEGEND}</p>",
    ]
    if result.solutions:
        head, rows = table(result)
        parts += ["<h2>Static poses</h2>", "<p>Only digits that are proved.</p>", _table(head, rows)]
        parts += ["<h2>Tensions</h2>", _figure(plots.tension_figure(result))]
    if result.undecided:
        parts += ["<h2>Undecided</h2>", _table(["cables", "cells", "why", "x, y, z m"], _undecided(result))]
    return _page(result.robot.name, parts)


def _proof(proof: Proof | None) -> str:
    """Return what the independent checker says."""
    if proof is None:
        return "<p>No certificate was given to the independent checker.</p>"
    kind = "bad" if proof.is_refused else "good" if proof.name == Verdict.PROVED else "open"
    return _banner(kind, f"Independent check of the certificate: {proof}")


def left_open(result: Result) -> str:
    """Return what is undecided or pending, counted; empty when nothing is."""
    cells = sum(one.cells for one in result.undecided)
    proved = [solution for solution in result.solutions if solution.is_proved]
    counts = {
        f"undecided regions ({cells} cells)": len(result.undecided),
        "cells not looked at": result.pending,
        "entries not proved to hold exactly one pose": len(result.solutions) - len(proved),
        "poses with an undecided cable": sum(s.has_open_cable for s in proved),
    }
    said = [f"{count} {what}" for what, count in counts.items() if count]
    return "Left open: " + ", ".join(said) + "." if said else ""


def _lengths(result: Result) -> list[str]:
    return [
        f"{lo:.10g}" if hi - lo < 1e-12 * hi else f"{lo:.10g} to {hi:.10g}"
        for lo, hi in result.lengths.tolist()
    ]


def _undecided(result: Result) -> list[list[str]]:
    return [
        [
            ",".join(result.cables[i] for i in one.taut),
            str(one.cells),
            one.reason,
            ", ".join(f"[{lo:.4g}, {hi:.4g}]" for lo, hi in one.position.tolist()),
        ]
        for one in result.undecided
    ]


def batch_page(ledger: Ledger, document: dict[str, Any]) -> str:
    """Return the report of a batch from its ledger and its summary."""
    jobs = document["jobs"]
    total, undecided = sum(jobs.values()), document["jobs_with_undecided"]
    ended, seconds = ledger.seconds()
    bad = list(ledger.recorded((Status.FAILED, Status.CRASHED)))
    parts = [
        f"<h1>{total} problems</h1>",
        f"<p>begun {escape(ledger.fact('created'))}, {duration(seconds)} of work for {ended} jobs</p>",
        _banner("bad" if bad else "open" if jobs["pending"] else "good",
                ", ".join(f"{count} {name}" for name, count in jobs.items() if count)),
        _banner("open" if undecided else "good", f"{undecided} jobs left something undecided."),
        _proofs(ledger),
    ]  # fmt: skip
    for group in document["groups"]:
        parts += _group(group)
    parts += _batch_figures(ledger)
    left = ledger.incomplete()
    if left:
        numbers = ", ".join(map(str, left[:MOST_ROWS])) + (" ..." if len(left) > MOST_ROWS else "")
        parts += ["<h2>Left open</h2>", f"<p>jobs {numbers}; to look at one: report DIR --job N</p>"]
    if bad:
        rows = [[str(j.number), j.status.value, str(j.attempts), j.message] for j in bad]
        parts += ["<h2>Failed</h2>", _table(["job", "status", "attempts", "why"], rows)]
    return _page(f"{total} problems", parts)


def _proofs(ledger: Ledger) -> str:
    """Return how many jobs have certificates, and what came out when they were checked."""
    count, checks = len(ledger.certified()), ledger.checks()
    if not count:
        return "<p>No certificates were asked for.</p>"
    verdicts = Counter(row.verdict for row in checks)
    if count > len(checks):
        verdicts["not checked (batch check)"] = count - len(checks)
    good = set(verdicts) == {Verdict.PROVED}
    bad = not good and any(verdicts[verdict] for verdict in REFUSED)
    said = ", ".join(f"{n} {verdict}" for verdict, n in verdicts.items())
    return _banner("good" if good else "bad" if bad else "open", f"{count} certificates: {said}")


def _group(group: dict[str, Any]) -> list[str]:
    parts = [f"<h2>{escape(group['robot'])}, problems[{group['problem']}]</h2>"]
    jobs = ", ".join(f"{n} jobs with {count}" for count, n in group["solutions_per_job"].items())
    rows = [["solutions", jobs]]
    for title, key in (("taut", "taut_subsets"), ("stability", "stability")):
        rows.append([title, ", ".join(f"{n} {name}" for name, n in group[key].items())])
    parts.append(_table(["", ""], rows))
    if group["quantities"]:
        heads = list(next(iter(group["quantities"].values())))
        body = [[name, *(f"{values[h]:.6g}" for h in heads)] for name, values in group["quantities"].items()]
        parts.append(_table(["", *heads], body))
    return parts


NO_REGION = '"undecided":[]'
"""In the text of an answer."""
Numbers = dict[str, dict[str, list[float]]]
Places = dict[str, list[list[float]]]


def quantities(ledger: Ledger) -> tuple[Numbers, Places]:
    """Return every quantity by robot and problem, and the positions in m by taut cables."""
    robots: dict[str, Robot] = {k: parse_robot(data) for k, (_, _, data) in ledger.robots().items()}
    # In the order of the cables, not in that of the first job in which they are taut.
    titles = dict.fromkeys(("x_m", "y_m", "z_m"))
    titles |= dict.fromkeys(f"tension_{name}_N" for robot in robots.values() for name in robot.cable_names)
    numbers: Numbers = {title: {} for title in titles}
    places: Places = {}
    for job in ledger.recorded((Status.DONE,)):
        robot = robots[job.robot]
        owner = f"{robot.name}, problems[{job.problem}]"
        for row in job_rows(job, robot.name, robot.cable_names):
            if "solution" not in row:
                continue
            names = row["taut"] if len(robots) == 1 else f"{robot.name}: {row['taut']}"
            if row["outcome"] != "complete":
                names = plots.LEFT_OPEN
            places.setdefault(names, []).append([row["x_m"], row["y_m"], row["z_m"]])
            tensions = [f"tension_{name}_N" for name in robot.cable_names if row[f"tension_{name}_N"]]
            for title in ("x_m", "y_m", "z_m", *tensions):
                numbers[title].setdefault(owner, []).append(row[title])
        for region in _regions(job):
            places.setdefault(plots.LEFT_OPEN, []).append(region)
    return {title: groups for title, groups in numbers.items() if groups}, places


def _regions(job: Recorded) -> list[list[float]]:
    """Return the middles of what a job left undecided, where they are bounded."""
    assert job.answer is not None
    if NO_REGION in job.answer:
        return []
    found = [region["position_m"] for region in json.loads(job.answer)["undecided"]]
    bounded = [box for box in found if all(None not in side for side in box)]
    return [[0.5 * (lo + hi) for lo, hi in box] for box in bounded]


def _batch_figures(ledger: Ledger) -> list[str]:
    """Return the positions of all solutions, and histograms of every quantity."""
    numbers, places = quantities(ledger)
    if not places:
        return []
    robots = [parse_robot(data) for _, _, data in ledger.robots().values()]
    total = sum(map(len, places.values()))
    share = min(1.0, plots.MOST_POINTS / total)
    some = {
        name: plots.thinned(rows, max(int(share * len(rows)), 1)) for name, rows in sorted(places.items())
    }
    exits = frame_points(robots[0]) if len(robots) == 1 else None
    shown = "every solution" if share == 1.0 else f"one in {1 / share:.0f} of {total} solutions"
    histograms = [_figure(plots.histogram_figure(title, values)) for title, values in numbers.items()]
    return [
        "<h2>Where the platform is</h2>",
        f"<p>{shown}, by taut cables</p>",
        _figure(plots.scatter_figure(some, exits)),
        "<h2>Distributions</h2>",
        f'<div class="pair">{"".join(f"<div>{one}</div>" for one in histograms)}</div>',
    ]


def _banner(kind: str, text: str) -> str:
    return f'<div class="{kind}">{escape(text)}</div>'


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    titles = "".join(f"<th>{escape(title)}</th>" for title in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows[:MOST_ROWS]
    )
    more = f"<p>and {len(rows) - MOST_ROWS} more</p>" if len(rows) > MOST_ROWS else ""
    return f'<div class="scroll"><table><tr>{titles}</tr>{body}</table></div>{more}'


def _figure(figure: Any) -> str:
    text: str = figure.to_html(full_html=False, include_plotlyjs=False, config={"displaylogo": False})
    return text


def _page(title: str, parts: Sequence[str]) -> str:
    from plotly.offline import get_plotlyjs

    tool = this_tool()
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n"
        f"<script>{get_plotlyjs()}</script></head>\n<body>\n"
        + "\n".join(parts)
        + f"\n<footer>{escape(tool.name)} {escape(tool.version)}</footer>\n</body></html>\n"
    )
