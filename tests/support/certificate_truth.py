"""What is false in a certificate that was PROVED, by what the solver found: an independent judgement."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from certificates.verdicts import Report, Verdict
from solvers.answers.data import Solution
from solvers.answers.result import Result
from tests.support.honest_certificates import Document
from tests.support.listed_bounds import every_bound

ROUNDING = 1e-12
"""How far the middle of the solver's bounds may be from the truth, over 1 and its size."""


def false_statements(document: Document, report: Report, truth: Result) -> list[str]:
    """Return what a PROVED says that is not so, the question being that of the truth."""
    if report.verdict is not Verdict.PROVED:
        return []
    listed = document["solutions"]
    is_open = any("undecided" in s["states"] or s["slack_respected"] is None for s in listed)
    counted = re.search(r"\d+ static|no static pose|no other", report.message)
    if is_open:
        return ["poses are counted"] * bool(counted) + ["open but complete"] * report.complete
    wrong, free = [], list(truth.solutions)
    for k, solution in enumerate(listed):
        found = next((i for i, s in enumerate(free) if agrees(solution, s)), None)
        if found is None:
            wrong.append(f"solution {k} is none, or is counted twice")
        else:
            del free[found]
    return wrong + [f"{len(free)} poses are missing"] * bool(report.complete and free)


def agrees(listed: Document, solution: Solution) -> bool:
    """Return True when what is listed is true of a solution that was found."""
    known = str(solution.stability)
    words = listed["states"] == [str(s) for s in solution.cable_states]
    words &= listed["stability"] in ("undecided", known) or known == "undecided"
    words &= (listed["family"] is None) == (solution.family is None)
    pairs = [
        (listed["position_m"], solution.position),
        (listed["rotation"], solution.rotation),
        (listed["height_m"], solution.height),
        (listed["tensions_N"], solution.tensions),
        (listed["distances_m"], solution.distances),
    ]
    return words and all(holds(outer, inner) for outer, inner in pairs)


def holds(outer: Any, inner: Any) -> bool:
    """Return True when bounds (..., 2) hold the middles of others, which are known up to rounding."""
    bounds = np.array(every_bound(outer, lambda lo, hi: (lo, hi), text=False))
    middle = inner.mean(axis=-1)
    off = ROUNDING * (1.0 + np.abs(middle))
    return bool(np.all(bounds[..., 0] <= middle + off) and np.all(middle - off <= bounds[..., 1]))
