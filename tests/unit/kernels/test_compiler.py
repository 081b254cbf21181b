"""How kernels are compiled: what they share while it lasts, and what is left afterwards."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numba.core.errors import TypingError

from cdpr_interval.kernels.compiler import COMPILATION, CallTypes
from cdpr_interval.kernels.kernel import entry, kernel


class Context:
    """A typing context that counts what it is asked."""

    known = "something else"

    def __init__(self) -> None:
        self.asked: list[Any] = []

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        self.asked.append((func, args, kws))
        return None if func == "none" else (func, *args, *kws.values())


@pytest.fixture(params=[True, False])
def collecting(request: pytest.FixtureRequest) -> Iterator[bool]:
    """Garbage collection, on or off."""
    before = gc.isenabled()
    (gc.enable if request.param else gc.disable)()
    yield request.param
    (gc.enable if before else gc.disable)()


def test_equal_calls_are_typed_once() -> None:
    context = Context()
    types = CallTypes(context, {})
    for _ in range(3):
        assert types.resolve_function_type("add", (1, 2), {}) == ("add", 1, 2)
        assert types.resolve_function_type("add", (1,), {"b": 2}) == ("add", 1, 2)
        assert types.resolve_function_type("add", (1,), {"b": 3}) == ("add", 1, 3)
    assert len(context.asked) == 3
    assert types.known == "something else"


def test_calls_without_a_type_are_asked_again() -> None:
    context = Context()
    types = CallTypes(context, {})
    assert types.resolve_function_type("none", (), {}) is None
    assert types.resolve_function_type("none", (), {}) is None
    assert len(context.asked) == 2


def test_kernels_share_what_they_find_under_equal_flags_until_the_last_is_compiled() -> None:
    with COMPILATION:
        COMPILATION.found("flags")["call"] = "signature"
        with COMPILATION:
            assert COMPILATION.found("flags") == {"call": "signature"}
            assert COMPILATION.found("others") == {}
        assert COMPILATION.found("flags") == {"call": "signature"}
    with COMPILATION:
        assert COMPILATION.found("flags") == {}


def test_a_kernel_calls_another_with_several_types() -> None:
    @kernel()
    def half(x: Any) -> Any:
        return x / 2

    @kernel()
    def quarter(x: Any) -> Any:
        return half(half(x))

    @entry()
    def sums(number: float, count: int, rows: Any) -> Any:
        row = half(rows)
        return half(number) + half(number), half(count) + quarter(count), quarter(number), row[0], row[1]

    assert sums(3.0, 10, np.array([4.0, 6.0])) == (3.0, 7.5, 0.75, 2.0, 3.0)
    assert sums(1.0, 2, np.array([1.0, 2.0])) == (1.0, 1.5, 0.25, 0.5, 1.0)


def test_each_entry_keeps_its_rule_for_divisions() -> None:
    @kernel()
    def quotient(a: float, b: float) -> float:
        return a / b

    @entry()
    def inside(a: float, b: float) -> float:
        return quotient(a, b)

    @entry()
    def outside(a: float, b: float) -> float:
        return quotient(b, 1.0) + a / b

    assert inside(1.0, 0.0) == np.inf
    with pytest.raises(ZeroDivisionError):
        outside(1.0, 0.0)


def test_garbage_is_looked_for_again_after_a_compilation(collecting: bool) -> None:
    @entry()
    def twice(x: float) -> float:
        return 2.0 * x

    assert twice(1.0) == 2.0
    assert gc.isenabled() is collecting


def test_garbage_is_looked_for_again_after_a_failure(collecting: bool) -> None:
    @kernel()
    def unknown(x: Any) -> Any:
        return x.nothing_of_the_kind

    @entry()
    def calls(x: float) -> Any:
        return unknown(x)

    with pytest.raises(TypingError):
        calls(1.0)
    assert gc.isenabled() is collecting
    with COMPILATION:
        assert COMPILATION.found("flags") == {}
