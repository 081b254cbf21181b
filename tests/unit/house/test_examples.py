"""Property tests draw the same examples on every run; `make fuzz` draws others, by a seed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from hypothesis import settings

ROOT = Path(__file__).resolve().parents[3]
DRAWS = """
from hypothesis import (given, strategies as st)

@given(st.integers(0, 10**9))
def test_drawn(number):
    print("drawn", number)
"""


def drawn(folder: Path, *options: str) -> tuple[list[str], str]:
    """Run a property test under the suite's settings; return the numbers it drew, and the header."""
    file = folder / "test_draws.py"
    file.write_text(DRAWS)
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-s",
        "-p",
        "tests.conftest",
        "-p",
        "no:cacheprovider",
        *options,
    ]
    printed = subprocess.run(
        [*command, f"--rootdir={folder}", str(file)], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    header = next(line for line in printed.splitlines() if line.startswith("property tests:"))
    return re.findall(r"drawn (\d+)", printed), header


def test_the_suite_draws_the_same_examples_on_every_run(tmp_path):
    first, header = drawn(tmp_path)
    assert len(first) >= 100 and "the same examples on every run" in header
    assert drawn(tmp_path)[0] == first
    assert settings.default is not None and settings.default.database is None


def test_fuzzing_draws_by_the_seed(tmp_path):
    first, header = drawn(tmp_path, "--hypothesis-profile=fuzz", "--hypothesis-seed=1")
    assert header.endswith("--hypothesis-seed=1")
    assert drawn(tmp_path, "--hypothesis-profile=fuzz", "--hypothesis-seed=1")[0] == first
    assert drawn(tmp_path, "--hypothesis-profile=fuzz", "--hypothesis-seed=2")[0] != first
    assert drawn(tmp_path)[0] != first
