"""The modules of the house and who imports whom, read from the sources: nothing is imported for it."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("cdpr_interval", "solvers", "certificates")

Graph = Mapping[str, set[str]]
"""Names with the names they point at."""


@cache
def modules() -> dict[str, Path]:
    """Return every module of the three packages with its file."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def tree(path: Path) -> ast.Module:
    """Return the parsed source of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def named(node: ast.AST, module: str) -> Iterator[tuple[str, str | None]]:
    """Return what a statement imports: modules, each with the name taken from it."""
    if isinstance(node, ast.Import):
        for alias in node.names:
            yield alias.name, None
    elif isinstance(node, ast.ImportFrom):
        assert node.level == 0, f"{module} imports by dots"
        for alias in node.names:
            yield node.module or "", alias.name


def imports_of(source: ast.Module, module: str, known: Iterable[str]) -> set[str]:
    """Return the modules that one imports anywhere: for its types only and inside functions too.

    ``from package import module`` points at the module, ``from package import name`` at the package.
    """
    found = set()
    for node in ast.walk(source):
        for origin, name in named(node, module):
            found |= {f"{origin}.{name}" if f"{origin}.{name}" in known else origin} & set(known)
    return found - {module}


@cache
def graph() -> dict[str, set[str]]:
    """Return the modules with those they import."""
    return {name: imports_of(tree(path), name, modules().keys()) for name, path in modules().items()}


def reached(arrows: Graph, starts: Iterable[str]) -> set[str]:
    """Return the starts and all that they point at, however far."""
    found: set[str] = set()
    left = list(starts)
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += arrows[name]
    return found


def circles(arrows: Graph) -> list[list[str]]:
    """Return the sets of more than one name in which each reaches each (strongly connected components)."""
    ahead = {name: reached(arrows, [name]) for name in arrows}
    together = {frozenset(other for other in ahead[name] if name in ahead[other]) for name in arrows}
    return sorted(sorted(names) for names in together if len(names) > 1)


def floors(arrows: Graph) -> list[list[str]]:
    """Return the names floor by floor: one stands a floor above the highest of those it points at.

    A circle counts as one name: all of it stands on one floor.
    """
    circle = {name: tuple(names) for names in circles(arrows) for name in names}

    @cache
    def floor(name: str) -> int:
        group = circle.get(name, (name,))
        below = {other for member in group for other in arrows[member]} - set(group)
        return 1 + max(map(floor, below), default=0)

    return [
        sorted(name for name in arrows if floor(name) == number)
        for number in range(1, 1 + max(map(floor, arrows), default=0))
    ]


def room(module: str) -> str:
    """Return the room of a module: its folder, or itself at the top of `cdpr_interval` or `solvers`."""
    folder = module if modules()[module].name == "__init__.py" else module.rpartition(".")[0]
    return module if folder in ("cdpr_interval", "solvers") else folder


def rooms() -> dict[str, set[str]]:
    """Return the rooms with those they import from."""
    found: dict[str, set[str]] = {}
    for name, others in graph().items():
        found.setdefault(room(name), set()).update({room(other) for other in others} - {room(name)})
    return found


def long_functions(limit: int) -> dict[str, int]:
    """Return the functions of more lines than the limit with their lines, from `def` to the end."""
    return {
        f"{name}.{node.name}": (node.end_lineno or 0) - node.lineno + 1
        for name, path in modules().items()
        for node in ast.walk(tree(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (node.end_lineno or 0) - node.lineno + 1 > limit
    }
