"""What is known of a pose in another chart: every choice stays within the radii, and these stay small."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np

from solvers.six_dof.way import turned

SEED = 20261130


def exactly(before: int, after: int, u: list[Fraction]) -> list[Fraction]:
    """Return u in another chart in exact numbers."""
    x, y, z = u
    one = Fraction(1)
    products = ((one, x, y, z), (-x, one, z, -y), (-y, -z, one, x), (-z, y, -x, one))
    w, x, y, z = (q / products[before][after] for q in products[before])
    return list(((x, y, z), (-w, -z, y), (z, -w, -x), (-y, x, -w))[after])


def test_radii_in_another_chart_hold_and_stay_small() -> None:
    rng = random.Random(SEED)
    for _ in range(300):
        before, after = rng.sample(range(4), 2)
        k = (before ^ after) - 1
        zero, radii = np.zeros(8), np.zeros(8)
        zero[:3] = [rng.uniform(-1.2, 1.2) for _ in range(3)]
        zero[k] = rng.choice((-1, 1)) * rng.uniform(1.2, 1.5)
        radii[:3] = [rng.choice((0.0, 10.0 ** rng.uniform(-12, -0.5))) for _ in range(3)]
        there, around = turned(before, after, zero, radii)
        for _ in range(8):
            signs = [rng.choice((-1, 1)) for _ in range(3)]
            u = [Fraction(x) + s * Fraction(r) for x, r, s in zip(zero[:3], radii[:3], signs, strict=True)]
            for x, c, r in zip(exactly(before, after, u), there[:3], around[:3], strict=True):
                assert abs(x - Fraction(float(c))) <= Fraction(float(r))
        if radii[:3].max() < 0.01:
            assert around[:3].max() <= 2.0 * radii[:3].max() + 1e-13


def test_nothing_is_known_where_the_other_chart_may_have_a_pole() -> None:
    zero, radii = np.array([1.2, 0.0, 0.0, 0.0]), np.array([1.3, 0.0, 0.0, 0.0])
    _, around = turned(0, 1, zero, radii)
    assert np.isinf(around[:3]).all()
