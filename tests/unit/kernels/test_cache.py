"""numba's cache: a folder for each file and state of what it imports, several processes."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from numba.core import caching

from cdpr_interval.kernels import cache, rounding, sources
from cdpr_interval.kernels.cache import ANY, KEPT, LOCK, PREFIX, KeyedCacheFile, locked, make_room, mark_used

ROOT = Path(__file__).resolve().parents[3]
PLAIN = KeyedCacheFile.__bases__[0]
NO_LOCKS = pytest.mark.skipif(sys.platform == "win32", reason="no folder locks")

INNER = """
from numba import (njit)
FACTOR = {factor}
@njit(cache=True)
def inner(x):
    return {inner}
"""
OUTER = """
from numba import (njit)
import cdpr_interval.kernels
from solvers.six_dof.inner import (FACTOR, inner)
@njit(cache=True)
def outer(x):
    return FACTOR * inner(x)
"""
BINDS = """
from numba import (njit)
import cdpr_interval.kernels
def bound(kind):
    @njit(cache=True)
    def run(x):
        return kind(x, 2.0).a
    return run
"""
TAKES = """
from numba import (njit)
import cdpr_interval.kernels
@njit(cache=True)
def takes(pair):
    return pair.a
"""
PAIRS = """
import numba
from typing import (NamedTuple)
class Pair(NamedTuple):
    {}: float
    {}: float
"""
ASK = "from solvers.six_dof.outer import outer\nprint(outer(10.0))"
TOLD = """
from numba.core import (event)
class Told(event.Listener):
    def on_start(self, event): raise SystemExit('compiles')
    def on_end(self, event): pass
event.register('numba:compile', Told())
"""
"""Statements after which a process that compiles anything fails."""


def test_every_file_with_cached_kernels_brings_the_cache():
    """Also when nothing else was imported before it."""
    folders = [ROOT / "solvers", *(ROOT / "cdpr_interval" / name for name in ("engine", "mechanics"))]
    files = [path for folder in folders for path in folder.rglob("*.py")]
    cached = [path for path in files if "kernels.kernel import" in path.read_text()]
    brings = re.compile(r"^(from|import) cdpr_interval\.kernels\b", re.MULTILINE)
    assert cached
    assert [path.name for path in cached if not brings.search(path.read_text())] == []


def test_a_kernel_lies_in_the_folder_of_its_file():
    file = rounding.down._cache._cache_file
    assert isinstance(file, KeyedCacheFile)
    assert caching.IndexDataCacheFile is KeyedCacheFile
    assert Path(file._index_path).parent.name == f"{PREFIX}rounding-{sources.digest(rounding.__name__)}"


class House:
    """A small copy of the house: its cache, a kernel, and one of another file that it calls."""

    def __init__(self, root: Path, variables: dict[str, str]) -> None:
        self.root, self.variables = root, variables
        kernels = root / "cdpr_interval" / "kernels"
        kernels.mkdir(parents=True)
        for name in ("__init__.py", "announcement.py", "cache.py", "sources.py"):
            shutil.copy(ROOT / "cdpr_interval" / "kernels" / name, kernels / name)
        self.solver = root / "solvers" / "six_dof"
        self.solver.mkdir(parents=True)
        for folder in (kernels.parent, self.solver.parent, self.solver):
            (folder / "__init__.py").touch()
        self.write_inner(factor=1.0, inner="x + 1")
        (self.solver / "outer.py").write_text(OUTER)

    def write_inner(self, factor: float, inner: str) -> None:
        (self.solver / "inner.py").write_text(INNER.format(factor=factor, inner=inner))

    def write_pairs(self, first: str, second: str) -> None:
        """Write a class of two fields, in a file that needs numba as well: it is one of a kernel's."""
        (self.solver / "pairs.py").write_text(PAIRS.format(first, second))

    def answer(self, before: str = "", ask: str = ASK) -> float:
        """Return outer(10), or what is asked, as a new process computes it after some more statements."""
        code = f"{before}\n{ask}"
        environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
        environment |= {"PYTHONPATH": str(self.root), **self.variables}
        environment["PYTHONDONTWRITEBYTECODE"] = "1"
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=self.root, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return float(done.stdout)

    def folders(self) -> set[str]:
        return {path.name for path in self.root.rglob(f"{PREFIX}*")}


