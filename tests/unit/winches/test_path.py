"""Paths are proved piece by piece: no gaps, pieces as long as can be, and what ends it."""

from __future__ import annotations

import numpy as np
import pytest

from cdpr_interval import load_robot
from solvers import inverse_kinematics
from solvers.questions.pose import read_pose
from solvers.winches import path as module
from solvers.winches.path import BLUNT, PathRefused, _Polyline, _proved, plan
from solvers.winches.where import Whereabouts

ROBOT = load_robot("four_winches")
LIMITS = [cable.winch.limits for cable in ROBOT.cables]


class Prover:
    """Refuses what is longer than it likes at that place, and keeps what it has accepted."""

    def __init__(self, likes, blunt=np.inf):
        self.likes, self.blunt = likes, blunt
        self.accepted, self.asked = [], 0

    def refutes(self, ranges, sharply=False):
        self.asked += 1
        travel = float((ranges[:, 1] - ranges[:, 0]).max())
        if travel > self.likes(float(ranges[0].mean())):
            return "too wide"
        if sharply and travel > self.blunt:
            return BLUNT
        self.accepted.append(ranges)
        return ""

    def compare(self, ranges):
        assert (ranges[:, 1] >= ranges[:, 0]).all()


def walk(cycles=400, width=0.0):
    """Return a path of three cables: one goes there and back, one rests, one goes on."""
    t = np.linspace(0, 1, cycles + 1) ** 2 * (3 - 2 * np.linspace(0, 1, cycles + 1))
    rows = np.stack([5 + np.sin(7 * t), np.full_like(t, 4.0), 3 + 2 * t], axis=1)
    return rows, np.full_like(rows, width)


@pytest.mark.parametrize("width", [0.0, 0.002])
@pytest.mark.parametrize("most", [1.0, 0.02, 0.0051])
def test_every_length_between_two_set_points_lies_in_a_proved_piece(width, most):
    rows, widths = walk(width=width)
    rng = np.random.default_rng(1)
    prover = Prover(lambda place: 2 * width + most * (0.5 + 0.5 * rng.random()))
    pieces = _proved(prover, _Polyline(rows, widths), 0.01, None)
    assert pieces == len(prover.accepted) - 1  # the first is the start alone
    boxes = np.array(prover.accepted[1:])
    for share in (0.0, 0.3, 0.999):
        places = rows[:-1] + share * (rows[1:] - rows[:-1])
        for place in (*places, rows[-1]):
            # What lies between two pieces by rounding alone is covered by what the widths are rounded up by.
            inside = (boxes[:, :, 0] + width - 1e-12 <= place) & (place <= boxes[:, :, 1] - width + 1e-12)
            assert inside.all(axis=1).any()


def test_pieces_grow_where_they_are_proved_and_shrink_where_not():
    rows, widths = walk()
    easy, hard = Prover(lambda place: 1.0), Prover(lambda place: 0.001 if place > 5.9 else 1.0)
    assert _proved(easy, _Polyline(rows, widths), 0.01, None) < 400
    _proved(hard, _Polyline(rows, widths), 0.01, None)
    travels = [float((box[:, 1] - box[:, 0]).max()) for box in hard.accepted[1:]]
    assert min(travels) < 0.001 and max(travels) == pytest.approx(max(
        float((box[:, 1] - box[:, 0]).max()) for box in easy.accepted
    ))  # fmt: skip
    assert hard.asked < 4 * len(hard.accepted)


@pytest.mark.parametrize("width", [0.0, 1.0])
def test_blunt_pieces_are_halved_but_never_refused(width):
    rows, widths = walk(width=width)
    prover = Prover(lambda place: 3.0, blunt=0.0)
    told = []
    _proved(prover, _Polyline(rows, widths), 0.01, told.append)
    longest = module.FINE_PIECE * rows.max()
    assert all((box[:, 1] - box[:, 0]).max() <= 2 * width + longest + 1e-12 for box in prover.accepted)
    assert [one.pieces for one in told] == list(range(1, len(told) + 1))
    assert (np.diff([one.seconds for one in told]) > 0).all() and told[-1].travel == 1.0
    assert told[-1].seconds == told[-1].duration == pytest.approx(4.0)


def test_what_is_never_proved_is_refused_with_its_place():
    rows, widths = walk(width=1e-3)
    with pytest.raises(PathRefused, match=r"near the lengths \(5\.5\d+, 4\.0000, 3\.\d+\) m: too wide"):
        _proved(Prover(lambda place: 0.0 if place > 5.55 else 1.0), _Polyline(rows, widths), 0.01, None)


def test_a_path_that_stands_still_is_proved_once():
    rows, widths = walk()
    assert _proved(Prover(lambda place: 1.0), _Polyline(rows[[3, 3, 3]], widths[:3]), 0.01, None) == 1


def test_an_interrupt_that_the_search_for_the_start_has_taken_is_not_lost(monkeypatch):
    held = inverse_kinematics(ROBOT, (2, 1.5, 1)).lengths
    monkeypatch.setattr(
        module, "whereabouts", lambda *_: Whereabouts((), "interrupted", False, is_interrupted=True)
    )
    with pytest.raises(KeyboardInterrupt):
        plan(ROBOT, LIMITS, held, [(length, length) for length in held], read_pose("1,1,0.6"))
