"""``python -m certificates FILE``: check a certificate."""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import dataclass

from certificates.checker import check
from certificates.container import LIMIT
from certificates.verdicts import Verdict

EXIT_CODES = {
    Verdict.PROVED: 0,
    Verdict.MALFORMED: 2,
    Verdict.SAMPLED: 3,
    Verdict.OUT_OF_TIME: 3,
    Verdict.NOT_PROVED: 5,
}
PARTIAL = 3
"""PROVED, but something is left open."""
MIB = 2**20


@dataclass(frozen=True)
class Options:
    """How a file is to be checked; see `certificates.check`."""

    sample: int | None = None
    seed: int | None = None
    threads: int = 1
    time_limit: float | None = None
    size_limit: int = LIMIT
    quiet: bool = False


def run(file: str | bytes, options: Options) -> int:
    """Check a file (or its bytes), print the outcome (quiet: one line) and return the exit code."""
    shown = sys.stderr.isatty() and not options.quiet

    def progress(done: int, total: int) -> None:
        """Rewrite the line that says how far the check is."""
        sys.stderr.write(f"\r\x1b[K{done}/{total} cells\r")
        sys.stderr.flush()

    report = check(
        file,
        sample=options.sample,
        seed=options.seed,
        threads=options.threads,
        time_limit=options.time_limit,
        size_limit=options.size_limit,
        progress=progress if shown else None,
    )
    if shown:
        sys.stderr.write("\x1b[K")
    print(*report.lines()[: 1 if options.quiet else None], sep="\n")
    return PARTIAL if report.verdict is Verdict.PROVED and not report.complete else EXIT_CODES[report.verdict]


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
    parser.add_argument("--seed", type=int, metavar="S", help="draw the sample another check has printed")
    parser.add_argument("--threads", type=count, default=os.cpu_count() or 1, metavar="N", help=THREADS)
    parser.add_argument("--time-limit", type=positive, metavar="S", help="stop after so many seconds")
    size = "largest file and document [default: 64]"
    parser.add_argument("--size-limit", type=count, default=LIMIT // MIB, metavar="MIB", help=size)
    parser.add_argument("-q", "--quiet", action="store_true", help="print the verdict only")
    given = vars(parser.parse_args())
    return run(given.pop("file"), Options(**{**given, "size_limit": given["size_limit"] * MIB}))


THREADS = "how many processes work at a time [default: all cores]"
ABOUT = """Check a certificate. Exit code: 0 proved; 3 in part, or not all was checked; 5 not proved; 2 no
certificate."""

if __name__ == "__main__":
    try:
        code = main()
        sys.stdout.flush()
    except KeyboardInterrupt:
        code = 130
    except BrokenPipeError:
        # The reader has gone (``| head``): what a shell reports then; nothing more can be written.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 141
    sys.exit(code)
