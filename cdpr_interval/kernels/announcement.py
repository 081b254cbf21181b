"""What is said when kernels start to be compiled: for what, and how long it takes, once for each part."""

from __future__ import annotations

import logging
from typing import Any

from numba.core import event

LOGGER = "cdpr_interval"
"""Name of the logger. It warns, so that who waits hears why without any setting."""
PARTS = {
    "solvers.point_mass.": ("point masses", 20),
    "solvers.routed_mass.": ("point masses over pulleys", 40),
    "solvers.six_dof.cells.certified": ("certificates of platforms", 20),
    "solvers.six_dof.cells.noted": ("certificates of platforms", 20),
    "solvers.six_dof.track": ("trackers of platforms", 15),
    "solvers.six_dof.": ("six-dof platforms", 45),
    "cdpr_interval.mechanics.six_dof.": ("six-dof platforms", 45),
}
"""What kernels are for, and about how many seconds of a processor all of them take, by the start of their
module's name: the first that fits. Kernels elsewhere take no time that would be worth a word."""


def text_of(module: str) -> str | None:
    """Return what is said when a kernel of a module is compiled, None when nothing is."""
    for start, (part, seconds) in PARTS.items():
        if module.startswith(start):
            return f"compiling kernels for {part}, for the first question of a kind, up to {seconds} s"
    return None


class Announcement(event.Listener):  # type: ignore[misc]
    """Tells a logger what numba compiles."""

    def __init__(self) -> None:
        self._said: set[str] = set()
        self._depth = 0

    def on_start(self, event: Any) -> None:
        """Say it of the kernel that is asked for, not of those that it calls."""
        self._depth += 1
        text = text_of(event.data["dispatcher"].py_func.__module__) if self._depth == 1 else None
        if text is not None and text not in self._said:
            self._said.add(text)
            logging.getLogger(LOGGER).warning(text)

    def on_end(self, event: Any) -> None:
        """Note that a kernel is done."""
        self._depth -= 1


def install() -> None:
    """Listen from now on."""
    event.register("numba:compile", Announcement())
