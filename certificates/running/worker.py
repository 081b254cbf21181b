"""A worker, which checks lots of cells, and lots checked one after the other."""

from __future__ import annotations

from collections.abc import Iterator

from certificates.certificate import Certificate, about
from certificates.running.lots import Lot
from certificates.searches import Searches


class Worker:
    """Checks cells; the searches of the subset at hand are kept."""

    def __init__(self, certificate: Certificate) -> None:
        self.certificate = certificate
        self.at: tuple[int, Searches] | None = None

    def check(self, lot: Lot) -> int:
        """Check some cells; return the number of parts it took."""
        k, place, cells, twice = lot
        with about(self.certificate.name(k)):
            if self.at is None or self.at[0] != k:
                self.at = k, self.certificate.searches(k)
            return self.at[1].check(place, cells, twice)


def in_turn(certificate: Certificate, lots: Iterator[Lot]) -> Iterator[tuple[int, int]]:
    """Yield the size of each lot, and the number of parts, once it is checked."""
    one = Worker(certificate)
    for lot in lots:
        yield len(lot[2]), one.check(lot)
