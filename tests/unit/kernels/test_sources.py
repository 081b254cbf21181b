"""Which files the digest of compiled kernels is made of."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

from cdpr_interval.kernels import sources
from tests.support.house import graph, modules, reached, tree

ROOT = Path(__file__).resolve().parents[3]
COMPILERS = {
    "njit",
    "jit",
    "vectorize",
    "guvectorize",
    "cfunc",
    "kernel",
    "entry",
    "intrinsic",
    "overload",
    "lower_builtin",
}


def names(decorator: ast.expr) -> set[str]:
    """Return the names in a decorator, those behind dots too."""
    found = ast.walk(decorator)
    return {
        n.id if isinstance(n, ast.Name) else n.attr for n in found if isinstance(n, (ast.Name, ast.Attribute))
    }


def declares(path: Path) -> bool:
    """Return whether a file has a function under one of numba's decorators, or ours."""
    return any(
        isinstance(node, ast.FunctionDef)
        and any(word in COMPILERS for decorator in node.decorator_list for word in names(decorator))
        for node in ast.walk(tree(path))
    )


def test_every_file_that_can_define_or_feed_a_kernel_is_in_the_digest():
    """Found in another way: from the syntax trees of all files of the house, wherever they lie."""
    starts = [name for name, path in modules().items() if declares(path)]
    needed = {modules()[name] for name in reached(graph(), starts)}
    found = {sources.modules()[name].path for name in sources.closure()}
    assert len(starts) > 20
    assert needed <= found
    assert {path for path in found - needed if path.name != "__init__.py"} == set()


def test_every_file_that_can_feed_a_kernel_is_in_the_closure_of_its_own():
    """Found in the same other way, a file of kernels at a time; and no more but what packages bring."""
    known = {source.path: name for name, source in sources.modules().items()}
    for start in [name for name, path in modules().items() if declares(path)]:
        needed = reached(graph(), [start])
        packages = {name.rpartition(".")[0] for name in needed} & modules().keys()
        found = sources.closure(start)
        assert {known[modules()[name]] for name in needed} <= found, start
        assert found <= reached(graph(), needed | packages), start


def test_arithmetic_knows_no_solver_and_a_search_knows_arithmetic():
    assert not any(name.startswith("solvers") for name in sources.closure("cdpr_interval.kernels.interval"))
    search = sources.closure("solvers.six_dof.cells.root_search")
    assert {"solvers.six_dof.cells.root_search", "cdpr_interval.kernels.interval"} <= search
    assert search < sources.closure()
    point = sources.closure("solvers.point_mass.one_call")
    assert not any(name.startswith("solvers.six_dof") for name in point)


def test_what_feeds_no_kernel_is_not():
    """A change of a command or a report must not compile everything again."""
    names = sources.closure()
    assert not any(
        name.startswith(("solvers.commands", "solvers.report", "cdpr_interval.files")) for name in names
    )
    assert "solvers.six_dof.forward" not in names


def copied(root: Path) -> Path:
    """Copy the digest into a house of a kernel, a file of constants and one that nobody imports."""
    kernels, solver = root / "cdpr_interval" / "kernels", root / "solvers" / "six_dof"
    kernels.mkdir(parents=True)
    solver.mkdir(parents=True)
    for folder in (kernels.parent, kernels, solver.parent, solver):
        (folder / "__init__.py").touch()
    (kernels / "sources.py").write_text(Path(sources.__file__).read_text())
    (solver / "search.py").write_text(
        "import numba\nfrom solvers.six_dof import (\n    constants,  # a comment\n    other as renamed,\n)\n"
    )
    (solver / "constants.py").write_text("if True:\n    import solvers.six_dof.deeper as deeper\n")
    (solver / "deeper.py").write_text("LIMIT = 1\n")
    (solver / "other.py").write_text("")
    (solver / "alone.py").write_text("LIMIT = 1\n")
    return solver


def digest_in(root: Path, module: str | None = None) -> str:
    """Return the digest of a module, or of all, that a new process finds."""
    code = (
        "from cdpr_interval.kernels import sources\n"
        f"print(sources.digest({module!r}), sources.are_as_digested({module!r}))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    digest, same = done.stdout.split()
    assert same == "True"
    return digest


def test_the_digest_is_of_names_and_contents(tmp_path):
    solver = copied(tmp_path / "one")
    copied(tmp_path / "two")
    before = digest_in(tmp_path / "one")
    assert digest_in(tmp_path / "two") == before
    (solver / "alone.py").write_text("LIMIT = 2\n")
    assert digest_in(tmp_path / "one") == before
    seen = {before}
    for name in ("search", "constants", "deeper", "other"):
        with (solver / f"{name}.py").open("a") as file:
            file.write("# more\n")
        seen.add(digest_in(tmp_path / "one"))
    (solver / "deeper.py").rename(solver / "lower.py")
    (solver / "constants.py").write_text("import solvers.six_dof.lower as deeper\n")
    seen.add(digest_in(tmp_path / "one"))
    assert len(seen) == 6


def test_the_digest_of_a_module_is_of_what_it_imports(tmp_path):
    solver = copied(tmp_path)
    names = [f"solvers.six_dof.{name}" for name in ("search", "constants", "other")]
    before = [digest_in(tmp_path, name) for name in names]
    assert len(set(before)) == 3
    for edited, changes in (
        ("alone", [False, False, False]),
        ("deeper", [True, True, False]),
        ("other", [True, False, True]),
    ):
        with (solver / f"{edited}.py").open("a") as file:
            file.write("# more\n")
        after = [digest_in(tmp_path, name) for name in names]
        assert [one != other for one, other in zip(before, after, strict=True)] == changes
        before = after


def test_nothing_is_read_before_a_kernel_is_declared():
    code = (
        "import sys, cdpr_interval, solvers, certificates\n"
        "print('cdpr_interval.kernels.sources' in sys.modules)\n"
        "import cdpr_interval.kernels\n"
        "from cdpr_interval.kernels import sources\n"
        "print(sources.modules.cache_info().misses)\n"
        "import cdpr_interval.kernels.rounding\n"
        "print(sources.modules.cache_info().misses)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "0", "1"]
