"""Imports that import-linter cannot judge: allow-lists and laziness."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
CHECKER = sorted((ROOT / "certificates").rglob("*.py"))


def imported(path: Path) -> set[str]:
    """Return the top-level names a file imports anywhere, calls of import machinery included."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add("certificates" if node.level else (node.module or "").partition(".")[0])
        elif isinstance(node, ast.Name) and node.id in {"__import__", "exec", "eval"}:
            names.add(node.id)
    return names


@pytest.mark.parametrize("path", CHECKER, ids=lambda path: path.name)
def test_the_checker_imports_the_standard_library_numpy_flint_and_itself(path: Path):
    allowed = sys.stdlib_module_names - {"importlib", "runpy"} | {"numpy", "flint", "certificates"}
    assert imported(path) <= allowed


def test_the_walk_sees_what_it_must(tmp_path):
    path = tmp_path / "bad.py"
    path.write_text("def f():\n    from scipy.linalg import solve\n    __import__('numba')\n")
    assert imported(path) == {"scipy", "__import__"}
    assert CHECKER


NUMERICS = {"numpy", "numba", "sympy", "flint"}
READING = {"pydantic", "yaml", "click", "rich"}


def loaded(statements: str, watched: set[str]) -> str:
    """Run statements in a fresh interpreter and return which of the watched modules it loaded."""
    code = f"import sys\n{statements}\nprint(sorted({watched!r} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize("module", ["cdpr_interval", "cdpr_interval.robots.cable_robot", "certificates"])
def test_importing_is_light(module: str):
    assert loaded(f"import {module}", NUMERICS | READING) == "[]"


def test_reading_a_robot_needs_no_numerics():
    assert loaded("import cdpr_interval\ncdpr_interval.load_robot('uc2')", NUMERICS) == "[]"
    assert loaded("import numpy", NUMERICS) == "['numpy']"


def test_version():
    import cdpr_interval
    from cdpr_interval.version import RELEASE

    assert cdpr_interval.__version__.startswith(f"{RELEASE}")
    with pytest.raises(AttributeError):
        _ = cdpr_interval.nothing
