"""Some taut cables as a system of `solvers.point_mass.ranges.sensitivity`: the others carry nothing.

Unknowns: the position p and the multipliers t_i of the cables, N/m. Equations: |p - A_i|^2 / 2 = h_i^2 / 2
with h_i the distance at which a cable has the multiplier t_i (its length; of a spring k l / (k - t)), and
sum t_i (p - A_i) = f.

They say that L = sum t_i / 2 |p - A_i|^2 - f . p - sum psi_i(t_i), psi_i' = h_i^2 / 2, is stationary. Where
the multipliers have a positive sum and are below k, L is strictly convex in p and concave in t, h_i does
not fall: two zeros there have the same p.

Of inextensible cables the load's scale is no datum of the system: it multiplies the tensions afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from cdpr_interval.exact.balls import from_bounds
from solvers.point_mass.guesses.lowest import lowest_of_subset
from solvers.point_mass.one_call import guess_elastic
from solvers.point_mass.ranges.choices import Choices
from solvers.point_mass.ranges.sensitivity import ONE, ZERO, Balls, Output, Zero, data_balls

ROUNDING = 1e-10


@dataclass(frozen=True, eq=False)
class TautCables:
    """The cables ``taut`` of the robot of some choices."""

    choices: Choices
    taut: tuple[int, ...]

    @property
    def size(self) -> int:
        """Unknowns."""
        return 3 + len(self.taut)

    def start(self, d: Sequence[float]) -> Balls | None:
        """Return a guess of position and multipliers."""
        n, arrays = self.choices.count, self.choices.arrays
        A, L = np.array(d[n : 4 * n]).reshape(n, 3), np.array(d[:n])
        f = arrays.load.mean(axis=1) * (d[5 * n + 3] if arrays.is_elastic else 1.0) + np.array(
            d[5 * n : 5 * n + 3]
        )
        if arrays.is_elastic:
            given = np.array(d[4 * n : 5 * n])
            k = np.where(arrays.constant, given, given / L)
            x = np.zeros(3 + max(n, 4))
            guess_elastic(A, L, k, f, np.zeros(max(n, 4), dtype=np.int64), x)
            p = x[:3]
            t = k * (1.0 - L / np.linalg.norm(p - A, axis=1))
            found = [*p.tolist(), *t[list(self.taut)].tolist()]
        else:
            p, t = np.zeros(3), np.zeros(4)
            taut = np.array([*self.taut, 0, 0, 0][:4], dtype=np.int64)
            if not lowest_of_subset(A, L, f, taut, len(self.taut), p, t):
                return None
            found = [*p.tolist(), *t[: len(self.taut)].tolist()]
        return [arb(v) for v in found] if np.isfinite(found).all() else None

    def spoke(self, cable: int, x: Balls, d: Balls) -> Balls:
        """Return p - A of a cable."""
        first = self.choices.count + 3 * cable
        return [x[j] - d[first + j] for j in range(3)]

    def _law(self, cable: int, t: arb, d: Balls) -> tuple[arb, arb, arb, arb]:
        """Return h and its derivatives by t, by the length and by the spring's number."""
        length, given = d[cable], d[4 * self.choices.count + cable]
        if not self.choices.arrays.is_elastic:
            return length, ZERO, ONE, ZERO
        if self.choices.arrays.constant[cable]:
            left = given - t
            ratio = given / left
            return length * ratio, length * ratio / left, ratio, -length * t / (left * left)
        h = 1 / (1 / length - t / given)
        return h, h * h / given, (h / length) ** 2, -t * (h / given) ** 2

    def _load(self, d: Balls) -> Balls:
        n, arrays = self.choices.count, self.choices.arrays
        scale = d[5 * n + 3] if arrays.is_elastic else ONE
        return [from_bounds(*row) * scale + d[5 * n + j] for j, row in enumerate(arrays.load.tolist())]

    def residual(self, x: Balls, d: Balls) -> Balls:
        """Return G."""
        rest = [-f for f in self._load(d)]
        rows = []
        for a, i in enumerate(self.taut):
            e = self.spoke(i, x, d)
            h = self._law(i, x[3 + a], d)[0]
            rows.append((e[0] * e[0] + e[1] * e[1] + e[2] * e[2] - h * h) / 2)
            rest = [r + x[3 + a] * v for r, v in zip(rest, e, strict=True)]
        return [*rows, *rest]

    def jacobian(self, x: Balls, d: Balls) -> arb_mat:
        """Return dG/dx."""
        m = len(self.taut)
        total = sum(x[3:], ZERO)
        rows = [[ZERO] * (3 + m) for _ in range(3 + m)]
        for a, i in enumerate(self.taut):
            e = self.spoke(i, x, d)
            h, by_t, _, _ = self._law(i, x[3 + a], d)
            rows[a][3 + a] = -h * by_t
            for j in range(3):
                rows[a][j] = rows[m + j][3 + a] = e[j]
        for j in range(3):
            rows[m + j][j] = total
        return arb_mat(rows)

    def by_data(self, x: Balls, d: Balls) -> dict[int, list[tuple[int, arb]]]:
        """Return dG/d d_k."""
        n, m, arrays = self.choices.count, len(self.taut), self.choices.arrays
        found = {5 * n + j: [(m + j, -ONE)] for j in range(3)}
        if arrays.is_elastic:
            found[5 * n + 3] = [(m + j, -from_bounds(*row)) for j, row in enumerate(arrays.load.tolist())]
        for a, i in enumerate(self.taut):
            e = self.spoke(i, x, d)
            h, _, by_length, by_given = self._law(i, x[3 + a], d)
            found[i] = [(a, -h * by_length)]
            if arrays.is_elastic:
                found[4 * n + i] = [(a, -h * by_given)]
            for j in range(3):
                found[n + 3 * i + j] = [(a, -e[j]), (m + j, -x[3 + a])]
        return found

    def tension(self, cable: int, x: Balls, d: Balls) -> Output:
        """Return t h; zero for a cable that is not of the taut ones."""
        slopes = [ZERO] * self.size
        if cable not in self.taut:
            return Output(ZERO, slopes, {})
        a = self.taut.index(cable)
        t = x[3 + a]
        h, by_t, by_length, by_given = self._law(cable, t, d)
        slopes[3 + a] = h + t * by_t
        by_data = {cable: t * by_length}
        if self.choices.arrays.is_elastic:
            by_data[4 * self.choices.count + cable] = t * by_given
        return Output(t * h, slopes, by_data)

    def rules(self, x: Balls, d: Balls) -> tuple[int, ...]:
        """Return the cables of which it is open whether they keep their rule."""
        return tuple(i for i in range(self.choices.count) if not self.rule(i, x, d).value >= 0)

    def rule(self, cable: int, x: Balls, d: Balls) -> Output:
        """Return the multiplier of a taut cable, or (l^2 - |p - A|^2) / 2 of another one."""
        slopes = [ZERO] * self.size
        if cable in self.taut:
            a = 3 + self.taut.index(cable)
            slopes[a] = ONE
            return Output(x[a], slopes, {})
        e, length = self.spoke(cable, x, d), d[cable]
        slopes[:3] = [-v for v in e]
        first = self.choices.count + 3 * cable
        by_data = {cable: length, **{first + j: e[j] for j in range(3)}}
        return Output((length * length - e[0] * e[0] - e[1] * e[1] - e[2] * e[2]) / 2, slopes, by_data)

    def is_pose(self, x: Balls, d: Balls) -> bool:
        """Return whether all taut cables pull, and the others are long enough, up to rounding."""
        n = self.choices.count
        p, t = np.array([float(v.mid()) for v in x[:3]]), [float(v.mid()) for v in x[3:]]
        A = np.array([float(v.mid()) for v in d[n : 4 * n]]).reshape(n, 3)
        L = np.array([float(v.mid()) for v in d[:n]])
        far = np.linalg.norm(p - A, axis=1) - L
        return min(t) >= -ROUNDING and all(far[i] <= ROUNDING for i in range(n) if i not in self.taut)

    def is_only(self, x: Balls, d: Balls) -> bool:
        """Return whether the multipliers have a positive sum and are below the springs' constants."""
        if not sum(x[3:], ZERO) > 0:
            return False
        return not self.choices.arrays.is_elastic or all(
            self._law(i, x[3 + a], d)[0] > 0 for a, i in enumerate(self.taut)
        )

    def pattern(self, zero: Zero) -> tuple[bool, tuple[int, ...]]:
        """Say whether the cables may be the taut ones of the pose for some choice, and what may change.

        Returns
        -------
        possible, open : bool, tuple of int
            Whether they may be; the cables that may not be on their side: taut ones whose multiplier may
            not be positive, others that may be too far.
        """
        x = zero.box
        d = data_balls(self.choices.bounds)
        open_ones = []
        for i in range(self.choices.count):
            if i in self.taut:
                t = x[3 + self.taut.index(i)]
                if t < 0:
                    return False, ()
                if not t > 0:
                    open_ones.append(i)
                continue
            e = self.spoke(i, x, d)
            square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2]
            if square > d[i] * d[i]:
                return False, ()
            if not square < d[i] * d[i]:
                open_ones.append(i)
        return True, tuple(open_ones)
