"""What a pose is as a cable sees it, over a pulley or not, and the second variation of the energy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import arb, arb_mat

from certificates.arithmetic.balls import Vector, unit
from certificates.arithmetic.jets import Jet
from certificates.arithmetic.series import inverse_root
from certificates.arithmetic.vectors import cross, dot
from certificates.problem import Problem
from certificates.routed.ropes import Rope, over_pulley
from certificates.verdicts import NotProved


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


def second_variation(
    problem: Problem, cables: dict[int, tuple[Vector, Vector, arb]]
) -> tuple[arb_mat, list[Vector]]:
    """Return the matrix (6, 6) of the energy's second variation, and what holds motions back.

    ``cables`` : r, X and t of each. With dX = v + omega x r, a = dL/dX and the tension T = t sigma a cable
    adds T (dX . da/dX dX + a . (omega x (omega x r))), and K (a . dX)^2 where it stretches by 1 / K; else a .
    dX = 0 is a row. A cable whose tension is not proved positive may let go: it holds nothing back.
    """
    axes = [[arb(int(i == j)) for j in range(6)] for i in range(6)]
    form, rows = arb_mat(6, 6), []
    for i, (r, anchor, t) in cables.items():
        rope = rope_to(problem, i, [Jet(x, {k: arb(1)}) for k, x in enumerate(anchor)])
        root = inverse_root(rope.square)
        along = [-v * root for v in rope.pull]
        a, tension = [v.value for v in along], t * rope.free.value
        moves = [[v + w for v, w in zip(x[:3], cross(x[3:], r), strict=True)] for x in axes]
        pulled = [dot(a, m) for m in moves]
        spring = arb(problem.spring(i)) if problem.is_elastic and t > 0 else arb(0)
        turns = [[dot(a, cross(x[3:], cross(y[3:], r))) for y in axes] for x in axes]
        bent = [
            [sum((v.slopes.get(k, arb(0)) * m[k] for k in range(3)), arb(0)) for v in along] for m in moves
        ]
        form += arb_mat(
            [
                [
                    tension * (dot(moves[x], bent[y]) + (turns[x][y] + turns[y][x]) / 2)
                    + spring * pulled[x] * pulled[y]
                    for y in range(6)
                ]
                for x in range(6)
            ]
        )
        if not problem.is_elastic and t > 0:
            rows.append(pulled)
    return form, rows
