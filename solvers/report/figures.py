"""The figures of a report on paper: PNG and SVG, or one PDF, through matplotlib; the extra ``plot``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cdpr_interval.errors import InputError
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.text.literal import printable
from solvers.answers.data import CableState
from solvers.answers.result import Result
from solvers.batch.ledger import Ledger
from solvers.batch.summary import Summary, contiguous
from solvers.report.palette import BODY, DISCRETE, GREY, SLACK, TUBE, UNDECIDED, tension_rgb
from solvers.report.scene import Scene, axis_range, bins, frame_points, hull, labels, region, scene, space

KINDS = ("png", "svg")
PDF = ".pdf"
DPI = 150
ACROSS = 3
"""Histograms side by side."""
MOST_DRAWN = 12
"""Solutions that get a picture of their own."""
MOST_BRANCHES = 12
"""Of a problem of a batch that get histograms."""
MOST_TICKS = 24
"""Numbers of solutions that are written below an axis; of more every second, third, ... one."""
Named = tuple[str, Any]
"""A figure with the name of its file."""


def require_matplotlib(option: str = "--figures") -> Any:
    """Return matplotlib's figure class, without a display; `InputError` when it is not installed."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError(f"{option}: matplotlib is not installed: pip install '.[plot]'") from None

    def figure(width: float, height: float) -> Any:
        made = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(made)
        return made

    return figure


def result_figures(robot: Robot, result: Result, target: Path) -> list[Path]:
    """Write the robot in every pose, and the tensions; return the files.

    Parameters
    ----------
    robot : Robot
    result : Result
    target : Path
        A folder, for a PNG and an SVG of each figure; or a file ``*.pdf``, for one page of each.

    Raises
    ------
    InputError
        matplotlib is not installed, or a file cannot be written.
    """
    return _written(_result_figures(require_matplotlib(), robot, result), target)


def _result_figures(make: Any, robot: Robot, result: Result) -> Iterator[Named]:
    scenes = [scene(robot, s, result.lengths, i) for i, s in enumerate(result.solutions, 1)]
    for number, one in enumerate(scenes[:MOST_DRAWN], 1):
        yield f"pose_{number}", _pose_figure(make, robot, result, scenes, one)
    if scenes:
        yield "tensions", _tension_figure(make, result)
    if result.undecided and not scenes:
        yield "undecided", _pose_figure(make, robot, result, [], None)


