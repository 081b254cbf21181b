"""Random point-mass robots whose one static pose is known exactly: it must be found, and nothing else.

All directions are rational unit vectors, so pose, lengths, load and tensions are exact rationals.

Run as ``python scripts/planted_point_mass.py [COUNT [SEED]]``.
"""

from __future__ import annotations

import math
import random
import sys
from dataclasses import dataclass
from fractions import Fraction

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from solvers.answers.data import Answer, Outcome
from solvers.questions.problem import Method, Options, Problem

ORIGIN: Vector = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True)
class Planted:
    """A problem with its answer."""

    problem: Problem
    taut: tuple[int, ...]
    position: Vector
    tensions: tuple[Fraction, ...]
    """N, in file order."""


def number(rng: random.Random, low: float, high: float, digits: int = 6) -> Fraction:
    """Return a random decimal between two bounds."""
    return Fraction(round(rng.uniform(low, high) * 10**digits), 10**digits)


def direction(rng: random.Random) -> Vector:
    """Return a random rational unit vector (stereographic projection)."""
    a, b = number(rng, -2, 2, 3), number(rng, -2, 2, 3)
    s = 1 + a * a + b * b
    u = [2 * a / s, 2 * b / s, (1 - a * a - b * b) / s]
    rng.shuffle(u)
    sign = rng.choice((-1, 1))
    return (sign * u[0], sign * u[1], sign * u[2])


def plant(rng: random.Random, elastic: bool, scale: Fraction = Fraction(1)) -> Planted:
    """Return a random robot of 1 to 7 cables with a known pose; lengths of the order of ``scale`` m."""
    count = rng.randint(1, 7)
    most = count if elastic else min(3, count)
    taut = tuple(sorted(rng.sample(range(count), rng.randint(1, most))))
    position = (number(rng, -2, 2) * scale, number(rng, -2, 2) * scale, number(rng, -2, 2) * scale)
    force_scale = Fraction(10) ** rng.randint(-2, 5)
    cables, lengths, tensions = [], [], []
    load = list(ORIGIN)
    kind = rng.choice(("stiffness", "axial"))
    for i in range(count):
        u, distance = direction(rng), number(rng, 0.5, 5) * scale
        anchor = tuple(p - distance * x for p, x in zip(position, u, strict=True))
        tension = number(rng, 0.1, 10) * force_scale if i in taut else Fraction(0)
        elasticity = None
        length = distance
        if elastic:
            strain = Fraction(rng.choice((1, 10, 100)), 1000) * number(rng, 0.5, 2)
            length = distance / (1 + strain)
            axial = tension / strain if i in taut else force_scale * 1000
            if kind == "stiffness":
                elasticity = Elasticity(stiffness=axial / length)
            else:
                elasticity = Elasticity(axial_stiffness=axial)
        if i not in taut:
            length = distance * (1 + number(rng, 0.001, 0.5))
        for j in range(3):
            load[j] += tension * u[j]
        cables.append(Cable(f"c{i + 1}", (anchor[0], anchor[1], anchor[2]), ORIGIN, elasticity))
        lengths.append(length)
        tensions.append(tension)
    mass = number(rng, 1, 10)
    gravity = (load[0] / mass, load[1] / mass, load[2] / mass)
    robot = Robot("planted", Platform(mass), tuple(cables), gravity=gravity)
    problem = Problem(robot, tuple((x, x) for x in lengths))
    return Planted(problem, taut, position, tuple(tensions))


def outside(bounds: Bounds, value: Fraction) -> bool:
    """Return True when an exact number lies outside its enclosure (lo, hi)."""
    return not Fraction(float(bounds[0])) <= value <= Fraction(float(bounds[1]))


def complaints(planted: Planted, answer: Answer, widest: float) -> list[str]:
    """Return what is wrong with an answer; empty when the pose, and only it, was proved."""
    if answer.outcome is not Outcome.COMPLETE or len(answer.solutions) != 1:
        return [f"{answer.outcome} with {len(answer.solutions)} solutions instead of one: {answer.message}"]
    (solution,) = answer.solutions
    found = []
    if solution.taut != planted.taut:
        found.append(f"taut {solution.taut} instead of {planted.taut}")
    if any(outside(b, x) for b, x in zip(solution.position, planted.position, strict=True)):
        found.append(f"the pose is outside {solution.position.tolist()}")
    if any(outside(b, x) for b, x in zip(solution.tensions, planted.tensions, strict=True)):
        found.append(f"a tension is outside {solution.tensions.tolist()}")
    width = float((solution.position[:, 1] - solution.position[:, 0]).max())
    if not width <= widest:
        found.append(f"the box is {width} m wide")
    return found


def is_singular(planted: Planted) -> bool:
    """Return True when the taut directions are so nearly dependent that doubles cannot prove the pose."""
    rows = [
        [float(p - a) for p, a in zip(planted.position, planted.problem.loaded.exits[i], strict=True)]
        for i in planted.taut
    ]
    units = [[x / math.hypot(*row) for x in row] for row in rows]
    pairs = [(a, b) for k, a in enumerate(units) for b in units[:k]]
    if len(units) == 3:
        a, b, c = units
        volume = sum(
            a[j] * (b[(j + 1) % 3] * c[(j + 2) % 3] - b[(j + 2) % 3] * c[(j + 1) % 3]) for j in range(3)
        )
        if abs(volume) < 1e-5:
            return True
    return any(abs(sum(x * y for x, y in zip(a, b, strict=True))) > 1 - 1e-9 for a, b in pairs)


def run(
    count: int, seed: int, methods: tuple[Method, ...] = (Method.CONVEX, Method.SEARCH)
) -> tuple[list[str], int]:
    """Solve ``count`` planted robots by every method.

    Returns
    -------
    lines, failed
        A report, one line per failure and a summary, and the number of robots that failed.
    """
    from solvers.point_mass.forward import solve

    lines, failed, done = [], 0, 0
    for index in range(count):
        rng = random.Random(seed * 1_000_003 + index)
        elastic = bool(rng.getrandbits(1))
        scale = Fraction(10) ** rng.choice((0, 0, 0, 2, -3))
        planted = plant(rng, elastic, scale)
        if not any(planted.problem.load) or (not elastic and is_singular(planted)):
            continue
        done += 1
        wrong = []
        for method in methods:
            answer = solve(planted.problem, Options(method=method))
            wrong += [f"{method}: {text}" for text in complaints(planted, answer, 1e-8 * float(scale))]
        failed += bool(wrong)
        kind = "elastic" if elastic else "inextensible"
        lines += [f"point mass {index} (seed {seed}, {kind}): {text}" for text in wrong]
    lines.append(f"point mass: {done} planted robots, {failed} failed")
    return lines, failed


if __name__ == "__main__":
    arguments = [int(x) for x in sys.argv[1:]] or [500]
    report, failures = run(arguments[0], arguments[1] if len(arguments) > 1 else 1)
    print("\n".join(report))
    sys.exit(1 if failures else 0)
