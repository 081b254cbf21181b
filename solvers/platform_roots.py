"""Roots of a taut subset's square system: found in floats, proved, and given a uniqueness box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE
from solvers import platform_newton as newton
from solvers import platform_pose as pose
from solvers import platform_turn as turn
from solvers.platform_model import HALF_TURNS, Model
from solvers.platform_scratch import enclose_pose_cell, enclose_turn_cell, form_arrays

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEWTON_STEPS = 40
FAR_OUT = 3.0
"""Newton may leave a chart's cube [-1, 1]^3; beyond this another chart finds the root better."""
INFLATIONS = 15
"""Rounds of epsilon-inflation before a candidate counts as not provable."""
REFINEMENTS = 3
"""Krawczyk steps after the proof; each contracts quadratically down to rounding."""
FIRST_REACH = 0.25
"""Half width in u of the first uniqueness box tried."""
LAST_REACH = 1e-9
"""Smallest one: below it rounding alone fills the box."""
ROD_WIDTH = 0.1
"""Widest box in u about a rod: the two kept moments then stay independent of the rod's direction."""
MARGIN = 0.1
"""Share by which a uniqueness box exceeds the enclosure it was made from."""


@dataclass(frozen=True)
class Reduction:
    """Which unknowns are free and which statics equations are kept, by chart.

    ``frozen[c]`` are the entries of u fixed at 0 in chart c, or None where the chart is not used.
    """

    frozen: tuple[tuple[int, ...] | None, ...]
    statics: tuple[int, ...]
    """Kept rows among (force, moment) in the base frame; with ``rod`` the moment is projected."""
    planar: bool = False
    rod: bool = False
    """Keep only the two moments across the line of the platform points (its z axis)."""

    def free(self, n: int, chart: int) -> Ints:
        """Return the indices of the free unknowns of z = (u, p, t)."""
        if not self.statics:
            return np.arange(6, dtype=np.int64)
        fixed = set(self.frozen[chart] or ())
        if self.planar:
            fixed.add(4)
        return np.array([k for k in range(6 + n) if k not in fixed], dtype=np.int64)

    def rows(self, z: Floats, chart: int) -> Floats:
        """Return the kept combinations of the six statics equations near the pose z."""
        unit = np.eye(6)
        if not self.rod:
            return np.ascontiguousarray(unit[list(self.statics)].reshape(-1, 6))
        axis = rotation(z[:3], chart)[:, 2]
        across = np.linalg.svd(axis[None, :])[2][1:]
        combinations = np.zeros((2, 6))
        combinations[:, 3:] = across
        return np.vstack([unit[:3], combinations])


GENERAL = Reduction(((), (), (), ()), (0, 1, 2, 3, 4, 5))
GEOMETRY = Reduction(((), (), (), ()), ())
"""Six taut cables: the lengths alone fix the pose, the tensions follow by a linear solve."""
ABOUT_VERTICAL = Reduction(((2,), (1,), (0,), None), (0, 1, 2, 3, 4))
"""Family (a): turning about the load direction z is taken out; its moment equation is dropped."""
ABOUT_ROD = Reduction(((2,), (1,), (0,), None), (0, 1, 2), rod=True)
"""Family (b): turning about the platform's z axis is taken out."""
PLANAR = Reduction(((0, 2), None, (0, 2), None), (0, 2, 4), planar=True)
"""The plane y = 0: one angle, two coordinates, three equilibrium equations."""


@dataclass(frozen=True, eq=False)
class Root:
    """A proved zero for every choice of lengths: exactly one in ``box``, no other one in ``unique``.

    Boxes are (6 + n, 2) in (u, p, t). ``core`` holds the zero for one choice of lengths. Two roots that
    coincide for one choice do so for all: zeros move continuously with the lengths, and none
    leaves ``box``, which lies inside ``unique``.
    """

    chart: int
    box: Floats
    unique: Floats
    core: Floats

    def holds(self, chart: int, lo: Floats, hi: Floats) -> bool:
        """Return True when the box [lo, hi] lies in the uniqueness box."""
        inside = self.chart == chart and np.all(self.unique[:, 0] <= lo) and np.all(hi <= self.unique[:, 1])
        return bool(inside)

    def row(self) -> Floats:
        """Return the uniqueness box as the kernels read it."""
        return np.concatenate([[self.chart], self.unique[:, 0], self.unique[:, 1]])


def rotation(u: Floats, chart: int) -> Floats:
    """Return R(u) D_c in floats, (3, 3)."""
    x = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
    result: Floats = (np.eye(3) + 2.0 / (1.0 + float(u @ u)) * (x + x @ x)) * HALF_TURNS[chart][None, :]
    return result


