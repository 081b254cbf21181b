"""How far a search is: one line on a terminal that is rewritten; elsewhere only that kernels are compiled."""

from __future__ import annotations

import os
import shutil
import time
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import TextIO

from solvers.questions.problem import Progress

BAR = 20
"""Width of the bar in characters."""


class ProgressDisplay:
    """A callable for `Options.progress`, and the context in which its line is on the screen."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_terminal = stream.isatty() and os.environ.get("TERM") != "dumb"
        self._has_colour = self._is_terminal and not os.environ.get("NO_COLOR")
        self._start = 0.0
        self._drawn = False
        self._listening = ExitStack()

    def __enter__(self) -> ProgressDisplay:
        from solvers.commands.compilation import listening

        self._start = time.perf_counter()
        self._listening.enter_context(listening(self._say))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._listening.close()
        if self._drawn:
            self._write("\r\x1b[K")

    def __call__(self, progress: Progress) -> None:
        """Show a report."""
        if not self._is_terminal:
            return
        text = self._line(progress)[: shutil.get_terminal_size().columns - 1]
        if self._has_colour:
            text = f"\x1b[36m{text}\x1b[0m"
        self._write(f"\r{text}\x1b[K")
        self._drawn = True

    def _line(self, progress: Progress) -> str:
        elapsed = max(time.perf_counter() - self._start, 1e-9)
        done = 1.0 - min(1.0, max(0.0, progress.volume_left))
        total = max(progress.subsets_total, 1)
        filled = round(BAR * min(1.0, (progress.subsets_done + done) / total))
        return (
            f"[{'#' * filled}{'.' * (BAR - filled)}]"
            f" subset {min(progress.subsets_done + 1, total)}/{total}"
            f"  {100.0 * (1.0 - done):.3g} % of the volume left"
            f"  {_count(progress.cells / elapsed)} cells/s"
            f"  {progress.solutions} solution{'s' if progress.solutions != 1 else ''}"
        )

    def _say(self, line: str) -> None:
        """Write a line that stays."""
        erase = "\r\x1b[K" if self._drawn else ""
        self._write(f"{erase}{line}\n")

    def _write(self, text: str) -> None:
        # A log that nobody reads any more must not end a search.
        with suppress(BrokenPipeError):
            self._stream.write(text)
            self._stream.flush()


def _count(number: float) -> str:
    for size, unit in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if number >= size:
            return f"{number / size:.3g}{unit}"
    return f"{number:.3g}"
