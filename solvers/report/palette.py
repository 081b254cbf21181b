"""The colours of reports, the same in the browser and on paper."""

from __future__ import annotations

GREY = "#777777"
BODY = "#555555"
TUBE = "#1f77b4"
SLACK = "#b8b8b8"
UNDECIDED = "#d62728"
DISCRETE = ("#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#8c564b", "#e377c2", "#17becf", "#bcbd22")
_STEPS = ((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 200, 37))
"""Dark blue to yellow, told apart without colour vision too."""
TENSION_SCALE = [[i / (len(_STEPS) - 1), "rgb({},{},{})".format(*step)] for i, step in enumerate(_STEPS)]


def tension_rgb(tension: float, most: float) -> tuple[int, int, int]:
    """Return the colour of a tension as red, green and blue, 0 to 255."""
    place = (len(_STEPS) - 1) * min(max(tension / most if most > 0 else 0.0, 0.0), 1.0)
    first = min(int(place), len(_STEPS) - 2)
    share = place - first
    low, high = _STEPS[first], _STEPS[first + 1]
    red, green, blue = (round(a + share * (b - a)) for a, b in zip(low, high, strict=True))
    return red, green, blue


def tension_colour(tension: float, most: float) -> str:
    """Return the colour of a tension for a browser."""
    return "rgb({},{},{})".format(*tension_rgb(tension, most))
