"""The robots of Paty et al. 2021, and the pose each takes for the cable lengths of the simple model.

Three cables at a time carry the load, as in the paper. The simple model (fixed exit points, no stretch)
gives their lengths for a target; the pose is where the whole cables, over their pulleys and stretched, have
the tensions that hold the load: for each cable of the set

    L_i(X) = l_i (1 + t_i / EA),    sum t_i a_i = f,

L_i and a_i being length and direction as `cdpr_interval.mechanics.cables.way_at` has them. Plain floats:
nothing here is proved.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.range import Range
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.route_rows import route_rows
from cdpr_interval.mechanics.cables.way_at import way_at
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from cdpr_interval.robots.numbers import exact
from cdpr_interval.robots.pulley import BISECTOR, EXACT, Pulley

Floats = NDArray[np.float64]
SIDE = HEIGHT = 5.0
"""m, section 3.2."""
MASS, GRAVITY, DIAMETER = Fraction(300), Fraction("9.81"), 0.004
"""kg, m/s2, m: table 1; the paper does not print its gravity."""
MODULUS, MODULUS_LEAST, MODULUS_MOST = 102.2e9, 67.2e9, 137.2e9
"""Pa: table 1, and the ends of section 5."""
TENSION_LIMIT = 5140.0
"""N, table 1."""
LEAD_IN = Fraction(5)
"""m from the winch's exit C up to A: the paper does not print it; here C is on the floor."""
NONE = Fraction(0)
ORIGIN = (NONE, NONE, NONE)
STEPS = 60
"""Of Newton's method, most."""
LONGEST_STEP, LAST_STEP = 0.25, 1e-12
"""m."""
NO_SET = -1


@dataclass(frozen=True)
class Design:
    """A robot of the paper."""

    cables: int
    """3: on an equilateral triangle; 4: on a square."""
    joints: int
    """Of each pulley; 0: fixed exit points."""
    arm: Fraction = Fraction("0.1")
    """h, m."""
    radius: Fraction = Fraction("0.0665")
    """r_p, m."""
    lead_in: Fraction = LEAD_IN

    @property
    def name(self) -> str:
        """Return what the paper calls it."""
        return f"CDPR{self.cables}{('', '_SR', '_DR')[self.joints]}"


def corners(cables: int) -> Floats:
    """Return the points A_i (cables, 3), m."""
    half, inner = SIDE / 2, SIDE / math.sqrt(12)
    flat = [(-half, -half), (half, -half), (half, half), (-half, half)]
    if cables == 3:
        flat = [(-half, -inner), (half, -inner), (0.0, 2 * inner)]
    return np.array([(x, y, HEIGHT) for x, y in flat])


def axial_stiffness(modulus: float) -> Fraction:
    """Return EA in N: the full section of the cable."""
    return Fraction(modulus * math.pi * DIAMETER**2 / 4)


def robot(design: Design, modulus: float | tuple[float, float] | None = MODULUS) -> Robot:
    """Return a robot of the paper; ``modulus`` is E in Pa, two for a range, None for no stretch."""
    spring = None
    if isinstance(modulus, tuple):
        spring = Elasticity(axial_stiffness=Range(*map(axial_stiffness, modulus)))
    elif modulus is not None:
        spring = Elasticity(axial_stiffness=axial_stiffness(modulus))
    cables = []
    for i, corner in enumerate(corners(design.cables)):
        x, y, z = map(Fraction, corner)
        cables.append(Cable(f"c{i + 1}", (x, y, z), ORIGIN, spring, pulley=pulley(design)))
    return Robot(design.name, Platform(MASS), tuple(cables), gravity=(NONE, NONE, -GRAVITY))


def pulley(design: Design) -> Pulley:
    """Return the pulley of a design; the arm of two joints lies on the bisector, as in the paper."""
    if design.joints == 0:
        return Pulley(NONE, lead_in=design.lead_in)
    balance = BISECTOR if design.joints == 2 else EXACT
    return Pulley(design.radius, design.arm, design.joints, lead_in=design.lead_in, balance=balance)


@kernel()
def solve(routes: Any, cables: Any, lengths: Any, load: Any, compliance: float, x: Any, t: Any) -> bool:
    """Move x (3,) to the pose that three cables hold, write their tensions t (3,); say whether it is found.

    Newton's method in x, the tensions being those that balance the load (3,) in x; ``lengths`` (N,) are
    without stretch, ``compliance`` is 1/EA. Where the direction is not quite a gradient steps are not quite
    Newton's.
    """
    a, turning = np.empty((3, 3)), np.empty((3, 3, 3))
    system, longer = np.empty((3, 7)), np.empty(3)
    for _ in range(STEPS):
        for i in range(3):
            longer[i] = way_at(routes[cables[i]], x, a[i], turning[i])
        # Columns: the load, then the derivatives of the forces by x, whose solutions are t and -dt/dx.
        for j in range(3):
            for i in range(3):
                system[j, i] = a[i, j]
            system[j, 3] = load[j]
        if not solve_in_place(system, 3, 1):
            return False
        for i in range(3):
            t[i] = system[i, 3]
        for j in range(3):
            for i in range(3):
                system[j, i] = a[i, j]
                system[j, 3 + i] = 0.0
                for k in range(3):
                    system[j, 3 + i] += t[k] * turning[k, j, i]
        if not solve_in_place(system, 3, 3):
            return False
        for i in range(3):
            stretch = compliance * lengths[cables[i]]
            for j in range(3):
                turning[0, i, j] = a[i, j] + stretch * system[i, 3 + j]
            turning[1, i, 0] = lengths[cables[i]] + stretch * t[i] - longer[i]
        for i in range(3):
            for j in range(3):
                system[i, j] = turning[0, i, j]
            system[i, 3] = turning[1, i, 0]
        if not solve_in_place(system, 3, 1):
            return False
        step = 0.0
        for j in range(3):
            step = max(step, abs(system[j, 3]))
        if not step < math.inf:
            return False
        share = min(1.0, LONGEST_STEP / max(step, 1e-300))
        for j in range(3):
            x[j] += share * system[j, 3]
        if step < LAST_STEP:
            return True
    return False


