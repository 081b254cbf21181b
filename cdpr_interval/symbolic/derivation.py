"""The derivation of a point mass's eliminant as formulas that a reader can follow, named as in Merlet (2012).

The same steps as `cdpr_interval.symbolic.curves` takes in numbers, by sympy, with a robot's exact data.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from flint import fmpq

from cdpr_interval.symbolic.statics import Statics


@dataclass(frozen=True)
class Step:
    """One step: what is done, and the equations it leads to (each expression is zero, or an equality)."""

    title: str
    formulas: list[sympy.Basic]


def rational(x: fmpq) -> sympy.Rational:
    """Return a number as sympy's."""
    return sympy.Rational(int(x.p), int(x.q))


def derivation(statics: Statics) -> list[Step]:
    """Return the steps from the balance to the conditions of which resultants are taken."""
    n = statics.count
    rho = sympy.symbols(f"rho_1:{n + 1}")
    w = sympy.symbols(f"w_1:{n + 1}")
    centre = sympy.Matrix(sympy.symbols("x y z"))
    exits = [sympy.Matrix([rational(v) for v in a]) for a in statics.exits]
    load = sympy.Matrix([rational(v) for v in statics.load])
    laws = [rational(u) - rational(v) / r for u, v, r in zip(statics.u, statics.v, rho, strict=True)]
    balance = sum((x * (centre - a) for x, a in zip(w, exits, strict=True)), -load)
    total = sum(w)
    pose = (load + sum((x * a for x, a in zip(w, exits, strict=True)), sympy.zeros(3, 1))) / total
    spheres = [(centre - a).dot(centre - a) - r**2 for a, r in zip(exits, rho, strict=True)]
    # The squares of x, y, z cancel before the pose is put in, so one factor sum w clears the fractions.
    lines = [sympy.expand(s - spheres[0]) for s in spheres[1:]]
    pulls = list(pose * total)
    differences = [
        sympy.expand(
            (line.subs(dict.fromkeys(centre, 0))) * total
            + sum(line.coeff(c) * pull for c, pull in zip(centre, pulls, strict=True))
        )
        for line in lines
    ]
    steps = [
        Step(
            "Tension over distance of every cable", [sympy.Eq(x, law) for x, law in zip(w, laws, strict=True)]
        ),
        Step("Equation (1), the balance of forces", list(balance)),
        Step("The pose that follows from it", [sympy.Eq(c, p) for c, p in zip(centre, pose, strict=True)]),
        Step("Equations (4), the inverse kinematics", spheres),
    ]
    if n > 1:
        steps.append(Step("Differences (4_i) - (4_1), the pose put in, times the sum of all w", differences))
    if n > 2:
        last = sympy.solve(differences[0], w[-1], dict=True)[0]
        steps.append(
            Step(f"(4_2) - (4_1) is linear in w_{n}, and with it in rho_{n}", [sympy.Eq(w[-1], last[w[-1]])])
        )
        names = ", ".join(["(4_1)", *(f"(4_{i}) - (4_1)" for i in range(3, n + 1))])
        steps.append(
            Step(f"Put into {names}: with w_i from the first step these hold rho_1..rho_{n - 1} only", [])
        )
    return steps


def latex(statics: Statics, results: list[str]) -> str:
    """Return a document with all steps, then lines of results."""
    lines = [
        r"\documentclass{article}",
        r"\usepackage{amsmath,breqn}",
        r"\begin{document}",
    ]
    for number, step in enumerate(derivation(statics), 1):
        lines.append(rf"\paragraph{{{number}.}} {escaped(step.title)}.")
        for formula in step.formulas:
            text = sympy.latex(formula if isinstance(formula, sympy.Equality) else sympy.Eq(formula, 0))
            lines += [r"\begin{dmath*}", text, r"\end{dmath*}"]
    lines.append(r"\paragraph{Elimination.}\begin{itemize}")
    lines += [rf"\item {escaped(line)}" for line in results]
    return "\n".join([*lines, r"\end{itemize}", r"\end{document}", ""])


def escaped(text: str) -> str:
    """Return plain text for LaTeX."""
    for character in "&%$#_{}":
        text = text.replace(character, "\\" + character)
    return text
