"""Why a certificate leaves something open: the reasons that are in it, counted; nobody checks them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

from certificates.verdicts import counted

if TYPE_CHECKING:
    from certificates.certificate import Certificate

MOST_KINDS = 5
"""Of reasons that are told."""
LONGEST = 100
"""Characters of a reason: it is whatever the writer of the file has put there."""


def reasons(certificate: Certificate, pending: int, undecided: int) -> list[str]:
    """Return a line for each kind of reason, the most frequent first, at most `MOST_KINDS` of them.

    ``pending`` counts subsets and cells of which nothing is claimed, ``undecided`` cells.
    """
    subsets = [entry["pending"] for entry in certificate.entries if "pending" in entry]
    found = Counter(("pose", "not certified", reason) for reason in certificate.left_out)
    found.update(("subset", "pending", reason) for reason in subsets)
    found["cell", "pending", "the search has not come to it"] += pending - len(subsets)
    found["cell", "undecided", "too small to be cut once more"] += undecided
    return list(lines(+found))


def lines(found: Counter[tuple[str, str, str]]) -> Iterator[str]:
    """Yield a line for each kind."""
    for (what, state, reason), number in found.most_common(MOST_KINDS):
        short = reason if len(reason) <= LONGEST else reason[: LONGEST - 3] + "..."
        yield f"{counted(number, what)} {state}: {short}"
    if (more := len(found) - MOST_KINDS) > 0:
        yield f"and {counted(more, 'other reason')}"
