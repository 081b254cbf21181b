"""How far a batch is: a line that is rewritten on a terminal, and one now and then elsewhere."""

from __future__ import annotations

import os
import shutil
import time
from contextlib import suppress
from typing import TextIO

from solvers.batch.run import BatchProgress

SECONDS_BETWEEN = 10.0
"""Between two lines of a log."""


class ProgressLine:
    """A callable for `BatchRun`."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_terminal = stream.isatty() and os.environ.get("TERM") != "dumb"
        self._written_at = time.monotonic()
        self._drawn = False

    def __call__(self, progress: BatchProgress) -> None:
        """Show a report."""
        text = line(progress)
        if self._is_terminal:
            self._write(f"\r{text[: shutil.get_terminal_size().columns - 1]}\x1b[K")
            self._drawn = True
        elif time.monotonic() - self._written_at > SECONDS_BETWEEN:
            self._write(text + "\n")
            self._written_at = time.monotonic()

    def end(self) -> None:
        """Take the line off the terminal."""
        if self._drawn:
            self._write("\r\x1b[K")

    def _write(self, text: str) -> None:
        # A log that nobody reads any more must not end a batch.
        with suppress(BrokenPipeError):
            self._stream.write(text)
            self._stream.flush()


def line(progress: BatchProgress) -> str:
    """Return one line: done, rate, remaining time, what went wrong."""
    share = 100.0 * progress.done / max(progress.total, 1)
    rest = "" if progress.remaining is None else f", {duration(progress.remaining)} left"
    bad = f", {progress.bad} failed" if progress.bad else ""
    return f"{progress.done}/{progress.total} jobs ({share:.0f} %), {progress.rate:.3g} jobs/s{rest}{bad}"


def duration(seconds: float) -> str:
    """Return a time for people: 42 s, 3 min 10 s, 2 h 5 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{seconds:.2g} s" if seconds < 10 else f"{whole} s"
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min"
