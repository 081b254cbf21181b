"""What inverse kinematics returns: distances, lengths and tensions for a pose, in plain floats.

`IkData` is the only description of the file format ``cdpr-ik-result/1``, as `data` is of results. Nothing in
it is certified: put the lengths to forward kinematics for that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from solvers.answers.data import RobotIdentity, Tool
from solvers.answers.fields import Described, Floats, Quadruple, Triple
from solvers.answers.provenance import Provenance

FORMAT = "cdpr-ik-result/1"
ANGLE_DECIMALS = 12
"""Of degrees to paste: 2e-14 rad, about the rounding of a settled pose."""
Rows = tuple[Triple, Triple, Triple]


@dataclass(frozen=True, kw_only=True)
class IkQuestion(Described):
    """What was asked."""

    command: str
    """The command that would ask the same."""
    position: Triple
    """The pose that was given: platform origin in the base frame."""
    quaternion_wxyz: Quadruple
    """The pose that was given: unit quaternion, scalar first, platform to base."""
    taut: tuple[str, ...] | None
    """The cables that may carry tension; null: all."""
    slack_margin: float
    """Every other cable is longer than its distance by this fraction."""
    settle: bool
    """The pose was to be moved to the nearest static pose of the taut cables."""
    settle_within: float | None
    """How far settling may move any point of the platform; null: it was not asked for."""
    static: bool
    """The caller wanted a static pose or nothing."""
    wrench_tolerance: float
    """Residual, as a share of the load's size, of a pose that counts as static."""
    external_force: Triple
    """Constant force at the centre of mass, base axes, added to the weight."""

    @property
    def quaternion(self) -> Quadruple:
        """Unit quaternion (w, x, y, z) of the pose that was given."""
        return self.quaternion_wxyz


@dataclass(frozen=True)
class IkPose(Described):
    """The pose that the result is about: after settling, if that was asked and succeeded."""

    position: Triple
    """Platform origin in the base frame."""
    rotation: Rows
    """Platform to base, row by row; the identity for a point mass."""
    quaternion_wxyz: Quadruple
    """Unit quaternion, scalar first, platform to base."""
    rpy: Triple
    """Roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll)."""


@dataclass(frozen=True)
class Residual(Described):
    """Load and cable forces together."""

    force: Triple
    """Base axes."""
    moment: Triple
    """About the centre of mass, base axes."""


@dataclass(frozen=True)
class Settling(Described):
    """How far the pose was moved to become static, or how far away the static pose is that was found."""

    succeeded: bool
    """False: the result is about the pose that was asked for, and has no lengths."""
    found: bool
    """A static pose was found, near enough or not; False: what follows is about the best pose."""
    distance: float
    """Translation of the centre of mass."""
    angle: float
    """Rotation."""
    travel: float
    """Way of the point of the platform that moves most: an anchor or the centre of mass."""


@dataclass(frozen=True, kw_only=True, repr=False)
class IkData(Described):
    """Distances, lengths and tensions at one pose, file order; plain floats, nothing is certified."""

    tool: Tool
    """The program that wrote it."""
    robot: RobotIdentity
    """Which robot it is about."""
    model: str
    """The class of the robot: point-mass or six-dof."""
    cables: tuple[str, ...]
    """Names, file order: the order of all lists of cables."""
    question: IkQuestion
    """What was asked, beside the robot."""
    message: str
    """One sentence."""
    static: bool
    """The residual is within the tolerance."""
    pose: IkPose
    """Of what follows."""
    distances: Floats
    """From each exit point to its platform anchor, ||A_i - p - R B_i||."""
    lengths: Floats | None
    """Cable lengths that give this pose, unstretched for elastic cables; null where an elastic cable needs
    a tension and the pose is not static, and where settling did not succeed."""
    lengths_option: str | None
    """The lengths as ``--lengths`` takes them, each restoring its double."""
    tensions: Floats
    """The non-negative tensions of least norm, or the best fit where the pose is not static; of
    legs the forces of any sign, negative where a leg pushes."""
    residual: Residual
    """What of the load the cables leave."""
    settled: Settling | None
    """How far the pose was moved; null: that was not asked for."""
    outside_tension_limits: tuple[str, ...]
    """Cables whose tension is outside their ``tension_limits_N``; reported, never a filter."""
    outside_length_limits: tuple[str, ...] = ()
    """Legs whose length is outside their ``length_limits_m``; reported, never a filter; absent for none."""
    provenance: Provenance | None = field(default=None, compare=False)
    """Where the result comes from; left out of results written before there was one."""

    @property
    def position(self) -> Triple:
        """Platform origin in the base frame, m: after settling, if that was asked."""
        return self.pose.position

    @property
    def rotation(self) -> Rows:
        """Platform to base."""
        return self.pose.rotation

    @property
    def quaternion(self) -> Quadruple:
        """Unit quaternion (w, x, y, z), platform to base."""
        return self.pose.quaternion_wxyz

    @property
    def rpy(self) -> Triple:
        """Roll, pitch, yaw, rad."""
        return self.pose.rpy

    @property
    def is_static(self) -> bool:
        """True when the residual is within the tolerance."""
        return self.static

    @property
    def residual_force(self) -> Triple:
        """Load and cable forces together, N."""
        return self.residual.force

    @property
    def residual_moment(self) -> Triple:
        """About the centre of mass, N m."""
        return self.residual.moment

    @property
    def settling(self) -> Settling | None:
        """How far the pose was moved."""
        return self.settled

    @property
    def pose_option(self) -> str:
        """The pose as ``--pose`` takes it, angles in degrees; a point mass has none."""
        angles = () if self.model == "point-mass" else self.rpy
        degrees = (round(math.degrees(angle), ANGLE_DECIMALS) + 0.0 for angle in angles)
        return ",".join([*map(repr, self.position), *(f"{angle!r}deg" for angle in degrees)])


def lengths_option(lengths: tuple[float, ...] | None) -> str | None:
    """Return lengths as ``--lengths`` takes them, each restoring its double."""
    return None if lengths is None else ",".join(repr(length) for length in lengths)
