"""The diagrams of Paty et al. 2021 as they come out here: figures 10, 12, 15, 16 and 19, as PNG files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from paty_2021_accuracy import both, reach
from paty_2021_design import NAMES, effects, responses
from paty_2021_elasticity import END, START, optimal, study
from paty_2021_model import robot, solved
from paty_2021_targets import Settings, plane, rising, straight

Figures = Callable[[float, float], Any]
"""Makes a figure of a width and height in inches."""
CABLES = (3, 4)
LEVELS = 12
DPI = 120


def draw(folder: Path, figures: Figures, settings: Settings) -> Iterator[Path]:
    """Write the pictures into a folder, which is made; yield the files."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in (
        ("paths", on_paths),
        ("contours", contours),
        ("experiments", experiments),
        ("elasticity", elasticity),
    ):
        target = folder / f"paty_2021_{name}.png"
        picture(figures, settings).savefig(target, dpi=DPI)
        yield target


def on_paths(figures: Figures, settings: Settings) -> Any:
    """Return errors along the paths, as far as the tension limit allows: figure 10."""
    figure = figures(8, 4)
    axes = figure.subplots()
    for cables in CABLES:
        path = rising(cables, settings.path_points)
        for design in both(cables, settings):
            poses = solved(robot(design), path.targets)
            end = reach(poses)
            axes.plot(path.abscissa[:end], poses.error[:end], label=design.name)
    axes.set(xlabel="along the path, m", ylabel="error, m")
    axes.legend()
    return figure


def contours(figures: Figures, settings: Settings) -> Any:
    """Return iso-contours on z = 2.5 m, targets that no three cables hold left out: figure 12."""
    figure = figures(10, 9)
    grid = figure.subplots(2, 2)
    for row, cables in zip(grid, CABLES, strict=True):
        targets = plane(cables, settings.plane_intervals)
        for axes, design in zip(row, both(cables, settings), strict=True):
            poses = solved(robot(design), targets)
            x, y = targets[poses.valid, :2].T
            drawn = axes.tricontourf(x, y, poses.error[poses.valid], LEVELS)
            figure.colorbar(drawn, ax=axes, label="error, m")
            axes.set(title=design.name, xlabel="x, m", ylabel="y, m", aspect="equal")
    return figure


def experiments(figures: Figures, settings: Settings) -> Any:
    """Return the means of the tests and the effects: figures 15 and 16."""
    figure = figures(10, 4)
    left, right = figure.subplots(1, 2)
    means, _, _ = responses(settings)
    left.bar(range(1, len(means) + 1), means)
    left.set(xlabel="test", ylabel="mean error, m")
    found = effects(means)
    right.barh([" x ".join(names) for names in found], list(found.values()))
    right.set(xlabel="effect, m")
    return figure


def elasticity(figures: Figures, settings: Settings) -> Any:
    """Return errors along the path of section 5 between the ends of E: figure 19."""
    figure = figures(8, 4)
    axes = figure.subplots()
    path = straight(START, END, settings.path_points)
    for joints, name in NAMES.items():
        errors = study(optimal(joints, settings), path)
        (line,) = axes.plot(path.abscissa, errors.middle, label=f"{name}*, 102.2 GPa")
        low, high = np.min(errors.moduli, axis=0), np.max(errors.moduli, axis=0)
        axes.fill_between(path.abscissa, low, high, color=line.get_color(), alpha=0.3)
    axes.set(xlabel="along the path, m", ylabel="error, m; bands: 67.2 to 137.2 GPa")
    axes.legend()
    return figure
