"""Stability where a tension may be zero: such a cable can let go, so it holds nothing back."""

import pytest
from flint import arb

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.energy import classify
from cdpr_interval.mechanics.stability import Stability

UP = balls.vector([arb(0), arb(0), arb(1)])
BELOW = balls.vector([arb(0), arb(0), arb(-1)])
"""The carrying cable holds a point under the centre of mass: balanced; over it: hanging."""
TURNING = balls.vector([arb(0), arb(0), arb(0), arb(0), arb(0), arb(1)])
OTHERS = [
    ([1, 0, 0], [0, 1, 0]),
    ([0, 1, 0], [0, 0, 1]),
    ([1, 1, 0], [1, 0, 0]),
    ([1, 0, 1], [0, 1, 1]),
    ([0, 1, 1], [1, 0, 1]),
]
"""Spokes and arms of five cables that together with the first leave no motion free."""


def stability(arm: object, others: int, density: arb, slack_open: bool) -> Stability:
    """Classify a pose of one carrying cable along the load and some others of one density."""
    spokes = [UP, *(balls.vector([arb(x) for x in e]) for e, _ in OTHERS[:others])]
    arms = [arm, *(balls.vector([arb(x) for x in r]) for _, r in OTHERS[:others])]
    return classify(spokes, arms, [arb(1), *[density] * others], [TURNING], slack_open)


def test_one_cable_hangs_stably_and_balances_unstably():
    assert stability(UP, 0, arb(0), False) is Stability.STABLE
    assert stability(BELOW, 0, arb(0), False) is Stability.UNSTABLE


@pytest.mark.parametrize("others", range(1, 6))
def test_cables_without_a_proved_tension_do_not_make_a_balanced_pose_stable(others: int):
    nearly_zero = arb(0, 1e-20)
    assert stability(BELOW, others, nearly_zero, True) is Stability.UNDECIDED
    assert stability(UP, others, nearly_zero, True) is Stability.STABLE


def test_cables_that_carry_do_hold_it():
    assert stability(BELOW, 5, arb(1), False) is Stability.STABLE