@pytest.fixture(params=["beside the source", "NUMBA_CACHE_DIR", "the user's own"])
def house(request, tmp_path):
    """The house with each of the places that numba may choose."""
    if request.param == "NUMBA_CACHE_DIR":
        return House(tmp_path / "house", {"NUMBA_CACHE_DIR": str(tmp_path / "house" / "cache")})
    if request.param == "the user's own":
        made = House(
            tmp_path / "house", {"XDG_CACHE_HOME": str(tmp_path / "house"), "HOME": str(tmp_path / "house")}
        )
        # As if nothing could be written beside the source: a file stands where numba wants its folder.
        (made.solver / "__pycache__").touch()
        return made
    return House(tmp_path / "house", {})


def test_a_change_in_a_called_file_gives_the_new_answer(house):
    """Both of the kernel that is called and of a constant that is read."""
    assert house.answer() == 11
    house.write_inner(factor=3.0, inner="x + 2")
    assert house.answer() == 36
    assert len(house.folders()) == 4


def test_a_change_elsewhere_compiles_nothing(house):
    """Of a file of kernels that is not imported: in each of the places that numba may choose."""
    (house.solver / "apart.py").write_text(INNER.format(factor=1.0, inner="x + 5"))
    assert house.answer() == 11
    (house.solver / "apart.py").write_text(INNER.format(factor=2.0, inner="x + 6"))
    assert house.answer(before=TOLD) == 11


def test_a_kernel_that_a_changed_one_calls_is_not_compiled_again(tmp_path):
    house = House(tmp_path, {})
    assert house.answer() == 11
    with (house.solver / "outer.py").open("a") as file:
        file.write("# more\n")
    assert (
        house.answer(
            before=TOLD,
            ask="import cdpr_interval.kernels\nfrom solvers.six_dof.inner import inner\nprint(inner(10.0))",
        )
        == 11
    )
    assert house.answer() == 11
    assert len(house.folders()) == 3


def test_a_kernel_of_others_is_made_of_every_file(house):
    """Also where its file is named as one of ours that imports less."""
    others = house.root / "others"
    others.mkdir()
    (others / "inner.py").write_text(OUTER)
    ask = "from others.inner import outer\nprint(outer(10.0))"
    assert house.answer(ask=ask) == 11
    house.write_inner(factor=3.0, inner="x + 2")
    assert house.answer(ask=ask) == 36
    assert sum(name.startswith(f"{PREFIX}{ANY}-") for name in house.folders()) == 2


def test_a_kernel_inside_a_function_is_made_of_every_file(tmp_path):
    """It may use what the function was given, of a file that its own does not import."""
    house = House(tmp_path, {})
    (house.solver / "binds.py").write_text(BINDS)
    ask = (
        "from solvers.six_dof.binds import bound\n"
        "from solvers.six_dof.pairs import Pair\n"
        "print(bound(Pair)(1.0))"
    )
    for first, second in (("a", "b"), ("b", "a")):
        house.write_pairs(first, second)
        assert house.answer(ask=ask) == (1 if first == "a" else 2)
        assert house.answer(before=TOLD, ask=ask) == (1 if first == "a" else 2)
    assert len(house.folders()) == 2


def test_a_change_of_an_argument_s_class_gives_the_new_answer(tmp_path):
    """The kernel holds the places of the fields, though its file imports nothing that tells them."""
    house = House(tmp_path, {})
    (house.solver / "takes.py").write_text(TAKES)
    ask = (
        "from solvers.six_dof.pairs import Pair\n"
        "from solvers.six_dof.takes import takes\n"
        "print(takes(Pair(a=1.0, b=2.0)))"
    )
    for fields in (("a", "b"), ("b", "a")):
        house.write_pairs(*fields)
        assert house.answer(ask=ask) == 1
        assert house.answer(before=TOLD, ask=ask) == 1
    assert len(house.folders()) == 1


