"""A certificate as it was read, and what is checked of each of its subsets."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import zip_longest
from typing import Any

from flint import ctx

from certificates.arithmetic.balls import BITS
from certificates.arithmetic.floats import machine_rounds
from certificates.clock import OutOfTime
from certificates.container import unpack
from certificates.families import check_one_point_family
from certificates.literals import entry_of, list_of, text_of
from certificates.point_mass import check_point
from certificates.problem import described, needed, read_left_out, read_problem, read_solutions, read_taut
from certificates.root_claims import check_all_roots
from certificates.searches import SubsetSearches
from certificates.subsets import Kind, classify, examined
from certificates.tree import Leaf
from certificates.verdicts import Malformed, NotProved


class Certificate:
    """A certificate that was read, but for the proofs in it: the bytes of a file, or its document."""

    def __init__(self, content: bytes | dict[str, Any], limit: int | None = None) -> None:
        document = unpack(content, limit) if isinstance(content, bytes) else content
        self.problem = read_problem(document)
        self.question = described(document, self.problem)
        self.solutions = read_solutions(document, self.problem)
        self.left_out = read_left_out(document, self.problem)
        self.entries = list_of(document["subsets"], "subsets")
        needed(all(isinstance(v, dict) and "taut" in v for v in self.entries), "a subset without taut cables")
        self.subsets = [read_taut(v["taut"], len(self.problem.names)) for v in self.entries]
        if any(a != b for a, b in zip_longest(self.subsets, examined(self.problem))):
            raise NotProved("the subsets are not those to be examined, in their order")

    def name(self, k: int) -> str:
        """Return what a subset is called."""
        return "subset " + ",".join(self.problem.names[i] for i in self.subsets[k])

    def searches(self, k: int) -> SubsetSearches:
        """Return the searches of a subset."""
        kind = classify(self.problem, self.subsets[k])
        return SubsetSearches(
            self.problem, self.subsets[k], kind, self.entries[k]["searches"], self.solutions
        )

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
        searches = self.searches(k)
        backed, cells = check_all_roots(searches, self.solutions), searches.tally()
        return backed, cells.leaves, pending + cells.pending, cells.undecided

    def leaves(self, k: int) -> Iterator[tuple[int, Leaf]]:
        """Yield the search and the leaf of each cell of a subset."""
        yield from self.searches(k).leaves()


@contextmanager
def about(what: str) -> Iterator[None]:
    """Compute precisely and say what a failure is about: one of any kind proves nothing."""
    try:
        if not machine_rounds():
            raise NotProved("doubles are not rounded to nearest here, or small ones are lost")
        with ctx.workprec(BITS):
            yield
    except OutOfTime:
        raise
    except (Malformed, NotProved) as error:
        raise type(error)(f"{what}: {error}") from None
    except Exception as error:
        raise NotProved(f"{what}: {type(error).__name__}: {error}") from None
