"""A YAML parser's error, said so that whoever typed the file knows what to change, at the place to change it.

A parser stops where it can no longer go on, often a line below the mistake, and names what it expected. The
mistakes people make are few: they are looked for in the line of the error and in those above it.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from cdpr_interval.text.count import counted
from cdpr_interval.text.literal import printable

LINES_ABOVE = 3
"""Lines looked at above the error: a text goes on over lines until something in it cannot be a text."""

_WORD = r"[A-Za-z_][A-Za-z0-9_.-]*"
_ENTRY = rf"\s*(?:- +)*({_WORD})"
_NO_SPACE_AFTER_DASH = re.compile(rf"(\s*)-({_WORD}\s*:.*)")
_NO_SPACE_AFTER_COLON = re.compile(rf"{_ENTRY}:([^\s/\\:].*)")
_EQUALS = re.compile(rf"{_ENTRY}\s*=\s*\S.*")
_NO_COLON = re.compile(rf"{_ENTRY}(?:\s+[-+.0-9\[{{\"'].*)?\s*")
_COLON_IN_TEXT = re.compile(rf"{_ENTRY}: +[^\s\"'\[{{|>&*!#][^#]*: .*")
_VALUE = re.compile(rf"{_ENTRY}:\s+[^\s#|>].*")
_SLASHES = re.compile(r"(?:^|\s)(//)")
_QUOTED = re.compile(r"\"[^\"]*\"|'[^']*'")
_ODD_SPACE = re.compile(r"[ -]*([\u00a0\u2000-\u200b\u202f\u3000])")


class Explained(NamedTuple):
    """A mistake and its place, line and column from 1."""

    line: int
    column: int
    rule: str


def explained(text: str, error: Exception) -> Explained:
    """Return what is wrong with a text that a parser refused.

    Parameters
    ----------
    text : str
        The whole file.
    error : Exception
        A `yaml.YAMLError`, or what PyYAML raises beside it.
    """
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    problem = str(getattr(error, "problem", None) or getattr(error, "context", None) or error)
    if mark is None:
        return Explained(1, 1, _said(problem))
    lines = text.replace("\r\n", "\n").split("\n")
    found = _typed(lines, mark.line, problem) or _said_better(lines, error, problem, mark)
    return found or Explained(mark.line + 1, mark.column + 1, _said(problem))


def _said(problem: str) -> str:
    """Return what a parser says, as a part of one short line."""
    said = printable(problem)
    return said if len(said) <= 100 else said[:97] + "..."


def _typed(lines: list[str], last: int, problem: str) -> Explained | None:
    """Return the mistake that a line shows by itself, the nearest at or above the line of the error."""
    for number in range(min(last, len(lines) - 1), max(-1, last - LINES_ABOVE - 1), -1):
        line = lines[number]
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        colon = number < last and ("expected ':'" in problem or "mapping values" in problem)
        found = _indented_by_tab(lines, number) or _in_line(line, number, colon)
        if found is not None:
            return found
    return None


def _indented_by_tab(lines: list[str], number: int) -> Explained | None:
    """Return a tab that indents a line; others that do so are counted."""
    tabs = [n for n, line in enumerate(lines) if "\t" in line[: len(line) - len(line.lstrip(" \t-"))]]
    if number not in tabs:
        return None
    first = min(tabs)
    others = f" (and {counted(len(tabs) - 1, 'more line')})" if len(tabs) > 1 else ""
    column = lines[first].index("\t") + 1
    return Explained(first + 1, column, f"a tab: YAML is indented by spaces only{others}")


def _in_line(line: str, number: int, colon: bool) -> Explained | None:
    """Return the mistake in one line; ``colon``: one may be missing, there or in the lines below."""
    if odd := _ODD_SPACE.match(line):
        return Explained(
            number + 1, odd.start(1) + 1, "a special space: YAML is indented by plain spaces only"
        )
    if line.startswith("```"):
        return Explained(number + 1, 1, "a line of Markdown, not of YAML: remove it")
    plain = _QUOTED.sub(lambda quoted: "'" * len(quoted[0]), line)
    if found := _NO_SPACE_AFTER_DASH.fullmatch(plain):
        word = found[2].partition(":")[0]
        return Explained(
            number + 1, len(found[1]) + 1, f"a space is missing after the '-': write '- {word}:'"
        )
    if found := _SLASHES.search(plain):
        return Explained(number + 1, found.start(1) + 1, "'//': a comment begins with '#'")
    for pattern, rule in (
        (_NO_SPACE_AFTER_COLON, "a space is missing after '{}:'"),
        (_EQUALS, "a '=': write '{}:'"),
        (_NO_COLON, "a ':' is missing after '{}'"),
    ):
        found = pattern.fullmatch(plain)
        if found and (colon or pattern is not _NO_COLON):
            return Explained(number + 1, found.end(1) + 1, rule.format(found[1]))
    return None


def _said_better(lines: list[str], error: Exception, problem: str, mark: Any) -> Explained | None:
    """Return in other words what a parser expected, from its error and the lines around it."""
    start = getattr(error, "context_mark", None) or mark
    line = lines[mark.line] if mark.line < len(lines) else ""
    here = mark.line + 1, mark.column + 1
    if "unexpected end of stream" in problem:
        return Explained(start.line + 1, start.column + 1, "the quote that opens here is never closed")
    if "expected ',' or" in problem:
        bracket = "[" if "']'" in problem else "{"
        opened = f"the '{bracket}' of line {start.line + 1}, column {start.column + 1} is not closed"
        return Explained(*here, f"a ',' is missing before this, or {opened}")
    if "cannot start any token" in problem and mark.column < len(line):
        sign = line[mark.column]
        tab = sign == "\t"
        return Explained(
            *here, "a tab: write a space" if tab else f"a text that begins with '{sign}' needs quotes"
        )
    if "mapping values are not allowed" in problem:
        if _COLON_IN_TEXT.fullmatch(line):
            return Explained(*here, "a second ': ' in this line: a text that holds one needs quotes")
        above = next((n for n in range(mark.line - 1, -1, -1) if lines[n].strip()), None)
        if above is not None and _indent(line) > _indent(lines[above]) and _VALUE.fullmatch(lines[above]):
            rule = f"is indented further than line {above + 1}, which has a value already"
            return Explained(mark.line + 1, _indent(line) + 1, rule)
    stray = problem.startswith(("did not find expected", "expected <block end>"))
    if stray and mark.column == _indent(line) != start.column:
        rule = f"is indented by {mark.column}, what it belongs to by {start.column} (line {start.line + 1})"
        return Explained(*here, rule)
    if stray and line[: mark.column].rstrip()[-1:] in ("'", '"'):
        sign = line[: mark.column].rstrip()[-1]
        return Explained(*here, f"the text in quotes ends before this: {_doubled(sign)}")
    return None


def _doubled(sign: str) -> str:
    """Return how a quote is written inside quotes."""
    return "a ' inside '...' is written ''" if sign == "'" else 'a " inside "..." is written \\"'


def _indent(line: str) -> int:
    """Return how many spaces a line begins with."""
    return len(line) - len(line.lstrip(" "))
