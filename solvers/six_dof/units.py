"""Units in which a platform is searched: powers of two of metre and newton, near its own size and load.

Proofs of roots compare unknowns of different kinds (rotation, position, tensions), which only works where
all are of moderate size. Scaling by powers of two is exact; robots of ordinary size keep their units.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.six_dof.arrays import Model
from solvers.six_dof.cells.columns import POSE_COLUMNS
from solvers.six_dof.cells.roots import Root
from solvers.six_dof.cells.tube import GluedTube, Tube

Floats = NDArray[np.float64]

LENGTH_STEP = 8
"""Lengths are scaled by powers of 2^8: platforms of 0.06 m to 16 m are left as they are."""
FORCE_STEP = 32
"""Forces are scaled by powers of 2^32: loads of 2e-5 N to 7e4 N are left as they are."""
SQUARES = ("square", "square_err", "lengths_sq", "lengths_sq_err")
FORCES = ("load", "load_err")
LENGTHS = (
    *("exits", "exits_err", "exit_steps", "exit_steps_err"),
    *("arms", "arms_err", "arm_steps", "arm_steps_err"),
    *("lengths", "exit_spread", "arm_spread", "gaps", "anchor_sides", "centre_sides", "size"),
)
"""Fields of a model by their dimension."""


class Units(NamedTuple):
    """The units of a model: 2^length m and 2^force N."""

    length: int = 0
    force: int = 0

    @property
    def inverse(self) -> Units:
        """The step back to m and N."""
        return Units(-self.length, -self.force)

    def __bool__(self) -> bool:
        return self.length != 0 or self.force != 0


METRES = Units()
"""Metre and newton."""


def units_of(model: Model) -> Units:
    """Return units near the platform's size and load."""
    load = float(np.abs(model.load).max())
    return Units(_step(model.size, LENGTH_STEP), _step(load, FORCE_STEP))


def _step(size: float, step: int) -> int:
    """Return the multiple of ``step`` nearest to the binary logarithm of a size."""
    return step * round(float(np.log2(size)) / step) if 0.0 < size < np.inf else 0


def in_units(model: Model, units: Units) -> Model | None:
    """Return a model of data in m and N in other units; None where a number would not be exact."""
    changed: dict[str, Any] = {}
    dimensions = ((LENGTHS, units.length), (SQUARES, 2 * units.length), (FORCES, units.force))
    for names, exponent in dimensions if units else ():
        for name in names:
            changed[name] = scaled(getattr(model, name), -exponent)
            if changed[name] is None:
                return None
    if changed:
        changed["size"] = float(changed["size"])
    return model._replace(**changed)


def scaled(values: Floats | float, exponent: int) -> Floats | None:
    """Return values times a power of two; None where that is not exact."""
    with np.errstate(over="ignore", under="ignore"):
        moved = np.ldexp(values, exponent)
        exact = np.array_equal(np.ldexp(moved, -exponent), values)
    return moved if exact else None


def root_in_metres(root: Root, units: Units) -> Root:
    """Return a root of a model in given units in m and N.

    Bounds stay bounds: what underflows is moved outwards.
    """
    # t = tension / length.
    exponents = np.array([0] * 3 + [units.length] * 3 + [units.force - units.length] * (len(root.box) - 6))
    changed: dict[str, Any] = {
        name: moved_outward(getattr(root, name), exponents) for name in ("box", "unique", "core")
    }
    if isinstance(root, Tube):
        column = exponents[:, None]
        radii, reach = np.ldexp(root.radii, exponents), np.ldexp(root.reach, exponents)
        changed |= {
            "polynomial": np.ldexp(root.polynomial, column),
            "sways": np.ldexp(root.sways, column),
            # What underflows is moved outwards, and inwards.
            "radii": np.where(root.radii > 0.0, np.maximum(radii, 1e-300), 0.0),
            "reach": np.where(reach > 1e-290, reach, 0.0),
            "squares": np.ldexp(root.squares, 2 * units.length),
            "radii_of_squares": np.ldexp(root.radii_of_squares, 2 * units.length),
        }
    elif isinstance(root, GluedTube):
        changed["halves"] = tuple(root_in_metres(half, units) for half in root.halves)
        changed["cut"] = float(np.ldexp(root.cut, 2 * units.length))
    return replace(root, **changed)


def moved_outward(box: Floats, exponents: NDArray[np.int64]) -> Floats:
    """Return bounds (k, 2) times powers of two, enclosed; exact but for overflow and underflow."""
    result = np.empty_like(box)
    with np.errstate(over="ignore", under="ignore"):
        for side, outward in ((0, -np.inf), (1, np.inf)):
            moved = np.ldexp(box[:, side], exponents)
            exact = np.ldexp(moved, -exponents) == box[:, side]
            result[:, side] = np.where(exact, moved, np.nextafter(moved, outward))
    return result


def cells_in_metres(cells: Floats, units: Units) -> Floats:
    """Return cells in (u, x) of a model in given units in m."""
    moved = cells.copy()
    position = slice(6, POSE_COLUMNS.chart)
    moved[:, position] = np.ldexp(cells[:, position], units.length)
    return moved
