"""What inverse kinematics returns: distances, lengths and tensions for a pose, in plain floats.

The layout follows the file format ``cdpr-ik-result/1``. Nothing in it is certified: put the lengths
to forward kinematics for that.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cdpr_interval.errors import InputError

FORMAT = "cdpr-ik-result/1"
ANGLE_DECIMALS = 12
"""Of degrees to paste: 2e-14 rad, about the rounding of a settled pose."""
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class IkQuestion:
    """What was asked beside the pose."""

    taut: tuple[str, ...] | None
    """Names of the cables that may carry tension; None: all."""
    slack_margin: float
    settle: bool
    settle_within: float | None
    """How far settling may move any point of the platform, m; None: it was not asked for."""
    static: bool
    wrench_tolerance: float
    """Share of the load's size."""
    external_force: Triple
    """N, base axes."""
    position: Triple
    """The pose that was given, platform origin, m."""
    quaternion: tuple[float, float, float, float]
    """(w, x, y, z), platform to base."""


@dataclass(frozen=True)
class Settling:
    """How far the pose was moved to become static, or how far away the static pose is that was found."""

    succeeded: bool
    """False: the result is about the pose that was asked for, and has no lengths."""
    found: bool
    """A static pose was found, near enough or not; False: what follows is about the best pose."""
    distance: float
    """Translation of the centre of mass, m."""
    angle: float
    """Rotation, rad."""
    travel: float
    """Way of the point of the platform that moves most, m: an anchor or the centre of mass."""


@dataclass(frozen=True)
class IkResult:
    """Distances, lengths and tensions at one pose, file order."""

    tool: tuple[str, str]
    """Name and version."""
    robot: tuple[str, str]
    """Name and sha256."""
    model: str
    cables: tuple[str, ...]
    question: IkQuestion
    position: Triple
    """Platform origin in the base frame, m: after settling, if that was asked."""
    rotation: tuple[Triple, Triple, Triple]
    """Platform to base."""
    quaternion: tuple[float, float, float, float]
    rpy: Triple
    """Roll, pitch, yaw, rad."""
    distances: tuple[float, ...]
    """||A_i - p - R B_i||, m."""
    lengths: tuple[float, ...] | None
    """Cable lengths that give this pose, m, unstretched for elastic cables; None where an elastic
    cable needs a tension and the pose is not static, and where settling did not succeed."""
    tensions: tuple[float, ...]
    """N: the non-negative tensions of least norm, or the best fit where the pose is not static."""
    is_static: bool
    """True when the residual is within the tolerance."""
    residual_force: Triple
    """Load and cable forces together, N."""
    residual_moment: Triple
    """About the centre of mass, N m."""
    settling: Settling | None
    outside_tension_limits: tuple[str, ...]
    """Cables whose tension is outside their ``tension_limits_N``; reported, never a filter."""
    message: str

    @property
    def lengths_option(self) -> str | None:
        """The lengths as ``--lengths`` takes them, each restoring its double."""
        return None if self.lengths is None else ",".join(repr(length) for length in self.lengths)

    @property
    def pose_option(self) -> str:
        """The pose as ``--pose`` takes it, angles in degrees; a point mass has none."""
        angles = () if self.model == "point-mass" else self.rpy
        degrees = (round(math.degrees(angle), ANGLE_DECIMALS) + 0.0 for angle in angles)
        return ",".join([*map(repr, self.position), *(f"{angle!r}deg" for angle in degrees)])

    def to_dict(self) -> dict[str, Any]:
        """Return the ``cdpr-ik-result/1`` document as plain lists and dictionaries."""
        question, settling = self.question, self.settling
        return {
            "format": FORMAT,
            "tool": {"name": self.tool[0], "version": self.tool[1]},
            "robot": {"name": self.robot[0], "sha256": self.robot[1]},
            "model": self.model,
            "cables": list(self.cables),
            "question": {
                "command": "ik",
                "position_m": list(question.position),
                "quaternion_wxyz": list(question.quaternion),
                "taut": None if question.taut is None else list(question.taut),
                "slack_margin": question.slack_margin,
                "settle": question.settle,
                "settle_within_m": question.settle_within,
                "static": question.static,
                "wrench_tolerance": question.wrench_tolerance,
                "external_force_N": list(question.external_force),
            },
            "message": self.message,
            "static": self.is_static,
            "pose": {
                "position_m": list(self.position),
                "rotation": [list(row) for row in self.rotation],
                "quaternion_wxyz": list(self.quaternion),
                "rpy_rad": list(self.rpy),
            },
            "distances_m": list(self.distances),
            "lengths_m": None if self.lengths is None else list(self.lengths),
            "lengths_option": self.lengths_option,
            "tensions_N": list(self.tensions),
            "residual": {"force_N": list(self.residual_force), "moment_N_m": list(self.residual_moment)},
            "settled": None
            if settling is None
            else {
                "succeeded": settling.succeeded,
                "found": settling.found,
                "distance_m": settling.distance,
                "angle_rad": settling.angle,
                "travel_m": settling.travel,
            },
            "outside_tension_limits": list(self.outside_tension_limits),
        }

    def to_json(self) -> str:
        """Return the document as text; ``from_json`` restores every double."""
        from solvers.answers.json_text import dumps

        return dumps(self.to_dict())

    @classmethod
    def from_json(cls, document: str | bytes | Mapping[str, Any]) -> IkResult:
        """Read a ``cdpr-ik-result/1`` document; keys it does not know are ignored.

        Raises
        ------
        InputError
            The text is not JSON, has another format, or a key is missing or of a wrong kind.
        """
        try:
            root = document if isinstance(document, Mapping) else json.loads(document)
            if root["format"] != FORMAT:
                raise InputError(f"ik result.format: must be '{FORMAT}', got {root['format']!r}")
            return _from_dict(root)
        except KeyError as error:
            raise InputError(f"ik result: missing key {error}") from None
        except (TypeError, ValueError, RecursionError) as error:
            raise InputError(f"ik result: not a {FORMAT} document: {error}") from None


