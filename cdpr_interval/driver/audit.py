"""The audit log: one line of JSON an event, and the last seconds of all cycles at every stop."""

from __future__ import annotations

import json
import queue
import threading
from collections import deque
from pathlib import Path
from types import TracebackType
from typing import Any

from cdpr_interval.driver.snapshot import Snapshot
from cdpr_interval.errors import InputError

KEPT_SECONDS = 10.0
"""How long before a stop cycles are kept."""


class AuditLog:
    """Writes events to a file from its own thread: a slow disk must not delay the cycle.

    Parameters
    ----------
    path : Path, optional
        Events are added at the end of this file; None: they are only counted.
    cycle : float
        s between two snapshots.

    Raises
    ------
    InputError
        When the file cannot be opened.
    """

    def __init__(self, path: Path | None, cycle: float) -> None:
        self._kept: deque[Snapshot] = deque(maxlen=max(int(KEPT_SECONDS / cycle), 1))
        self._lines: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self._writer: threading.Thread | None = None
        self.count = 0
        if path is not None:
            try:
                stream = path.open("a", encoding="utf-8")
            except OSError as error:
                raise InputError(f"log {path}: cannot be written: {error.strerror or error}") from None
            self._writer = threading.Thread(target=self._write, args=(stream,), name="audit log", daemon=True)
            self._writer.start()

    def event(self, time: float, kind: str, data: dict[str, Any]) -> None:
        """Log an event; at a stop also the cycles before it."""
        self.count += 1
        self._put({"time_s": time, "event": kind, **data})
        if kind == "stop":
            cycles = list(self._kept)
            self._kept.clear()
            self._put({"time_s": time, "event": "before", "cycles": cycles})

    def keep(self, snapshot: Snapshot) -> None:
        """Keep a cycle for the next stop."""
        self._kept.append(snapshot)

    def _put(self, line: dict[str, Any]) -> None:
        if self._writer is not None:
            self._lines.put(line)

    def _write(self, stream: Any) -> None:
        with stream:
            while (line := self._lines.get()) is not None:
                stream.write(json.dumps(line, default=_plain) + "\n")
                stream.flush()

    def close(self) -> None:
        """Write what is left."""
        if self._writer is not None:
            self._lines.put(None)
            self._writer.join(timeout=5.0)
            self._writer = None

    def __enter__(self) -> AuditLog:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _plain(value: object) -> object:
    """Return a snapshot as plain data; it is not turned into text in the cycle."""
    if isinstance(value, Snapshot):
        return value.to_json()
    raise TypeError(f"{type(value).__name__} is not for a log")
