"""What a batch did not settle, in words: for the first line of its summary, and for its exit code."""

from __future__ import annotations

from typing import Any

from certificates.verdicts import Conclusion
from solvers.batch.work import Status

NONE_FOUND = "without a pose from inverse kinematics (nothing is proved)"


def unsettled(document: dict[str, Any]) -> dict[str, int]:
    """Return how many jobs of a ``cdpr-batch-summary/1`` document are what; the worst comes first."""
    jobs = document["jobs"]
    found = {
        "failed or crashed": jobs[Status.FAILED] + jobs[Status.CRASHED],
        "pending": jobs[Status.PENDING],
        "with something undecided": document["jobs_with_undecided"],
        "with a partial certificate": document["certificates"].get(Conclusion.PARTIAL, 0),
        "with a certificate not checked in time": document["certificates"].get(Conclusion.OUT_OF_TIME, 0),
        NONE_FOUND: jobs[Status.NONE_FOUND],
    }
    return {what: count for what, count in found.items() if count}


def headline(document: dict[str, Any]) -> str:
    """Return the same as one sentence."""
    return ", ".join(f"{count} {what}" for what, count in unsettled(document).items()) or "nothing left open"
