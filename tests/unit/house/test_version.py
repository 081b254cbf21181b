"""The version says of what sources a result was made."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from cdpr_interval import version as module
from cdpr_interval.version import RELEASE, for_build, of_checkout, version

FILE = Path(module.__file__)
NOBODY = ("-c", "user.name=nobody", "-c", "user.email=nobody@localhost", "-c", "commit.gpgsign=false")


@pytest.fixture
def checkout(tmp_path):
    def git(*command: str) -> str:
        done = subprocess.run(
            ["git", *NOBODY, "-C", str(tmp_path), *command], capture_output=True, text=True, check=True
        )
        return done.stdout.strip()

    git("init", "--quiet")
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    git("add", ".")
    git("commit", "--quiet", "--message", "first")
    return tmp_path, git


def test_between_releases_it_has_the_commit(checkout):
    root, git = checkout
    assert of_checkout(root) == f"{RELEASE}.dev1+g{git('rev-parse', '--short=10', 'HEAD')}"
    git("commit", "--quiet", "--allow-empty", "--message", "second")
    second = of_checkout(root)
    assert second == f"{RELEASE}.dev2+g{git('rev-parse', '--short=10', 'HEAD')}"
    (root / "pyproject.toml").write_text("[project]\n\n")
    assert of_checkout(root) == f"{second}.dirty"


def test_at_its_tag_it_is_the_release(checkout):
    root, git = checkout
    git("tag", "v0.0.1")
    assert "dev1" in of_checkout(root)
    git("tag", f"v{RELEASE}")
    assert of_checkout(root) == RELEASE
    (root / "pyproject.toml").write_text("[project]\n\n")
    assert of_checkout(root).endswith(".dirty")


def test_without_git_or_a_checkout(checkout, monkeypatch, tmp_path_factory):
    """An installed package lies in a folder that may itself be in somebody else's repository."""
    root, _ = checkout
    (root / "site-packages").mkdir()
    assert of_checkout(root / "site-packages") is None
    monkeypatch.setenv("PATH", str(tmp_path_factory.mktemp("empty")))
    assert of_checkout(root) is None


def test_it_is_one_that_packages_may_have():
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.dev\d+(\+g[0-9a-f]{10}(\.dirty)?)?)?", for_build())
    assert version() == for_build() or not (FILE.parents[1] / ".git").exists()


def test_the_build_runs_the_file_alone(tmp_path):
    """The build has none of the dependencies."""
    (tmp_path / "version.py").write_bytes(FILE.read_bytes())
    code = "import version; print(version.for_build())"
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r}); {code}"],
        capture_output=True, text=True, check=True, env={"PATH": os.environ["PATH"]},
    )  # fmt: skip
    assert done.stdout.strip() == f"{RELEASE}.dev0"


def test_the_command_prints_it():
    done = subprocess.run(
        [sys.executable, "-m", "solvers", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"cdpr-solve, version {version()}\n"
