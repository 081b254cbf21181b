"""How kernels are declared: those that Python calls, those that only kernels call, and parts of these."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

from cdpr_interval.kernels.compiler import EntryKernel, InnerKernel

Decorator = Callable[[Callable[..., Any]], Any]


def kernel(signatures: Any = None, inline: str = "never") -> Decorator:
    """Return the decorator of a kernel that is called from other kernels only.

    It has no entry from Python or C and divides as IEEE 754 says instead of raising. Tests reach it through
    a compiled caller.

    Parameters
    ----------
    signatures
        Types to compile for, one or a list; without them those of each caller.
    inline
        "always": it becomes a part of its caller before types are known.
    """
    if inline == "always":
        return part(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
    return lambda function: InnerKernel(function, _listed(signatures), _options(error_model="numpy"))


def entry(signatures: Any = None) -> Decorator:
    """Return the decorator of a kernel that Python calls.

    A division by zero in it raises ``ZeroDivisionError``.

    Parameters
    ----------
    signatures
        As of ``kernel``: types to compile for where kernels call it.
    """
    return lambda function: EntryKernel(function, _listed(signatures), _options())


def part(**options: Any) -> Decorator:
    """Return the decorator of what becomes a part of its callers, with the functions handed in."""
    decorator: Decorator = njit(cache=True, nogil=True, inline="always", **options)
    return decorator


def _listed(signatures: Any) -> list[Any]:
    if signatures is None:
        return []
    return signatures if isinstance(signatures, list) else [signatures]


def _options(**more: Any) -> dict[str, Any]:
    return {"nopython": True, "nogil": True, "boundscheck": None, **more}