class Prover:
    """Finds and proves roots of one reduced system."""

    def __init__(self, model: Model, reduction: Reduction) -> None:
        self.model = model
        self.reduction = reduction
        self.turn_arrays = form_arrays(ROTATION_ONLY, turn.WIDTH)
        self.pose_arrays = form_arrays(WHOLE_POSE, pose.P_WIDTH)

    def start(self, chart: int, u: Floats, p: Floats) -> Floats:
        """Complete a pose to z = (u, p, t) with least-squares t; fixed coordinates become exactly 0."""
        model = self.model
        u, p = u.copy(), p.copy()
        u[list(self.reduction.frozen[chart] or ())] = 0.0
        if self.reduction.planar:
            p[1] = 0.0
        r = model.points[0, : model.n_taut] @ rotation(u, chart).T
        e = model.anchors[: model.n_taut] - r - p
        wrenches = np.hstack([e, np.cross(r, e) / model.size]).T
        load = np.concatenate([model.load, np.zeros(3)])
        t = np.linalg.lstsq(wrenches, -load, rcond=None)[0] if self.reduction.statics else np.zeros(len(e))
        return np.concatenate([u, p, t])

    def position_of(self, cell: Floats, in_position: bool) -> Floats:
        """Return p at the middle of a cell, in floats."""
        u = 0.5 * (cell[0:6:2] + cell[1:6:2])
        chart = int(cell[pose.P_CHART if in_position else turn.CHART])
        order = self.model.orders[0]
        centre = self.centres(chart, u)[order[0]]
        if in_position:
            return np.asarray(centre + 0.5 * (cell[6:12:2] + cell[7:12:2]))
        foot, normal, height_sq = self.branches(chart, u, order)
        return np.asarray(centre + foot + cell[turn.BRANCH] * np.sqrt(max(height_sq, 0.0)) * normal)

    def centres(self, chart: int, u: Floats) -> Floats:
        """Return the centres c_i = A_i - R b_i of the taut cables' spheres, (n, 3)."""
        n = self.model.n_taut
        centres: Floats = self.model.anchors[:n] - self.model.points[0, :n] @ rotation(u, chart).T
        return centres

    def branches(self, chart: int, u: Floats, order: Ints) -> tuple[Floats, Floats, float]:
        """Return foot, unit normal and squared height of the two positions x of a rotation."""
        model = self.model
        c = self.centres(chart, u)
        i, j = order[0], order[1]
        d2 = c[j] - c[i]
        k2 = 0.5 * (d2 @ d2 + model.lengths_sq[i] - model.lengths_sq[j])
        if model.planar:
            d3, k3 = np.array([0.0, 1.0, 0.0]), 0.0
        else:
            d3 = c[order[2]] - c[i]
            k3 = 0.5 * (d3 @ d3 + model.lengths_sq[i] - model.lengths_sq[order[2]])
        m = np.cross(d2, d3)
        normal = m / max(float(np.linalg.norm(m)), 1e-300)
        foot = np.linalg.lstsq(np.array([d2, d3, m]), np.array([k2, k3, 0.0]), rcond=None)[0]
        return foot, normal, float(model.lengths_sq[i] - foot @ foot)

    def polish(self, chart: int, z: Floats) -> Floats | None:
        """Run Newton in floats; None when it does not converge."""
        z = z.copy()
        rows, free = self.reduction.rows(z, chart), self.reduction.free(self.model.n_taut, chart)
        if not newton.newton(self.model, chart, rows, free, z, NEWTON_STEPS):
            return None
        return z if np.all(np.abs(z[:3]) < FAR_OUT) else None

    def prove(self, chart: int, z: Floats) -> Root | None:
        """Prove that exactly one root lies near the float zero z; None when that fails."""
        model = self.model
        rows, free = self.reduction.rows(z, chart), self.reduction.free(model.n_taut, chart)
        point = np.column_stack([z, z])
        m = len(free)
        jacobian, inverse = np.empty((m, m, 2)), np.empty((m, m))
        newton.jacobian_over(model, chart, rows, free, point, jacobian)
        if not newton.inverse_at(jacobian, inverse) or not np.all(np.isfinite(inverse)):
            return None
        box = self.existence_box(model, chart, rows, free, inverse, point)
        if box is None or (self.reduction.rod and np.ptp(box[:3], axis=1).max() > ROD_WIDTH):
            return None
        unique = self.uniqueness_box(chart, rows, free, inverse, box)
        if unique is None:
            return None
        core = box
        if np.any(model.lengths[:, 0] < model.lengths[:, 1]):
            one_choice = model._replace(lengths_sq_err=np.zeros_like(model.lengths_sq_err))
            found = self.existence_box(one_choice, chart, rows, free, inverse, point)
            core = box if found is None else found
        return Root(chart, box, unique, core)

    def existence_box(
        self, model: Model, chart: int, rows: Floats, free: Ints, inverse: Floats, point: Floats
    ) -> Floats | None:
        """Grow a box around the point until the Krawczyk operator maps it strictly into itself."""
        residual = np.empty((len(free), 2))
        newton.residual_at(model, chart, rows, free, point, residual)
        radius = np.abs(inverse) @ np.abs(residual).max(axis=1)
        scale = 1e-15 * (np.abs(point[free, 0]) + np.abs(point[:6, 0]).max())
        image = np.empty_like(point)
        box = point.copy()
        grown = np.column_stack([point[free, 0] - radius, point[free, 0] + radius])
        for _ in range(INFLATIONS):
            slack = MARGIN * (grown[:, 1] - grown[:, 0]) + scale
            box[free, 0] = grown[:, 0] - slack
            box[free, 1] = grown[:, 1] + slack
            if newton.krawczyk(model, chart, rows, free, inverse, box, image):
                return self.refined(model, chart, rows, free, inverse, box, image)
            grown = image[free].copy()
            if not np.all(np.isfinite(grown)):
                return None
        return None

    def refined(
        self, model: Model, chart: int, rows: Floats, free: Ints, inverse: Floats, box: Floats, image: Floats
    ) -> Floats:
        """Contract a proved box: the root lies in the box and in every image."""
        best = np.column_stack([np.maximum(box[:, 0], image[:, 0]), np.minimum(box[:, 1], image[:, 1])])
        for _ in range(REFINEMENTS):
            newton.krawczyk(model, chart, rows, free, inverse, best, image)
            best = np.column_stack([np.maximum(best[:, 0], image[:, 0]), np.minimum(best[:, 1], image[:, 1])])
        return best

    def uniqueness_box(
        self, chart: int, rows: Floats, free: Ints, inverse: Floats, box: Floats
    ) -> Floats | None:
        """Return the largest box tried around a proved root that is proved to hold no second one.

        Its shape is the enclosure of a search cell centred at the root, so that cells of half
        that size near the root fit into it.
        """
        reach = FIRST_REACH
        while reach > LAST_REACH:
            enclosure = self.cell_enclosure(chart, box, reach)
            if enclosure is not None:
                lo = np.minimum(enclosure[:, 0], box[:, 0])
                hi = np.maximum(enclosure[:, 1], box[:, 1])
                grow = MARGIN * (hi - lo)
                trial = box.copy()
                trial[free, 0] = (lo - grow)[free]
                trial[free, 1] = (hi + grow)[free]
                if newton.regular(self.model, chart, rows, free, inverse, trial):
                    return trial
            reach *= 0.5
        return None

    def cell_enclosure(self, chart: int, box: Floats, reach: float) -> Floats | None:
        """Enclose (u, p, t) over a cell in u or in (u, x) of half width ``reach`` around a root."""
        model = self.model
        lo, hi = np.empty(6 + model.n_taut), np.empty(6 + model.n_taut)
        cell = self.cell_around(chart, box, reach, turn.WIDTH)
        pivot = model.orders[0, 0]
        z = box.mean(axis=1)
        x = z[3:6] - self.centres(chart, z[:3])[pivot]
        cell[turn.CHART] = chart
        cell[turn.BRANCH] = np.sign(self.branches(chart, z[:3], model.orders[0])[1] @ x)
        if enclose_turn_cell(self.turn_arrays, model, cell, lo, hi):
            return np.column_stack([lo, hi])
        cell = self.cell_around(chart, box, reach, pose.P_WIDTH)
        for k in range(3):
            pad = 0.0 if k == 1 and model.planar else reach * model.size
            cell[6 + 2 * k], cell[7 + 2 * k] = x[k] - pad, x[k] + pad
        cell[pose.P_CHART] = chart
        if enclose_pose_cell(self.pose_arrays, model, cell, lo, hi):
            return np.column_stack([lo, hi])
        return None

    def cell_around(self, chart: int, box: Floats, reach: float, columns: int) -> Floats:
        """Return a cell of ``columns`` columns with u within ``reach`` of a root's."""
        cell = np.zeros(columns)
        frozen = self.reduction.frozen[chart] or ()
        for k in range(3):
            pad = 0.0 if k in frozen else reach
            cell[2 * k], cell[2 * k + 1] = box[k, 0] - pad, box[k, 1] + pad
        return cell

    def unsettled(self, cells: Floats, roots: list[Root], in_position: bool) -> Floats:
        """Return the cells whose equilibria are not all in one root's uniqueness box.

        The search looks before it contracts a cell; here the contracted leaves get a last look.
        """
        lo, hi = np.empty(6 + self.model.n_taut), np.empty(6 + self.model.n_taut)
        column = pose.P_CHART if in_position else turn.CHART
        keep = np.ones(len(cells), dtype=bool)
        for k, cell in enumerate(cells):
            if in_position:
                known = enclose_pose_cell(self.pose_arrays, self.model, cell, lo, hi)
            else:
                known = enclose_turn_cell(self.turn_arrays, self.model, cell, lo, hi)
            keep[k] = not (known and any(r.holds(int(cell[column]), lo, hi) for r in roots))
        return cells[keep]
