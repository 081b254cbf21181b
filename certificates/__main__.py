"""``python -m certificates FILE``: check a certificate."""

from __future__ import annotations

import argparse
import os
import signal
import sys

from certificates.checker import check
from certificates.container import LIMIT
from certificates.progress import ProgressLine

MIB = 2**20
INTERRUPTED = 130
OUTPUT_CLOSED = 141


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
    quiet, limit = given.pop("quiet"), given.pop("size_limit") * MIB
    line = ProgressLine(sys.stderr)
    try:
        report = check(given.pop("file"), **given, size_limit=limit, progress=None if quiet else line)
    finally:
        line.erase()
    print(*report.lines()[: 1 if quiet else None], sep="\n", flush=True)
    code = report.conclusion.exit_code
    if code:
        print(report.conclusion.remark, file=sys.stderr)
    return code


THREADS = "how many processes work at a time [default: all cores]"
ABOUT = """Check a certificate. Exit code: 0 proved; 3 in part, or not all was checked; 5 not proved; 2 no
certificate; 130 interrupted."""

if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        code = main()
    except KeyboardInterrupt as error:
        print(*("interrupted", *error.args), sep=": ", file=sys.stderr)
        code = INTERRUPTED
    except BrokenPipeError:
        # The reader has gone (``| head``): what a shell reports then; nothing more can be written.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = OUTPUT_CLOSED
    sys.exit(code)
