"""From exact data to the arrays of a platform on real cables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.cables.pulley import OverPulley
from cdpr_interval.mechanics.cables.straight import FixedExit
from cdpr_interval.mechanics.six_dof.arrays import nearest, platform_size, triples_by_spread
from solvers.questions.problem import Problem
from solvers.six_dof.real.model import RealModel

Floats = NDArray[np.float64]
Vector = tuple[Fraction, Fraction, Fraction]
ZERO: Vector = (Fraction(0), Fraction(0), Fraction(0))
UNIT = 2.0**-50
"""Relative error of the few roundings behind a number of a pulley."""


class RealCable(NamedTuple):
    """One cable, exact numbers in m and m/N."""

    exit: Vector
    """A."""
    arm: Vector
    """b, from the centre of mass, in the platform frame."""
    length: tuple[Fraction, Fraction]
    """Bounds of l."""
    radius: Fraction = Fraction(0)
    """0: straight from the exit point."""
    pulley_arm: Fraction = Fraction(0)
    """h >= r."""
    axis: Vector = (Fraction(0), Fraction(0), Fraction(1))
    """k, of any length but zero."""
    lead_in: Fraction = Fraction(0)
    joints: int = 1
    """2: in exact balance."""
    compliance: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))
    """Bounds of 1 / k, the stretch by 1 N."""


def build(
    cables: Sequence[RealCable],
    load: Vector,
    n_taut: int,
    *,
    statics: bool = True,
    slack: bool = True,
) -> RealModel:
    """Enclose the cables in the arrays of a ``RealModel``; the taut ones come first.

    Those first that do not stretch: a search is faster, and with more than six taut cables needs it.
    """
    exits, exits_err = _vectors([c.exit for c in cables])
    arms, arms_err = _vectors([c.arm for c in cables])
    force, force_err = _vectors([load])
    axes = np.array([_unit(c.axis) for c in cables]).reshape(-1, 3)
    radius, arm, lead = np.array([_sizes(c) for c in cables]).reshape(-1, 3).T.copy()
    joints = np.array([c.joints if c.radius > 0 else 1 for c in cables], dtype=np.int64)
    at_start = np.array([c.lead_in == 0 and c.pulley_arm <= c.radius for c in cables])
    fixed, fixed_err, angle, angle_err, before = _arrival(radius, arm, lead, at_start)
    fixed, before = np.where(joints == 2, lead, fixed), _before(before, lead, arm - radius, joints)
    point = np.linalg.norm(exits_err, axis=1) + np.linalg.norm(arms_err, axis=1)
    shift = np.stack(
        [(point + fixed_err + 4.0 * UNIT * (radius + arm)) * 1.01, 8.0 * UNIT * (radius > 0.0)], axis=1
    )
    lengths = np.array([_outward(*c.length) for c in cables])
    compliance = np.array([_outward(*c.compliance) for c in cables])
    # The rope of a longer arm lifts off: on one joint at theta_K.
    lifts = np.array([c.radius > 0 and c.pulley_arm > c.radius for c in cables]) & (joints == 1)
    least, most = _excess(radius, arm, lead, fixed, before, lifts, joints == 2)
    margin = shift[:, 0] + 1e-12 * (1.0 + arm)
    reach = np.linalg.norm(arms, axis=1) + np.linalg.norm(arms_err, axis=1)
    # T: a rope that runs past its pulley to next to it leaves a little before X, see ``_excess``.
    foot_reach = (arm + radius) * (1.0 + 1e-14) + np.where(lifts, 4e-3 * (lead + arm), 0.0)
    sway = radius + np.where(joints == 2, 0.5 * arm, 0.0)
    lifting = _lifting(lifts, angle, angle_err)
    paths = _paths(exits, reach, foot_reach, lengths, compliance, most + margin, force[0], n_taut)
    return RealModel(
        n_taut=n_taut,
        statics=statics,
        slack=slack,
        exits=exits,
        joints=joints,
        axes=axes,
        radius=radius,
        arm=arm,
        simple=~lifts & (joints == 1),
        is_simple=not (lifts.any() or (joints == 2).any()),
        rows=np.column_stack([exits, axes, radius, arm, lead, before, sway, *lifting, shift, joints]),
        sway=sway,
        lead=lead,
        fixed=fixed,
        before=before,
        lift_off=lifting[0],
        foot_reach=foot_reach,
        least_excess=least - margin,
        most_excess=most + margin,
        shift=shift,
        arms=arms,
        arm_lengths=np.linalg.norm(arms, axis=1) * (1.0 + 1e-14) + np.linalg.norm(arms_err, axis=1),
        lengths=lengths,
        paths=paths,
        compliance=compliance,
        elastic=bool((compliance[:n_taut, 1] > 0.0).any()),
        rigid=_rigid(compliance[:n_taut, 1]),
        load=force[0],
        load_err=force_err[0],
        size=platform_size(arms[:n_taut]),
        triple=_triple(exits, arms, n_taut),
    )


def _rigid(compliance: Floats) -> int:
    """Return from which taut cable on all stretch."""
    return int(np.flatnonzero(compliance <= 0.0).max(initial=-1)) + 1


def _arrival(
    radius: Floats, arm: Floats, lead: Floats, exact_start: NDArray[np.bool_]
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return of one joint |CK| + r theta_K (N,), the error of that, theta_K, the error of that, and |CK|.

    ``exact_start`` (N,): the rope starts where it meets the pulley. Between the bounds of theta_K a rope is
    taken to touch: T is off there by |CK| + r times their distance at most, which is less than the error of
    the length, with ``loss``, and that of its rounding.
    """
    wrapped = np.hypot(arm, lead)
    straight = np.sqrt(np.maximum((wrapped - radius) * (wrapped + radius), 0.0))
    with np.errstate(all="ignore"):
        # As arctangents: arccosines lose digits where the rope starts at the pulley.
        angle = np.pi + np.arctan2(lead, arm) - np.arctan2(straight, radius)
    tangent = straight.copy()
    angle[exact_start], tangent[exact_start] = np.pi, 0.0
    fixed = np.where(radius > 0.0, tangent + radius * angle, lead)
    # The square root is as sensitive as the rope's start is near the pulley.
    loss = np.where(
        exact_start, 0.0, 4.0 * wrapped * wrapped / np.maximum(straight, np.maximum(3e-8 * wrapped, 1e-12))
    )
    error = UNIT * np.where(radius > 0.0, fixed + loss + 8.0 * radius, lead)
    steep = np.maximum(straight, 3e-8 * wrapped)
    turned = UNIT * (2.0 + 2.0 * radius / np.where(steep > 0.0, steep, 1.0))
    return fixed, error, angle, turned, tangent


