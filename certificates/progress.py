"""How far a check is: one line on a terminal, rewritten a few times a second; in a log lines."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from typing import TextIO

from certificates.verdicts import counted

SECONDS_BETWEEN = 0.2
"""Between two lines on a terminal."""
SECONDS_IN_LOG = 10.0
"""Between two lines of a log."""
ERASE = "\r\x1b[K"


class ProgressLine:
    """A callable for `check`: cells checked, all cells, and the time that is left at this rate."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.is_rewritten = stream.isatty() and os.environ.get("TERM") != "dumb"
        self.begun = self.written = time.monotonic()
        self.is_drawn = False

    def __call__(self, done: int, total: int) -> None:
        """Write the line, unless that was done a moment ago."""
        now = time.monotonic()
        left = f", {(now - self.begun) * (total - done) / done:.0f} s left" if 0 < done < total else ""
        text, passed = f"{done}/{counted(total, 'cell')}{left}", now - self.written
        if not self.is_rewritten and passed > SECONDS_IN_LOG:
            self.write(f"{text}\n")
            self.written = now
        elif self.is_rewritten and (not self.is_drawn or passed > SECONDS_BETWEEN or done >= total):
            self.write(f"{ERASE}{text}")
            self.written, self.is_drawn = now, True

    def erase(self) -> None:
        """Take the line off the terminal."""
        if self.is_drawn:
            self.write(ERASE)

    def write(self, text: str) -> None:
        """Write; a terminal that has gone ends no check."""
        with suppress(OSError):
            self.stream.write(text)
            self.stream.flush()
