"""The figures of a report as plotly objects; the extra ``report``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr_interval.errors import InputError
from solvers.answers.data import CableState
from solvers.answers.result import Result
from solvers.report.palette import BODY, DISCRETE, GREY, SLACK, TENSION_SCALE, TUBE, UNDECIDED, tension_colour
from solvers.report.scene import (
    Points,
    Scene,
    axis_range,
    bins,
    frame_points,
    hull,
    labels,
    region,
    scene,
    space,
)

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
ACROSS = 4
"""Histograms side by side."""
WIDTH = 1080
"""px, of histograms; the page is a little wider."""
THIN = 0.2
"""A cloud of positions this many times thinner than long gets a scale for each axis."""
MOST_NAMES = 40
"""Of undecided regions that are written into the picture."""
ALWAYS = -1
"""Owner of what is drawn with every solution."""
LEFT_OPEN = "something left open"
"""Name of the middles of undecided regions."""
STABLE = ": stable"
"""In the name of a branch that a platform can hang in."""
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
    figure = go.Figure(layout={**LAYOUT, "height": HEIGHT_3D})
    always = [_frame(go, robot), *_regions(go, result)]
    for trace in always:
        figure.add_trace(trace)
    owners: list[int] = [ALWAYS] * len(always)
    scales = []
    for number, one in enumerate(scenes):
        most = max((cable.tension for cable in one.cables), default=0.0)
        traces = _pose(go, one, most)
        if most > 0.0:
            scales.append(len(owners) + len(traces))
            traces.append(_scale(go, frame_points(robot)[0], most))
        for trace in traces:
            trace.visible = number == 0
            figure.add_trace(trace)
            owners.append(number)
    _add_buttons(figure, owners, scales, [one.title for one in scenes])
    boxes = [one.position.T for one in result.undecided if np.isfinite(one.position).all()]
    figure.update_layout(scene=space_of(*hull(scenes, robot, boxes)), showlegend=False)
    return figure


def space_of(low: Points, high: Points) -> dict[str, Any]:
    """Return axes of one scale around what is drawn."""
    low, high = space(low, high)
    ratio = (high - low) / np.cbrt(np.prod(high - low))
    axis = {"backgroundcolor": "#f6f6f6", "gridcolor": "#dddddd"}
    return {
        "aspectmode": "manual",
        "aspectratio": dict(zip("xyz", ratio.tolist(), strict=True)),
        "camera": CAMERA,
        **{
            f"{name}axis": {**axis, "title": {"text": f"{name} m"}, "range": [float(low[k]), float(high[k])]}
            for k, name in enumerate("xyz")
        },
    }


def _frame(go: Any, robot: Robot) -> Any:
    points = frame_points(robot)
    return _points(
        go, points, mode="markers+text", text=labels(robot), marker={"size": 4, "color": GREY},
        hovertext=list(robot.cable_names), hoverinfo="text",
    )  # fmt: skip


def _points(go: Any, points: Points, **options: Any) -> Any:
    return go.Scatter3d(x=points[:, 0], y=points[:, 1], z=points[:, 2], **options)


def _scale(go: Any, place: Points, most: float) -> Any:
    """Return an invisible point that carries the colour bar of one pose."""
    marker = {
        "size": 0.1, "color": [0.0], "cmin": 0.0, "cmax": most, "colorscale": TENSION_SCALE,
        "showscale": True,
        "colorbar": {"title": {"text": "tension N"}, "thickness": 14, "len": 0.7},
    }  # fmt: skip
    return _points(go, place[None, :], mode="markers", marker=marker, hoverinfo="skip")


def _regions(go: Any, result: Result) -> list[Any]:
    """Return the boxes of what is undecided and their names; those without bounds cannot be drawn."""
    boxes = [
        (f"u{number}", one.position)
        for number, one in enumerate(result.undecided, 1)
        if np.isfinite(one.position).all()
    ]
    if not boxes:
        return []
    edges = np.concatenate([_separated(region(box)) for _, box in boxes])
    names = [name for name, box in boxes[:MOST_NAMES]]
    places = np.array([box.mean(axis=1) for _, box in boxes[:MOST_NAMES]])
    line, font = {"color": UNDECIDED, "width": 5}, {"color": UNDECIDED}
    return [
        _points(go, edges, mode="lines", line=line, hoverinfo="text", text="undecided"),
        _points(go, places, mode="text", text=names, textfont=font, hoverinfo="skip"),
    ]


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
    for pairs in (one.body, one.wheels):
        if len(pairs):
            line = {"color": BODY, "width": 2}
            traces.append(_points(go, _separated(pairs), mode="lines", line=line, hoverinfo="skip"))
    if len(np.unique(one.platform, axis=0)) > 3:
        x, y, z = one.platform.T
        body = {"alphahull": 0, "opacity": 0.25, "color": BODY, "hoverinfo": "skip"}
        traces.append(go.Mesh3d(x=x, y=y, z=z, **body))
    if len(one.tube):
        edges, line = _separated(one.tube), {"color": TUBE, "width": 2}
        text = "for every choice of the data the anchor is in here"
        traces.append(_points(go, edges, mode="lines", line=line, hoverinfo="text", text=text))
    text = f"{one.title}<br>({', '.join(f'{x:.6g}' for x in one.centre)}) m"
    marker = {"size": 6, "color": "#222222"}
    traces.append(
        _points(go, one.centre[None, :], mode="markers", marker=marker, text=text, hoverinfo="text")
    )
    return traces


def _add_buttons(figure: Any, owners: Sequence[int], scales: Sequence[int], titles: Sequence[str]) -> None:
    """Let a menu choose which solution is shown; all together have no colour bar: each has its own scale."""
    if not titles:
        return
    buttons = [
        {"label": title, "method": "restyle", "args": [{"visible": [o in (ALWAYS, n) for o in owners]}]}
        for n, title in enumerate(titles)
    ]
    if len(titles) > 1:
        everything = {"visible": [trace not in scales for trace in range(len(owners))]}
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


def histogram_figure(numbers: Mapping[str, Sequence[float]]) -> Any:
    """Return histograms of several quantities side by side."""
    require_plotly()
    from plotly.subplots import make_subplots

    rows = -(-len(numbers) // ACROSS)
    figure = make_subplots(rows, ACROSS, subplot_titles=list(numbers), vertical_spacing=0.32 / rows)
    for place, values in enumerate(numbers.values()):
        low, high = axis_range(values)
        # Counted here: a report must not carry a million numbers.
        counts, edges = np.histogram(np.array(values), bins=bins(len(values)), range=(low, high))
        middles, size = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
        row, column = divmod(place, ACROSS)
        figure.add_bar(x=middles, y=counts, width=size, marker_color=DISCRETE[0], row=row + 1, col=column + 1)
    # A fixed width: what is folded away has none to adapt to.
    figure.update_layout(
        **{**LAYOUT, "margin": {**MARGIN, "t": 60}},
        height=80 + 170 * rows,
        width=WIDTH,
        bargap=0,
        showlegend=False,
    )
    figure.update_xaxes(nticks=5)
    return figure


def scatter_figure(positions: Mapping[str, Points], exits: Points | None) -> tuple[Any, bool]:
    """Return the positions of all solutions in 3-D, and whether its axes have different scales.

    Parameters
    ----------
    positions : mapping
        Names to positions (n, 3) in m.
    exits : (N, 3) array, optional
        m: exit points, drawn on a click in the legend.
    """
    go = require_plotly()
    figure = go.Figure(layout={**LAYOUT, "height": HEIGHT_3D})
    for number, (name, rows) in enumerate(positions.items()):
        is_open, is_stable = name == LEFT_OPEN, STABLE in name
        marker = {
            "size": 4 if is_stable else 2.5,
            "color": UNDECIDED if is_open else DISCRETE[number % len(DISCRETE)],
        }
        figure.add_trace(_points(go, np.asarray(rows), mode="markers", marker=marker, name=name))
    if exits is not None:
        marker = {"size": 4, "color": GREY, "symbol": "square"}
        figure.add_trace(
            _points(go, exits, mode="markers", marker=marker, name="exit points", visible="legendonly")
        )
    spans = np.ptp(np.concatenate([np.asarray(rows) for rows in positions.values()]), axis=0)
    # With one scale for all, a thin cloud is a line that shows nothing.
    is_stretched = bool(spans.min() < THIN * spans.max())
    axes = {f"{name}axis": {"title": {"text": f"{name} m"}} for name in "xyz"}
    figure.update_layout(
        scene={"aspectmode": "cube" if is_stretched else "data", "camera": CAMERA, **axes},
        legend={"itemsizing": "constant", "orientation": "h", "y": -0.02},
    )
    return figure, is_stretched


def step(count: int, share: float) -> int:
    """Return the step by which about a share of so many is kept, and at least one."""
    return -(-count // max(int(share * count), 1)) if count else 1
