"""The report of a Delta: its poses in a picture with arms and bars, and as a table."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from cdpr_interval.exact import balls
from cdpr_interval.files.document import parse_document
from cdpr_interval.mechanics.delta import delta_of
from cdpr_interval.robots.delta import DeltaRobot
from cdpr_interval.robots.formats.delta_reader import delta
from cdpr_interval.robots.numbers import middle
from solvers.answers.data import Outcome
from solvers.delta.data import FORMAT
from solvers.delta.result import DeltaResult
from solvers.report.judgement import Judgement, Kind
from solvers.report.page import drawn, rendered
from solvers.report.palette import BODY, DISCRETE, GREY, SLACK
from solvers.report.plots import HEIGHT_3D, LAYOUT, require_plotly, space_of

BEGINNING = re.compile(rf'\s*{{\s*"format"\s*:\s*"{re.escape(FORMAT)}"')
LONGEST_BEGINNING = 200
"""Characters: a result of cables may be as long as two hundred million."""
SPACING = 0.25
"""Between two bars, as a share of the smaller radius or bar, where the file does not say."""
LEGEND = (
    "Arms in blue (or rails with their carriages), bars in orange, the platform dark; the upper one grey. "
    "Drawn are floats near the proved poses; the red point is the tool."
)
Points = np.ndarray


def is_delta_result(path: Path) -> bool:
    """Return True for a file that begins as a result of a Delta; what is wrong with it its reader says."""
    try:
        with path.open(encoding="utf-8") as file:
            return BEGINNING.match(file.read(LONGEST_BEGINNING)) is not None
    except (OSError, ValueError):
        return False


def delta_page(path: Path) -> tuple[str, Judgement]:
    """Return the page of a ``cdpr-delta-result/1`` file, and its judgement."""
    result = DeltaResult.from_json(path.read_text(encoding="utf-8"))
    robot = delta(parse_document(result.provenance.robot, "the robot of the result"))
    is_complete = result.outcome is Outcome.COMPLETE
    headline = "Complete" if is_complete else "Incomplete: what is listed is proved, but not that it is all"
    judgement = Judgement(
        Kind.GOOD if is_complete else Kind.OPEN, headline, (f"Solver: {result.message}.", *result.undecided)
    )
    drives = "carriages at" if robot.is_linear else "arms at"
    origin = result.provenance
    facts = {
        "answered": f"{origin.date:%Y-%m-%d %H:%M:%S} UTC on {origin.host}",
        "with": ", ".join(f"{name} {version}" for name, version in origin.versions.items()),
        "robot sha256": result.robot.sha256,
        "source": robot.source or "",
    }
    page = rendered(
        "delta.html",
        title=result.robot.name,
        subtitle=f"Delta, {drives} {', '.join(origin.asked)}",
        judgement=judgement,
        robot_figure=drawn(delta_figure(robot, result), "robot"),
        legend=LEGEND,
        table=str(result),
        origin=list(facts.items()),
    )
    return page, judgement


def delta_figure(robot: DeltaRobot, result: DeltaResult) -> Any:
    """Return a Delta in 3-D at each of its poses."""
    go = require_plotly()
    figure = go.Figure(layout={**LAYOUT, "height": HEIGHT_3D, "showlegend": False})
    seen = []
    for number, pose in reversed(list(enumerate(result.solutions))):
        for name, points, colour, width in lines(robot, result, pose.position.mean(axis=1)):
            seen.append(points[~np.isnan(points).any(axis=1)])
            line = {"color": colour if number == 0 else SLACK, "width": width if number == 0 else 2}
            figure.add_trace(_line(go, points, f"{name}, pose {number + 1}", line))
    tools = [pose.position.mean(axis=1) for pose in result.solutions]
    if tools:
        x, y, z = np.array(tools).T
        marker = {"size": 4, "color": "#d62728"}
        figure.add_trace(
            go.Scatter3d(x=x, y=y, z=z, mode="markers", marker=marker, hoverinfo="x+y+z", name="tool")
        )
        every = np.vstack([*seen, *tools])
        figure.update_layout(scene=space_of(every.min(axis=0), every.max(axis=0)))
    return figure


def lines(robot: DeltaRobot, result: DeltaResult, tool: Points) -> list[tuple[str, Points, str, int]]:
    """Return the lines of a Delta at a pose: name, points (n, 3) with gaps of NaN, colour and width."""
    rows = result.question.positions if robot.is_linear else result.question.angles
    assert rows is not None
    outer, inner = float(middle(robot.base_radius)), float(middle(robot.platform_radius))
    with balls.precision():
        whole = delta_of(robot)
        outward = np.array([[float(x.mid()) for x in chain.outward] for chain in whole.chains])
        moved = np.array(
            [[float(x.mid()) for x in whole.knee(i, balls.from_bounds(*rows[i]))] for i in range(3)]
        )
        centre = tool - np.array([float(x.mid()) for x in whole.tool])
    tangents = np.cross((0.0, 0.0, 1.0), outward)
    shoulders, knees, joints = outer * outward, moved + inner * outward, centre + inner * outward
    least = min(x for x in (outer, inner, float(middle(robot.bar))) if x > 0)
    given = None if robot.bar_spacing is None else float(middle(robot.bar_spacing))
    half = 0.5 * tangents * (SPACING * least if given is None else given)
    gap = np.full((1, 3), np.nan)
    bars = [
        np.vstack([k + side * h, j + side * h, gap])
        for k, j, h in zip(knees, joints, half, strict=True)
        for side in (1, -1)
    ]
    arms = [np.vstack([s, k, gap]) for s, k in zip(shoulders, knees, strict=True)]
    cross = [np.vstack([k - h, k + h, gap]) for k, h in zip(knees, half, strict=True)]
    return [
        ("base", np.vstack([shoulders, shoulders[:1]]), GREY, 3),
        ("rails" if robot.is_linear else "arms", np.vstack([*arms, *cross]), DISCRETE[0], 8),
        ("bars", np.vstack(bars), DISCRETE[1], 4),
        ("platform", np.vstack([joints, joints[:1], gap, centre[None], tool[None]]), BODY, 6),
    ]


def _line(go: Any, points: Points, name: str, line: dict[str, Any]) -> Any:
    x, y, z = points.T
    return go.Scatter3d(x=x, y=y, z=z, mode="lines", line=line, name=name, hoverinfo="name")
