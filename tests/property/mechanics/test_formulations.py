"""The fast search against others on random robots: the same poses, none lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from solvers import forward_kinematics
from solvers.answers.data import Outcome
from solvers.answers.result import Result
from solvers.six_dof import forward as six_dof
from solvers.six_dof.cells.kinds import POSE_CELLS
from solvers.six_dof.cells.subset_search import SubsetSearch, position_cells, start_cells
from tests.support.planted.platform import Planted, plant
from tests.support.planted.verdict import agrees, holds

SEEDS = range(3)
KINDS = ("two-cables", "general-3", "general-4", "general-5", "general-6", "shared-points-4", "chart-face-3")
STARTS, STEPS = 1500, 40


class InAllVariables(SubsetSearch):
    """The search in all six variables of a pose from the start: no triangulation, no branches."""

    def solve(self) -> None:
        self.rounds(position_cells(self.model, start_cells(self.reduction)), POSE_CELLS)


def poses(planted: Planted) -> Result:
    result = forward_kinematics(
        planted.robot,
        planted.lengths,
        taut=planted.taut,
        external_force=planted.external_force,
        cell_limit=2_000_000,
    )
    assert result.outcome is Outcome.COMPLETE, result.message
    return result


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_all_variables_give_the_same_poses(kind: str, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    planted = plant(kind, 700 + seed)
    print(f"kind {kind}, seed {700 + seed}")
    fast = poses(planted)
    monkeypatch.setattr(six_dof, "SubsetSearch", InAllVariables)
    full = poses(planted)
    assert full.statistics.cells != fast.statistics.cells
    assert len(fast.solutions) == len(full.solutions)
    assert any(agrees(planted, solution) for solution in fast.solutions)
    for a in fast.solutions:
        same = [b for b in full.solutions if meet(a.position, b.position) and meet(a.rotation, b.rotation)]
        assert len(same) == 1
        assert (same[0].taut, same[0].stability) == (a.taut, a.stability)
        assert meet(a.tensions, same[0].tensions) and meet(a.distances, same[0].distances)


def meet(a: Any, b: Any) -> bool:
    """Return True when bounds overlap everywhere: both enclose the same pose."""
    return bool(np.all(a[..., 0] <= b[..., 1]) and np.all(b[..., 0] <= a[..., 1]))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_newton_from_anywhere_finds_nothing_new(kind: str, seed: int) -> None:
    """Plain floats on unit quaternions, positions and tensions, sharing no code with the solver."""
    planted = plant(kind, 800 + seed)
    print(f"kind {kind}, seed {800 + seed}")
    solutions = poses(planted).solutions
    com = np.array([float(x) for x in planted.robot.platform.centre_of_mass])
    met = set()
    for rotation, position in static_poses(planted, np.random.default_rng(seed)):
        hit = [k for k, s in enumerate(solutions) if holds(s, rotation, position, com)]
        assert hit, f"lost: position {position}, rotation {rotation.tolist()}"
        met.update(hit)
    assert met


def static_poses(planted: Planted, rng: np.random.Generator) -> list[Any]:
    """Return the poses (rotation, position of the origin) that Newton finds from random starts."""
    robot, n = planted.robot, len(planted.taut)
    exits = np.array([[float(x) for x in c.frame_anchor] for c in robot.cables])
    com = np.array([float(x) for x in robot.platform.centre_of_mass])
    arms = np.array([[float(x) for x in c.platform_anchor] for c in robot.cables]) - com
    lengths = np.array([float(lo) for lo, _ in planted.lengths])
    load = np.array([float(x) for x in planted.load])
    taut, force = list(planted.taut), float(np.linalg.norm(load))

    def residual(z: Any) -> Any:
        """Return the equations (starts, 7 + n) of z = (quaternion, centre of mass, tension / length)."""
        r = np.einsum("sij,cj->sci", rotations(z[:, :4]), arms[taut])
        e = exits[taut] - z[:, None, 4:7] - r
        t = z[:, 7:, None] * force
        return np.concatenate(
            [
                (z[:, :4] ** 2).sum(axis=1, keepdims=True) - 1.0,
                (e**2).sum(axis=2) - lengths[taut] ** 2,
                (t * e).sum(axis=1) / force + load / force,
                (t * np.cross(r, e)).sum(axis=1) / force,
            ],
            axis=1,
        )

    z = np.empty((STARTS, 7 + n))
    z[:, :4] = rng.normal(size=(STARTS, 4))
    z[:, :4] /= np.linalg.norm(z[:, :4], axis=1, keepdims=True)
    z[:, 4:7] = exits[taut].mean(axis=0) + rng.normal(size=(STARTS, 3)) * lengths[taut].max()
    z[:, 7:] = rng.random((STARTS, n)) / lengths[taut].min()
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            f = residual(z)
            J = np.empty((*f.shape, z.shape[1]))
            for k in range(z.shape[1]):
                # The derivative by a complex step: exact but for rounding.
                w = z.astype(complex)
                w[:, k] += 1e-30j
                J[:, :, k] = residual(w).imag / 1e-30
            good = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(f).all(axis=1)
            z, f, J = z[good], f[good], J[good]
            steps = np.linalg.solve(J + 1e-14 * np.eye(J.shape[1]), f[..., None])[..., 0]
            # A step no longer than 1 keeps Newton from jumping about.
            z = z - steps / np.maximum(1.0, np.abs(steps).max(axis=1, keepdims=True))
    converged = np.abs(residual(z)).max(axis=1) < 1e-10
    converged &= np.abs(steps).max(axis=1) < 1e-7
    converged &= (z[:, 7:] > 1e-7).all(axis=1)
    found = []
    for x in z[converged]:
        R = rotations(x[None, :4])[0]
        e = exits - x[4:7] - arms @ R.T
        slack = [i for i in range(len(lengths)) if i not in taut]
        if (np.linalg.norm(e[slack], axis=1) < lengths[slack] - 1e-7).all():
            found.append((R, x[4:7] - R @ com))
    return found


def rotations(q: Any) -> Any:
    """Return the rotations (..., 3, 3) of quaternions, times their squared norm."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
