"""Which files the digest of compiled kernels is made of."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

from cdpr_interval.kernels import sources
from tests.house import graph, modules, reached, tree

ROOT = Path(__file__).resolve().parents[2]
COMPILERS = {
    "njit",
    "jit",
    "vectorize",
    "guvectorize",
    "cfunc",
    "kernel",
    "intrinsic",
    "overload",
    "lower_builtin",
}


def declares(path: Path) -> bool:
    """Return whether a file has a function under one of numba's decorators, or ours."""
    return any(
        isinstance(node, ast.FunctionDef)
        and any(word in ast.unparse(decorator) for decorator in node.decorator_list for word in COMPILERS)
        for node in ast.walk(tree(path))
    )


def test_every_file_that_can_define_or_feed_a_kernel_is_in_the_digest():
    """Found in another way: from the syntax trees of all files of the house, wherever they lie."""
    starts = [name for name, path in modules().items() if declares(path)]
    needed = {modules()[name] for name in reached(graph(), starts)}
    found = set(sources.compiled_sources())
    assert len(starts) > 20
    assert needed <= found
    assert {path for path in found - needed if path.name != "__init__.py"} == set()


def test_what_feeds_no_kernel_is_not():
    """A change of a command or a report must not compile everything again."""
    names = {path.relative_to(ROOT).as_posix() for path in sources.compiled_sources()}
    assert not any(
        name.startswith(("solvers/commands", "solvers/report", "cdpr_interval/files")) for name in names
    )
    assert "solvers/six_dof/forward.py" not in names


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


def digest_in(root: Path) -> str:
    code = "from cdpr_interval.kernels import sources; print(sources.digest(), sources.are_as_digested())"
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


def test_nothing_is_read_before_a_kernel_is_declared():
    code = (
        "import sys, cdpr_interval, solvers, certificates\n"
        "print('cdpr_interval.kernels.sources' in sys.modules)\n"
        "import cdpr_interval.kernels\n"
        "from cdpr_interval.kernels import sources\n"
        "print(sources.digest.cache_info().misses)\n"
        "import cdpr_interval.kernels.rounding\n"
        "print(sources.digest.cache_info().misses)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "0", "1"]
