"""The picture of a motion: which cables are taut over time, and the path in its tube; the extra ``plot``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cdpr_interval.errors import InputError
from cdpr_interval.text.literal import printable
from solvers.motions.data import Event, MotionData, Segment
from solvers.questions.arguments import read_path
from solvers.report.figures import DPI, require_matplotlib
from solvers.report.palette import DISCRETE, SLACK, UNDECIDED

TAUT, SWITCHING = DISCRETE[0], DISCRETE[1]
KINDS = (".png", ".svg", ".pdf")
BAR = 0.8
"""Height of a bar over the distance of two."""
EDGES = ((0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7))
"""Of a box whose corners are numbered x, y, z in binary."""


def motion_picture(motion: MotionData, path: str | os.PathLike[str], label: str = "path") -> Path:
    """Draw a motion's taut cables over time and its path, and return the file: .png, .svg or .pdf.

    Raises
    ------
    InputError
        matplotlib is not installed, the file has another ending, or it cannot be written.
    """
    make, target = require_picture(path, label)
    figure = _figure(make, motion)
    try:
        figure.savefig(target, dpi=DPI)
    except OSError as error:
        raise InputError(f"{label}: {printable(str(target))}: {error.strerror}") from None
    return target


def require_picture(path: str | os.PathLike[str], label: str) -> tuple[Any, Path]:
    """Return what makes figures, and the file; raise `InputError` where none can be drawn."""
    target = read_path(path, label)
    if target.suffix.lower() not in KINDS:
        raise InputError(f"{label}: must end in {', '.join(KINDS)}, got {printable(str(target))}")
    return require_matplotlib(label), target


def _figure(make: Any, motion: MotionData) -> Any:
    count = len(motion.cables)
    figure = make(11.0, 4.6 + 0.3 * count)
    grid = figure.add_gridspec(4, 2, height_ratios=(0.35 * count + 0.5, 1, 1, 1), width_ratios=(1.25, 1.0))
    bars = figure.add_subplot(grid[0, 0])
    _bars(bars, motion)
    for row, name in enumerate("xyz"):
        axes = figure.add_subplot(grid[row + 1, 0], sharex=bars)
        _band(axes, motion, row, name)
        axes.tick_params(labelbottom=row == 2)
    axes.set_xlabel("t s")
    bars.tick_params(labelbottom=False)
    bars.set_xlim(*motion.question.t)
    _path(figure.add_subplot(grid[:, 1], projection="3d"), motion)
    return figure


def _bars(axes: Any, motion: MotionData) -> None:
    """Draw a row for every cable: taut, switching or slack."""
    from matplotlib.patches import Patch

    for i in range(len(motion.cables)):
        for one in motion.segments:
            state = TAUT if i in one.taut else SWITCHING if i in one.switching else SLACK
            axes.barh(i, one.t[1] - one.t[0], BAR, one.t[0], color=state, linewidth=0)
            if i in one.switching:
                # However short it is, it is seen.
                ends = [i - BAR / 2, i + BAR / 2]
                axes.plot([sum(one.t) / 2] * 2, ends, color=SWITCHING, linewidth=1.5, solid_capstyle="butt")
    _mark_end(axes, motion.events)
    axes.set_yticks(range(len(motion.cables)), motion.cables)
    axes.invert_yaxis()
    axes.set_title(f"{motion.robot.name}: cables, platform origin", fontsize=10, loc="left")
    known = {"taut": TAUT, "switching": SWITCHING, "slack": SLACK}
    handles = [Patch(color=colour, label=name) for name, colour in known.items()]
    place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.3}
    axes.legend(handles=handles, ncols=3, fontsize=8, frameon=False, **place)


def _band(axes: Any, motion: MotionData, row: int, name: str) -> None:
    """Draw the bounds of one coordinate over time."""
    for number, segments in enumerate([motion.segments, *(track.segments for track in motion.others)]):
        colour = DISCRETE[0] if number == 0 else DISCRETE[2 + number % (len(DISCRETE) - 2)]
        for one in segments:
            low, high = one.tube.position[row].tolist()
            axes.fill_between(one.t, low, high, color=colour, alpha=0.35, linewidth=0)
            axes.plot(one.t, [(low + high) / 2] * 2, color=colour, linewidth=0.8)
    _mark_end(axes, motion.events)
    axes.set_ylabel(f"{name} m")
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.tick_params(labelsize=8)


def _mark_end(axes: Any, events: Sequence[Event]) -> None:
    """Draw where the pose ends or is lost."""
    for event in events:
        if event.cable is None:
            axes.axvline(event.t[0], color=UNDECIDED, linewidth=1.2, linestyle="--")


def _path(axes: Any, motion: MotionData) -> None:
    """Draw the boxes in which the platform origin is, with the exit points."""
    every = [motion.segments, *(track.segments for track in motion.others)]
    for number, segments in enumerate(every):
        colour = DISCRETE[0] if number == 0 else DISCRETE[2 + number % (len(DISCRETE) - 2)]
        for one in segments:
            corners = _corners(one)
            for start, end in EDGES:
                edge = corners[[start, end]]
                axes.plot(*edge.T, color=SWITCHING if one.switching else colour, linewidth=0.7)
        if segments:
            middles = np.array([one.tube.position.mean(axis=1) for one in segments])
            axes.plot(*middles.T, color="#222222", linewidth=1.0)
            axes.scatter(*middles[0], color="#222222", s=16)
    boxes = [one.tube.position for segments in every for one in segments]
    if boxes:
        low = np.min([box[:, 0] for box in boxes], axis=0)
        high = np.max([box[:, 1] for box in boxes], axis=0)
        margin = 0.1 * max(float((high - low).max()), 1e-9)
        axes.set(**{f"{c}lim": (low[k] - margin, high[k] + margin) for k, c in enumerate("xyz")})
        axes.set_box_aspect(high - low + 2 * margin, zoom=0.8)
    for name in "xyz":
        getattr(axes, f"set_{name}label")(f"{name} m", labelpad=6)
    axes.tick_params(labelsize=7)
    axes.locator_params(nbins=4)
    axes.locator_params(axis="z", nbins=3)
    axes.set_title("path of the platform origin, in the boxes of the segments", fontsize=10)


def _corners(segment: Segment) -> Any:
    """Return the corners (8, 3) of a segment's box."""
    box = segment.tube.position
    return np.array([[box[k, (n >> (2 - k)) & 1] for k in range(3)] for n in range(8)])
