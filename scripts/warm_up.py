"""Compile every kernel into numba's cache, once, before several processes need them.

Run as ``python scripts/warm_up.py``: some two minutes of processor time with an empty cache, else seconds.
"""

from __future__ import annotations

import importlib
import pkgutil
import time

from cdpr_interval import load_robot
from solvers import PointMass, Tracker, forward_kinematics
from solvers.forward import answer_question, pose_problem
from solvers.proofs.document import certificate_bytes
from solvers.questions.problem import Options
from solvers.six_dof.record import Record

PACKAGES = (
    "cdpr_interval.kernels",
    "cdpr_interval.engine",
    "cdpr_interval.mechanics",
    "solvers.point_mass",
    "solvers.six_dof",
)
"""Packages with kernels."""
QUESTIONS = {
    "merlet_4_1": ("2.6925824", "3.9051248", "3.3541019", "4.385"),
    "merlet_4_1_k100": ("2.955855", "2.955855", "4.10288", "4.10288"),
    "uc2": ("7.5", "8"),
    "uc3": ("7.5", "8", "7"),
}
"""Robots of each kind, with lengths."""


def warm_up() -> None:
    """Import every module with kernels, which compiles those with given types; solve for the others."""
    for name in PACKAGES:
        package = importlib.import_module(name)
        for module in pkgutil.walk_packages(package.__path__, f"{name}."):
            importlib.import_module(module.name)
    for name, lengths in QUESTIONS.items():
        robot = load_robot(name)
        result = forward_kinematics(robot, lengths)
        floats = [float(length) for length in lengths]
        if name.startswith("merlet"):
            PointMass(robot).solve(floats)
        else:
            Tracker(robot, result.solutions[0]).update(floats)
    # The searches of a certificate have kernels of their own.
    options = Options(record=Record())
    problem = pose_problem(robot, lengths, None, None, options)
    certificate_bytes(problem, options, answer_question(problem, options))


def main() -> None:
    """Compile, and say how long it took."""
    start = time.monotonic()
    warm_up()
    print(f"kernels are ready after {time.monotonic() - start:.0f} s")


if __name__ == "__main__":
    main()
