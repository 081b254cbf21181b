"""Kernels without an entry from Python, called through a compiled caller."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from numba import njit
from numba.core.registry import CPUDispatcher


def caller(inner: Any) -> Any:
    """Return a function that Python can call."""
    if inner.targetoptions.get("inline") == "always":
        # It is inlined wherever it is called, also into a function that passes on its arguments as they are.
        return njit(inner.py_func)

    @njit
    def call(*arguments: Any) -> Any:
        return inner(*arguments)

    return call


class Callers:
    """The names of some modules, with kernels that can be called from Python."""

    def __init__(self, *modules: ModuleType) -> None:
        self.modules = modules

    def __getattr__(self, name: str) -> Any:
        """Return a module's name; what was found is kept."""
        module = next((m for m in self.modules if hasattr(m, name)), None)
        if module is None:
            raise AttributeError(name)
        found = getattr(module, name)
        if isinstance(found, CPUDispatcher) and found.targetoptions.get("no_cpython_wrapper"):
            found = caller(found)
        setattr(self, name, found)
        return found
