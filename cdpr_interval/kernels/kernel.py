"""How kernels that only other kernels call are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def kernel(signatures: Any = None, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return the decorator of a kernel that is called from other kernels only.

    It has no entry from Python or C, which would take a third of its compilation, and divides as IEEE 754
    says instead of raising. Tests reach it through a compiled caller.

    Parameters
    ----------
    signatures
        Types to compile for at import; without them at the first use.
    options
        More options of ``numba.njit``.
    """
    inner = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "error_model": "numpy"}
    decorator: Callable[[Callable[..., Any]], Any] = njit(
        signatures, cache=True, nogil=True, **inner, **options
    )
    return decorator
