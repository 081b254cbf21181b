"""The report of a batch: its judgement, where the platform is, and what scatters by how much."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

import numpy as np

from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.text.count import counted
from solvers.batch.branches import Branch
from solvers.batch.duration import duration
from solvers.batch.ledger import Ledger, Recorded
from solvers.batch.summary import Group, Summary, contiguous
from solvers.batch.summary_text import branch_title, pools
from solvers.batch.work import Status
from solvers.report import plots
from solvers.report.judgement import Judgement, judge_batch
from solvers.report.origin import batch_origin
from solvers.report.page import MOST_ROWS, drawn, listed, rendered, table_of
from solvers.report.scene import frame_points

MOST_BRANCHES = 12
"""Of a group that get statistics and histograms; ``summary.json`` has all."""
NO_REGION = '"undecided":[]'
"""In the text of an answer."""


def judgement_of(ledger: Ledger, summary: Summary) -> Judgement:
    """Return the judgement of a batch from its ledger and its summary."""
    document, checks = summary.to_json(), ledger.checks()
    verdicts = Counter(row.verdict for row in checks)
    unchecked = len(ledger.certified()) - len(checks)
    return judge_batch(document["jobs"], document["jobs_with_undecided"], verdicts, unchecked)


def batch_page(ledger: Ledger, summary: Summary) -> str:
    """Return the report of a batch from its ledger and its summary."""
    document = summary.to_json()
    jobs = document["jobs"]
    title = title_of(ledger, summary)
    ended, seconds = ledger.seconds()
    bad = list(ledger.recorded((Status.FAILED, Status.CRASHED)))
    scatter, caption = _scatter(ledger, summary)
    rows = [[str(job.number), job.status.value, str(job.attempts), job.message] for job in bad[:MOST_ROWS]]
    return rendered(
        "batch.html",
        title=title,
        subtitle=f"{counted(sum(jobs.values()), 'problem')}, begun {ledger.fact('created')}, "
        f"{duration(seconds)} of work for {counted(ended, 'job')}",
        judgement=judgement_of(ledger, summary),
        scatter=scatter,
        scatter_caption=caption,
        groups=[
            _group(number, group, found)
            for number, (group, found) in enumerate(zip(summary.groups, document["groups"], strict=True))
        ],
        left_open=listed(ledger.incomplete()),
        left_open_jobs="job" if len(ledger.incomplete()) == 1 else "jobs",
        failed=rows,
        failed_left_out=len(bad) - len(rows),
        origin=batch_origin(ledger),
    )


def title_of(ledger: Ledger, summary: Summary) -> str:
    """Return the name of a batch; that of its folder where it has none."""
    return summary.name or ledger.folder.resolve().name


def _group(number: int, group: Group, found: dict[str, Any]) -> dict[str, Any]:
    """Return what the template says of one problem for one robot."""
    jobs = ", ".join(f"{counted(n, 'job')} with {count}" for count, n in found["solutions_per_job"].items())
    counts = [("solutions", jobs)]
    for title, key in (("taut", "taut_subsets"), ("stability", "stability")):
        counts.append((title, ", ".join(f"{n} {name or '-'}" for name, n in found[key].items())))
    pooled = None
    branches = list(zip(group.branches.sorted(), found["branches"], strict=True))
    if pools(found) and found["quantities"]:
        head, rows = table_of(found["quantities"])
        figure = plots.histogram_figure(contiguous(group.numbers()))
        pooled = {"head": head, "rows": rows, "figure": drawn(figure, f"group{number}")}
        branches = branches if len(branches) > 1 else []
    return {
        "title": f"{group.robot}, problems[{group.problem}]",
        "counts": counts,
        "pooled": pooled,
        "branches": [_branch(number, *one, pooled is None) for one in branches[:MOST_BRANCHES]],
        "branches_left_out": max(len(branches) - MOST_BRANCHES, 0),
    }


def _branch(number: int, branch: Branch, found: dict[str, Any], is_first: bool) -> dict[str, Any]:
    head, rows = table_of(found["quantities"])
    figure = plots.histogram_figure(contiguous(branch.numbers))
    return {
        "title": branch_title(found),
        "is_open": is_first and branch.stability == "stable",
        "head": head,
        "rows": rows,
        "figure": drawn(figure, f"group{number}branch{branch.number}"),
    }


def _scatter(ledger: Ledger, summary: Summary) -> tuple[Any, str]:
    """Return the picture of all positions, and what it shows."""
    places = _places(ledger, summary)
    total = sum(map(len, places.values()))
    if not total:
        return "", ""
    share = min(1.0, plots.MOST_POINTS / total)
    some = {name: rows[:: plots.step(len(rows), share)] for name, rows in places.items()}
    robots = [parse_robot(data) for _, _, data in ledger.robots().values()]
    exits = frame_points(robots[0]) if len(robots) == 1 else None
    shown = "Every solution" if share == 1.0 else f"One in {1 / share:.0f} of {counted(total, 'solution')}"
    figure, is_stretched = plots.scatter_figure(some, exits)
    scale = "; each axis has a scale of its own" if is_stretched else ""
    return drawn(figure, "places"), f"{shown}, by branch{scale}. A click on the legend hides or shows one."


def _places(ledger: Ledger, summary: Summary) -> dict[str, np.ndarray[Any, Any]]:
    """Return positions (n, 3) in m by branch, and the middles of what was left undecided."""
    found: dict[str, np.ndarray[Any, Any]] = {}
    groups = summary.groups
    for group in groups:
        whose = f"{group.robot}, problems[{group.problem}], " if len(groups) > 1 else ""
        for branch in group.branches.sorted():
            columns = [branch.numbers.get(title, []) for title in ("x_m", "y_m", "z_m")]
            found[whose + branch.title] = np.array(columns, dtype=np.float64).T
    regions = [place for job in ledger.recorded((Status.DONE,)) for place in _regions(job)]
    return {**found, plots.LEFT_OPEN: np.array(regions)} if regions else found


def _regions(job: Recorded) -> list[list[float]]:
    """Return the middles of what a job left undecided, where they are bounded."""
    if job.answer is None or NO_REGION in job.answer:
        return []
    found = [region["position_m"] for region in json.loads(job.answer)["undecided"]]
    bounded = [box for box in found if all(None not in side for side in box)]
    return [[0.5 * (lo + hi) for lo, hi in box] for box in bounded]
