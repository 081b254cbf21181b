"""The shape of the house: no circles, and numbers that keep it walkable."""

from __future__ import annotations

import ast
import re
from collections import Counter

import pytest

from tests.support.house import (
    ROOT,
    circles,
    floors,
    graph,
    imports_of,
    long_functions,
    modules,
    reached,
    rooms,
)


def test_no_modules_import_each_other():
    """Counted are imports for types only and imports inside functions, too."""
    assert circles(graph()) == []


def test_no_packages_import_each_other():
    """A folder is a room; at the top of `cdpr_interval` and of `solvers` each module is one."""
    assert circles(rooms()) == []


def test_there_are_few_floors():
    """A room stands one floor above the highest it imports from; what imports from none, on the first.

    Rooms that import each other, and so have no order, stand on one floor together.
    """
    found = floors(rooms())
    assert len(found) <= 12, found


def test_no_folder_is_crowded():
    files = Counter(path.parent.relative_to(ROOT).as_posix() for path in modules().values())
    assert {folder: count for folder, count in files.items() if count > 30} == {}


def test_few_functions_are_long():
    assert len(long_functions(70)) <= 4, long_functions(70)


def test_a_class_of_robot_is_asked_for_in_few_files():
    """The checker asks by itself: it shares nothing with the others."""
    asking = re.compile(r"\bis_point_mass\b")
    files = [
        name
        for name, path in modules().items()
        if not name.startswith("certificates") and asking.search(path.read_text(encoding="utf-8"))
    ]
    assert len(files) <= 6, files


KNOWN = ("p", "p.a", "p.b", "p.c", "p.d", "p.e")
SOURCE = """
import os, p.a
from p import (b, name)
if TYPE_CHECKING:
    from p.c import (C)
def f():
    from p.d import (D)
    import q.e
"""


def test_every_kind_of_import_counts():
    assert imports_of(ast.parse(SOURCE), "p.x", KNOWN) == {"p", "p.a", "p.b", "p.c", "p.d"}
    assert imports_of(ast.parse(SOURCE), "p.a", KNOWN) == {"p", "p.b", "p.c", "p.d"}
    with pytest.raises(AssertionError, match="imports by dots"):
        imports_of(ast.parse("from . import a"), "p.x", KNOWN)


def test_circles_and_floors_are_found():
    arrows = {"a": {"b", "f"}, "b": {"c"}, "c": {"a", "d"}, "d": {"e"}, "e": {"d"}, "f": set()}
    assert reached(arrows, ["d"]) == {"d", "e"}
    assert circles(arrows) == [["a", "b", "c"], ["d", "e"]]
    assert floors(arrows) == [["d", "e", "f"], ["a", "b", "c"]]
    assert circles({"a": {"b"}, "b": set()}) == []


def test_the_graph_is_of_the_whole_house():
    assert {"cdpr_interval.errors", "solvers.forward", "certificates.checker"} <= graph().keys()
    assert "cdpr_interval.kernels.rounding" in graph()["cdpr_interval.kernels.interval"]
    assert rooms()["solvers.point_mass"] >= {"cdpr_interval.kernels"}
