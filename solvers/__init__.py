"""Solvers: forward and inverse kinematics of cable robots, and the command line.

Importing this package imports neither numpy nor numba; each name below is loaded on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solvers.answers.data import Outcome, Solution, StopReason
    from solvers.answers.inverse import IkResult
    from solvers.answers.result import Result
    from solvers.forward import forward_kinematics
    from solvers.kinematics.inverse import inverse_kinematics
    from solvers.point_mass.controller import PointMass, PointMassPose, PoseStatus
    from solvers.polynomial import polynomial_report
    from solvers.six_dof.tracked_pose import TrackedPose, TrackStatus
    from solvers.six_dof.tracker import Tracker
    from solvers.tensions import pose_from_tensions

_HOMES = {
    "IkResult": "solvers.answers.inverse",
    "Outcome": "solvers.answers.data",
    "PointMass": "solvers.point_mass.controller",
    "PointMassPose": "solvers.point_mass.controller",
    "PoseStatus": "solvers.point_mass.controller",
    "Result": "solvers.answers.result",
    "Solution": "solvers.answers.data",
    "StopReason": "solvers.answers.data",
    "TrackStatus": "solvers.six_dof.tracked_pose",
    "TrackedPose": "solvers.six_dof.tracked_pose",
    "Tracker": "solvers.six_dof.tracker",
    "forward_kinematics": "solvers.forward",
    "inverse_kinematics": "solvers.kinematics.inverse",
    "polynomial_report": "solvers.polynomial",
    "pose_from_tensions": "solvers.tensions",
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
