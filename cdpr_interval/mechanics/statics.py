"""Cable directions, wrenches and their derivatives at a pose, in plain floats.

Wrenches are about the centre of mass G in base axes; moments are divided by the platform's radius, so
that all six rows are forces. A point mass has the three force rows only.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import InputError
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables import path
from cdpr_interval.mechanics.cables.law import Route
from cdpr_interval.mechanics.cables.path import OffTheCable, Path
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.orientation import rotation_from_vector, vector_from_rotation
from cdpr_interval.robots.cable_robot import Robot

Floats = NDArray[np.float64]
FLOATS = path.Floats()


@dataclass(frozen=True, eq=False)
class Pose:
    """Platform origin in the base frame and rotation from platform to base, plain floats."""

    position: NDArray[np.float64]
    """(3,) m."""
    rotation: NDArray[np.float64]
    """(3, 3)."""


@dataclass(frozen=True, eq=False)
class StaticModel:
    """A robot and its load as float arrays."""

    names: tuple[str, ...]
    routes: tuple[Route, ...]
    exits: Floats | None
    """A_i, (N, 3) m, base frame; None where a cable runs over a pulley."""
    arms: Floats
    """B_i - G, (N, 3) m, platform frame."""
    centre: Floats
    """G, (3,) m, platform frame."""
    load: Floats
    """(3,) N, base axes: weight and external force."""
    rows: int
    """Of a wrench: 6, or 3 where there are no moments (all cables end at G)."""

    @property
    def radius(self) -> float:
        """Largest distance of a platform point from G, m; 1 for a point mass."""
        return 1.0 if self.rows == 3 else float(np.linalg.norm(self.arms, axis=1).max())

    @property
    def load_wrench(self) -> Floats:
        """The load as a scaled wrench, (3,) or (6,) N."""
        return self.load if self.rows == 3 else np.concatenate([self.load, np.zeros(3)])

    def turned_arms(self, pose: Pose) -> Floats:
        """Return r_i = R (B_i - G), (N, 3) m, base axes."""
        return np.asarray(self.arms @ pose.rotation.T)

    def distances(self, pose: Pose) -> Floats:
        """Return how long the ways of the cables are, (N,) m; raises as `ways` does."""
        return self.ways(pose)[0]

    def ways(self, pose: Pose) -> tuple[Floats, Floats]:
        """Return how long the cables' ways are, (N,) m, and their unit vectors from the platform, (N, 3).

        Raises
        ------
        InputError
            When a platform anchor lies in its exit point, inside its pulley or on its swivel axis: such a
            cable has no direction.
        """
        anchors = pose.position + pose.rotation @ self.centre + self.turned_arms(pose)
        if self.exits is None:
            paths = [self._path(i, anchor) for i, anchor in enumerate(anchors.tolist())]
            return np.array([p.length for p in paths]), -np.array([p.direction for p in paths])
        spokes = self.exits - anchors
        distances: Floats = np.linalg.norm(spokes, axis=1)
        if not (distances > 0.0).all():
            name = self.names[int(np.argmin(distances))]
            raise InputError(f"pose: the length of cable '{name}' is zero at this pose")
        return distances, spokes / distances[:, None]

    def _path(self, cable: int, anchor: list[float]) -> Path:
        """Return the way of a cable to an anchor; `InputError` where there is none."""
        x, y, z = anchor
        try:
            return self.routes[cable].path((x, y, z), FLOATS)
        except OffTheCable:
            where = "inside its pulley or on its swivel axis"
            raise InputError(
                f"pose: the anchor of cable '{self.names[cable]}' is {where} at this pose"
            ) from None

    def turnings(self, pose: Pose) -> Floats:
        """Return the derivatives of the directions towards the platform by the anchors, (N, 3, 3) 1/m."""
        if self.exits is not None:
            distances, units = self.ways(pose)
            outer = units[:, :, None] * units[:, None, :]
            return np.asarray((np.eye(3) - outer) / distances[:, None, None])
        anchors = pose.position + pose.rotation @ self.centre + self.turned_arms(pose)
        rows = []
        for i, (x, y, z) in enumerate(anchors.tolist()):
            rows.append(self.routes[i].turning(self._path(i, [x, y, z]), (x, y, z), FLOATS))
        return np.array(rows)

    def wrenches(self, pose: Pose) -> Floats:
        """Return the scaled wrench of unit tension of each cable, (3 or 6, N)."""
        arms, units = self.turned_arms(pose), self.ways(pose)[1]
        if self.rows == 3:
            return units.T
        return np.vstack([units.T, np.cross(arms, units).T / self.radius])

    def wrench_derivative(self, pose: Pose, tensions: Floats) -> Floats:
        """Return the derivative of the cables' total wrench by the pose, tensions (N,) fixed.

        Rows as `wrenches`; columns: translation of G (m) and, unless a point mass, rotation vector
        in base axes times the radius (m); (3, 3) or (6, 6) N/m.
        """
        arms, units = self.turned_arms(pose), self.ways(pose)[1]
        total = np.zeros((6, 6))
        for arm, unit, turn, tension in zip(arms, units, self.turnings(pose), tensions, strict=True):
            # An anchor moves by v + omega x arm = v - [arm] omega.
            motion = np.hstack([np.eye(3), -_cross_matrix(arm) / self.radius])
            turning = -turn @ motion
            swing = np.hstack([np.zeros((3, 3)), -_cross_matrix(arm) / self.radius])
            total[:3] += tension * turning
            total[3:] += tension / self.radius * (_cross_matrix(arm) @ turning - _cross_matrix(unit) @ swing)
        return total[:3, :3] if self.rows == 3 else total

    def moved(self, pose: Pose, step: Floats) -> Pose:
        """Return the pose after a step in the columns of `wrench_derivative`."""
        centre = pose.position + pose.rotation @ self.centre + step[:3]
        if self.rows == 3:
            return Pose(centre - pose.rotation @ self.centre, pose.rotation)
        turned = rotation_from_vector(step[3:] / self.radius) @ pose.rotation
        # One Newton step towards the nearest orthogonal matrix keeps rounding from adding up.
        rotation = turned @ (3.0 * np.eye(3) - turned.T @ turned) / 2.0
        return Pose(centre - rotation @ self.centre, rotation)

    def displacement(self, start: Pose, end: Pose) -> Floats:
        """Return the step from one pose to another, (3,) or (6,) m, as `moved` takes it."""
        shift = end.position - start.position + (end.rotation - start.rotation) @ self.centre
        if self.rows == 3:
            return np.asarray(shift)
        return np.concatenate([shift, self.radius * vector_from_rotation(end.rotation @ start.rotation.T)])

    def travel(self, start: Pose, end: Pose) -> float:
        """Return how far the point of the platform that moves most goes, m: an anchor or G."""
        shift = end.position - start.position + (end.rotation - start.rotation) @ self.centre
        turned = self.arms @ (end.rotation - start.rotation).T
        return float(np.linalg.norm(np.vstack([shift, shift + turned]), axis=1).max())


def static_model(robot: Robot, external_force: Vector) -> StaticModel:
    """Return the float model of a robot; every number is the double nearest to the exact one."""
    under_load = loaded(robot, external_force)
    return StaticModel(
        names=robot.cable_names,
        routes=tuple(model.route for model in under_load.models),
        exits=None
        if any(m.route.fixed_exit is None for m in under_load.models)
        else _array(under_load.exits),
        arms=_array(under_load.arms),
        centre=_array([under_load.centre])[0],
        load=_array([under_load.load])[0],
        rows=6 if any(map(any, under_load.arms)) else 3,
    )


def _array(vectors: Iterable[Vector]) -> Floats:
    return np.array([[float(x) for x in vector] for vector in vectors], dtype=np.float64)


def _cross_matrix(v: Floats) -> Floats:
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