def test_numba_alone_serves_the_old_kernel(tmp_path):
    """When this fails, numba has become safe itself, and the digest in `kernels/cache.py` can go."""
    house = House(tmp_path, {})
    (tmp_path / "cdpr_interval" / "kernels" / "__init__.py").write_text("")
    assert house.answer() == 11
    house.write_inner(factor=3.0, inner="x + 2")
    assert house.answer() == 11
    assert house.folders() == set()


def test_a_state_of_the_sources_is_found_again(tmp_path):
    house = House(tmp_path, {})
    times = os.stat(house.solver / "inner.py").st_mtime_ns
    assert house.answer() == 11
    house.write_inner(factor=1.0, inner="x + 2")
    assert house.answer() == 12
    assert len(house.folders()) == 4
    house.write_inner(factor=1.0, inner="x + 1")
    os.utime(house.solver / "inner.py", ns=(times, times))  # some numba tell a file by its time
    assert house.answer(before=TOLD) == 11


def test_what_is_edited_while_a_process_runs_is_not_saved(tmp_path):
    """The process has one text of a kernel and may read another: what it compiles belongs to no digest."""
    house = House(tmp_path, {})
    edited = INNER.format(factor=1.0, inner="x + 2")
    before = (
        "from pathlib import Path\n"
        "import cdpr_interval.kernels\n"
        "from cdpr_interval.kernels import sources\n"
        "sources.digest()\n"
        f"Path({str(house.solver / 'inner.py')!r}).write_text({edited!r})\n"
    )
    assert house.answer(before) == 12
    house.write_inner(factor=1.0, inner="x + 1")
    assert house.answer() == 11


def test_only_the_last_used_folders_of_a_file_stay(tmp_path):
    names = [f"{PREFIX}file-{number}" for number in range(KEPT + 2)]
    for number, name in enumerate(names):
        (tmp_path / name).mkdir()
        (tmp_path / name / "kernel.nbi").touch()
        os.utime(tmp_path / name, (number, number))
    rest = {"other", f"{PREFIX}other_file-0", f"{PREFIX}{ANY}-0"}
    for name in rest:
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (0, 0))
    mark_used(str(tmp_path / names[0]))
    assert os.stat(tmp_path / names[0]).st_mtime > 1e9
    make_room(str(tmp_path), f"{PREFIX}file-new")
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {*rest, names[0], *names[-KEPT + 2 :]}


def test_a_folder_that_is_made_removes_an_old_one(tmp_path):
    for number in range(KEPT):
        (tmp_path / f"{PREFIX}{ANY}-{number}").mkdir()
        os.utime(tmp_path / f"{PREFIX}{ANY}-{number}", (number, number))
    KeyedCacheFile(str(tmp_path), "kernel", "stamp").save("first", 1)
    left = {path.name for path in tmp_path.iterdir()}
    folders = {f"{PREFIX}{ANY}-{digest}" for digest in (*range(1, KEPT), sources.digest())}
    assert left == {LOCK, *folders}


def test_a_folder_that_another_process_removes_is_made_again(tmp_path):
    file = KeyedCacheFile(str(tmp_path), "kernel", "stamp")
    file.save("first", 1)
    shutil.rmtree(tmp_path / f"{PREFIX}{ANY}-{sources.digest()}")
    assert file.load("first") is None
    file.save("second", 2)
    assert file.load("second") == 2
    file.flush()
    assert file.load("second") is None


