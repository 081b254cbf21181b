"""Solvers: forward and inverse kinematics of cable robots, and the command line.

Importing this package imports neither numpy nor numba; each name below is loaded on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solvers.forward import forward_kinematics
    from solvers.given_tensions import pose_from_tensions
    from solvers.ik_result import IkResult
    from solvers.inverse import inverse_kinematics
    from solvers.point_mass_pose import PointMassPose, PoseStatus
    from solvers.point_mass_solver import PointMass
    from solvers.polynomial import polynomial_report
    from solvers.result import Outcome, Result, Solution, StopReason
    from solvers.tracked_pose import TrackedPose, TrackStatus
    from solvers.tracker import Tracker

_HOMES = {
    "IkResult": "solvers.ik_result",
    "Outcome": "solvers.result",
    "PointMass": "solvers.point_mass_solver",
    "PointMassPose": "solvers.point_mass_pose",
    "PoseStatus": "solvers.point_mass_pose",
    "Result": "solvers.result",
    "Solution": "solvers.result",
    "StopReason": "solvers.result",
    "TrackStatus": "solvers.tracked_pose",
    "TrackedPose": "solvers.tracked_pose",
    "Tracker": "solvers.tracker",
    "forward_kinematics": "solvers.forward",
    "inverse_kinematics": "solvers.inverse",
    "polynomial_report": "solvers.polynomial",
    "pose_from_tensions": "solvers.given_tensions",
}

__all__ = [
    "IkResult",
    "Outcome",
    "PointMass",
    "PointMassPose",
    "PoseStatus",
    "Result",
    "Solution",
    "StopReason",
    "TrackStatus",
    "TrackedPose",
    "Tracker",
    "forward_kinematics",
    "inverse_kinematics",
    "polynomial_report",
    "pose_from_tensions",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """List the public names beside what is loaded."""
    return sorted({*globals(), *__all__})
