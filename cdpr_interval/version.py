"""The version of this package: its release, and between releases the commit that is used.

The build takes it from here into the wheel. Imports nothing but the standard library: the build runs this
file alone.
"""

from __future__ import annotations

import os
import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from pathlib import Path

PACKAGE = "cdpr-interval"
RELEASE = "0.2.0"
"""The next release, until its tag ``v0.2.0`` is set; a checkout of that tag has this version."""
ROOT = Path(__file__).resolve().parents[1]
PATIENCE = 5.0
"""Seconds that git may take."""


@cache
def version() -> str:
    """Return the version: of the checkout these sources lie in, else of the package that is installed.

    In a checkout what was true when it was installed is not asked: an editable install does not see commits.
    """
    found = of_checkout(ROOT)
    if found is not None:
        return found
    try:
        return installed(PACKAGE)
    except PackageNotFoundError:
        return f"{RELEASE}.dev0"


def for_build() -> str:
    """Return the version that a wheel is built with; without git it does not know its commit."""
    return of_checkout(ROOT) or f"{RELEASE}.dev0"


def of_checkout(root: Path) -> str | None:
    """Return the version of a git checkout, None where there is none or git cannot say.

    Returns
    -------
    str or None
        The release at its tag, else ``0.2.0.devN+gHASH`` after N commits, with ``.dirty`` where tracked files
        were changed.
    """
    if not ((root / ".git").exists() and (root / "pyproject.toml").is_file()):
        return None
    commit = _git(root, "describe", "--always", "--dirty", "--abbrev=10", "--exclude=*")
    count = _git(root, "rev-list", "--count", "HEAD")
    if commit is None or count is None:
        return None
    name, _, dirty = commit.partition("-")
    if not dirty and f"v{RELEASE}" in (_git(root, "tag", "--points-at", "HEAD") or "").split():
        return RELEASE
    return f"{RELEASE}.dev{count}+g{name}{'.dirty' if dirty else ''}"


def _git(root: Path, *command: str) -> str | None:
    """Return what git prints, None where it fails or is not installed."""
    try:
        done = subprocess.run(
            ["git", "-C", str(root), *command],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=True,
            # Asking must not write to the index, which a commit in another terminal may hold.
            env={**os.environ, "GIT_OPTIONAL_LOCKS": "0"},
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
