"""The figures of a report as plotly objects; the extra ``report``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr_interval.errors import InputError
from solvers.answers.data import CableState
from solvers.answers.result import Result
from solvers.report.palette import BODY, DISCRETE, GREY, SLACK, TENSION_SCALE, UNDECIDED, tension_colour
from solvers.report.scene import Points, Scene, axis_range, frame_points, region, scene

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Robot

MARGIN = {"l": 50, "r": 20, "t": 30, "b": 40}
LAYOUT = {
    "template": "plotly_white",
    "font": {"family": "system-ui, sans-serif", "size": 13},
    "margin": MARGIN,
}
HEIGHT_3D = 620
CAMERA = {"eye": {"x": 1.15, "y": -1.85, "z": 0.75}, "center": {"x": 0, "y": 0, "z": -0.15}}
BINS = 40
"""Of a histogram."""
LEFT_OPEN = "something left open"
"""Name of the positions of poses and regions that are not decided."""
MOST_POINTS = 20_000
"""Of a scatter plot; more are thinned evenly, which the caption says."""


def require_plotly() -> Any:
    """Return plotly's graph objects; `InputError` when it is not installed."""
    try:
        import plotly.graph_objects as objects
    except ImportError:
        raise InputError("report: plotly is not installed: pip install '.[report]'") from None
    return objects


def robot_figure(robot: Robot, result: Result) -> Any:
    """Return the robot in 3-D with every solution; buttons choose one, undecided regions always stay."""
    go = require_plotly()
    scenes = [scene(robot, s, result.lengths, i) for i, s in enumerate(result.solutions, 1)]
    most = max((cable.tension for one in scenes for cable in one.cables), default=0.0)
    figure = go.Figure(layout={**LAYOUT, "height": HEIGHT_3D})
    always = [_frame(go, robot)]
    if result.undecided:
        always.append(_regions(go, result))
    if any(cable.tension > 0 for one in scenes for cable in one.cables):
        always.append(_scale(go, frame_points(robot)[0], most))
    for trace in always:
        figure.add_trace(trace)
    owners: list[int] = [-1] * len(always)
    for number, one in enumerate(scenes):
        for trace in _pose(go, one, most):
            trace.visible = number == 0
            figure.add_trace(trace)
            owners.append(number)
    _add_buttons(figure, owners, [one.title for one in scenes])
    axis = {"backgroundcolor": "#f6f6f6", "gridcolor": "#dddddd"}
    figure.update_layout(
        scene={
            "aspectmode": "data",
            "camera": CAMERA,
            **{f"{name}axis": {**axis, "title": {"text": f"{name} m"}} for name in "xyz"},
        },
        showlegend=False,
    )
    return figure


def _frame(go: Any, robot: Robot) -> Any:
    points = frame_points(robot)
    names = [cable.name for cable in robot.cables]
    return _points(
        go, points, mode="markers+text", text=names, marker={"size": 4, "color": GREY}, hoverinfo="text"
    )


def _points(go: Any, points: Points, **options: Any) -> Any:
    return go.Scatter3d(x=points[:, 0], y=points[:, 1], z=points[:, 2], **options)


def _scale(go: Any, place: Points, most: float) -> Any:
    """Return an invisible point that carries the colour bar."""
    marker = {
        "size": 0.1, "color": [0.0], "cmin": 0.0, "cmax": most, "colorscale": TENSION_SCALE,
        "showscale": True,
        "colorbar": {"title": {"text": "tension N"}, "thickness": 14, "len": 0.7},
    }  # fmt: skip
    return _points(go, place[None, :], mode="markers", marker=marker, hoverinfo="skip")


def _regions(go: Any, result: Result) -> Any:
    edges = np.concatenate([_separated(region(one.position)) for one in result.undecided])
    return _points(
        go, edges, mode="lines", line={"color": UNDECIDED, "width": 5}, hoverinfo="text", text="undecided"
    )


