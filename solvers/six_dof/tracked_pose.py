"""What a tracker answers: one light object, its parts made when they are asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial

from cdpr_interval.errors import CdprError
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.orientation import (
    Quaternion,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from cdpr_interval.mechanics.six_dof.fields import STABLE, UNSTABLE, Fields
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import CableState
from solvers.six_dof.estimate import Estimate


class TrackStatus(StrEnum):
    """What is proved for all lengths in their ranges."""

    TRACKED = "tracked"
    """The bounds enclose the pose, and it is proved which one that is."""
    LOST = "lost-track"
    """That could not be proved; ``reason`` says why."""


@dataclass(frozen=True, slots=True)
class Region:
    """The poses about which a tracker's answer speaks.

    All poses whose centre of mass lies within ``radius`` of the reference's centre, and whose rotation
    differs from the reference's by a turn of at most ``angle``.

    Attributes
    ----------
    centre : (x, y, z)
        The reference's centre of mass in m, base frame, these very doubles.
    quaternion : (w, x, y, z)
        The reference's rotation: that of these very doubles, divided by their norm.
    radius : float
        m.
    angle : float
        rad.
    """

    centre: tuple[float, float, float]
    quaternion: Quaternion
    radius: float
    angle: float


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class TrackedPose:
    """The static pose near the last one, as `Tracker.update` returns it.

    Bounds are float64 arrays whose last axis is (lo, hi). Where track is lost nothing is known: asking for a
    bound, the taut cables or the region raises `CdprError`, and ``estimate`` has plain floats instead.

    Attributes
    ----------
    status : TrackStatus
        TRACKED or LOST.
    reason : str
        Empty with TRACKED; else one sentence: which step of the proof failed, and on which cable it hangs.
    tried : Region or None
        The region tried last, also where track is lost; None where the pose was followed, or none was tracked
        before.
    pieces : int
        In how many pieces the way to these lengths was proved; 0 where the pose is the only one in
        ``region``.
    switching : tuple of int
        Cables that became taut or slack on that way; one whose state is ``switching`` still is taut for some
        of these lengths and slack for others.

    Guarantee
    ---------
    With status TRACKED the bounds enclose a static pose for every choice of lengths in their ranges; the
    cables in ``taut`` carry tension, those whose state is ``slack`` are nearer than their lengths, and one
    whose state is ``switching`` is either. Which pose that is:

    * with a ``region`` the only one in it, whatever cables are taut;
    * without, the one that the last pose becomes while the lengths go straight, at any pace, from any choice
      of the last lengths to any choice of these. On that way the cables in ``switching`` change. After a
      start, the last pose is the one next to the start's numbers: with its taut cables as long as they are
      there, and slack ones long enough.

    With LOST nothing is claimed.
    """

    status: TrackStatus
    reason: str
    tried: Region | None
    _taut: tuple[int, ...]
    """With LOST those of the last pose tracked."""
    fields: Fields | None
    """Of the one pose, as kernels compute them; None with LOST."""
    _guess: Callable[[], Estimate] | None = field(default=None, compare=False)
    """Computes the estimate: it takes a millisecond, which only those wait for who ask."""
    pieces: int = 0
    switching: tuple[int, ...] = ()

    def __repr__(self) -> str:
        if not self.tracked:
            return f"<TrackedPose {self.status}: {self.reason}>"
        place = ", ".join(f"{x:.6g}" for x in self.point)
        return f"<TrackedPose {self.status}: ({place}) m, taut {self.taut}, {self.stability}>"

    def __reduce__(self) -> tuple[object, ...]:
        """Take the estimate along to another process; the tracker that computes it stays."""
        guess = None if self._guess is None else partial(_known_estimate, self._guess())
        return TrackedPose, (
            self.status,
            self.reason,
            self.tried,
            self._taut,
            self.fields,
            guess,
            self.pieces,
            self.switching,
        )

    @property
    def proved(self) -> bool:
        """The same as ``tracked``, in the word of all classes of robots."""
        return self.tracked

    @property
    def tracked(self) -> bool:
        """True when the pose is proved, and lies in the bounds."""
        return self.status is TrackStatus.TRACKED

    @property
    def region(self) -> Region | None:
        """The poses among which this is the only one; None where it was followed, and others may be near."""
        self._known()
        return self.tried

    @property
    def taut(self) -> tuple[int, ...]:
        """The cables that carry, file order."""
        self._known()
        return self._taut

    @property
    def position(self) -> Bounds:
        """(3, 2) m: platform origin in the base frame."""
        return self._known().position[0]

    @property
    def rotation(self) -> Bounds:
        """(3, 3, 2): platform to base."""
        return self._known().rotation[0]

    @property
    def height(self) -> Bounds:
        """(2,) m: of the centre of mass, along up."""
        return self._known().height[0]

    @property
    def tensions(self) -> Bounds:
        """(N, 2) N, file order; [0, 0] for a slack cable."""
        return self._known().tensions[0]

    @property
    def distances(self) -> Bounds:
        """(N, 2) m: from the exit points to the platform's points."""
        return self._known().distances[0]

    @property
    def stability(self) -> Stability:
        """Whether the pose is a strict minimum of the potential energy."""
        verdict = self._known().verdicts[0]
        if verdict == STABLE:
            return Stability.STABLE
        return Stability.UNSTABLE if verdict == UNSTABLE else Stability.UNDECIDED

    @property
    def states(self) -> tuple[CableState, ...]:
        """What is proved about each cable, file order."""
        count = self._known().tensions.shape[1]
        tensions = self._known().tensions[0]
        return tuple([self._state(i, float(tensions[i, 1])) for i in range(count)])

    def _state(self, cable: int, most: float) -> CableState:
        if cable in self._taut:
            return CableState.TAUT
        return CableState.SWITCHING if cable in self.switching and most > 0.0 else CableState.SLACK

    @property
    def point(self) -> tuple[float, float, float]:
        """Middle of ``position`` in m; plain floats, not certified."""
        (xlo, xhi), (ylo, yhi), (zlo, zhi) = self.position.tolist()
        return 0.5 * xlo + 0.5 * xhi, 0.5 * ylo + 0.5 * yhi, 0.5 * zlo + 0.5 * zhi

    @property
    def quaternion(self) -> Quaternion:
        """Unit quaternion (w, x, y, z) near the rotation; plain floats, not certified."""
        return quaternion_from_rotation(self.rotation.mean(axis=-1))

    @property
    def estimate(self) -> Estimate | None:
        """Where the platform may be, in plain floats, **not certified**; also where track is lost.

        With TRACKED the middle of the bounds. With LOST what Newton's method finds from the last pose,
        tracked or estimated, which takes one or a few milliseconds when it is asked for. None where no pose
        was ever known, and of a lost pose over pulleys or on elastic cables.
        """
        if self.fields is None:
            return None if self._guess is None else self._guess()
        rotation = rotation_from_quaternion(self.quaternion)
        tensions = self.tensions.mean(axis=-1)
        return Estimate(True, 0.0, self.taut, self.point, rotation, tensions)

    def _known(self) -> Fields:
        """Return the fields, or say that there are none."""
        if self.fields is None:
            raise CdprError(f"no pose is proved: {self.reason}")
        return self.fields


def _known_estimate(found: Estimate) -> Estimate:
    return found