def _from_dict(root: Mapping[str, Any]) -> IkResult:
    asked, pose, settled = root["question"], root["pose"], root["settled"]
    rows = [_triple(row) for row in pose["rotation"]]
    return IkResult(
        tool=(root["tool"]["name"], root["tool"]["version"]),
        robot=(root["robot"]["name"], root["robot"]["sha256"]),
        model=root["model"],
        cables=tuple(root["cables"]),
        question=IkQuestion(
            taut=None if asked["taut"] is None else tuple(asked["taut"]),
            slack_margin=asked["slack_margin"],
            settle=asked["settle"],
            settle_within=asked["settle_within_m"],
            static=asked["static"],
            wrench_tolerance=asked["wrench_tolerance"],
            external_force=_triple(asked["external_force_N"]),
            position=_triple(asked["position_m"]),
            quaternion=_quadruple(asked["quaternion_wxyz"]),
        ),
        position=_triple(pose["position_m"]),
        rotation=(rows[0], rows[1], rows[2]),
        quaternion=_quadruple(pose["quaternion_wxyz"]),
        rpy=_triple(pose["rpy_rad"]),
        distances=tuple(root["distances_m"]),
        lengths=None if root["lengths_m"] is None else tuple(root["lengths_m"]),
        tensions=tuple(root["tensions_N"]),
        is_static=root["static"],
        residual_force=_triple(root["residual"]["force_N"]),
        residual_moment=_triple(root["residual"]["moment_N_m"]),
        settling=None
        if settled is None
        else Settling(
            settled["succeeded"],
            settled["found"],
            settled["distance_m"],
            settled["angle_rad"],
            settled["travel_m"],
        ),
        outside_tension_limits=tuple(root["outside_tension_limits"]),
        message=root["message"],
    )


def _triple(values: Any) -> Triple:
    x, y, z = values
    return float(x), float(y), float(z)


def _quadruple(values: Any) -> tuple[float, float, float, float]:
    w, x, y, z = values
    return float(w), float(x), float(y), float(z)
