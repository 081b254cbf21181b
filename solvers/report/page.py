"""The report as one HTML file that needs nothing else: no request leaves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.text.count import counted
from solvers.answers.pose_row import POINT_MASS, pose_rows
from solvers.answers.region_row import advice, region_rows
from solvers.answers.result import Result
from solvers.answers.table import asked_only
from solvers.answers.tool import this_tool
from solvers.report import plots
from solvers.report.judgement import judge
from solvers.report.origin import asked_of, origin_of
from solvers.report.source import ResultSource

MOST_ROWS = 500
"""Of a table of solutions or failed jobs; what is left out is said."""
LEGEND = (
    "Straight cables are coloured by tension, each pose on a scale of its own; slack ones hang in grey; "
    "dashed: just taut or just slack, one pose either way; dashed red: neither taut nor slack is proved. Red "
    "boxes hold what the search left undecided; blue boxes are where the platform's anchors may be, over all "
    "choices of data with ranges. Drawn are floats near the certified poses."
)
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:"
)
"""Browsers refuse every request of the page."""
TEMPLATES = Path(__file__).parent / "templates"


def result_page(source: ResultSource) -> str:
    """Return the report of one result."""
    result = source.result
    turns = result.model != POINT_MASS
    rows = pose_rows(result)
    with_remarks = any(row.remarks for row in rows)
    head = ["#", "taut", "stability", "x m", "y m", "z m", *(("roll", "pitch", "yaw") if turns else ())]
    head += [f"{name} N" for name in result.cables] + (["remarks"] if with_remarks else [])
    regions = [
        [row.name, row.taut, row.cells, row.metres, *([row.degrees] if turns else []), bounds, row.reason]
        for row, bounds in zip(region_rows(result), _bounds(result), strict=True)
    ]
    cables = counted(len(result.cables), "cable")
    return rendered(
        "result.html",
        title=result.robot.name,
        subtitle=f"{result.model}, {cables}{asked_only(result.question, result.cables)}",
        judgement=judge(result, source.proof),
        asked=asked_of(result),
        robot_figure=drawn(plots.robot_figure(source.robot, result), "robot"),
        legend=LEGEND,
        cables=result.cables,
        turns=turns,
        pose_head=head,
        poses=rows[:MOST_ROWS],
        poses_left_out=max(len(rows) - MOST_ROWS, 0),
        with_remarks=with_remarks,
        tension_figure=drawn(plots.tension_figure(result), "tensions") if rows else "",
        regions=regions[:MOST_ROWS],
        regions_left_out=max(len(regions) - MOST_ROWS, 0),
        advice=advice(result),
        origin=origin_of(result, source.robot),
    )


def _bounds(result: Result) -> list[str]:
    """Return the bounds of the position of every undecided region."""
    return [
        ", ".join(f"[{lo:.4g}, {hi:.4g}]" for lo, hi in one.position.tolist()) for one in result.undecided
    ]


def drawn(figure: Any, name: str) -> Any:
    """Return a figure of plotly as markup with an id of its own: the same page every time."""
    from markupsafe import Markup

    text: str = figure.to_html(
        full_html=False, include_plotlyjs=False, div_id=name, config={"displaylogo": False}
    )
    return Markup(text)


def require_libraries() -> None:
    """Raise `InputError` when what a report needs is not installed."""
    plots.require_plotly()
    try:
        import jinja2  # noqa: F401
    except ImportError:
        raise InputError("report: Jinja2 is not installed: pip install '.[report]'") from None


def rendered(template: str, **context: Any) -> str:
    """Return a page from a template of this folder; every text in it is escaped.

    Raises
    ------
    InputError
        Jinja2 or plotly is not installed.
    """
    require_libraries()
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup
    from plotly.offline import get_plotlyjs

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    tool, now = this_tool(), datetime.now(UTC).replace(microsecond=0)
    return environment.get_template(template).render(
        policy=POLICY,
        # The library is trusted, and must not be escaped.
        plotly=Markup(get_plotlyjs()),
        footer=f"Report written {now:%Y-%m-%d %H:%M} UTC by {tool.name} {tool.version}",
        **context,
    )


def table_of(quantities: Mapping[str, Mapping[str, float]]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of a table of statistics; a value that a quantity lacks is empty."""
    heads: dict[str, None] = {}
    for values in quantities.values():
        heads |= dict.fromkeys(values)
    rows = [
        [name, *(f"{values[head]:.6g}" if head in values else "" for head in heads)]
        for name, values in quantities.items()
    ]
    return ["", *heads], rows


def listed(numbers: Sequence[int]) -> str:
    """Return the first of many numbers."""
    return ", ".join(map(str, numbers[:MOST_ROWS])) + (" ..." if len(numbers) > MOST_ROWS else "")
