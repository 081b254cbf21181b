"""A forward-kinematics question as exact fractions, and its text as a robot file and a command."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Context, Decimal
from fractions import Fraction

Vector = tuple[Fraction, Fraction, Fraction]
Range = tuple[Fraction, Fraction]
ORIGIN: Vector = (Fraction(0), Fraction(0), Fraction(0))
DOWN: Vector = (Fraction(0), Fraction(0), Fraction("-9.81"))


def decimal_text(x: Fraction) -> str:
    """Return a fraction whose denominator divides a power of ten as its decimal literal."""
    value = Context(prec=400).divide(Decimal(x.numerator), Decimal(x.denominator))
    if Fraction(value) != x:
        raise ValueError(f"{x} is not a finite decimal")
    return format(value, "f")


def vector_text(v: Sequence[Fraction]) -> str:
    return "[" + ", ".join(decimal_text(x) for x in v) + "]"


@dataclass(frozen=True)
class Case:
    """A robot and one question about it; every number is a finite decimal."""

    name: str
    exits: tuple[Vector, ...]
    points: tuple[Vector, ...]
    """Platform anchors, platform frame."""
    lengths: tuple[Range, ...]
    mass: Fraction = Fraction(1)
    centre: Vector = ORIGIN
    """Centre of mass, platform frame."""
    gravity: Vector = DOWN
    force: Vector = ORIGIN
    stiffness: tuple[Fraction, ...] | None = None
    """N/m, for elastic cables."""
    taut: tuple[int, ...] | None = None
    """The one subset asked for."""
    ignore_slack: bool = False

    @property
    def count(self) -> int:
        """Number of cables."""
        return len(self.exits)

    @property
    def point_mass(self) -> bool:
        """True where every platform anchor is the centre of mass."""
        return all(b == self.centre for b in self.points)

    @property
    def exact(self) -> bool:
        """True where no length is a range."""
        return all(lo == hi for lo, hi in self.lengths)

    @property
    def load(self) -> Vector:
        """Weight and external force."""
        x, y, z = (self.mass * g + f for g, f in zip(self.gravity, self.force, strict=True))
        return x, y, z

    def at(self, lengths: Sequence[Fraction]) -> Case:
        """Return the same question for one choice of lengths."""
        return replace(self, lengths=tuple((x, x) for x in lengths))

    def robot_yaml(self) -> str:
        """Return the robot as a ``cdpr-robot/1`` file."""
        lines = [
            "format: cdpr-robot/1",
            f"name: {self.name}",
            f"gravity_m_s2: {vector_text(self.gravity)}",
            f"platform: {{mass_kg: {decimal_text(self.mass)}, centre_of_mass_m: {vector_text(self.centre)}}}",
            "cables:",
        ]
        for i, (a, b) in enumerate(zip(self.exits, self.points, strict=True)):
            line = f"name: c{i + 1}, frame_anchor_m: {vector_text(a)}, platform_anchor_m: {vector_text(b)}"
            if self.stiffness is not None:
                line += f", elasticity: {{stiffness_N_per_m: {decimal_text(self.stiffness[i])}}}"
            lines.append(f"  - {{{line}}}")
        return "\n".join(lines) + "\n"

    def length_texts(self) -> list[str]:
        """Return the lengths as ``--lengths`` takes them."""
        return [
            decimal_text(a) if a == b else f"{decimal_text(a)}..{decimal_text(b)}" for a, b in self.lengths
        ]

    def command(self, path: str) -> str:
        """Return the command that asks this question about a robot file."""
        words = ["cdpr-solve", "fk", path, "--lengths", ",".join(self.length_texts())]
        if self.taut is not None:
            words += ["--taut", ",".join(f"c{i + 1}" for i in self.taut)]
        if self.ignore_slack:
            words.append("--ignore-slack")
        if any(self.force):
            words.append("--external-force=" + ",".join(decimal_text(x) for x in self.force))
        return shlex.join(words)