@entry()
def measure(routes: Any, targets: Any, lengths: Any) -> None:
    """Write the lengths (T, N) of the ways of all cables to each target (T, 3), m."""
    direction, turning = np.empty(3), np.empty((3, 3))
    for k in range(len(targets)):
        for i in range(len(routes)):
            lengths[k, i] = way_at(routes[i], targets[k], direction, turning)


@entry()
def solve_all(
    routes: Any, sets: Any, lengths: Any, load: Any, compliance: float, targets: Any,
    poses: Any, tensions: Any, chosen: Any,
) -> None:  # fmt: skip
    """Write pose (T, 3), tensions (T, 3) and set of cables (T,) for each target (T, 3), m and N.

    Of the sets (S, 3) without a negative tension at their pose the one with the least distance from the
    target; none: `NO_SET`, and the pose is not a number. ``lengths`` (T, N) are those of the simple model.
    """
    x, t = np.empty(3), np.empty(3)
    for k in range(len(targets)):
        chosen[k] = NO_SET
        least = math.inf
        for j in range(3):
            poses[k, j] = tensions[k, j] = math.nan
        for s in range(len(sets)):
            for j in range(3):
                x[j] = targets[k, j]
            if not solve(routes, sets[s], lengths[k], load, compliance, x, t):
                continue
            error = 0.0
            for j in range(3):
                error += (x[j] - targets[k, j]) ** 2
            if error < least and min(t[0], t[1], t[2]) >= 0.0:
                least = error
                chosen[k] = s
                for j in range(3):
                    poses[k, j], tensions[k, j] = x[j], t[j]


@dataclass(frozen=True)
class Poses:
    """What the robot does for some targets; rows of what no set of cables can do are not numbers."""

    targets: Floats
    """(T, 3), m."""
    position: Floats
    """(T, 3), m."""
    tensions: Floats
    """(T, 3), N, of the chosen set."""
    chosen: NDArray[np.int64]
    """(T,): the number of the chosen set in `sets_of_three`, or `NO_SET`."""

    @property
    def error(self) -> Floats:
        """Return the distances (T,) from the targets, m."""
        return np.asarray(np.linalg.norm(self.position - self.targets, axis=1))

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Return which targets (T,) have a pose."""
        return np.asarray(self.chosen != NO_SET)

    @property
    def within(self) -> NDArray[np.bool_]:
        """Return which targets (T,) have a pose whose tensions are within the paper's limit."""
        return np.asarray(self.valid & (self.tensions <= TENSION_LIMIT).all(axis=1))


def sets_of_three(cables: int) -> NDArray[np.int64]:
    """Return the sets of three cables (S, 3), numbered from 0."""
    return np.array(list(itertools.combinations(range(cables), 3)), np.int64)


def simple_lengths(whole: Robot, targets: Floats) -> Floats:
    """Return the lengths (T, N) of the simple model: fixed exit points, the dead length included, m."""
    bare = whole.replace(cables=tuple(cable.replace(pulley=without_radius(cable)) for cable in whole.cables))
    lengths = np.empty((len(targets), len(bare.cables)))
    measure(routes(bare), targets, lengths)
    return lengths


def without_radius(cable: Cable) -> Pulley:
    """Return the fixed exit point in place of a cable's pulley, the dead length kept."""
    return Pulley(NONE, lead_in=NONE if cable.pulley is None else cable.pulley.lead_in)


def routes(whole: Robot) -> Floats:
    """Return the routes (N, ROUTE, 2) of the cables of a robot, base frame, m."""
    return route_rows(whole, ORIGIN, Fraction(1))


def solved(whole: Robot, targets: Floats) -> Poses:
    """Return the poses of a robot for the simple lengths of targets (T, 3); all cables stretch alike."""
    spring = whole.cables[0].elasticity
    compliance = 0.0
    if spring is not None:
        assert spring.axial_stiffness is not None
        compliance = 1.0 / float(exact(spring.axial_stiffness))
    load = np.array([0.0, 0.0, -float(MASS * GRAVITY)])
    lengths, count = simple_lengths(whole, targets), len(targets)
    found = np.empty((count, 3)), np.empty((count, 3)), np.empty(count, np.int64)
    solve_all(routes(whole), sets_of_three(len(whole.cables)), lengths, load, compliance, targets, *found)
    return Poses(targets, *found)


def ends(whole: Robot) -> tuple[Robot, ...]:
    """Return a robot whose cables have a range of stiffness with the lower and with the upper end for all."""
    sides = zip(*(cable.elasticity.ends() for cable in whole.cables if cable.elasticity), strict=True)
    return tuple(
        whole.replace(
            cables=tuple(c.replace(elasticity=end) for c, end in zip(whole.cables, side, strict=True))
        )
        for side in sides
    )
