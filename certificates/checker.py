"""The check of a whole certificate."""

from __future__ import annotations

import multiprocessing
import random
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from itertools import zip_longest
from pathlib import Path
from typing import Any

from flint import ctx

from certificates.balls import BITS
from certificates.container import HEAD, load, unpack
from certificates.families import check_one_point_family
from certificates.literals import entry_of, list_of, text_of
from certificates.point_mass import check_point
from certificates.problem import Listed, read_left_out, read_problem, read_solutions, read_taut
from certificates.searches import Searches
from certificates.subsets import Kind, classify, examined
from certificates.verdicts import Malformed, NotProved, Report, Verdict

CHUNK = 16
"""Leaves that a worker checks in one go."""
SHOWN = 64 + len(HEAD)
"""Bytes of a file that identify it."""
Chunk = tuple[int, Sequence[int]]
"""The place of a subset, and those of some of its leaves."""


class OutOfTime(Exception):
    """The time limit has passed."""


class Certificate:
    """A certificate that was read; its proofs are read when they are checked."""

    def __init__(self, content: bytes) -> None:
        document = unpack(content)
        self.problem = read_problem(document)
        self.solutions = read_solutions(document, self.problem)
        self.left_out = read_left_out(document, self.problem)
        self.entries = list_of(document["subsets"], "subsets")
        given = (read_taut(v.get("taut") if isinstance(v, dict) else None, len(self.problem.names)) for v in self.entries)
        if any(a != b for a, b in zip_longest(given, examined(self.problem))):
            raise NotProved("the subsets are not those to be examined, in order")
        self.searches: tuple[int, Searches] | None = None

    def name(self, k: int) -> str:
        """Return what a subset is called."""
        return "subset " + ",".join(self.problem.names[i] for i in self.entries[k]["taut"])

    def prepare(self, k: int) -> tuple[set[int], int, int, int]:
        """Check all of a subset but its leaves; return its solutions, and how many leaves, pending, undecided."""
        entry, taut = self.entries[k], tuple(self.entries[k]["taut"])
        kind = None if self.problem.is_point_mass else classify(self.problem, taut)
        place = "point" if kind in (None, Kind.FREE, Kind.ONE_POINT) else "searches"
        entry_of(entry, "subset", ("taut", *(key for key in ("pending", place) if key in entry)))
        pending = int("pending" in entry)
        text_of(entry.get("pending", ""), "pending")
        if place not in entry or kind is Kind.DEPENDENT:
            if not pending and (kind is not Kind.DEPENDENT or self.problem.taut is not None):
                raise NotProved("there is no proof")
            if place in entry:
                raise Malformed("a proof where none is needed")
            return set(), 0, pending, 0
        if place == "point":
            check = check_point if kind is None else check_one_point_family
            return check(self.problem, taut, entry[place], self.solutions), 0, pending, 0
        searches = Searches(self.problem, taut, kind or Kind.GENERAL, entry[place], self.solutions)
        self.searches = k, searches
        waiting, undecided = searches.open
        return searches.check_roots(), len(searches.leaves), pending + waiting, undecided

    def check(self, chunk: Chunk) -> int:
        """Check leaves; return the number of parts it took."""
        k, places = chunk
        parts = 0
        with about(self.name(k)), ctx.workprec(BITS):
            if self.searches is None or self.searches[0] != k:
                taut = tuple(self.entries[k]["taut"])
                kind = classify(self.problem, taut)
                self.searches = k, Searches(self.problem, taut, kind, self.entries[k]["searches"], self.solutions)
            for place in places:
                with about(f"cell {place + 1}"):
                    parts += self.searches[1].check(self.searches[1].leaves[place])
        return parts


@contextmanager
def about(what: str) -> Iterator[None]:
    """Say what a failure is about; a failed computation proves nothing."""
    try:
        yield
    except (Malformed, NotProved) as error:
        raise type(error)(f"{what}: {error}") from None
    except Exception as error:
        raise NotProved(f"{what}: {type(error).__name__}: {error}") from None
