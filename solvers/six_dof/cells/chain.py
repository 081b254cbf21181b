"""One static pose for each choice of lengths while one cable may be taut or slack: chains of tubes.

Over a box of lengths a chain of tubes is proved (``chain_proof``): the cable's tension goes from nothing to
where its distance is below its lengths, a tube from each density to the next one, until one ends there. Where
that fails one length is halved. Tubes that follow each other have the zero where they meet in common, for one
choice and so for all; the chains of both halves that without the cable's tension, where they meet.

So for each choice there is exactly one static pose on the chains. It moves continuously with the lengths:
two chains share their poses on the face between their boxes as far as both go, and the static one is where
both go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.rotation import rotation_at
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model
from cdpr_interval.mechanics.six_dof.frame import Frame
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from cdpr_interval.mechanics.six_dof.tube import SYMBOLS
from solvers.questions.problem import Problem
from solvers.six_dof.cells.chain_proof import ENDED, FAILED, prove_given
from solvers.six_dof.cells.tube import Tube, around
from solvers.six_dof.cells.tube_prover import forms_of_thread
from solvers.six_dof.cells.tube_search import TERMS

Floats = NDArray[np.float64]

MOST_CUTS = 7
"""How often lengths are halved, one after the other."""
MOST_CHAINS = 48
"""Boxes of lengths tried: a bound of the time."""
MOST_TUBES = 64
"""Tubes of one chain."""
MOST_PARTS = 32
"""Of a chain, by its steps' length."""
PACE = 2.0
"""What a tube's densities turn the platform over what the lengths do: a reach is as wide as its tube."""
FURTHER = 1.1
"""How far a chain goes over the density that is expected at its end."""
SHORTEST = 0.01
"""Shortest tube of a chain over that."""
INSIDE = 1e-9
"""Of a reach, left out of the box in which a zero for the middle of the data is alone."""
LEAST = 1e-6
"""Of a chain's densities, over the largest of the others."""


@dataclass(frozen=True, eq=False)
class Chain:
    """A box of lengths with one static pose for each choice.

    Of each tube the last unknown is the density of the cable that may be taut, and so is its last symbol:
    ``squares`` and ``radii_of_squares`` have it instead of the cable's square of length.
    """

    lengths: Floats
    """(N, 2) in the order of the cables."""
    tubes: tuple[Tube, ...]

    @property
    def parts(self) -> tuple[Chain, ...]:
        """Itself."""
        return (self,)

    def at(self, lengths: Floats) -> Chain:
        """Return the chain for a choice of lengths (N,)."""
        return self

    @property
    def slack(self) -> Tube:
        """The tube of the others' system, the cable slack."""
        first = self.tubes[0]
        polynomial = at_start(first.polynomial)[:-1]
        radii = first.radii[:-1] + 1e-15 * np.abs(first.polynomial[:-1]).sum(axis=1)
        return tube_of(
            first.chart, polynomial, radii, first.reach[:-1], first.squares[:-1], first.radii_of_squares[:-1]
        )


@dataclass(frozen=True, eq=False)
class Chains:
    """Two halves of a box of lengths whose static poses are the same where they meet."""

    halves: tuple[Chain | Chains, Chain | Chains]
    cable: int
    """Whose length was cut, in the order of the cables."""
    cut: float
    """Where, in m."""

    @property
    def parts(self) -> tuple[Chain, ...]:
        """All of its chains."""
        first, second = self.halves
        return (*first.parts, *second.parts)

    def at(self, lengths: Floats) -> Chain:
        """Return the chain for a choice of lengths (N,)."""
        return self.halves[int(lengths[self.cable] > self.cut)].at(lengths)


