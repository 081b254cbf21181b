"""What is logged while a command runs, that kernels are compiled above all, for the command's own display."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Told(logging.Handler):
    """Hands each message on."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        super().__init__()
        self._tell = tell

    def emit(self, record: logging.LogRecord) -> None:
        """Hand a message on."""
        self._tell(record.getMessage())


@contextmanager
def listening(tell: Callable[[str], None]) -> Iterator[None]:
    """Call ``tell`` with what the package logs, instead of what loggers do with it.

    Parameters
    ----------
    tell : callable
        Takes a line; called from the thread that compiles.
    """
    # The name is ``kernels.announcement.LOGGER``; importing that would import numba.
    logger, handler = logging.getLogger("cdpr_interval"), Told(tell)
    before = logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = before
