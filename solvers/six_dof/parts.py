"""The search of one taut subset in parts: sub-cells of its charts that are searched apart, and put together.

Every part covers its own cells, and all parts cover the charts. A part knows the roots it finds itself; roots
found twice, and cells that another part's root settles, are dealt with when the parts are put together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof.families import Kind
from solvers.questions.problem import Options, Problem
from solvers.six_dof.cells.columns import POSE_COLUMNS, ROTATION_COLUMNS
from solvers.six_dof.cells.kinds import POSE_CELLS, ROTATION_CELLS
from solvers.six_dof.cells.roots import Prover, Reduction, Root
from solvers.six_dof.cells.subset_search import SubsetSearch, start_cells
from solvers.six_dof.prepared import kind_of, lengths_of
from solvers.six_dof.reduction import Reduced, reduced_problems

Floats = NDArray[np.float64]
FEWEST_TAUT = 3
"""Searches of fewer cables take milliseconds and are not split."""
SEARCHED = (Kind.GENERAL, Kind.PLANE, Kind.ABOUT_VERTICAL, Kind.ABOUT_ROD)


@dataclass(frozen=True)
class Part:
    """One part of the search of a subset in one of its frames."""

    taut: tuple[int, ...]
    frame: int
    """Number of the reduced problem; a subset in a plane has several."""
    number: int
    """From 0."""
    of: int
    """How many parts there are."""

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {"taut": list(self.taut), "frame": self.frame, "number": self.number, "of": self.of}

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Part:
        """Return the part of such data."""
        return cls(tuple(data["taut"]), data["frame"], data["number"], data["of"])


@dataclass(frozen=True)
class PartFound:
    """What the search of a part found."""

    roots: tuple[Root, ...]
    undecided: Floats
    undecided_position: Floats
    reason: str
    pending: int
    cells: int
    stop: Stop

    def to_json(self) -> dict[str, Any]:
        """Return plain data that restores every double."""
        roots = [[r.chart, r.box.tolist(), r.unique.tolist(), r.core.tolist()] for r in self.roots]
        return {
            "roots": roots,
            "undecided": self.undecided.tolist(),
            "undecided_position": self.undecided_position.tolist(),
            "reason": self.reason,
            "pending": self.pending,
            "cells": self.cells,
            "stop": self.stop.value,
        }

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> PartFound:
        """Return what such data say."""
        return cls(
            tuple(Root(chart, *(np.array(box) for box in boxes)) for chart, *boxes in data["roots"]),
            np.array(data["undecided"], dtype=np.float64).reshape(-1, ROTATION_COLUMNS.width),
            np.array(data["undecided_position"], dtype=np.float64).reshape(-1, POSE_COLUMNS.width),
            data["reason"],
            data["pending"],
            data["cells"],
            Stop(data["stop"]),
        )


Parts = dict[tuple[tuple[int, ...], int], Sequence[PartFound]]
"""All parts of a search, by taut subset and frame."""


def parts_of(problem: Problem, options: Options, taut: tuple[int, ...], count: int) -> list[Part]:
    """Return the parts of a subset's searches; none where they are not worth splitting."""
    loaded = problem.loaded
    if not problem.is_exact or any(lo < hi for lo, hi in problem.lengths):
        # What parts hand over are boxes of roots; a tube is alone within its reach, not within a box.
        return []
    if len(taut) < FEWEST_TAUT or kind_of(loaded, taut).kind not in SEARCHED:
        return []
    frames = len(reduced_problems(loaded, lengths_of(problem), options, taut))
    return [Part(taut, frame, k, count) for frame in range(frames) for k in range(count)]


def solve_part(problem: Problem, options: Options, part: Part) -> PartFound:
    """Search one part.

    Guarantee
    ---------
    Every pose whose rotation lies in the part's cells is in the box of one of the roots or in an undecided
    cell, or something is pending.
    """
    budget = Budget(options.time_limit, options.cell_limit)
    with budget.listening(), balls.precision():
        reduced = reduced_problems(problem.loaded, lengths_of(problem), options, part.taut)[part.frame]
        found = SubsetSearch(reduced.model, reduced.reduction, budget, options.threads)
        found.solve(part_cells(reduced.reduction, part))
    return PartFound(
        tuple(found.roots), found.undecided, found.undecided_position, found.reason, found.pending,
        found.cells, found.stop,
    )  # fmt: skip


def part_cells(reduction: Reduction, part: Part) -> Floats:
    """Return a part's cells: the charts are halved along their widest sides until there are enough."""
    cells = list(start_cells(reduction))
    while len(cells) < part.of:
        # The first of the widest: halves go to the end.
        widths = [max(cell[1:6:2] - cell[0:5:2]) for cell in cells]
        if max(widths) == 0.0:
            break
        cell = cells.pop(int(np.argmax(widths)))
        side = int(np.argmax(cell[1:6:2] - cell[0:5:2]))
        middle = 0.5 * (cell[2 * side] + cell[2 * side + 1])
        for end in (1, 0):
            half = cell.copy()
            half[2 * side + end] = middle
            half[-1] *= 0.5
            cells.append(half)
    return np.array(cells[part.number :: part.of]).reshape(-1, ROTATION_COLUMNS.width)


def put_together(search: SubsetSearch, reduced: Reduced, parts: Sequence[PartFound]) -> None:
    """Let a search have what its parts found."""
    prover = Prover(reduced.model, reduced.reduction)
    search.roots = [root for part in parts for root in part.roots]
    for name, kind in (("undecided", ROTATION_CELLS), ("undecided_position", POSE_CELLS)):
        cells = np.concatenate([getattr(part, name) for part in parts])
        setattr(search, name, prover.unsettled(cells, search.roots, kind))
    search.reason = next((part.reason for part in parts if part.reason), "")
    search.pending = sum(part.pending for part in parts)
    search.cells = sum(part.cells for part in parts)
    search.stop = next((part.stop for part in parts if part.stop is not Stop.EXHAUSTED), Stop.EXHAUSTED)
