"""``python -m certificates FILE``: check a certificate."""

from __future__ import annotations

import argparse
import sys

from certificates.checker import check
from certificates.verdicts import Verdict

EXIT_CODES = {
    Verdict.PROVED: 0,
    Verdict.MALFORMED: 2,
    Verdict.SAMPLED: 3,
    Verdict.OUT_OF_TIME: 3,
    Verdict.NOT_PROVED: 5,
}


def run(path: str, sample: int | None, jobs: int, time_limit: float | None, quiet: bool) -> int:
    """Check a file, print the outcome (``quiet``: its first line only) and return the exit code."""
    shown = sys.stderr.isatty() and not quiet

    def progress(done: int, total: int) -> None:
        """Rewrite the line that says how far the check is."""
        sys.stderr.write(f"\r\x1b[K{done}/{total} cells\r")
        sys.stderr.flush()

    watch = progress if shown else None
    report = check(path, sample=sample, jobs=jobs, time_limit=time_limit, progress=watch)
    if shown:
        sys.stderr.write("\x1b[K")
    print(*report.lines()[: 1 if quiet else None], sep="\n")
    return EXIT_CODES[report.verdict]


def positive(text: str) -> float:
    """Return a positive number."""
    if not float(text) > 0:
        raise ValueError
    return float(text)


def count(text: str) -> int:
    """Return a whole number from 1 on."""
    if int(text) < 1:
        raise ValueError
    return int(text)


def main() -> int:
    """Read the command line and check."""
    parser = argparse.ArgumentParser("python -m certificates", description=ABOUT)
    parser.add_argument("file", metavar="FILE")
    parser.add_argument("--sample", type=count, metavar="N", help="check so many cells, chosen at random")
    parser.add_argument("--jobs", type=count, default=1, metavar="N", help="number of processes")
    parser.add_argument("--time-limit", type=positive, metavar="S", help="stop after so many seconds")
    parser.add_argument("-q", "--quiet", action="store_true", help="print the verdict only")
    given = parser.parse_args()
    return run(given.file, given.sample, given.jobs, given.time_limit, given.quiet)


ABOUT = "Check a certificate. Exit code: 0 proved, 5 not proved, 2 no certificate, 3 not all was checked."

if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
