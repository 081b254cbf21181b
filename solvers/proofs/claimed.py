"""What a certificate claims, counted as the checker does, before anybody has checked it."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import Any

from certificates.certificate import Certificate
from certificates.checker import summary
from certificates.tree import Node
from certificates.verdicts import Conclusion, reasons

Json = dict[str, Any]
SIZES = {Node.TOO_LONG: 2, Node.UNBALANCED: 25}
"""Bytes of a node, where it is more than one; those of a cut depend on its bits."""


@dataclass(frozen=True)
class Claimed:
    """What a certificate says of itself."""

    is_complete: bool
    """It claims that there is no other pose."""
    message: str
    """As the checker says it of a certificate whose claims all follow."""
    reasons: tuple[str, ...] = ()
    """Why something is left open, counted."""

    @property
    def conclusion(self) -> Conclusion:
        """What a check will conclude, unless a claim does not follow."""
        return Conclusion.PROVED if self.is_complete else Conclusion.PARTIAL


def claimed(document: Json) -> Claimed:
    """Return what the document of a certificate claims; its proofs are not looked at."""
    pending = undecided = 0
    for entry in document["subsets"]:
        pending += "pending" in entry
        for search in entry.get("searches", ()):
            for tree in search["trees"]:
                found = unclaimed(base64.b64decode(tree or ""))
                pending, undecided = pending + found[0], undecided + found[1]
    certificate = Certificate(document)
    message, is_complete = summary(certificate, pending, undecided)
    return Claimed(
        is_complete, message, tuple(reasons(certificate.entries, certificate.left_out, pending, undecided))
    )


def unclaimed(tree: bytes) -> tuple[int, int]:
    """Return how many cells of a tree are pending and undecided; its nodes follow each other."""
    place = pending = undecided = 0
    while place < len(tree):
        code = tree[place]
        if code == Node.CUT:
            place += 2 + 16 * tree[place + 1].bit_count()
            continue
        pending += code == Node.PENDING
        undecided += code == Node.UNDECIDED
        place += SIZES.get(code, 1)  # type: ignore[call-overload]
    return pending, undecided