def _sizes(cable: RealCable) -> tuple[float, float, float]:
    """Return radius, arm and lead-in."""
    radius = float(cable.radius)
    return radius, max(float(cable.pulley_arm), radius), float(cable.lead_in)


def _before(tangent: Floats, lead: Floats, across: Floats, joints: NDArray[np.int64]) -> Floats:
    """Return how much of a rope (N,) arrives where it lifts off.

    With two joints its straight line from C passes A at h - r then.
    """
    return np.where(joints == 2, np.sqrt(np.maximum((lead - across) * (lead + across), 0.0)), tangent)


def _lifting(lifts: NDArray[np.bool_], angle: Floats, error: Floats) -> tuple[Floats, Floats]:
    """Return bounds (N,) of theta_K; of ropes that never lift off pi and infinity."""
    below = np.minimum(np.where(lifts, angle - error, np.pi), np.pi)
    return below, np.where(lifts, angle + error + 4.0 * UNIT, np.inf)


def _excess(
    radius: Floats,
    arm: Floats,
    lead: Floats,
    fixed: Floats,
    before: Floats,
    lifts: NDArray[np.bool_],
    hangs: NDArray[np.bool_],
) -> tuple[Floats, Floats]:
    """Return bounds (N,) of L - |X - A|, wherever X is.

    With two joints, ``hangs``, the rope passes A at h - r in the middle of its wrap W, or nearer where it
    runs past the pulley; and each leg is by h sin(W / 2) shorter than lead-in and |X - A|, or more. Past one
    joint L = ``before`` + |X - T|, or X is nearer to C than that, and then within h + r of A.
    """
    near = arm + radius
    least = np.where(radius > 0.0, fixed - radius * (1.5 * np.pi) - near, fixed)
    most = np.where(radius > 0.0, fixed + radius * np.pi + arm, fixed)
    least = np.where(lifts, np.minimum(least, lead - 2.0 * near), least)
    most = np.where(lifts, np.maximum(most, before + near), most)
    least = np.where(hangs, lead - 2.0 * (arm - radius), least)
    most = np.where(hangs, lead + 2.0 * np.pi * radius, most)
    return least, most