def overlapping(kind: Any, folder: Path) -> list[Any]:
    """Save two signatures, the second as soon as the first has chosen its place; return what is loaded."""
    started = threading.Event()

    class Slow(kind):
        def _save_index(self, overloads: dict[str, str]) -> None:
            started.set()
            time.sleep(0.2)
            super()._save_index(overloads)

    first, second = Slow(str(folder), "kernel", "stamp"), kind(str(folder), "kernel", "stamp")
    thread = threading.Thread(target=first.save, args=("first", 1))
    thread.start()
    assert started.wait(10)
    second.save("second", 2)
    thread.join()
    return [second.load("first"), second.load("second")]


@NO_LOCKS
def test_two_signatures_saved_at_once_are_both_kept(tmp_path):
    assert overlapping(KeyedCacheFile, tmp_path) == [1, 2]


def test_without_the_lock_numba_mixes_them_up(tmp_path):
    """When this fails, numba has become safe itself, and the lock in `kernels/cache.py` can go."""
    assert overlapping(PLAIN, tmp_path) != [1, 2]


HOLDS = """
import sys, time
from filelock import FileLock
lock = FileLock(sys.argv[1])
lock.acquire()
print("held", flush=True)
time.sleep(600)
"""


@NO_LOCKS
def test_a_lock_that_is_not_given_back_is_not_waited_for_for_ever(tmp_path, monkeypatch, caplog):
    """Nothing is loaded or saved meanwhile, which is said once; a killed process holds no lock."""
    file = KeyedCacheFile(str(tmp_path), "kernel", "stamp")
    file.save("first", 1)
    monkeypatch.setattr(cache, "PATIENCE", 0.1)
    monkeypatch.setattr(cache, "_given_up", set())
    command = [sys.executable, "-c", HOLDS, str(tmp_path / LOCK)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as holder:
        try:
            assert holder.stdout.readline() == "held\n"
            assert file.load("first") is None
            file.save("second", 2)
            file.flush()
        finally:
            holder.kill()
    assert [record.message.startswith("compiled kernels are not used") for record in caplog.records] == [True]
    # This process has given up; another one, or this one before, finds all as it was.
    monkeypatch.setattr(cache, "_given_up", set())
    assert (file.load("first"), file.load("second")) == (1, None)


def test_a_folder_that_is_not_there_is_no_error(tmp_path):
    with locked(str(tmp_path / "none")):
        pass
    assert KeyedCacheFile(str(tmp_path / "none"), "kernel", "stamp").load("first") is None


UNWRITABLE = """
import os, tempfile
honest = tempfile.TemporaryFile
def refuse(*given, dir=None, **more):
    if dir is not None and not os.path.basename(os.path.dirname(dir)).startswith('cdpr-kernels-'):
        raise PermissionError(13, 'Permission denied', dir)
    return honest(*given, dir=dir, **more)
tempfile.TemporaryFile = refuse
"""
"""Statements after which numba finds no folder that can be written, whoever runs the test."""


def answered(house, before, ask=ASK):
    environment = {**os.environ, "PYTHONPATH": str(house.root), **house.variables}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"
    return subprocess.run(
        [sys.executable, "-c", f"{before}\n{ask}"],
        cwd=house.root,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_kernels_that_cannot_be_kept_lie_in_a_temporary_folder_and_one_warning_says_so(tmp_path):
    house = House(tmp_path / "house", {"NUMBA_CACHE_DIR": str(tmp_path / "cache")})
    done = answered(house, UNWRITABLE)
    assert (done.returncode, done.stdout) == (0, "11.0\n")
    compiling, line = done.stderr.splitlines()
    assert compiling.startswith("compiling")
    assert re.fullmatch(
        r"compiled kernels cannot be kept: .* they lie in (\S+) until this process ends", line
    )
    assert not Path(line.split()[-5]).exists()
    assert house.folders() == set()


@pytest.mark.parametrize("variables", [{}, {"NUMBA_CACHE_DIR": "cache"}])
def test_kernels_in_a_folder_that_cannot_be_written_are_used(tmp_path, variables):
    house = House(tmp_path / "house", variables)
    assert house.answer() == 11
    done = answered(house, TOLD + UNWRITABLE)
    assert (done.returncode, done.stdout, done.stderr) == (0, "11.0\n", "")
