"""Stability of a static pose.

With a motion x = (v, omega) at the centre of mass, cables with arm r, spoke e and density t,

    Q = sum t (|v + omega x r|^2 - e . (omega x (omega x r)))

is looked at on the motions that keep the lengths: (e, r x e) . x = 0 for all cables.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import arb, arb_mat

from certificates.arithmetic.balls import Vector, column, unit
from certificates.arithmetic.jets import Jet
from certificates.arithmetic.series import inverse_root
from certificates.arithmetic.vectors import cross, dot
from certificates.problem import Listed, Problem
from certificates.routed.ropes import Rope, over_pulley
from certificates.verdicts import NotProved

Cable = tuple[Vector, Vector, arb]
"""r, e, t."""
POWERS = range(4, 80, 6)
"""Powers of two by which the constraints are weighted: large ones ask for sharp data."""


def check_stability(
    problem: Problem, listed: Listed, cables: Sequence[Cable], motions: Sequence[Vector]
) -> bool:
    """Return True when what is said about stability follows."""
    if listed.stability == "undecided":
        return True
    if problem.is_point_mass:
        return listed.stability == "stable"  # a minimum of a convex problem
    form = second_variation(cables)
    # Without a tension proved positive a cable may let go: it holds no motion back.
    holding = [(r, e) for r, e, t in cables if t > 0 or problem.ignore_tension_sign]
    rows = [[*e, *cross(r, e)] for r, e in holding]
    return (bool(rows) or listed.stability != "stable") and follows(
        listed, form, rows, motions, len(rows) == len(cables)
    )


def follows(
    listed: Listed, form: arb_mat, rows: Sequence[Vector], motions: Sequence[Vector], all_hold: bool
) -> bool:
    """Return True when what is said about stability follows from the form on what the rows leave free."""
    if listed.stability == "stable":
        return is_stable(form, [*rows, *motions])
    decided = all_hold and "undecided" not in listed.states
    return listed.stability == "unstable" and decided and falls(form, rows)


def second_variation(cables: Sequence[Cable]) -> arb_mat:
    """Return the matrix (6, 6) of Q, from its values on sums of unit motions."""
    axes = [[arb(int(i == j)) for j in range(6)] for i in range(6)]
    return arb_mat([[sum((polar(x, y, c) for c in cables), arb(0)) for y in axes] for x in axes])


def polar(x: Vector, y: Vector, cable: Cable) -> arb:
    """Return a cable's part of the symmetric bilinear form of Q."""
    r, e, t = cable
    dx = [a + b for a, b in zip(x[:3], cross(x[3:], r), strict=True)]
    dy = [a + b for a, b in zip(y[:3], cross(y[3:], r), strict=True)]
    twice = dot(e, cross(x[3:], cross(y[3:], r))) + dot(e, cross(y[3:], cross(x[3:], r)))
    return t * (dot(dx, dy) - twice / 2)


def weighted(form: arb_mat, rows: Sequence[Vector], power: int) -> arb_mat:
    """Return form + rho rows^T rows for an exact rho > 0."""
    if not rows:
        return form
    gram = arb_mat(rows).transpose() * arb_mat(rows)
    rho = (sum((abs(form[i, i]) for i in range(6)), arb(1)) / gram.trace()).mid() * 2**power
    return form + gram * rho if rho > 0 else form


def leading(m: arb_mat, k: int) -> arb_mat:
    """Return the first k rows and columns."""
    return arb_mat([[m[i, j] for j in range(k)] for i in range(k)])


def is_stable(form: arb_mat, rows: Sequence[Vector]) -> bool:
    """Return True when form + rho rows^T rows is positive definite for some rho (Sylvester's minors).

    Then the form is positive on every motion that the rows annihilate (Finsler).
    """
    for power in POWERS:
        m = weighted(form, rows, power)
        if all(leading(m, k).det() > 0 for k in range(1, 7)):
            return True
    return False


def falls(form: arb_mat, rows: Sequence[Vector]) -> bool:
    """Return True when the form is negative for a motion that the rows annihilate exactly."""
    m = weighted(form, rows, 60).mid()
    across = arb_mat(rows).transpose() if rows else None
    for k in range(6):
        try:
            # A guess: where the Schur complement of entry k is negative, m is negative for this motion.
            head = (leading(m, k).solve(column([-m[i, k] for i in range(k)]))).mid().entries() if k else []
            motion = column([*head, 1, *[0] * (5 - k)])
            if across is not None:
                along = across.transpose()
                motion -= across * (along * across).solve(along * motion)
        except ZeroDivisionError:
            continue
        if (motion.transpose() * form * motion)[0, 0] < 0:
            return True
    return False


def rope_to(problem: Problem, i: int, anchor: Sequence[Any]) -> Rope:
    """Return a cable's way to its anchor, balls or jets; refused where the pulley may not be in its way."""
    g = [x - arb(a) for x, a in zip(anchor, problem.exits[i], strict=True)]
    pulley = problem.pulleys[i] if problem.pulleys else None
    if pulley is None:
        return Rope([-v for v in g], dot(g, g), arb(0))
    rope = over_pulley(g, unit(pulley.axis), arb(pulley.radius), arb.pi())
    wrapped = rope.wrapped.value if isinstance(rope.wrapped, Jet) else rope.wrapped
    if not wrapped >= 0:
        raise NotProved(f"{problem.names[i]} may run past its pulley")
    rope.wrapped = rope.wrapped + arb(pulley.before)
    return rope


def variation_of_ropes(
    problem: Problem, cables: dict[int, tuple[Vector, Vector, arb]]
) -> tuple[arb_mat, list[Vector]]:
    """Return the matrix (6, 6) of the energy's second variation, and what holds motions back.

    ``cables`` : r, X and t of each. With dX = v + omega x r, a = dL/dX and the tension T = t sigma a cable
    adds T (dX . da/dX dX + a . (omega x (omega x r))); a . dX = 0 is a row. A cable whose tension is not
    proved positive may let go: it holds nothing back.
    """
    axes = [[arb(int(i == j)) for j in range(6)] for i in range(6)]
    form, rows = arb_mat(6, 6), []
    for i, (r, anchor, t) in cables.items():
        rope = rope_to(problem, i, [Jet(x, {k: arb(1)}) for k, x in enumerate(anchor)])
        root = inverse_root(rope.square)
        along = [-v * root for v in rope.pull]
        a, tension = [v.value for v in along], t * rope.free.value
        moves = [[v + w for v, w in zip(x[:3], cross(x[3:], r), strict=True)] for x in axes]
        turns = [[dot(a, cross(x[3:], cross(y[3:], r))) for y in axes] for x in axes]
        bent = [
            [sum((v.slopes.get(k, arb(0)) * m[k] for k in range(3)), arb(0)) for v in along] for m in moves
        ]
        both = [
            [dot(m, b) + (turns[x][y] + turns[y][x]) / 2 for y, b in enumerate(bent)]
            for x, m in enumerate(moves)
        ]
        form += arb_mat(both) * tension
        if t > 0:
            rows.append([dot(a, m) for m in moves])
    return form, rows
