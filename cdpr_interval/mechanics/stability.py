"""Whether a static pose is a strict minimum of the potential energy."""

from __future__ import annotations

from enum import StrEnum


class Stability(StrEnum):
    """Whether the pose is a strict minimum of the potential energy."""

    STABLE = "stable"
    UNSTABLE = "unstable"
    UNDECIDED = "undecided"
