"""Solvers: forward and inverse kinematics of cable robots, and the command line.

Importing this package imports neither numpy nor numba; each name below is loaded on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cdpr_interval.mechanics.stability import Stability
    from solvers.answers.data import (
        CableState,
        Certainty,
        Family,
        Nominal,
        Outcome,
        Proof,
        Question,
        Solution,
        StopReason,
        SubsetReport,
        Undecided,
    )
    from solvers.answers.ik_result import IkResult
    from solvers.answers.provenance import Provenance
    from solvers.answers.result import Result
    from solvers.certification import write_certificate
    from solvers.delta.controller import Delta
    from solvers.delta.drives import delta_drives
    from solvers.delta.kinematics import delta_kinematics
    from solvers.delta.poses import delta_poses
    from solvers.forward import forward_kinematics
    from solvers.kinematics.inverse import inverse_kinematics
    from solvers.kinematics.mobility import Mobility, mobility
    from solvers.motions.motion import motion
    from solvers.motions.result import Motion
    from solvers.point_mass.controller import PointMassPose, PoseStatus
    from solvers.polynomial import polynomial_report
    from solvers.report.motion_picture import motion_picture
    from solvers.report.written import result_figure, write_report
    from solvers.routed_mass.controller import PointMass
    from solvers.six_dof.estimate import Estimate
    from solvers.six_dof.tracked_pose import Region, TrackedPose, TrackStatus
    from solvers.six_dof.tracker import Tracker
    from solvers.tensions import pose_from_tensions

_HOMES = {
    "CableState": "solvers.answers.data",
    "Certainty": "solvers.answers.data",
    "Delta": "solvers.delta.controller",
    "Estimate": "solvers.six_dof.estimate",
    "Family": "solvers.answers.data",
    "IkResult": "solvers.answers.ik_result",
    "Mobility": "solvers.kinematics.mobility",
    "Motion": "solvers.motions.result",
    "Nominal": "solvers.answers.data",
    "Outcome": "solvers.answers.data",
    "PointMass": "solvers.routed_mass.controller",
    "PointMassPose": "solvers.point_mass.controller",
    "PoseStatus": "solvers.point_mass.controller",
    "Proof": "solvers.answers.data",
    "Provenance": "solvers.answers.provenance",
    "Question": "solvers.answers.data",
    "Region": "solvers.six_dof.tracked_pose",
    "Result": "solvers.answers.result",
    "Solution": "solvers.answers.data",
    "Stability": "cdpr_interval.mechanics.stability",
    "StopReason": "solvers.answers.data",
    "SubsetReport": "solvers.answers.data",
    "TrackStatus": "solvers.six_dof.tracked_pose",
    "TrackedPose": "solvers.six_dof.tracked_pose",
    "Tracker": "solvers.six_dof.tracker",
    "Undecided": "solvers.answers.data",
    "delta_drives": "solvers.delta.drives",
    "delta_kinematics": "solvers.delta.kinematics",
    "delta_poses": "solvers.delta.poses",
    "forward_kinematics": "solvers.forward",
    "inverse_kinematics": "solvers.kinematics.inverse",
    "mobility": "solvers.kinematics.mobility",
    "motion": "solvers.motions.motion",
    "motion_picture": "solvers.report.motion_picture",
    "polynomial_report": "solvers.polynomial",
    "pose_from_tensions": "solvers.tensions",
    "result_figure": "solvers.report.written",
    "write_certificate": "solvers.certification",
    "write_report": "solvers.report.written",
}

__all__ = [
    "CableState",
    "Certainty",
    "Delta",
    "Estimate",
    "Family",
    "IkResult",
    "Mobility",
    "Motion",
    "Nominal",
    "Outcome",
    "PointMass",
    "PointMassPose",
    "PoseStatus",
    "Proof",
    "Provenance",
    "Question",
    "Region",
    "Result",
    "Solution",
    "Stability",
    "StopReason",
    "SubsetReport",
    "TrackStatus",
    "TrackedPose",
    "Tracker",
    "Undecided",
    "delta_drives",
    "delta_kinematics",
    "delta_poses",
    "forward_kinematics",
    "inverse_kinematics",
    "mobility",
    "motion",
    "motion_picture",
    "polynomial_report",
    "pose_from_tensions",
    "result_figure",
    "write_certificate",
    "write_report",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """List the public names beside what is loaded."""
    return sorted({*globals(), *__all__})