def _separated(pairs: Points) -> Points:
    """Return pairs of points with gaps between them, as one line is drawn."""
    gaps = np.full((len(pairs) // 2, 1, 3), np.nan)
    joined: Points = np.concatenate([pairs.reshape(-1, 2, 3), gaps], axis=1).reshape(-1, 3)
    return joined


def _pose(go: Any, one: Scene, most: float) -> list[Any]:
    traces = []
    for cable in one.cables:
        line: dict[str, Any] = {"width": 6, "color": tension_colour(cable.tension, most)}
        if cable.state is CableState.SLACK:
            line = {"width": 3, "color": SLACK}
        elif cable.state is CableState.UNDECIDED:
            line = {"width": 5, "color": UNDECIDED, "dash": "dash"}
        elif cable.state is CableState.SWITCHING:
            line["dash"] = "dash"
        traces.append(_points(go, cable.points, mode="lines", line=line, hoverinfo="text", text=cable.text))
    if len(one.body):
        line = {"color": BODY, "width": 2}
        traces.append(_points(go, _separated(one.body), mode="lines", line=line, hoverinfo="skip"))
    if len(np.unique(one.platform, axis=0)) > 3:
        x, y, z = one.platform.T
        body = {"alphahull": 0, "opacity": 0.25, "color": BODY, "hoverinfo": "skip"}
        traces.append(go.Mesh3d(x=x, y=y, z=z, **body))
    text = f"{one.title}<br>({', '.join(f'{x:.6g}' for x in one.centre)}) m"
    marker = {"size": 6, "color": "#222222"}
    traces.append(
        _points(go, one.centre[None, :], mode="markers", marker=marker, text=text, hoverinfo="text")
    )
    return traces


def _add_buttons(figure: Any, owners: Sequence[int], titles: Sequence[str]) -> None:
    """Let a menu choose which solution is shown."""
    if not titles:
        return
    buttons = [
        {"label": title, "method": "restyle", "args": [{"visible": [o in (-1, n) for o in owners]}]}
        for n, title in enumerate(titles)
    ]
    if len(titles) > 1:
        everything = {"visible": [True] * len(owners)}
        buttons.append({"label": f"all {len(titles)} solutions", "method": "restyle", "args": [everything]})
    menu = {"buttons": buttons, "x": 0.01, "y": 0.99, "xanchor": "left", "yanchor": "top", "bgcolor": "white"}
    figure.update_layout(updatemenus=[menu])


def tension_figure(result: Result) -> Any:
    """Return the tensions of every solution as bars, with their proved bounds."""
    go = require_plotly()
    figure = go.Figure(layout={**LAYOUT, "height": 340, "barmode": "group"})
    numbers = [str(i) for i in range(1, len(result.solutions) + 1)]
    for cable, name in enumerate(result.cables):
        bounds = np.array([s.tensions[cable] for s in result.solutions])
        finite = np.where(np.isfinite(bounds), bounds, np.nan)
        middle = finite.mean(axis=1)
        figure.add_trace(
            go.Bar(
                x=numbers, y=middle, name=name, marker_color=DISCRETE[cable % len(DISCRETE)],
                error_y={"type": "data", "array": (finite[:, 1] - middle), "width": 2, "thickness": 1},
            )
        )  # fmt: skip
    figure.update_layout(xaxis={"title": {"text": "solution"}, "type": "category"}, yaxis_title="tension N")
    return figure


def histogram_figure(title: str, values: Mapping[str, Sequence[float]]) -> Any:
    """Return histograms of one quantity, one for each robot and problem."""
    go = require_plotly()
    margin = {**MARGIN, "t": 60}
    figure = go.Figure(layout={**LAYOUT, "height": 290, "barmode": "overlay", "margin": margin})
    low, high = axis_range([value for some in values.values() for value in some])
    size = (high - low) / BINS
    for number, (name, some) in enumerate(values.items()):
        # Counted here: a report must not carry a million numbers.
        counts, edges = np.histogram(np.array(some), bins=BINS, range=(low, high))
        middles = 0.5 * (edges[1:] + edges[:-1])
        colour = DISCRETE[number % len(DISCRETE)]
        figure.add_trace(
            go.Bar(x=middles, y=counts, width=size, name=name, marker_color=colour, opacity=0.75)
        )
    figure.update_layout(
        xaxis_title=title, yaxis_title="solutions", bargap=0, showlegend=len(values) > 1,
        legend={"orientation": "h", "y": 1.15},
    )  # fmt: skip
    return figure


def scatter_figure(positions: Mapping[str, Sequence[Sequence[float]]], exits: Points | None) -> Any:
    """Return the positions of all solutions in 3-D, coloured by what they are named."""
    go = require_plotly()
    figure = go.Figure(layout={**LAYOUT, "height": HEIGHT_3D})
    for number, (name, rows) in enumerate(positions.items()):
        open_ones = name == LEFT_OPEN
        marker = {"size": 2.5, "color": UNDECIDED if open_ones else DISCRETE[number % len(DISCRETE)]}
        figure.add_trace(_points(go, np.array(rows), mode="markers", marker=marker, name=name))
    if exits is not None:
        marker = {"size": 4, "color": GREY, "symbol": "square"}
        figure.add_trace(
            _points(go, exits, mode="markers", marker=marker, name="exit points", visible="legendonly")
        )
    axes = {f"{name}axis": {"title": {"text": f"{name} m"}} for name in "xyz"}
    figure.update_layout(
        scene={"aspectmode": "data", "camera": CAMERA, **axes}, legend={"itemsizing": "constant"}
    )
    return figure


def thinned(rows: Sequence[Any], most: int = MOST_POINTS) -> list[Any]:
    """Return at most so many of the rows, evenly chosen."""
    step = -(-len(rows) // most)
    return list(rows[:: max(step, 1)])
