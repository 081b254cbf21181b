"""Every kernel of platforms asked for once, so that none is left to be compiled or loaded."""

from __future__ import annotations

import numpy as np

from cdpr_interval.mechanics.rotation import rotation_at
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.tube import SYMBOLS, tube
from cdpr_interval.robots.formats.reader import load_robot
from solvers.point_mass.controller import StraightPointMass
from solvers.questions.force import ZERO
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import Options, Problem
from solvers.six_dof.cells.kinds import POSE_CELLS, ROTATION_CELLS
from solvers.six_dof.cells.roots import GENERAL, system_of
from solvers.six_dof.cells.tube_prover import forms_of_thread
from solvers.six_dof.forward import solve
from solvers.six_dof.switch import System

QUESTIONS = (
    ("uc2", "7.5,8", (0, 1)),
    ("uc3", "7.5+-0.001,8+-0.001,7+-0.001", (0, 1, 2)),
    ("uc3", "7.5,8,7", (0, 1, 2)),
)
"""Robots, lengths and taut cables: two planes need the searches with and without the position, three cables
both searches together; ranges of lengths have kernels of their own."""


def searches() -> None:
    """Ask for what every search of a platform may call; a second of work when all is compiled."""
    for name, lengths, taut in QUESTIONS:
        robot = load_robot(name)
        problem = Problem(robot, read_lengths(lengths, robot.cable_names), ZERO, taut)
        solve(problem, Options())
    # What only cells near a fold, and cables that are just tight, need.
    system = System(problem, taut, 0)
    bounds = np.ones((6 + len(taut), 2))
    system.at(bounds)
    rotation_at(np.zeros(3), np.empty((3, 3)))
    for kind in (ROTATION_CELLS, POSE_CELLS):
        kind.enclose(system.model, np.zeros(kind.columns.width), bounds[:, 0].copy(), bounds[:, 1].copy())
    tensions_of_six(system.model)


def tensions_of_six(model: Model) -> None:
    """Ask for what the tensions of six cables need along a tube, whatever the model."""
    system, k = system_of(GENERAL, model.n_taut), 6 + model.n_taut
    free, m = system.free[0].copy(), system.free.shape[1]
    zero, inverse, radii, hull = np.ones(k), np.empty((m, m)), np.empty(m), np.empty((k, 2))
    tube(forms_of_thread(SYMBOLS), SYMBOLS, model, 0, system.rows, free, zero, inverse, radii, hull)


def points() -> None:
    """Ask for what the subsets need whose cables meet in one point of the platform."""
    StraightPointMass(load_robot("merlet_4_1")).warm_up()
