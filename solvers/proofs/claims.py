"""The roots of one search as a certificate claims them: each is tried with the checker's own tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.rotation import rotation_at
from certificates.arithmetic.floats import Floats
from certificates.problem import Listed
from certificates.root_claims import check_root
from certificates.search import Root as Claimed
from certificates.search import Search
from certificates.verdicts import NotProved
from solvers.six_dof.cells.roots import Root, pose_of
from solvers.six_dof.reduction import Reduced

NEAR = 1e-6
"""Entries of rotation matrices that differ by less may belong to one pose: it is checked."""
GROWTH = tuple(2.0**k for k in range(7, -6, -1))
"""Sizes of a root's box in (u, x) that are tried, over the solver's smallest half width in u."""


def claim(search: Search, reduced: Reduced, root: Root, listed: list[Listed]) -> Claimed | None:
    """Return the first claim about a root that the checker confirms, if any."""
    box = box_of(search, reduced, root)
    if box is None:
        return None
    for k in (*candidates(root, reduced, listed, search.setting.family), None):
        found = Claimed(root.chart, box, k)
        try:
            check_root(search, found, listed)
        except NotProved:
            continue
        return found
    return None


def box_of(search: Search, reduced: Reduced, root: Root) -> list[tuple[float, float]] | None:
    """Return the largest box tried in which the checker finds one zero at most, or None."""
    model = reduced.model
    z = root.core.mean(axis=1)
    turned = np.empty((3, 3))
    rotation_at(z[:3].copy(), turned)
    pivot = model.orders[0, 0]
    x = z[3:6] - model.exits[pivot] + turned @ model.arms[root.chart, pivot]
    flat = search.flat(root.chart)
    assert flat is not None
    widths = [hi - lo for lo, hi in root.unique[:3].tolist() if hi > lo]
    boxes = []
    for grown in GROWTH:
        half = grown * 0.5 * min(widths)
        reach = [half] * 3 + [half * model.size] * 3
        boxes.append(
            [
                (0.0, 0.0) if k in flat else (m - r, m + r)
                for k, (m, r) in enumerate(zip([*z[:3].tolist(), *x.tolist()], reach, strict=True))
            ]
        )
    system = search.system(root.chart)
    holds = system.one_zero(np.moveaxis(np.array(boxes), 0, -1), Floats)
    return boxes[int(np.argmax(holds))] if holds.any() else None


def candidates(root: Root, reduced: Reduced, listed: Sequence[Listed], family: bool) -> list[int]:
    """Return the solutions that a root's pose may be."""
    middle = balls.middle(pose_of(root, reduced.frame).rotation)

    def may_be(solution: Listed) -> bool:
        """Return True when a solution may be the root's: over ranges of lengths their middles differ."""
        near = NEAR + np.ptp(solution.rotation, axis=-1)
        return bool(np.all(np.abs(middle - np.mean(solution.rotation, axis=-1)) < near))

    return [
        k
        for k, solution in enumerate(listed)
        if (solution.family is not None) == family and (family or may_be(solution))
    ]


def root_entry(root: Claimed) -> dict[str, Any]:
    """Return a root as the document has it."""
    box = [[lo.hex(), hi.hex()] for lo, hi in root.box]
    return {"chart": root.chart, "u": box[:3], "x": box[3:], "pose": root.pose}