def _pose_figure(make: Any, robot: Robot, result: Result, scenes: list[Scene], one: Scene | None) -> Any:
    figure = make(6.5, 5.5)
    axes = figure.add_subplot(projection="3d")
    most = max((cable.tension for cable in one.cables), default=0.0) if one is not None else 0.0
    for point, name in zip(frame_points(robot), labels(robot), strict=True):
        axes.scatter(*point, color=GREY, s=14)
        axes.text(*point, f" {name}", fontsize=8, color=GREY)
    if one is not None:
        for cable_line in one.cables:
            axes.plot(*cable_line.points.T, **_style(cable_line.state, cable_line.tension, most))
        for pair in np.concatenate([one.body, one.wheels]).reshape(-1, 2, 3):
            axes.plot(*pair.T, color=BODY, linewidth=0.8)
        axes.scatter(*one.centre, color="black", s=20)
        for pair in one.tube.reshape(-1, 2, 3):
            axes.plot(*pair.T, color=TUBE, linewidth=0.8)
        axes.set_title(f"{result.robot.name}, pose {one.title}", fontsize=10)
    for left in result.undecided:
        for start, end in region(left.position).reshape(-1, 2, 3):
            axes.plot(*np.array([start, end]).T, color=UNDECIDED, linewidth=2)
    low, high = space(*hull(scenes, robot))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    axes.set_xlabel("x m", labelpad=8)
    axes.set_ylabel("y m", labelpad=8)
    axes.set_zlabel("z m", labelpad=8)
    axes.tick_params(labelsize=8)
    axes.locator_params(nbins=5)
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
    """Return the proved bounds of all tensions: a bar to the middle, a whisker over the enclosure."""
    count = len(result.solutions)
    figure = make(max(7.0, 0.12 * count * len(result.cables)), 3.4)
    axes = figure.add_subplot()
    width = 0.8 / len(result.cables)
    for cable, name in enumerate(result.cables):
        bounds = np.array([s.tensions[cable] for s in result.solutions])
        finite = np.where(np.isfinite(bounds), bounds, np.nan)
        middle = finite.mean(axis=1)
        places = np.arange(count) + 1 + (cable - (len(result.cables) - 1) / 2) * width
        axes.bar(
            places, middle, width, label=name, color=DISCRETE[cable % len(DISCRETE)],
            yerr=(finite[:, 1] - finite[:, 0]) / 2, error_kw={"elinewidth": 0.8, "capsize": 1.5},
        )  # fmt: skip
    axes.set_xticks(range(1, count + 1, -(-count // MOST_TICKS)))
    axes.set_xlim(0.4, count + 0.6)
    axes.set(xlabel="solution", ylabel="tension N", title=result.robot.name)
    axes.legend(ncols=min(len(result.cables), 8), fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.2))
    return figure


def batch_figures(ledger: Ledger, summary: Summary, target: Path) -> list[Path]:
    """Write the histograms of every branch; return the files.

    Parameters
    ----------
    ledger : Ledger
        Gives a batch without a name the name of its folder.
    summary : Summary
    target : Path
        A folder, for a PNG and an SVG of each figure; or a file ``*.pdf``, for one page of each.

    Raises
    ------
    InputError
        matplotlib is not installed, or a file cannot be written.
    """
    name = summary.name or ledger.folder.resolve().name
    return _written(_batch_figures(require_matplotlib(), name, summary), target)


def _batch_figures(make: Any, name: str, summary: Summary) -> Iterator[Named]:
    for group in summary.groups:
        place = f"problem_{group.problem}_{group.robot}"
        title = f"{name}: {group.robot}, problems[{group.problem}]"
        for branch in group.branches.sorted()[:MOST_BRANCHES]:
            numbers = contiguous(branch.numbers)
            yield f"{place}_branch_{branch.number}", _histograms(make, numbers, f"{title}, {branch.title}")


def _histograms(make: Any, numbers: Mapping[str, Sequence[float]], title: str) -> Any:
    rows = -(-len(numbers) // ACROSS)
    figure = make(8.0, 0.6 + 1.9 * rows)
    figure.suptitle(title, fontsize=10)
    for place, (quantity, values) in enumerate(numbers.items(), 1):
        axes = figure.add_subplot(rows, ACROSS, place)
        axes.hist(values, bins=bins(len(values)), range=axis_range(values), color=DISCRETE[0])
        axes.set_xlabel(quantity, fontsize=8)
        axes.tick_params(labelsize=7)
        axes.locator_params(axis="x", nbins=4)
        axes.yaxis.get_major_locator().set_params(integer=True)
        axes.ticklabel_format(axis="x", useOffset=False)
    return figure


def _written(figures: Iterator[Named], target: Path) -> list[Path]:
    """Write figures one by one, each as soon as it is drawn."""
    try:
        if target.suffix.lower() == PDF:
            return _pages(figures, target)
        target.mkdir(parents=True, exist_ok=True)
        files = []
        for name, figure in figures:
            for kind in KINDS:
                files.append(target / f"{name}.{kind}")
                # No date in a file that is otherwise the same.
                metadata = {"Date": None} if kind == "svg" else None
                figure.savefig(files[-1], dpi=DPI, metadata=metadata)
        return files
    except OSError as error:
        raise InputError(f"--figures: {printable(str(target))}: {error.strerror}") from None


def _pages(figures: Iterator[Named], target: Path) -> list[Path]:
    from matplotlib.backends.backend_pdf import PdfPages

    target.parent.mkdir(parents=True, exist_ok=True)
    with PdfPages(target, metadata={"CreationDate": None}) as pages:
        for _, figure in figures:
            pages.savefig(figure)
    return [target]
