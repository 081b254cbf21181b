"""Certificates of one answer, each with one thing changed: none that says something false may be PROVED.

Run as ``python scripts/single_changes.py [COUNT [SEED]]``. UC2, all subsets, eight poses, by default 2 000
changes: of values, bounds, entries and indices of solutions, roots and lengths, and of bytes of the trees.
What a PROVED claims is compared with what the solver found. One line for each kind of change:

    refused     NOT PROVED or MALFORMED
    true        PROVED, in whole or in part, and nothing it says is false
    FALSE       PROVED and false: a defect of the checker; the exit code is 1

``tests.support.single_changes.changed`` makes change K of a seed from ``random.Random(f"{SEED} {K}")``.
"""

from __future__ import annotations

import random
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pytest

# Run from anywhere: the generators live beside the tests.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from certificates.verdicts import Verdict
from tests.support.certificate_truth import false_statements
from tests.support.honest_certificates import Document, Honest, made
from tests.support.single_changes import Remembered, changed

VERDICTS = ("refused", "true", "FALSE")


def judged(honest: Honest, document: Document, checker: Remembered, seed: int) -> str:
    """Return what the checker makes of a document."""
    report = checker.check(document, seed)
    if report.verdict is not Verdict.PROVED:
        return VERDICTS[0]
    other = document["lengths_m"] != honest.document["lengths_m"]
    return VERDICTS[2] if other or false_statements(document, report, honest.truth) else VERDICTS[1]


def main(arguments: Sequence[str]) -> int:
    """Print a table; return 1 where something false was PROVED."""
    count, seed = (*map(int, arguments), *(2000, 1)[len(arguments) :])
    honest, found = made("plane"), Counter[tuple[str, str]]()
    started = time.process_time()
    with pytest.MonkeyPatch.context() as patch:
        checker = Remembered(patch)
        assert checker.check(honest.document, seed).complete
        for k in range(count):
            what, document = changed(honest.document, random.Random(f"{seed} {k}"))
            verdict = judged(honest, document, checker, seed)
            found[what, verdict] += 1
            if verdict == VERDICTS[2]:
                print(f"FALSE: {what}, seed {seed}, change {k}", flush=True)
    print(f"seed {seed}: {count} changes, {time.process_time() - started:.0f} s of CPU")
    print(f"{'change':20}" + "".join(f"{verdict:>9}" for verdict in VERDICTS))
    for what in sorted({what for what, _ in found}):
        print(f"{what:20}" + "".join(f"{found[what, verdict]:9}" for verdict in VERDICTS))
    return int(any(verdict == VERDICTS[2] for _, verdict in found))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
