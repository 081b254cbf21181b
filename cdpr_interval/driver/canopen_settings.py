"""What a drive on a CANopen bus is configured with: written by SDO, and read back."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

from cdpr_interval.driver import canopen_objects as objects
from cdpr_interval.driver.canopen_objects import RPDOS, TPDOS, Setting
from cdpr_interval.driver.winch import WinchModel
from cdpr_interval.robots.winch import Winch

ANSWER_SECONDS = 1.0
"""For one SDO answer: drives that store a setting, and busy machines, need more than the library's 0.3 s."""
SPARE = 2
"""The drive's own limits (braking, following error) in units of the winch's: the supervisor's come first."""


@dataclass(frozen=True)
class DriveSettings:
    """What one drive is configured with."""

    node: int
    braking: int
    """Counts/s^2."""
    window: int
    """Counts of following error."""


def settings_of(winch: Winch) -> DriveSettings:
    """Return what the drive of a winch is configured with."""
    model = WinchModel(winch)
    low, high = winch.limits.length
    middle = model.placed(0, (low + high) / 2)
    counts_per_metre = 1 / abs(middle.rate(0).mid)
    braking = max(round(SPARE * winch.limits.acceleration * counts_per_metre), 1)
    window = max(round(SPARE * winch.limits.following_error * counts_per_metre), 1)
    return DriveSettings(winch.node, braking, window)


def configure(canopen: Any, node: Any, drive: DriveSettings, cycle: float, heartbeat: float) -> list[str]:
    """Write and read back every setting of a drive; return what is wrong, a line each.

    Parameters
    ----------
    canopen : module
        The library: it is loaded when a bus is used only.
    node : canopen.RemoteNode
        The drive.
    drive : DriveSettings
        What it is configured with.
    cycle, heartbeat : float
        s.
    """
    node.sdo.RESPONSE_TIMEOUT = ANSWER_SECONDS
    wanted = objects.drive_settings(cycle, heartbeat, drive.braking, drive.window)
    wanted += objects.pdo_settings(drive.node)
    faults = []
    for setting in wanted:
        try:
            node.sdo.download(setting.entry.index, setting.entry.sub, setting.entry.pack(setting.value))
        except canopen.SdoAbortedError as error:
            faults.append(f"node {drive.node}: {setting.entry}: refused ({error})")
        except canopen.SdoCommunicationError:
            # Nobody there: every further question would wait as long.
            return [f"node {drive.node}: no answer"]
    for setting in wanted:
        if setting.is_read_back:
            faults += _read_back(canopen, node, drive.node, setting)
    for entry in (entry for pdo in (*RPDOS, *TPDOS) for entry in pdo):
        try:
            node.sdo.upload(entry.index, entry.sub)
        except (canopen.SdoAbortedError, canopen.SdoCommunicationError) as error:
            faults.append(f"node {drive.node}: {entry}: missing ({error})")
    return list(dict.fromkeys(faults))


def _read_back(canopen: Any, node: Any, number: int, setting: Setting) -> list[str]:
    entry = setting.shown_by or setting.entry
    try:
        value = entry.unpack(node.sdo.upload(entry.index, entry.sub))
    except canopen.SdoAbortedError as error:
        return [f"node {number}: {entry}: missing ({error})"]
    except (canopen.SdoCommunicationError, struct.error) as error:
        return [f"node {number}: {entry}: not readable ({error})"]
    if value != setting.value:
        return [f"node {number}: {entry}: is {value}, must be {setting.value}"]
    return []
