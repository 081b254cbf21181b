"""How far a check is: one line on a terminal, rewritten a few times a second."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from typing import TextIO

SECONDS_BETWEEN = 0.2
"""Between two lines."""
ERASE = "\r\x1b[K"


class ProgressLine:
    """A callable for `check`: cells checked, all cells, and the time that is left at this rate."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.is_shown = stream.isatty() and os.environ.get("TERM") != "dumb"
        self.begun = self.written = time.monotonic()
        self.is_drawn = False

    def __call__(self, done: int, total: int) -> None:
        """Rewrite the line, unless that was done a moment ago."""
        now = time.monotonic()
        if not self.is_shown or (self.is_drawn and now - self.written < SECONDS_BETWEEN and done < total):
            return
        left = f", {(now - self.begun) * (total - done) / done:.0f} s left" if 0 < done < total else ""
        self.write(f"{ERASE}{done}/{total} cells{left}")
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
