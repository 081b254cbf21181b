"""Write the file tables of ``docs/architecture.md`` anew: a package each, a line for every module."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
PACKAGES = ("cdpr_interval", "solvers", "certificates")
START, END = "## Files\n", "## Adding a solver\n"


def summary(path: Path) -> str:
    """Return the first line of a module's docstring without its full stop."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return text.partition("\n")[0].removesuffix(".").replace("|", "\\|")


def tables() -> str:
    """Return the tables of all packages, each under its name and what it is for."""
    parts = []
    for top in PACKAGES:
        for package in sorted(path.parent for path in (ROOT / top).rglob("__init__.py")):
            files = sorted(path for path in package.glob("*.py") if path.name != "__init__.py")
            rows = [f"| `{path.relative_to(ROOT).as_posix()}` | {summary(path)} |" for path in files]
            heading = f"### `{package.relative_to(ROOT).as_posix()}/`"
            lines = [heading, "", f"{summary(package / '__init__.py')}.", "", "| file | holds |", "|---|---|"]
            parts.append("\n".join([*lines, *rows]) + "\n")
    return "\n".join(parts)


def page(text: str) -> str:
    """Return the page with its tables renewed."""
    before, rest = text.split(START)
    return f"{before}{START}\n{tables()}\n{END}{rest.split(END)[1]}"


def main() -> None:
    """Renew the page."""
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
