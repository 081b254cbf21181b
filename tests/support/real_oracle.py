"""Platforms on real cables in plain floats: planted ones as robots, and where they go along lengths.

Nothing of the solvers is used but what makes a planted pose a start.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.orientation import quaternion_from_rotation
from cdpr_interval.mechanics.rotation import chart_of
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Solution
from solvers.questions.problem import Options, Problem
from solvers.six_dof.cells.roots import Root
from solvers.six_dof.over_pulleys import solution_of
from solvers.six_dof.real.build import model_for
from solvers.six_dof.real.roots import root_near
from tests.support.planted.pulleys import Floats, Planted, turned


@dataclass(frozen=True)
class Body:
    """Where a platform is in floats; the cables in ``taut`` carry ``tensions`` (n,) N."""

    position: Floats
    rotation: Floats
    taut: tuple[int, ...]
    tensions: Floats


def robot_of(planted: Planted, stiffness: float | None = None) -> Robot:
    """Return a planted platform as a robot, its cables with so many N/m; its load is its weight at 1 kg."""
    cables = []
    for i, (cable, arm) in enumerate(zip(planted.cables, planted.arms, strict=True)):
        one: dict[str, object] = {
            "name": f"c{i + 1}",
            "frame_anchor_m": cable.exit.tolist(),
            "platform_anchor_m": arm.tolist(),
        }
        if cable.radius:
            one["pulley"] = {
                "joints": cable.joints,
                "radius_m": cable.radius,
                "arm_m": cable.arm,
                "lead_in_m": cable.lead_in,
                "axis": cable.axis.tolist(),
            }
        if stiffness is not None:
            one["elasticity"] = {"stiffness_N_per_m": stiffness}
        cables.append(one)
    return Robot.from_dict(
        {
            "format": "cdpr-robot/1",
            "name": "planted",
            "gravity_m_s2": planted.load.tolist(),
            "platform": {"mass_kg": 1},
            "cables": cables,
        }
    )


def start_of(planted: Planted, robot: Robot, lengths: Floats) -> Solution:
    """Return the planted pose, all cables taut, as forward kinematics would."""
    exact = tuple((Fraction(x), Fraction(x)) for x in lengths.tolist())
    problem, taut = Problem(robot, exact), tuple(range(len(lengths)))
    chart, u = chart_of(quaternion_from_rotation(planted.rotation))
    found = root_near(model_for(problem, taut), chart, np.array([*u, *planted.position]), [])
    assert found is not None
    with balls.precision():
        pose = solution_of(problem, Options(), taut, Root(found.chart, found.box, found.unique, found.core))
    assert isinstance(pose, Solution)
    return pose


class Oracle:
    """Newton's method with the cables that carry now, step by step; cables are let go and taken hold of."""

    def __init__(self, planted: Planted, compliance: float = 0.0) -> None:
        self.planted, self.compliance = planted, compliance

    def along(self, body: Body, before: Floats, after: Floats, steps: int) -> Iterator[tuple[float, Body]]:
        """Yield shares of the way and poses; ends where there is none."""
        for k in range(1, steps + 1):
            share = k / steps
            found = self.settled(body, before + share * (after - before))
            if found is None or np.abs(found.position - body.position).max() > 0.05:
                return
            body = found
            yield share, body

    def settled(self, body: Body, lengths: Floats) -> Body | None:
        """Return the pose for lengths next to another one."""
        for _ in range(6):
            found = self.solved(body, lengths)
            if found is None:
                return None
            if found.tensions.min() < 0.0:
                keep = [j for j in range(len(found.taut)) if j != int(found.tensions.argmin())]
                taut = tuple(found.taut[j] for j in keep)
                body = replace(found, taut=taut, tensions=found.tensions[keep])
                continue
            over = self.paths(found)[0] - lengths
            over[list(found.taut)] = -1.0
            if over.max() <= 1e-9:
                return found
            taut = tuple(sorted((*found.taut, int(over.argmax()))))
            tensions = [0.0 if i not in found.taut else found.tensions[found.taut.index(i)] for i in taut]
            body = replace(found, taut=taut, tensions=np.array(tensions))
        return None

    def paths(self, body: Body) -> tuple[Floats, Floats, Floats]:
        """Return lengths (N,), directions (N, 3) and lever arms (N, 3)."""
        levers = self.planted.arms @ body.rotation.T
        seen = [c.path(body.position + r) for c, r in zip(self.planted.cables, levers, strict=True)]
        return np.array([s[0] for s in seen]), np.array([s[1] for s in seen]), levers

    def residual(self, body: Body, lengths: Floats) -> Floats:
        """Return what is to vanish."""
        own, along, levers = self.paths(body)
        taut = list(body.taut)
        pulls = -along[taut]
        return np.concatenate(
            [
                own[taut] - lengths[taut] - self.compliance * body.tensions,
                body.tensions @ pulls + self.planted.load,
                body.tensions @ np.cross(levers[taut], pulls),
            ]
        )

    def moved(self, body: Body, by: Floats) -> Body:
        """Return a pose after a turn and a shift of (6 + n,)."""
        turn = turned(by[:3]) if np.linalg.norm(by[:3]) > 0.0 else np.eye(3)
        return Body(body.position + by[3:6], turn @ body.rotation, body.taut, body.tensions + by[6:])

    def solved(self, body: Body, lengths: Floats) -> Body | None:
        """Return the zero near a pose with its own taut cables."""
        m = 6 + len(body.taut)
        for _ in range(12):
            J = np.empty((m, m))
            for j in range(m):
                step = np.zeros(m)
                step[j] = 1e-6
                up, down = self.moved(body, step), self.moved(body, -step)
                J[:, j] = (self.residual(up, lengths) - self.residual(down, lengths)) / 2e-6
            move = -np.linalg.lstsq(J, self.residual(body, lengths), rcond=None)[0]
            if not np.isfinite(move).all() or np.abs(move[:6]).max() > 0.5:
                return None
            body = self.moved(body, move)
            if np.abs(move[:6]).max() < 1e-11:
                return body
        return body if np.abs(self.residual(body, lengths)).max() < 1e-9 else None
