"""Winches: from lengths to turning drums, and back from encoders to bounds of lengths that solvers take.

Importing this package imports neither canopen nor python-can; each name below is loaded on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "BusError": "bus",
    "Command": "bus",
    "DriveBus": "bus",
    "FaultKind": "simulated_drive",
    "Feedback": "bus",
    "GroupState": "snapshot",
    "Interlock": "violation",
    "Reference": "reference",
    "ReferenceState": "reference",
    "Refused": "requests",
    "SimulatedBus": "simulator",
    "SimulatedDrive": "simulated_drive",
    "SimulatedFault": "simulated_drive",
    "Snapshot": "snapshot",
    "Supervisor": "supervisor",
    "Violation": "violation",
    "WinchGroup": "group",
    "WinchModel": "winch",
    "WinchesStopped": "group",
}


def __getattr__(name: str) -> Any:
    """Load a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """List the public names beside what is loaded."""
    return sorted({*globals(), *_HOMES})
