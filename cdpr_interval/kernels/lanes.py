"""Four doubles in one register: the same arithmetic on four cells at once.

A ``Lanes`` value exists inside compiled kernels only. It is loaded from and stored to float64 arrays of shape
(rows, columns, LANES); all operations act lane by lane, each rounded to nearest as the scalar one, so that
what is computed for a cell never depends on its neighbours. Python floats mix freely with lanes.

numba has no vector type, and its compiler vectorises loops over such arrays only when it can
prove that rows do not overlap; this type states it instead. Made with numba's documented
extension interface (numba.pydata.org, "Low-level extension API").
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

LANES = 4
"""Doubles in a value: one AVX2 register; with 8 the forms of a cell leave the fastest cache."""

Lanes = Any
"""A value of type ``lanes`` inside a kernel."""
LaneArray = Any
"""float64 array (rows, columns, LANES)."""

VECTOR = ir.VectorType(ir.DoubleType(), LANES)
WORD = ir.IntType(64)
INDEX = ir.IntType(32)


class LanesType(types.Type):  # type: ignore[misc]
    """The numba type of ``LANES`` doubles."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{LANES}")


lanes = LanesType()
array3 = types.Array(types.float64, 3, "C")
"""Type of a ``LaneArray``."""


@register_model(LanesType)
class LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    """Lanes are held in one vector register."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, VECTOR)


def address(context: Any, builder: Any, kind: Any, array: Any, i: Any, k: Any) -> Any:
    """Return the pointer to row ``i``, column ``k``."""
    whole = context.make_array(kind)(context, builder, array)
    rows = cgutils.unpack_tuple(builder, whole.strides, 3)[0]
    columns = ir.Constant(WORD, 8 * LANES)
    offset = builder.add(builder.mul(i, rows), builder.mul(k, columns))
    start = builder.ptrtoint(whole.data, WORD)
    return builder.inttoptr(builder.add(start, offset), VECTOR.as_pointer())


@intrinsic
def load(typing: Any, a: Any, i: Any, k: Any) -> Any:
    """Return a[i, k]."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(address(context, builder, sig.args[0], *args), align=8)

    return lanes(array3, types.intp, types.intp), lower


@intrinsic
def store(typing: Any, a: Any, i: Any, k: Any, value: Any) -> Any:
    """Set a[i, k]."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = args[3] if sig.args[3] == lanes else broadcast(builder, args[3])
        builder.store(value, address(context, builder, sig.args[0], *args[:3]), align=8)
        return context.get_dummy_value()

    kind = lanes if value == lanes else types.float64
    return types.void(array3, types.intp, types.intp, kind), lower


def broadcast(builder: Any, x: Any) -> Any:
    """Return a double in every lane."""
    nothing = ir.Constant(VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, x, ir.Constant(INDEX, 0))
    return builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(INDEX, LANES), [0] * LANES))


@intrinsic
def splat(typing: Any, x: Any) -> Any:
    """Return a double in every lane."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return broadcast(builder, args[0])

    return lanes(types.float64), lower


@intrinsic
def where_less(typing: Any, a: Any, b: Any, yes: Any, no: Any) -> Any:
    """Return ``yes`` where a < b, else ``no`` (also where a or b is NaN)."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b, yes, no = (
            x if kind == lanes else broadcast(builder, x) for kind, x in zip(sig.args, args, strict=True)
        )
        return builder.select(builder.fcmp_ordered("<", a, b), yes, no)

    kinds = [x if x == lanes else types.float64 for x in (a, b, yes, no)]
    return lanes(*kinds), lower


@intrinsic
def root(typing: Any, x: Any) -> Any:
    """Return the square root, lane by lane."""
    return lanes(lanes), lambda context, builder, sig, args: call_vector(builder, "sqrt", args)


def call_vector(builder: Any, name: str, args: Any) -> Any:
    """Call LLVM's intrinsic of that name on vectors."""
    kind = ir.FunctionType(VECTOR, [VECTOR] * len(args))
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{LANES}f64")
    return builder.call(function, args)


def define(function: Callable[..., Any], instruction: str) -> None:
    """Let an operator act on two lanes, or on lanes and a float."""
    pairs = ((lanes, lanes), (lanes, types.float64), (types.float64, lanes))

    @infer_global(function)
    class Template(AbstractTemplate):  # type: ignore[misc]
        """Typing of the operator."""

        def generic(self, args: Any, keywords: Any) -> Any:
            """Return the signature when lanes take part."""
            return signature(lanes, *args) if tuple(args) in pairs else None

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (x if kind == lanes else broadcast(builder, x) for kind, x in zip(sig.args, args, strict=True))
        return getattr(builder, instruction)(a, b)

    for pair in pairs:
        lower_builtin(function, *pair)(lower)


for plain, in_place, instruction in (
    (operator.add, operator.iadd, "fadd"),
    (operator.sub, operator.isub, "fsub"),
    (operator.mul, operator.imul, "fmul"),
    (operator.truediv, operator.itruediv, "fdiv"),
):
    define(plain, instruction)
    define(in_place, instruction)


@infer_global(abs)
class AbsTemplate(AbstractTemplate):  # type: ignore[misc]
    """Typing of abs(lanes)."""

    def generic(self, args: Any, keywords: Any) -> Any:
        """Return the signature for lanes."""
        return signature(lanes, lanes) if tuple(args) == (lanes,) else None


@lower_builtin(abs, lanes)
def lower_abs(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Clear the signs."""
    return call_vector(builder, "fabs", args)


@infer_global(operator.neg)
class NegTemplate(AbstractTemplate):  # type: ignore[misc]
    """Typing of -lanes."""

    def generic(self, args: Any, keywords: Any) -> Any:
        """Return the signature for lanes."""
        return signature(lanes, lanes) if tuple(args) == (lanes,) else None


@lower_builtin(operator.neg, lanes)
def lower_neg(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Flip the signs."""
    return builder.fneg(args[0])
