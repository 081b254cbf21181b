"""The figures of a report on paper: PNG and SVG through matplotlib; the extra ``plot``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cdpr_interval.errors import InputError
from cdpr_interval.files.literal import printable
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import CableState
from solvers.answers.result import Result
from solvers.report.palette import BODY, DISCRETE, GREY, SLACK, UNDECIDED, tension_rgb
from solvers.report.scene import Scene, axis_range, frame_points, hull, region, scene

KINDS = ("png", "svg")
DPI = 150
BINS = 40
"""Of a histogram."""
MOST_DRAWN = 12
"""Solutions that get a picture of their own."""


def require_matplotlib() -> Any:
    """Return matplotlib's figure class, without a display; `InputError` when it is not installed."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("--figures: matplotlib is not installed: pip install '.[plot]'") from None

    def figure(width: float, height: float) -> Any:
        made = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(made)
        return made

    return figure


def result_figures(robot: Robot, result: Result, folder: Path) -> list[Path]:
    """Write the robot in every pose, and the tensions; return the files."""
    make = require_matplotlib()
    scenes = [scene(robot, s, result.lengths, i) for i, s in enumerate(result.solutions, 1)]
    most = max((cable.tension for one in scenes for cable in one.cables), default=0.0)
    files = []
    for number, one in enumerate(scenes[:MOST_DRAWN], 1):
        files += _saved(_pose_figure(make, robot, result, scenes, one, most), folder / f"pose_{number}")
    if scenes:
        files += _saved(_tension_figure(make, result), folder / "tensions")
    if result.undecided and not scenes:
        files += _saved(_pose_figure(make, robot, result, [], None, most), folder / "undecided")
    return files


def _pose_figure(
    make: Any, robot: Robot, result: Result, scenes: list[Scene], one: Scene | None, most: float
) -> Any:
    figure = make(6.5, 5.5)
    axes = figure.add_subplot(projection="3d")
    for point, cable in zip(frame_points(robot), robot.cables, strict=True):
        axes.scatter(*point, color=GREY, s=14)
        axes.text(*point, f" {cable.name}", fontsize=8, color=GREY)
    if one is not None:
        for cable_line in one.cables:
            axes.plot(*cable_line.points.T, **_style(cable_line.state, cable_line.tension, most))
        for pair in one.body.reshape(-1, 2, 3):
            axes.plot(*pair.T, color=BODY, linewidth=0.8)
        axes.scatter(*one.centre, color="black", s=20)
        axes.set_title(f"{result.robot.name}, pose {one.title}", fontsize=10)
    for left in result.undecided:
        for start, end in region(left.position).reshape(-1, 2, 3):
            axes.plot(*np.array([start, end]).T, color=UNDECIDED, linewidth=2)
    low, high = hull(scenes, robot)
    axes.set_box_aspect(np.maximum(high - low, 0.05 * (high - low).max()))
    axes.set(xlabel="x m", ylabel="y m", zlabel="z m")
    if most > 0:
        _colour_bar(figure, axes, most)
    return figure


def _style(state: CableState, tension: float, most: float) -> dict[str, Any]:
    if state is CableState.SLACK:
        return {"color": SLACK, "linewidth": 1.2}
    if state is CableState.UNDECIDED:
        return {"color": UNDECIDED, "linewidth": 1.6, "linestyle": "--"}
    line = "--" if state is CableState.SWITCHING else "-"
    return {"color": [c / 255 for c in tension_rgb(tension, most)], "linewidth": 2.2, "linestyle": line}


def _colour_bar(figure: Any, axes: Any, most: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    steps = [[c / 255 for c in tension_rgb(k, 255)] for k in range(256)]
    scale = ScalarMappable(Normalize(0.0, most), ListedColormap(steps))
    figure.colorbar(scale, ax=axes, shrink=0.6, label="tension N")


def _tension_figure(make: Any, result: Result) -> Any:
    figure = make(7.0, 3.2)
    axes = figure.add_subplot()
    width = 0.8 / len(result.cables)
    for cable, name in enumerate(result.cables):
        bounds = np.array([s.tensions[cable] for s in result.solutions])
        middle = np.where(np.isfinite(bounds), bounds, np.nan).mean(axis=1)
        places = np.arange(len(middle)) + 1 + (cable - (len(result.cables) - 1) / 2) * width
        axes.bar(places, middle, width, label=name, color=DISCRETE[cable % len(DISCRETE)])
    axes.set_xticks(range(1, len(result.solutions) + 1))
    axes.set(xlabel="solution", ylabel="tension N")
    axes.legend(ncols=min(len(result.cables), 8), fontsize=8)
    return figure


def batch_figures(numbers: dict[str, dict[str, list[float]]], folder: Path) -> list[Path]:
    """Write a histogram of every quantity; return the files.

    Parameters
    ----------
    numbers : dict
        Quantity, then robot and problem, to values.
    folder : Path
    """
    make = require_matplotlib()
    files = []
    for title, groups in numbers.items():
        figure = make(6.0, 3.2)
        axes = figure.add_subplot()
        span = axis_range([value for some in groups.values() for value in some])
        for k, (name, values) in enumerate(groups.items()):
            axes.hist(
                values, bins=BINS, range=span, alpha=0.75, label=name, color=DISCRETE[k % len(DISCRETE)]
            )
        axes.set(xlabel=title, ylabel="solutions")
        axes.legend(fontsize=8)
        files += _saved(figure, folder / f"histogram_{title}")
    return files


def _saved(figure: Any, path: Path) -> list[Path]:
    files = [path.with_name(f"{path.name}.{kind}") for kind in KINDS]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for file in files:
            # No date in a file that is otherwise the same.
            figure.savefig(file, dpi=DPI, metadata={"Date": None} if file.suffix == ".svg" else None)
    except OSError as error:
        raise InputError(f"--figures: {printable(str(path.parent))}: {error.strerror}") from None
    return files
