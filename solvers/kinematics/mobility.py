"""The degrees of freedom of a mechanism, by Gruebler's count and by the rank of its loops."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from cdpr_interval.mechanics.mobility import Count, Freedom, count, freedom
from cdpr_interval.robots.formats.mechanism_reader import load_mechanism
from cdpr_interval.robots.mechanism import Mechanism
from cdpr_interval.text.count import counted
from solvers.answers.json_text import dumps

FORMAT = "cdpr-mobility-result/1"


@dataclass(frozen=True)
class Mobility:
    """What is known about the freedoms of a mechanism; ``print(found)`` shows it."""

    mechanism: Mechanism
    count: Count
    freedom: Freedom | None
    """None where points and axes are not given for all joints."""

    def __repr__(self) -> str:
        by_rank = "" if self.freedom is None else f", {self.freedom.mobility} by rank"
        return f"<Mobility {self.mechanism.name}: {self.count.mobility} by count{by_rank}>"

    def __str__(self) -> str:
        """Return the lines that the command line prints."""
        return "\n".join(_lines(self))

    def to_dict(self) -> dict[str, Any]:
        """Return the ``cdpr-mobility-result/1`` document."""
        of, free, joints = self.count, self.freedom, self.mechanism.joints
        return {
            "format": FORMAT,
            "mechanism": self.mechanism.name,
            "bodies": of.bodies,
            "joints": of.joints,
            "freedoms": of.freedoms,
            "loops": [
                {"bodies": list(loop.bodies), "joints": [joints[k].name for k, _ in loop.steps]}
                for loop in of.loops
            ],
            "gruebler": of.mobility,
            "rank": None if free is None else free.rank,
            "mobility": None if free is None else free.mobility,
            "redundant_constraints": None if free is None else free.redundant,
            "platform": self.mechanism.platform,
            "platform_freedoms": None if free is None else free.platform,
            "idle_freedoms": None if free is None else free.idle,
            "idle_joints": [] if free is None else list(free.idle_joints),
        }

    def to_json(self) -> str:
        """Return the document as text."""
        return dumps(self.to_dict())


def mobility(mechanism: Mechanism | str | os.PathLike[str]) -> Mobility:
    """Return the degrees of freedom of a mechanism.

    Parameters
    ----------
    mechanism : Mechanism, str or PathLike
        Itself, its file (``mechanism/1``), or the name of one that ships.

    Returns
    -------
    Mobility
        Gruebler's count; where points and axes of all joints are given, also the rank of the rows of all
        loops, in exact rationals: it tells over-constraint and idle spins from freedoms of the platform, at
        that pose.

    Raises
    ------
    InputError
        With one line per error of the file.

    Examples
    --------
    >>> mobility("delta_12_balls")
    <Mobility delta-12-balls: 9 by count, 9 by rank>
    >>> mobility("delta_12_balls").freedom.platform
    3
    """
    given = mechanism if isinstance(mechanism, Mechanism) else load_mechanism(mechanism)
    return Mobility(given, count(given), freedom(given) if given.is_placed else None)


def _lines(found: Mobility) -> Iterator[str]:
    of, free = found.count, found.freedom
    yield (
        f"{found.mechanism.name}: {counted(of.bodies, 'body', 'bodies')} with the base,"
        f" {counted(of.joints, 'joint')}, {of.freedoms} freedoms, {counted(len(of.loops), 'loop')}"
    )
    for loop in of.loops:
        names = [found.mechanism.joints[k].name for k, _ in loop.steps]
        parts = [f"{body} -{name}- " for body, name in zip(loop.bodies, names, strict=True)]
        yield f"  loop  {''.join(parts)}{loop.bodies[0]}"
    n, k, b = of.bodies, of.joints, len(of.loops)
    yield f"  Gruebler     {of.freedoms} - 6 * {b} = 6 ({n} - {k} - 1) + {of.freedoms} = {of.mobility}"
    if free is None:
        yield "  rank         not asked for: points and axes are not given for all joints"
        return
    here = f"{of.freedoms} - {free.rank} = {counted(free.mobility, 'freedom')} here"
    yield f"  rank         {free.rank} of {6 * b} rows, so {here}"
    if free.redundant:
        yield f"  redundant    {counted(free.redundant, 'constraint')} more than needed: over-constrained"
    if free.platform is not None:
        yield f"  platform     {counted(free.platform, 'freedom')} of {found.mechanism.platform}"
        idle = f" (in {', '.join(free.idle_joints)})" if free.idle else ""
        yield f"  idle         {free.idle}{idle}"
