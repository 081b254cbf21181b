"""How far a command is: a bar with the time left, on a terminal or in a notebook; in a log lines."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, TextIO

from cdpr_interval.text.count import counted
from solvers.questions.problem import Progress

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

    from solvers.batch.run import BatchProgress

BAR = 20
"""Width of the bar in characters."""
PATIENCE = 0.3
"""s before a bar is drawn: what ends earlier neither flickers nor pays for it."""
REDRAWS = 4.0
"""A second; each takes 2 ms of processor time."""
SECONDS_BETWEEN = 10.0
"""Between two lines of a log."""


class ProgressDisplay:
    """A callable for `Options.progress`, and the context in which its bar is on the screen.

    Parameters
    ----------
    stream : TextIO
        Standard error.
    task : str
        What is being done, in a word.

    Where no bar can be drawn, a line is written every ten seconds, also while nothing is told.
    """

    def __init__(self, stream: TextIO, task: str = "search") -> None:
        self._stream = Unbroken(stream)
        self._has_bar = in_notebook() or (stream.isatty() and os.environ.get("TERM") != "dumb")
        self._task, self._done, self._total, self._detail = task, 0.0, None, ""
        self._start = time.monotonic()
        self._lock = threading.RLock()
        self._bar: Bar | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._open if self._has_bar else self._log, daemon=True)
        self._listening = ExitStack()

    _total: float | None

    def __enter__(self) -> ProgressDisplay:
        from solvers.commands.compilation import listening

        self._start = time.monotonic()
        self._listening.enter_context(listening(self._say))
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._listening.close()
        self._ended.set()
        with self._lock:
            if self._bar is not None:
                self._bar.stop()

    def __call__(self, progress: Progress) -> None:
        """Show how far a search is."""
        total = max(progress.subsets_total, 1)
        done = progress.done
        if done is None:
            done = (progress.subsets_done + 1.0 - min(1.0, max(0.0, progress.volume_left))) / total
        rate = progress.cells / max(time.monotonic() - self._start, 1e-9)
        parts = [f"subset {min(progress.subsets_done + 1, total)}/{total}"] if total > 1 else []
        if progress.solutions:
            parts.append(counted(progress.solutions, "solution"))
        self._show(done, 1.0, ", ".join([*parts, f"{_count(rate)} cells/s"]))

    def cells(self, done: int, total: int) -> None:
        """Show how many cells of a certificate are checked."""
        self._show(done, total, f"{done}/{counted(total, 'cell')}")

    def jobs(self, progress: BatchProgress) -> None:
        """Show how far a batch is."""
        bad = f", {progress.bad} failed" if progress.bad else ""
        text = f"{progress.done}/{counted(progress.total, 'job')}, {progress.rate:.3g} jobs/s{bad}"
        self._show(progress.done, progress.total, text)

    def stage(self, task: str, detail: str = "") -> None:
        """Say what is done next; how long it takes is not known."""
        with self._lock:
            self._task, self._done, self._total, self._detail = task, 0.0, None, detail
            if self._bar is not None:
                # A task of a bar cannot forget its length.
                self._bar.remove_task(self._bar.task_ids[0])
                self._bar.add_task(**self._state())

    def _show(self, done: float, total: float | None, detail: str) -> None:
        with self._lock:
            self._done, self._total, self._detail = done, total, detail
            if self._bar is not None:
                self._bar.update(self._bar.task_ids[0], **self._state())

    def _state(self) -> dict[str, Any]:
        found = {"completed": self._done, "total": self._total}
        return {"description": self._task, "detail": self._detail, **found}

    def _open(self) -> None:
        """Draw the bar; this is a thread."""
        if self._ended.wait(PATIENCE):
            return
        bar = drawn_on(self._stream)
        with self._lock:
            if not self._ended.is_set():
                self._bar = bar
                bar.add_task(**self._state())
                bar.start()

    def _log(self) -> None:
        """Write a line now and then; this is a thread."""
        while not self._ended.wait(SECONDS_BETWEEN):
            with self._lock:
                if not self._ended.is_set():
                    self._say(self._line())

    def _line(self) -> str:
        """Return how long the command has been at work, and how far it is."""
        from solvers.batch.duration import duration

        gone, total = time.monotonic() - self._start, self._total
        left = gone * (total - self._done) / self._done if total and self._done else None
        parts = ", ".join(filter(None, [*_rest(self._done, total, left), self._detail]))
        return f"{self._task} after {duration(gone)}{': ' if parts else ''}{parts}"

    def _say(self, line: str) -> None:
        """Write a line that stays, above the bar."""
        with self._lock:
            if self._bar is not None:
                self._bar.console.print(line, markup=False, highlight=False)
            else:
                self._stream.write(f"{line}\n")
                self._stream.flush()


@contextmanager
def shown(task: str, quiet: bool) -> Iterator[ProgressDisplay | None]:
    """Give the display of a command on standard error; None where nothing is to be shown."""
    from solvers.commands.compilation import listening

    if quiet:
        with listening(lambda line: None):
            yield None
    else:
        with ProgressDisplay(sys.stderr, task) as display:
            yield display


class Unbroken:
    """A stream that forgets what nobody reads any more: a closed log or terminal must not end a search."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write, or do nothing."""
        with suppress(OSError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush, or do nothing."""
        with suppress(OSError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def drawn_on(stream: Any) -> Bar:
    """Return a bar that vanishes at its end; `NO_COLOR` is honoured."""
    from rich.console import Console
    from rich.progress import BarColumn, ProgressColumn, Task, TextColumn
    from rich.progress import Progress as Bar
    from rich.table import Column
    from rich.text import Text

    from solvers.batch.duration import duration

    class Rest(ProgressColumn):
        """What is done, the time left, and what else is to be said, cut where the terminal ends."""

        def render(self, task: Task) -> Text:
            parts = _rest(task.completed, task.total, task.time_remaining)
            if not parts and task.elapsed is not None:
                parts = [duration(task.elapsed)]
            parts.append(task.fields["detail"])
            return Text(", ".join(filter(None, parts)), no_wrap=True, overflow="ellipsis")

    return Bar(
        TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True)),
        BarColumn(bar_width=BAR, table_column=Column(min_width=BAR)),
        Rest(table_column=Column(no_wrap=True)),
        console=Console(file=stream),
        refresh_per_second=REDRAWS,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )


def _rest(done: float, total: float | None, left: float | None) -> list[str]:
    """Return the share that is done, and the time it will take, as far as these are known."""
    from solvers.batch.duration import duration

    if not total:
        return []
    share = f"{100.0 * done / total:.0f} %"
    return [share] if left is None else [share, f"{duration(left)} left"]


def in_notebook() -> bool:
    """Return whether this runs in a notebook, whose output has no terminal but can be redrawn."""
    shell = sys.modules.get("IPython")
    return shell is not None and type(shell.get_ipython()).__name__ == "ZMQInteractiveShell"


def _count(number: float) -> str:
    for size, unit in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if number >= size:
            return f"{number / size:.3g}{unit}"
    return f"{number:.3g}"
