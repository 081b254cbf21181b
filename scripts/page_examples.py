"""Run the examples of the pages and write what they print anew: ``python scripts/page_examples.py PAGE ...``.

A fenced block ``yaml NAME`` (or ``csv``, ``json``) is a file. The commands of ``console`` blocks are run in
order, in one folder for each page; below each stands what it prints, errors too, or the first lines of it
(``| head -8``); ``$ echo $?`` prints the last exit code. Without a page all are renewed.
"""

from __future__ import annotations

import math
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[1]
FILE = re.compile(r"^```(?:yaml|csv|json) (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CONSOLE = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PROGRESS = re.compile(r"^\w+ after \d+ s: .*\n", re.MULTILINE)
NUMBER = re.compile(r"([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)")
MEANWHILE = re.compile(r"compiling|(search|certificate|check|batch|report|polynomial) after \d")
"""What a line begins with that is written while a command works, if that takes long."""
LIMIT = 300
"""Seconds for a command: the first one may have to compile kernels."""


def pages() -> list[Path]:
    """Return the pages that show commands."""
    every = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [page for page in every if CONSOLE.search(page.read_text(encoding="utf-8"))]


def commands(block: str) -> list[tuple[str, str]]:
    """Return each command of a console block with what is shown below it."""
    parts = re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]
    return [(line, shown) for line, _, shown in (part.partition("\n") for part in parts)]


class Session:
    """A folder in which the commands of a page run one after the other."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._code = 0

    def write_files(self, text: str) -> None:
        """Write the files that a page shows."""
        for name, content in FILE.findall(text):
            (self._folder / name).write_text(content, encoding="utf-8")

    def run(self, line: str) -> str:
        """Return what a command prints."""
        if line == "echo $?":
            return f"{self._code}\n"
        line, _, most = line.partition(" | head -")
        program, *arguments = shlex.split(line, comments=True)
        if program == "cat":
            return "".join((self._folder / name).read_text(encoding="utf-8") for name in arguments)
        if program != "cdpr-solve":
            raise ValueError(f"only cdpr-solve, cat and echo $? are run, not {line!r}")
        done = subprocess.run(
            [sys.executable, "-m", "solvers", *arguments],
            cwd=self._folder,
            # Pages show what a pipe gets, however wide a terminal is.
            env={**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": ""},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LIMIT,
            check=False,
        )
        self._code = done.returncode
        found = [t for t in done.stdout.splitlines(keepends=True) if not MEANWHILE.match(t)]
        return "".join(found[: int(most)] if most else found)


def renewed(text: str) -> str:
    """Return a page with what its commands print today."""
    with TemporaryDirectory() as folder:
        session = Session(Path(folder))
        session.write_files(text)

        def block(match: re.Match[str]) -> str:
            shown = "".join(f"$ {line}\n{session.run(line)}" for line, _ in commands(match[1]))
            return f"```console\n{shown}```"

        return CONSOLE.sub(block, text)


def is_same(printed: str, shown: str) -> bool:
    """Compare words and numbers, these up to the last digits, in which processors may differ.

    Lines of progress, which only slow machines print, do not count.
    """
    a, b = (NUMBER.split(re.sub(r"\s+", " ", PROGRESS.sub("", text).strip())) for text in (printed, shown))
    return len(a) == len(b) and all(
        math.isclose(float(x), float(y), rel_tol=1e-5, abs_tol=1e-5) if i % 2 else x == y
        for i, (x, y) in enumerate(zip(a, b, strict=True))
    )


def main() -> None:
    """Renew the pages named, or all."""
    named = [Path(name).resolve() for name in sys.argv[1:]]
    for page in named or pages():
        text = page.read_text(encoding="utf-8")
        now = renewed(text)
        page.write_text(now, encoding="utf-8")
        print(page.relative_to(ROOT), "is as it was" if now == text else "is renewed")


if __name__ == "__main__":
    main()
