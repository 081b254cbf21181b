"""Build the wheel in a scratch folder and check what a user would get from it."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("cdpr_interval", "solvers", "certificates")


def expected_files() -> set[str]:
    """Return every file of the packages that must ship: code, markers, robots, schemas, templates."""
    files: set[str] = set()
    for package in PACKAGES:
        for pattern in ("*.py", "py.typed", "*.yaml", "*.json", "*.eds", "*.html"):
            files |= {path.relative_to(ROOT).as_posix() for path in (ROOT / package).rglob(pattern)}
    return files


def faults(names: set[str]) -> list[str]:
    """Return what is wrong with a wheel that holds files of these names, one line each."""
    tops = {name.partition("/")[0] for name in names}
    own = {top for top in tops if not top.endswith(".dist-info")}
    found = [f"top level holds {top}" for top in sorted(own.difference(PACKAGES))]
    found += [f"{package}/py.typed is missing" for package in PACKAGES if f"{package}/py.typed" not in names]
    found += [f"{name} is missing" for name in sorted(expected_files() - names)]
    if len(tops - own) != 1:
        found.append(f"{len(tops - own)} .dist-info folders")
    return found


def main() -> int:
    """Build, check, and return the exit status."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", scratch, str(ROOT)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        (wheel,) = Path(scratch).glob("*.whl")
        with zipfile.ZipFile(wheel) as archive:
            names = set(archive.namelist())
    found = faults(names)
    for line in found:
        print(f"{wheel.name}: {line}", file=sys.stderr)
    if not found:
        print(f"{wheel.name}: {len(names)} files, top level {', '.join(PACKAGES)} and .dist-info only")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
