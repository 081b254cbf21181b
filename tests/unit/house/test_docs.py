"""The pages say what is: links lead somewhere, every file has its line, examples print what they show."""

import doctest
import re
from pathlib import Path

import pytest

from scripts import architecture_table, page_examples

ROOT = Path(__file__).parents[3]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
EXAMPLES = page_examples.pages()
PACKAGES = ("cdpr_interval", "solvers", "certificates")


def blocks(page: Path, language: str) -> list[str]:
    """Return the fenced blocks of one language."""
    text = page.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


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


@pytest.mark.parametrize("page", EXAMPLES, ids=lambda page: page.name)
def test_commands_print_what_the_page_shows(page: Path, tmp_path: Path):
    text = page.read_text(encoding="utf-8")
    session = page_examples.Session(tmp_path)
    session.write_files(text)
    for block in blocks(page, "console"):
        for line, shown in page_examples.commands(block):
            printed = session.run(line)
            assert page_examples.is_same(printed, shown), f"{line}\n{printed}"


def test_the_comparison_sees_what_it_must():
    same = page_examples.is_same
    assert same("1  c1,c2  -7.869615deg\n", "1  c1,c2   -7.869614deg")
    assert not same("1  c1,c2  -7.869615\n", "1  c1,c3  -7.869615")
    assert not same("-7.869615", "-7.8697")
    assert not same("-7.869615 deg", "-7.869615")
    assert not same("8 static poses", "8 static")
    assert not same("8 static poses", "9 static poses")


def test_there_are_commands_to_compare():
    assert len(EXAMPLES) >= 3


PYTHON = [page for page in PAGES if blocks(page, "pycon")]


@pytest.mark.parametrize("page", PYTHON, ids=lambda page: page.name)
def test_python_examples(page: Path):
    text = "".join(blocks(page, "pycon"))
    test = doctest.DocTestParser().get_doctest(text, {}, page.name, str(page), 0)
    report: list[str] = []
    results = doctest.DocTestRunner().run(test, out=report.append)
    assert results.attempted
    assert results.failed == 0, "".join(report)


def test_there_is_python_to_run():
    assert len(PYTHON) >= 2
