"""Numbers with their derivatives by some unknowns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Jet:
    """A number of any kind and its derivatives; those that are missing are 0."""

    value: Any
    slopes: dict[int, Any]

    def __add__(self, other: Any) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.slopes)
        both = self.slopes.keys() & other.slopes.keys()
        slopes = self.slopes | other.slopes | {k: self.slopes[k] + other.slopes[k] for k in both}
        return Jet(self.value + other.value, slopes)

    def __mul__(self, other: Any) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value * other, {k: v * other for k, v in self.slopes.items()})
        first = Jet(self.value * other.value, {k: v * other.value for k, v in self.slopes.items()})
        return first + Jet(0, {k: self.value * v for k, v in other.slopes.items()})

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Jet:
        return self * -1

    def inverse(self) -> Jet:
        """Return 1 / self."""
        value = 1 / self.value
        return Jet(value, {k: -v * value * value for k, v in self.slopes.items()})

    def root(self) -> Jet:
        """Return the square root of a positive number."""
        value = self.value.sqrt()
        return Jet(value, {k: v / (2 * value) for k, v in self.slopes.items()})

    def __sub__(self, other: Any) -> Jet:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Jet:
        return self.__neg__().__add__(other)
