"""The pages say what is: links lead somewhere, every file has its line, examples print what they show."""

import doctest
import math
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from scripts import architecture_table

ROOT = Path(__file__).parents[3]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
EXAMPLES = [
    ROOT / "README.md",
    *(ROOT / "docs" / page for page in ("adding-a-robot.md", "command-line.md", "winches.md")),
]
PACKAGES = ("cdpr_interval", "solvers", "certificates")


def blocks(page: Path, language: str) -> list[str]:
    """Return the fenced blocks of one language."""
    text = page.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def commands(page: Path) -> list[tuple[str, str]]:
    """Return each command of a page's console blocks with the output shown."""
    found = []
    for block in blocks(page, "console"):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            line, _, shown = part.partition("\n")
            found.append((line, shown))
    return found


SHOWN = [(page, line, shown) for page in EXAMPLES for line, shown in commands(page)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page: Path):
    text = page.read_text(encoding="utf-8")
    targets = [t for t in re.findall(r"\]\(([^)#]+)[^)]*\)", text) if not t.startswith("https://")]
    assert [t for t in targets if not (page.parent / t).exists()] == []


def test_the_architecture_page_has_a_line_for_every_module():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `([^`]+\.py)` \|", text, re.MULTILINE)
    files = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
        if path.name != "__init__.py"
    }
    assert len(listed) == len(set(listed))
    assert set(listed) == files


def test_the_architecture_page_says_what_the_modules_say():
    text = architecture_table.PAGE.read_text(encoding="utf-8")
    assert architecture_table.page(text) == text, "run python scripts/architecture_table.py"


def test_files_named_in_the_pages_exist():
    folders = [ROOT, ROOT / "solvers", ROOT / "cdpr_interval"]
    for page in (ROOT / "docs").rglob("*.md"):
        names = re.findall(r"`([a-z_]+(?:/[a-z_]+)*\.py)`", page.read_text(encoding="utf-8"))
        assert [n for n in names if not any((folder / n).exists() for folder in folders)] == []


@pytest.mark.parametrize(("page", "line", "shown"), SHOWN, ids=[line for _, line, _ in SHOWN])
def test_commands_print_what_the_page_shows(page: Path, line: str, shown: str, tmp_path: Path):
    for number, robot in enumerate(blocks(page, "yaml")):
        assert number == 0
        (tmp_path / "gantry.yaml").write_text(robot, encoding="utf-8")
    program, *arguments = shlex.split(line)
    assert program == "cdpr-solve"
    done = subprocess.run(
        [sys.executable, "-m", "solvers", *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert same(done.stdout, shown), done.stdout


def same(printed: str, shown: str) -> bool:
    """Compare word by word, numbers up to the last digits in which processors may differ."""
    a, b = re.split(r"[\s,]+", printed.strip()), re.split(r"[\s,]+", shown.strip())
    return len(a) == len(b) and all(x == y or close(x, y) for x, y in zip(a, b, strict=True))


def close(x: str, y: str) -> bool:
    try:
        a, b = (float(word.strip("()[]").removesuffix("deg")) for word in (x, y))
        return math.isclose(a, b, rel_tol=1e-5, abs_tol=1e-5)
    except ValueError:
        return False


def test_the_comparison_sees_what_it_must():
    assert same("1  c1,c2  -7.869615\n", "1  c1,c2   -7.869614")
    assert not same("1  c1,c2  -7.869615\n", "1  c1,c3  -7.869615")
    assert not same("-7.869615", "-7.8697")
    assert same("(0.5, 19.4590deg)", "(0.500001, 19.4590000001deg)")
    assert not same("(0.5, 19.459deg)", "(0.5, 19.46deg)")
    assert not same("8 static poses", "8 static")


def test_there_are_commands_to_compare():
    assert len(SHOWN) >= 4


@pytest.mark.parametrize("page", ["README.md", "docs/controllers.md"])
def test_python_examples(page: str):
    text = "".join(blocks(ROOT / page, "pycon"))
    assert text
    test = doctest.DocTestParser().get_doctest(text, {}, page, page, 0)
    report: list[str] = []
    results = doctest.DocTestRunner().run(test, out=report.append)
    assert results.attempted >= 8
    assert results.failed == 0, "".join(report)
