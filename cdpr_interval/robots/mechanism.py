"""A mechanism: bodies and the joints between them, with points and axes where known; exact numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.vector import Vector
from cdpr_interval.text.count import counted

FORMAT = "mechanism/1"
FREEDOMS = {"R": 1, "P": 1, "C": 2, "U": 2, "S": 3}
"""Of revolute, prismatic, cylindrical, universal and spherical joints."""
AXES = {"R": 1, "P": 1, "C": 1, "U": 2, "S": 0}
"""How many axes each kind of joint has."""


@dataclass(frozen=True)
class Joint:
    """A joint between two bodies."""

    name: str
    kind: str
    """R, P, C, U or S."""
    bodies: tuple[str, str]
    point: Vector | None = None
    """On the axes, or the centre of a sphere, m."""
    axes: tuple[Vector, ...] = ()
    """Of any length but zero."""

    @property
    def freedoms(self) -> int:
        """How many motions it leaves free."""
        return FREEDOMS[self.kind]

    @property
    def is_placed(self) -> bool:
        """True where what its motions are is known."""
        return len(self.axes) == AXES[self.kind] and (self.kind == "P" or self.point is not None)


@dataclass(frozen=True)
class Mechanism:
    """Bodies and joints; every body is connected to the base.

    Raises
    ------
    InputError
        With one message per rule that is broken.
    """

    name: str
    bodies: tuple[str, ...]
    joints: tuple[Joint, ...]
    base: str
    """The body that stands still."""
    platform: str | None = None
    """The body whose freedoms are asked for."""
    source: str | None = None
    notes: str | None = None

    def __post_init__(self) -> None:
        """Refuse what is no mechanism."""
        if broken := [f"{path}: {text}" for path, text in complaints(self)]:
            raise InputError(*broken)

    @property
    def is_placed(self) -> bool:
        """True where points and axes of all joints are given."""
        return all(joint.is_placed for joint in self.joints)


def complaints(mechanism: Any) -> Iterator[tuple[str, str]]:
    """Yield the rules that a mechanism, or anything with its fields, breaks: pairs of a path and a text."""
    bodies = mechanism.bodies
    for body in sorted({b for b in bodies if bodies.count(b) > 1}):
        yield "bodies", f"{body!r} is there twice"
    for key in ("base", "platform"):
        body = getattr(mechanism, key)
        if body is not None and body not in bodies:
            yield key, f"{body!r} is no body"
    if mechanism.platform is not None and mechanism.platform == mechanism.base:
        yield "platform", "must not be the base"
    names = [joint.name for joint in mechanism.joints]
    for k, joint in enumerate(mechanism.joints):
        yield from ((f"joints[{k}]{key}", text) for key, text in _of_joint(joint, bodies))
        if joint.name in names[:k]:
            yield (
                f"joints[{k}].name",
                f"{joint.name!r} is the name of joints[{names.index(joint.name)}] already",
            )
    if set(bodies) >= {b for joint in mechanism.joints for b in joint.bodies} and mechanism.base in bodies:
        loose = sorted(set(bodies) - connected(mechanism))
        if loose:
            yield "bodies", f"not connected to {mechanism.base!r}: {', '.join(loose)}"


def _of_joint(joint: Any, bodies: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    if joint.kind not in FREEDOMS:
        yield ".kind", f"must be one of {', '.join(FREEDOMS)}, got {joint.kind!r}"
        return
    for i, body in enumerate(joint.bodies):
        if body not in bodies:
            yield f".bodies[{i}]", f"{body!r} is no body"
    if joint.bodies[0] == joint.bodies[1]:
        yield ".bodies", "must be two different bodies"
    if joint.axes and len(joint.axes) != AXES[joint.kind]:
        yield ".axes", f"{joint.kind} has {counted(AXES[joint.kind], 'axis', 'axes')}, got {len(joint.axes)}"
    for i, axis in enumerate(joint.axes):
        if not any(axis):
            yield f".axes[{i}]", "must not be the zero vector"
    if joint.kind == "U" and len(joint.axes) == 2 and _are_parallel(*joint.axes):
        yield ".axes", "the two axes of a universal joint must not be parallel"


def _are_parallel(a: Vector, b: Vector) -> bool:
    return all(a[i] * b[j] == a[j] * b[i] for i, j in ((0, 1), (1, 2), (2, 0)))


def connected(mechanism: Any) -> set[str]:
    """Return the bodies that joints connect to the base, the base too."""
    found, waiting = {mechanism.base}, [mechanism.base]
    while waiting:
        body = waiting.pop()
        for joint in mechanism.joints:
            if body in joint.bodies:
                for other in set(joint.bodies) - found:
                    found.add(other)
                    waiting.append(other)
    return found