class ChainProver:
    """Proves one static pose for each choice of lengths, the last of some cables taut or slack."""

    def __init__(self, problem: Problem, cables: tuple[int, ...], chart: int) -> None:
        count = len(problem.robot.cables)
        self.cables, self.chart, self.n = cables, chart, len(cables)
        self.order = (*cables, *(i for i in range(count) if i not in cables))
        self.model = model_of(problem, self.order, self.n)
        self.lengths = np.array([bounds_of(problem, i) for i in self.order])
        self.tried = 0

    def prove(self, z: Floats, lengths: Floats | None = None, depth: int = 0) -> Chain | Chains | None:
        """Prove chains over a box of lengths (N, 2), by default all, from a pose z (6 + n,) near it."""
        lengths = self.lengths if lengths is None else lengths
        self.tried += 1
        found = self.chain(z, lengths)
        if found is not None or depth == MOST_CUTS or self.tried >= MOST_CHAINS:
            return found
        cable = self.cable_to_cut(z, lengths)
        low, high = lengths.copy(), lengths.copy()
        low[cable, 1] = high[cable, 0] = cut = float(lengths[cable].mean())
        halves = []
        for half in (low, high):
            part = self.prove(z, half, depth + 1)
            if part is None:
                return None
            halves.append(part)
        face = lengths.mean(axis=1)
        face[cable] = cut
        first, second = (half.at(face).tubes[0] for half in halves)
        squares = np.array([*(face[: self.n - 1] ** 2), 0.0])
        if not (first.holds(second, squares) or second.holds(first, squares)):
            return None
        return Chains((halves[0], halves[1]), cable, cut)

    def chain(self, z: Floats, lengths: Floats) -> Chain | None:
        """Prove one chain over a box of lengths (N, 2)."""
        start = self.tube(z, lengths, 0.0, 0.0)
        if start is None:
            return None
        fall, fine = self.paces(start[0], lengths)
        tubes: list[Tube] = []
        here, last = 0.0, start[0]
        far = max(self.missing(last, lengths) / fall, LEAST * float(np.abs(last.polynomial[6:, 0]).max()))
        longest = step = min(far, max(fine, far / MOST_PARTS))
        while len(tubes) < MOST_TUBES:
            found = self.tube(last.polynomial[:, 0], lengths, here, here + step)
            if found is None or (tubes and not follows(last, found[0], here)):
                step *= 0.5
                if step < SHORTEST * far:
                    return None
                continue
            last, ends = found
            tubes.append(last)
            if ends:
                return Chain(lengths, (*tubes, *self.beyond(last, lengths, here + step, longest)))
            here += step
            step = min(2.0 * step, longest, max(self.missing(last, lengths) / fall, SHORTEST * far))
        return None

    def beyond(self, last: Tube, lengths: Floats, here: float, step: float) -> list[Tube]:
        """Return a tube behind a chain's end, if there is one: none of its poses is static, cells learn."""
        found = self.tube(last.polynomial[:, 0], lengths, here, here + step)
        return [found[0]] if found is not None and follows(last, found[0], here) else []

    def tube(self, z: Floats, lengths: Floats, first: float, last: float) -> tuple[Tube, bool] | None:
        """Prove one tube, for densities between two; return it and whether its chain ends there."""
        m, n = 6 + self.n, self.n
        polynomial, radii, reach = np.zeros((m, TERMS)), np.empty(m), np.empty(m)
        model, tau = self.own_model(), np.array([first, last])
        at = z.copy()
        result = prove_given(
            forms_of_thread(SYMBOLS), SYMBOLS, model, self.chart, lengths, tau, at, polynomial, radii,
            reach,
        )  # fmt: skip
        if result == FAILED:
            return None
        squares, off = model.lengths_sq[:n].copy(), model.lengths_sq_err[:n].copy()
        squares[-1], off[-1] = 0.5 * first + 0.5 * last, 0.5 * (last - first)
        return tube_of(self.chart, polynomial, radii, reach, squares, off), result == ENDED

    def own_model(self) -> Model:
        """Return the model with lengths of its own, which the proofs write."""
        model = self.model
        arrays = {name: getattr(model, name).copy() for name in ("lengths", "lengths_sq", "lengths_sq_err")}
        return model._replace(**arrays)

    def square(self, z: Floats) -> float:
        """Return the square of the last cable's distance at z (6 + n,), in floats."""
        turned = np.empty((3, 3))
        rotation_at(z[:3], turned)
        k = self.n - 1
        spoke = self.model.exits[k] - z[3:6] - turned @ self.model.arms[self.chart, k]
        return float(spoke @ spoke)

    def slopes(self, tube: Tube) -> Floats:
        """Return how the last cable's square of distance moves with a tube's symbols (n,), in floats."""
        middle, step = tube.polynomial[:, 0], tube.polynomial[:, 1 : 1 + self.n]
        return np.array([0.5 * (self.square(middle + s) - self.square(middle - s)) for s in step.T])

    def paces(self, start: Tube, lengths: Floats) -> tuple[float, float]:
        """Return how the square of the last cable's distance falls with its density, and a step of densities.

        The step turns the platform as much as the lengths do.
        """
        z = start.polynomial[:, 0]
        step = 1e-4 * float(np.abs(z[6:]).max())
        moved = self.tube(z, lengths.mean(axis=1)[:, None] * np.ones(2), 0.0, step)
        if moved is None:
            return np.inf, np.inf
        fall = -2.0 * self.slopes(moved[0])[-1] / step
        turned = np.abs(2.0 * moved[0].polynomial[:3, self.n] / step).max()
        with_lengths = np.abs(start.polynomial[:3, 1 : self.n]).sum(axis=1).max()
        return (fall if fall > 0.0 else np.inf), PACE * with_lengths / turned if turned > 0.0 else np.inf

    def missing(self, tube: Tube, lengths: Floats) -> float:
        """Return by how much the last cable's square of distance may exceed its length's at a tube's end."""
        z = tube.polynomial[:, 0] + tube.polynomial[:, self.n] + tube.polynomial[:, MOST_TAUT + self.n]
        excess = self.square(z) + np.abs(self.slopes(tube)[:-1]).sum() - lengths[self.n - 1, 0] ** 2
        return FURTHER * max(float(excess), 0.0)

    def cable_to_cut(self, z: Floats, lengths: Floats) -> int:
        """Return the cable whose range moves the last one's distance, over its length, most."""
        start = self.tube(
            z, lengths.mean(axis=1)[:, None] + 1e-3 * (lengths - lengths.mean(axis=1)[:, None]), 0.0, 0.0
        )
        own = lengths[self.n - 1, 1] ** 2 - lengths[self.n - 1, 0] ** 2
        if start is None:
            return int(np.argmax((lengths[:, 1] - lengths[:, 0])[: self.n]))
        return int(np.argmax([*np.abs(1e3 * 2.0 * self.slopes(start[0])[:-1]), own]))


