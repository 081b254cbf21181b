"""What is known of a cable's length: a reading at which it was known, and how the drum turned since."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import cached_property

from cdpr_interval.driver.winch import WinchModel
from cdpr_interval.exact.range import Range

ZERO = Fraction(0)


class ReferenceState(StrEnum):
    """How far a cable's length can be believed; automatic motion needs REFERENCED."""

    UNREFERENCED = "unreferenced"
    """Nobody has said yet how long the cable is."""
    REFERENCED = "referenced"
    """The length lies in a range that follows from the data of the file."""
    DEGRADED = "degraded"
    """A mark contradicted that range: cable slipped, wrong layer, a mark missed or seen twice."""


@dataclass(frozen=True)
class Budget:
    """Where the uncertainty of a length comes from: half widths in m."""

    reference: Fraction
    """Of the length at the reference: tolerance of the mark, its detection, or of the home pose."""
    drum: Fraction
    """Grows with the distance from the reference: tolerance of radius, pitch, layers, table."""
    encoder: Fraction
    """Resolution and error of the two readings."""

    @property
    def total(self) -> Fraction:
        """Half the width of the length's range in m."""
        return self.reference + self.drum + self.encoder


@dataclass(frozen=True)
class Reference:
    """A reading at which the length was known to a range; lengths at other readings follow."""

    model: WinchModel
    counts: int
    """The reading, unwrapped."""
    length: Range
    """m, unstrained, from the exit point A to the cable's end."""
    source: str
    """``home``, or the name of a mark."""

    @cached_property
    def offset(self) -> Fraction:
        """Return what is added to the model's nominal length, in m."""
        return self.length.mid - self.model.length(self.counts)

    def length_range(self, counts: int) -> Range:
        """Return bounds of the length in m at a reading.

        Guarantee
        ---------
        Encloses the true unstrained length when the length at the reference was in its range, the cable
        has not slipped on the drum since, and drum and encoder keep to the tolerances of the robot file.
        """
        return self.length + self.model.span(self.counts, counts)

    def nominal(self, counts: int | Fraction) -> Fraction:
        """Return the most likely length in m at a reading."""
        return self.model.length(counts) + self.offset

    def budget(self, counts: int) -> Budget:
        """Return the uncertainty of the length at a reading, part by part."""
        travel = self.model.span(self.counts, counts)
        turns = (Range(place, place) for place in (self.model.turns(self.counts), self.model.turns(counts)))
        drum = self.model.law.span(*turns).width / 2
        return Budget(self.length.width / 2, drum, travel.width / 2 - drum)


@dataclass(frozen=True)
class Known:
    """What a run leaves to the next one about a cable."""

    reference: Reference
    state: ReferenceState
    reading: int
    """Of the encoder at the end, unwrapped: a drive that shows another one has lost its position."""


def home(model: WinchModel, counts: int, length: Range) -> Reference:
    """Return the reference of a cable whose length was measured or set by hand at a reading.

    The place on the drum is taken from the length too, which matters for drums whose law is not one line.
    """
    return Reference(model.placed(counts, length.mid), counts, length, "home")