def cables_of(problem: Problem) -> list[RealCable]:
    """Return the cables of a question, file order."""
    loaded, found = problem.loaded, []
    for arm, length, (route, law) in zip(loaded.arms, problem.lengths, loaded.models, strict=True):
        constants = [law.spring_constant(end) for end in length]
        given = tuple(Fraction(0) if k is None else 1 / k for k in constants)
        compliance = (min(given), max(given))
        if isinstance(route, OverPulley):
            found.append(
                RealCable(
                    route.point,
                    arm,
                    length,
                    route.radius,
                    route.arm,
                    route.axis,
                    route.lead_in,
                    route.joints,
                    compliance,
                )
            )
        else:
            assert isinstance(route, FixedExit)
            found.append(RealCable(route.point, arm, length, lead_in=route.before, compliance=compliance))
    return found


def model_for(problem: Problem, taut: Sequence[int], *, slack: bool = True) -> RealModel:
    """Return the arrays of a question with these cables taut; cables that need not be slack are left out."""
    cables = cables_of(problem)
    others = [i for i in range(len(cables)) if i not in taut] if slack else []
    return build([cables[i] for i in (*taut, *others)], problem.load, len(taut))


def within(real: RealModel, most: float) -> RealModel:
    """Return arrays for equilibria with no tension of an elastic cable above ``most`` N.

    A tension of at most ``most`` stretches a cable by at most so much.
    """
    paths = real.paths.copy()
    stretched = (real.lengths[:, 1] + real.compliance[:, 1] * most) * (1.0 + 1e-14)
    is_elastic = (real.compliance[:, 1] > 0.0) & (np.arange(len(paths)) < real.n_taut)
    paths[is_elastic, 1] = np.minimum(paths[is_elastic, 1], stretched[is_elastic])
    return real._replace(paths=paths)


def _paths(
    exits: Floats,
    reach: Floats,
    pulley: Floats,
    lengths: Floats,
    compliance: Floats,
    excess: Floats,
    load: Floats,
    n_taut: int,
) -> Floats:
    """Return bounds (N, 2) of path lengths in every static pose; of slack cables the upper ones are lengths.

    With c the middle of the exit points and Q the farthest of what lies around c and around the centre of
    mass p, together: where p is within 3 Q of c, L is at most 4 Q and an excess. Elsewhere every rope pulls
    back by at least half of its tension, so that the tensions together are at most twice the load, which
    bounds the stretch.
    """
    paths = lengths.copy()
    middle = exits.mean(axis=0)
    far = np.linalg.norm(exits - middle, axis=1) + pulley
    size = float(far.max() + reach.max())
    stretched = lengths[:, 1] + 2.0 * np.linalg.norm(load) * compliance[:, 1]
    highest = np.maximum(stretched, 4.0 * size + excess) * (1.0 + 1e-9)
    is_elastic = (compliance[:, 1] > 0.0) & (np.arange(len(exits)) < n_taut)
    paths[is_elastic, 1] = highest[is_elastic]
    return paths


def _vectors(vectors: Sequence[Vector]) -> tuple[np.ndarray, np.ndarray]:
    pairs = [[nearest(x) for x in v] for v in vectors]
    found = np.array(pairs)
    return np.ascontiguousarray(found[:, :, 0]), np.ascontiguousarray(found[:, :, 1])


def _unit(axis: Vector) -> list[float]:
    """Return an axis over its length, correctly but for some units."""
    most = max(map(abs, axis))
    scaled = [x / most for x in axis]
    norm = math.sqrt(sum(x * x for x in scaled))
    return [float(x) / norm for x in scaled]


def _outward(lo: Fraction, hi: Fraction) -> tuple[float, float]:
    (m, e), (n, d) = nearest(lo), nearest(hi)
    return (m if e == 0.0 else math.nextafter(m, -math.inf)), (n if d == 0.0 else math.nextafter(n, math.inf))


def _triple(exits: np.ndarray, arms: np.ndarray, n_taut: int) -> np.ndarray:
    """Return the three taut cables whose centres stay farthest from one line; any where there are fewer."""
    if n_taut < 3:
        return np.zeros(3, dtype=np.int64)
    return np.ascontiguousarray(triples_by_spread(exits, arms, n_taut)[0, :3])
