"""Every kernel's docstring names the shapes of its arrays, or its module's does in a paragraph "Arrays: ..".

A kernel's parameters are ``Any``: who reads ``(data, rows, free, C, z)`` would have to find the caller.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[3]
FOLDERS = (
    "cdpr_interval/kernels",
    "cdpr_interval/engine",
    "cdpr_interval/mechanics",
    "solvers/six_dof",
    "solvers/point_mass",
)
LANE_ARRAYS = ("Forms", "LaneArray")
"""Annotations of arrays (rows, columns, LANES)."""
RECORDS = ("Symbols",)
"""Annotations of tuples: they say what they are."""


class Parameter(NamedTuple):
    """What a kernel's code says about a parameter that is an array or a tuple."""

    name: str
    least: int
    """It has at least so many axes: 0 for a tuple."""
    exact: bool
    """It has exactly so many."""
    record: bool
    """Its fields are taken by name, or it is unpacked: a (named) tuple."""


def modules() -> dict[str, Path]:
    """Return all modules of the folders by their dotted names."""
    paths = (path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py")))
    return {".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in paths}


MODULES = modules()


def decorator_of(node: ast.FunctionDef) -> ast.expr | None:
    """Return what makes a function a kernel: ``njit``, ``njit(..)`` or ``kernel(..)``."""
    for decorator in node.decorator_list:
        function = decorator.func if isinstance(decorator, ast.Call) else decorator
        if isinstance(function, ast.Name) and function.id in ("njit", "kernel"):
            return decorator
    return None


def kernels(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    """Yield the compiled functions of a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and decorator_of(node) is not None:
            yield node


def axes_by_signature(node: ast.FunctionDef) -> list[int | None]:
    """Return each parameter's number of axes by the text of the explicit signature; None where unknown."""
    decorator = decorator_of(node)
    unknown: list[int | None] = [None] * len(node.args.args)
    if not isinstance(decorator, ast.Call) or not decorator.args:
        return unknown
    text = decorator.args[0]
    if not isinstance(text, ast.Constant):
        return unknown
    arguments = str(text.value)[:-1].rsplit("(", 1)[1]
    kinds = re.findall(r"[^,\[]+(?:\[[^\]]*\])?", arguments)
    assert len(kinds) == len(unknown), node.name
    return [kind.count(":, ") + 1 if "[" in kind else 0 for kind in kinds]


def axes_by_use(node: ast.FunctionDef) -> tuple[dict[str, int], set[str]]:
    """Return how many axes each name has at least by its indices, and the names that are used as tuples."""
    least: dict[str, int] = {}
    records: set[str] = set()
    for part in ast.walk(node):
        if isinstance(part, ast.Subscript) and isinstance(part.value, ast.Name):
            axes = len(part.slice.elts) if isinstance(part.slice, ast.Tuple) else 1
            least[part.value.id] = max(axes, least.get(part.value.id, 0))
        elif isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name):
            if part.attr == "shape":
                least.setdefault(part.value.id, 1)
            else:
                records.add(part.value.id)
        elif isinstance(part, ast.Assign) and isinstance(part.value, ast.Name):
            unpacked = any(isinstance(target, ast.Tuple) for target in part.targets)
            records |= {part.value.id} if unpacked else set()
    return least, records


def parameters(node: ast.FunctionDef) -> Iterator[Parameter]:
    """Yield the parameters that must be named; what only passes through to other kernels is not known."""
    least, records = axes_by_use(node)
    for argument, signed in zip(node.args.args, axes_by_signature(node), strict=True):
        name = argument.arg
        annotation = argument.annotation
        if isinstance(annotation, ast.Name) and annotation.id in LANE_ARRAYS:
            yield Parameter(name, 3, True, False)
        elif isinstance(annotation, ast.Name) and annotation.id in RECORDS:
            continue
        elif signed:
            yield Parameter(name, signed, True, False)
        elif name in records:
            yield Parameter(name, 0, False, True)
        elif name in least:
            yield Parameter(name, least[name], False, False)


SHAPE = r"\((?=[^()]*,)(?:[^()]|\([^()]*\))+\)"
"""At least one comma: (n,) or (n, 2) or (m, 2 (6 + n))."""


def shapes_of(name: str, text: str) -> list[str]:
    """Return the shapes that a text gives a name: ``x (n, 2)``, ``x : (3,)`` or ``a, x : (3,), (n, 2)``."""
    found = []
    for names, shapes in re.findall(
        rf"(?<![\w.\[])(\w+(?:, \w+)*)(?:``)? ?:? ?({SHAPE}(?:, {SHAPE})*)", text
    ):
        listed, given = names.split(", "), re.findall(SHAPE, shapes)
        if name in listed and len(given) == len(listed):
            found.append(given[listed.index(name)])
        elif name in listed and len(given) == 1:
            found.append(given[0])
    return found


def axes_of(shape: str) -> int:
    """Return how many axes a shape has."""
    return len([axis for axis in shape[1:-1].split(",") if axis.strip()])


def names_record(name: str, text: str) -> bool:
    """Return True when a text says what tuple a name is: ``x`` is a ``Class``, or x is ``(a, b)``."""
    item = r"(?:an? |the )?`{1,2}"
    prose = rf"(?<![\w.]){re.escape(name)}(?:``)?,? (?:is|are) {item}"
    listed = rf"(?<![\w.]){re.escape(name)} {item}"
    return re.search(f"{prose}|{listed}", text, re.IGNORECASE) is not None


def one_line(text: str) -> str:
    """Return a text without line breaks."""
    return " ".join(text.split())


def arrays_paragraph(tree: ast.Module, seen: tuple[str, ...] = ()) -> str:
    """Return the paragraphs "Arrays: .." of a module's docstring and of those it is to be read with."""
    paragraphs = re.split(r"\n\s*\n", ast.get_docstring(tree) or "")
    text = " ".join(one_line(p) for p in paragraphs if re.match(r"Arrays\b[^:]*:", p))
    for reference in re.findall(r"as in ``([\w.]+)``", text):
        targets = [name for name in MODULES if f".{name}".endswith(f".{reference}")]
        assert len(targets) == 1, f"``{reference}`` is {targets}"
        assert targets[0] not in seen, f"{targets[0]} refers to itself"
        text += " " + arrays_paragraph(ast.parse(MODULES[targets[0]].read_text()), (*seen, targets[0]))
    return text


def complaints(tree: ast.Module) -> Iterator[str]:
    """Yield the arrays of a module's kernels whose shape is not named, or has another number of axes."""
    shared = arrays_paragraph(tree)
    for node in kernels(tree):
        own = one_line(ast.get_docstring(node) or "")
        for parameter in parameters(node):
            where = f"{node.name}({parameter.name})"
            shapes = shapes_of(parameter.name, own) or shapes_of(parameter.name, shared)
            record = names_record(parameter.name, own) or names_record(parameter.name, shared)
            if parameter.record or (not shapes and not parameter.exact and record):
                if not record:
                    yield f"{where}: a tuple of what?"
            elif not shapes:
                yield f"{where}: no shape, {parameter.least} axes or more"
            elif not any(fits(parameter, shape) for shape in shapes):
                yield f"{where}: {shapes} has not {parameter.least} axes"


def fits(parameter: Parameter, shape: str) -> bool:
    """Return True when a shape has as many axes as the code needs."""
    axes = axes_of(shape)
    return axes == parameter.least if parameter.exact else axes >= parameter.least


def with_kernels() -> Iterable[str]:
    """Return the modules that define kernels."""
    return [name for name, path in MODULES.items() if any(kernels(ast.parse(path.read_text())))]


def test_kernels_are_found() -> None:
    """The folders hold the kernels this test is about: each has some."""
    names = list(with_kernels())
    for folder in FOLDERS:
        assert any(name.startswith(folder.replace("/", ".")) for name in names), folder


@pytest.mark.parametrize("module", with_kernels())
def test_shapes_are_named(module: str) -> None:
    """Each array of each kernel has its shape in the docstring."""
    assert list(complaints(ast.parse(MODULES[module].read_text()))) == []


KERNEL = """
def bend(x, rows, model):
    \'\'\'Bend x {shape}.\'\'\'
    n, m = rows.shape
    return x[0, n] + model.load[m]
"""
ARRAYS = "Arrays: ``rows`` (n, m); ``model`` is a ``Model``."


def example(arrays: str, shape: str, decorator: str = "@kernel()") -> list[str]:
    """Return the complaints about a module with one kernel."""
    function = KERNEL.format(shape=shape).lstrip()
    return list(complaints(ast.parse(f'"""A module.\n\n{arrays}\n"""\n{decorator}\n{function}')))


def test_a_named_shape_is_seen() -> None:
    """Shapes count where the kernel or its module's paragraph names them."""
    assert example(ARRAYS, "(n, 2)") == []
    assert example(ARRAYS + " ``x`` (n,\n2) too.", "much") == []
    assert example("Arrays, for n cables: ``rows, x`` (n, m); ``model`` is a ``Model``.", "much") == []


@pytest.mark.parametrize(
    ("arrays", "shape", "wrong"),
    [
        (ARRAYS, "much", ["x"]),
        (ARRAYS, "(n)", ["x"]),
        (ARRAYS, "(n,)", ["x"]),
        ("Rows (n, m) are arrays, ``model`` is a ``Model``.", "(n, 2)", ["model", "rows"]),
        ("Arrays: ``rows`` (n, m), model.", "(n, 2)", ["model"]),
        ("", "much", ["model", "rows", "x"]),
    ],
)
def test_a_missing_shape_is_noticed(arrays: str, shape: str, wrong: list[str]) -> None:
    """Complaints: nothing named, too few axes, named outside the paragraph, a tuple without a class."""
    named = [re.search(r"\((\w+)\)", text) for text in example(arrays, shape)]
    assert sorted(match[1] for match in named if match) == wrong


def test_axes_must_be_those_of_the_signature() -> None:
    """An explicit signature counts the axes."""
    signed = '@njit("f8(f8[:, ::1], f8[:, ::1], i8)", cache=True)'
    assert example(ARRAYS, "(n, 2)", signed) == []
    assert example(ARRAYS, "(n, 2, 2)", signed) == ["bend(x): ['(n, 2, 2)'] has not 2 axes"]


def test_a_paragraph_may_refer_to_another_module() -> None:
    """The shapes of that one count, and a module that does not exist is an error."""
    reference = "Arrays: as in ``cells.tests``; ``x`` (n, 2), ``rows`` (n, m)."
    assert example(reference, "much") == []
    with pytest.raises(AssertionError, match="nowhere"):
        example("Arrays: as in ``nowhere.tests``.", "much")
