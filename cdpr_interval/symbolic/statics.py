"""The static poses of a point mass on n cables that all carry load, as one polynomial system.

With exit points A_i, distances rho_i = |C - A_i|, tensions tau_i and the load f the balance is

    sum w_i (C - A_i) = f,    w_i = tau_i / rho_i.

Elastic cables have tau_i = k_i (rho_i - l_i), given tensions are constants; both are w_i = u_i - v_i /
rho_i. With A_1 as origin, a_i = A_i - A_1, T = sum w_i and M = f + sum w_i a_i, C = A_1 + M / T, and what
is left is

    S:    rho_1^2 T^2 = |M|^2,
    D_i:  T (rho_i^2 - rho_1^2 - |a_i|^2) + 2 a_i . M = 0    (i = 2..n),

equation (4) of Merlet, "The kinematics of the redundant N-1 wire driven parallel robot" (2012), for cable 1
and its differences with the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import fmpq

Exact = list[fmpq]


@dataclass(frozen=True)
class Statics:
    """Exact data: lengths in m, forces in N.

    ``u`` and ``v`` in N/m and N: w_i = u_i - v_i / rho_i.
    """

    exits: list[Exact]
    load: Exact
    u: Exact
    v: Exact

    @classmethod
    def elastic(cls, exits: list[Exact], load: Exact, stiffness: Exact, lengths: Exact) -> Statics:
        """Return the system of springs with constants in N/m and unstretched lengths in m."""
        return cls(exits, load, list(stiffness), [k * x for k, x in zip(stiffness, lengths, strict=True)])

    @classmethod
    def given_tensions(cls, exits: list[Exact], load: Exact, tensions: Exact) -> Statics:
        """Return the system of cables whose tensions in N are known."""
        return cls(exits, load, [fmpq(0)] * len(tensions), [-t for t in tensions])

    @property
    def count(self) -> int:
        """Number of cables."""
        return len(self.exits)

    def arms(self) -> list[Exact]:
        """Return a_i = A_i - A_1."""
        return [[x - y for x, y in zip(a, self.exits[0], strict=True)] for a in self.exits]

    def reordered(self, order: Sequence[int]) -> Statics:
        """Return the system with its cables in another order."""
        return Statics(
            [self.exits[i] for i in order], self.load, [self.u[i] for i in order], [self.v[i] for i in order]
        )


def dot(a: Exact, b: Exact) -> fmpq:
    """Return the scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), fmpq(0))