def follows(one: Tube, other: Tube, tau: float) -> bool:
    """Return True when two tubes are proved to have the same zero where they meet, at a density."""
    squares = one.squares.copy()
    squares[-1] = tau
    return one.holds(other, squares) or other.holds(one, squares)


def tube_of(
    chart: int, polynomial: Floats, radii: Floats, reach: Floats, squares: Floats, off: Floats
) -> Tube:
    """Return a tube as data."""
    middle = polynomial[:, 0]
    # Of one number the symbol is its rounding, with which the middle moves.
    inner = reach * (1.0 - INSIDE)
    return Tube(
        chart=chart,
        box=around(middle, (np.abs(polynomial[:, 1:]).sum(axis=1) + radii) * (1.0 + 1e-14)),
        unique=np.stack([middle - inner, middle + inner], axis=1),
        core=around(middle, radii),
        squares=squares,
        radii_of_squares=off,
        polynomial=polynomial,
        sways=np.zeros((len(middle), 0)),
        radii=radii,
        reach=reach,
    )


def at_start(polynomial: Floats) -> Floats:
    """Return a polynomial (m, TERMS) of n symbols, m = 6 + n, where the last is -1."""
    k = len(polynomial) - 7
    out = polynomial.copy()
    square, mixed = 1 + MOST_TAUT, {}
    for q, (i, j) in enumerate(zip(*np.triu_indices(MOST_TAUT, 1), strict=True)):
        mixed[i, j] = 1 + 2 * MOST_TAUT + q
    out[:, 0] += out[:, square + k] - out[:, 1 + k]
    for (i, j), q in mixed.items():
        if k in (i, j):
            out[:, 1 + (i if j == k else j)] -= out[:, q]
            out[:, q] = 0.0
    out[:, 1 + k] = out[:, square + k] = 0.0
    return out


def model_of(problem: Problem, order: Sequence[int], n: int) -> Model:
    """Return the arrays of all cables in an order, n of them taut."""
    frame = Frame.plain()
    return build_model(
        [frame.exit_point(problem.loaded.exit_ranges[i]) for i in order],
        [frame.arm(problem.loaded.arm_ranges[i]) for i in order],
        [Range(*problem.lengths[i]) for i in order],
        frame.force(problem.loaded.load_direction_ranges),
        n,
    )


def bounds_of(problem: Problem, i: int) -> tuple[float, float]:
    """Return bounds of a cable's lengths."""
    lo, hi = problem.lengths[i]
    return enclose(lo)[0], enclose(hi)[1]
