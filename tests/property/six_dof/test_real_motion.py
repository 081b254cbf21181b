"""Motions of platforms on pulleys and elastic cables, held against Newton's method in floats."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from cdpr_interval.robots.cable_robot import Robot
from solvers import forward_kinematics
from solvers.motions.course import Course, given_course
from solvers.motions.platform import PlatformMover
from solvers.motions.real_platform import RealPlatformMover
from solvers.motions.stretch import Mover, Stretch
from solvers.motions.trail import Span, Trail, lead
from tests.support.planted.pulleys import FloatCable, Floats, Planted, plant
from tests.support.real_oracle import Body, Oracle, robot_of, start_of

NEAR = 1e-8
"""Errors of the poses in floats."""
STIFF = 1000.0
CASES = [
    (0, 3, 0.0),
    (1, 3, 0.0),  # a fold
    (5, 4, 0.0),  # c3 lets go
    (1, 5, 0.0),  # two of them
    (2, 5, 1e-3),
    (5, 6, 1e-3),  # three of them
    (1, 6, 0.0),
    (5, 3, 1e-3),  # a fold
]


def travelled(planted: Planted, lengths: Floats, seed: int, size: float) -> Floats:
    """Return other lengths; one cable is paid out most."""
    count = len(lengths)
    rng = np.random.default_rng(seed + 100 * count)
    after = lengths + size * rng.uniform(-1.0, 1.0, count)
    after[rng.integers(count)] += 2.0 * size
    return np.asarray(after)


def course_of(robot: Robot, *rows: Floats) -> Course:
    return given_course([(k, [Fraction(x) for x in row]) for k, row in enumerate(rows)], robot.cable_names)


def mover_at_start(planted: Planted, robot: Robot, lengths: Floats, course: Course) -> RealPlatformMover:
    return RealPlatformMover(robot, start_of(planted, robot, lengths), course.bounds(Fraction(0)))


def led(mover: Mover, course: Course) -> Trail:
    return lead(mover, course, course.knots(), Budget())


def is_in(body: Body, tube: Stretch) -> bool:
    """Return True where a pose in floats is what a tube says."""
    tensions = np.zeros(len(tube.tensions))
    tensions[list(body.taut)] = body.tensions
    pairs = ((body.position, tube.position), (body.rotation, tube.rotation))
    inside = all(((b[..., 0] - NEAR <= x) & (x <= b[..., 1] + NEAR)).all() for x, b in pairs)
    off = 1e-5
    carried = ((tube.tensions[:, 0] - off <= tensions) & (tensions <= tube.tensions[:, 1] + off)).all()
    return bool(inside and carried and set(tube.taut) <= set(body.taut) <= {*tube.taut, *tube.switching})


def check(trail: Trail, oracle: Oracle, body: Body, before: Floats, after: Floats, begin: int = 0) -> Body:
    """Hold a trail against poses in floats on a way that takes a second."""
    reached, steps = float(trail.reached) - begin, 250
    for share, found in oracle.along(body, before, after, steps):
        body = found
        if share > reached:
            break
        spans = at(trail, begin + share)
        assert spans and all(is_in(body, span.tube) for span in spans), share
    return body


def at(trail: Trail, time: float) -> list[Span]:
    return [span for span in trail.spans if span.begin <= time <= span.end]


def planted_start(seed: int, count: int, compliance: float) -> tuple[Planted, Robot, Floats, Body]:
    planted = plant(seed, count)
    robot = robot_of(planted, STIFF if compliance else None)
    lengths = planted.lengths - compliance * planted.tensions
    body = Body(planted.position, planted.rotation, tuple(range(count)), planted.tensions)
    return planted, robot, lengths, body


@pytest.mark.parametrize(("seed", "count", "compliance"), CASES)
def test_a_planted_pose_goes_where_newtons_method_goes(seed: int, count: int, compliance: float) -> None:
    planted, robot, lengths, body = planted_start(seed, count, compliance)
    after = travelled(planted, lengths, seed, 0.1)
    course = course_of(robot, lengths, after)
    trail = led(
        RealPlatformMover(robot, start_of(planted, robot, lengths), course.bounds(Fraction(0))), course
    )
    oracle = Oracle(planted, compliance)
    check(trail, oracle, body, lengths, after)
    shares = [share for share, _ in oracle.along(body, lengths, after, 250)]
    if shares[-1] == 1.0:
        assert trail.reached == 1 and not trail.reason
    else:
        # The pose ends: it is followed to its end, and not beyond.
        assert shares[-1] - 0.01 <= trail.reached <= shares[-1] + 0.01 and "may end there" in trail.reason
    assert all(a.end == b.begin for a, b in zip(trail.spans, trail.spans[1:], strict=False))


@pytest.mark.parametrize(("seed", "count", "compliance"), [(5, 4, 0.0), (1, 5, 0.0), (2, 5, 1e-3)])
def test_there_and_back_is_the_pose_of_the_start(seed: int, count: int, compliance: float) -> None:
    """Cables that became slack take hold again."""
    planted, robot, lengths, body = planted_start(seed, count, compliance)
    after = travelled(planted, lengths, seed, 0.1)
    course = course_of(robot, lengths, after, lengths)
    mover = mover_at_start(planted, robot, lengths, course)
    start = mover.here
    trail = led(mover, course)
    assert trail.reached == 2
    oracle = Oracle(planted, compliance)
    there = check(trail, oracle, body, lengths, after)
    check(trail, oracle, there, after, lengths, begin=1)
    assert set(there.taut) < set(range(count))
    assert mover.here.taut == tuple(range(count)) and not mover.here.is_apart(start)


@pytest.mark.parametrize(
    ("seed", "count", "compliance", "tolerance"), [(5, 4, 0.0, 5e-5), (1, 5, 1e-3, 1e-5)]
)
def test_every_choice_of_the_lengths_lies_in_the_tube(
    seed: int, count: int, compliance: float, tolerance: float
) -> None:
    planted, robot, lengths, body = planted_start(seed, count, compliance)
    after = travelled(planted, lengths, seed, 0.1)
    middle = course_of(robot, lengths, after)
    course = middle.widened(Fraction(tolerance), "tolerance")
    mover = mover_at_start(planted, robot, lengths, middle)
    assert not mover.go(course.bounds(Fraction(0))).reason
    trail = led(mover, course)
    assert trail.reached == 1 and any(span.tube.switching for span in trail.spans)
    rng, oracle = np.random.default_rng(seed), Oracle(planted, compliance)
    for _ in range(3):
        one, other = (x + rng.choice([-1.0, 1.0], count) * tolerance for x in (lengths, after))
        first = oracle.settled(body, one)
        assert first is not None
        check(trail, oracle, first, one, other)


def test_a_pulley_of_no_size_is_an_exit_point() -> None:
    """UC4's way of the page of motions, over pulleys of a tenth of a micrometre."""
    rows = [(0, ["7.5", "8", "7", "9"]), (10, ["7.5", "8", "7", "9.3"]), (15, ["7.5", "7.8", "7.2", "9.1"])]
    plain = load_robot("uc4")
    document = plain.to_dict()
    for cable in document["cables"]:
        cable["pulley"] = {"joints": 1, "radius_m": "1e-7", "axis": [0, 0, 1]}
    robot = Robot.from_dict(document)
    course = given_course(rows, robot.cable_names)
    question = {"taut": (0, 1, 2, 3)}
    begin = course.bounds(Fraction(0))
    ways = []
    for one, kind in ((plain, PlatformMover), (robot, RealPlatformMover)):
        found = forward_kinematics(one, course.rows[0].lengths, **question).solutions
        (start,) = (pose for pose in found if pose.stability == "stable")
        ways.append(led(kind(one, start, begin), course))
    straight, over = ways
    assert straight.reached == over.reached == 15
    for time in np.linspace(0.01, 14.99, 60):
        for a in at(straight, float(time)):
            for b in at(over, float(time)):
                assert not a.tube.is_apart(b.tube)
                assert set(a.tube.taut) <= {*b.tube.taut, *b.tube.switching}
    for a, b in zip(switches(straight), switches(over), strict=True):
        assert a[0] == b[0] and abs(a[1] - b[1]) < 0.05


def switches(trail: Trail) -> list[tuple[tuple[int, ...], float]]:
    """Return which cables switch, and when."""
    found = [(x.tube.switching, float(x.begin + x.end) / 2.0) for x in trail.spans if x.tube.switching]
    return found


def arriving_inward(rng: np.random.Generator, angle: float) -> FloatCable:
    """Return a cable that comes along the frame's top and is bent down by a pulley on a long arm."""
    out = np.array([np.cos(angle), np.sin(angle), 0.0])
    return FloatCable(1.5 * out + [0.0, 0.0, 2.0], 0.02 * rng.normal(size=3) - out, 0.045, 0.05, 0.0)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_rope_that_lifts_off_its_pulley_ends_the_proof(seed: int) -> None:
    """The platform is wound up until ropes leave their pulleys: by 26 degrees below the horizontal."""
    planted = plant(seed, 3, arriving_inward)
    robot, lengths = robot_of(planted), planted.lengths
    course = course_of(robot, lengths, lengths - 0.5)
    trail = led(
        RealPlatformMover(robot, start_of(planted, robot, lengths), course.bounds(Fraction(0))), course
    )
    assert 0 < trail.reached < 1 and "may lift off its pulley" in trail.reason
    body = Body(planted.position, planted.rotation, (0, 1, 2), planted.tensions)
    oracle = Oracle(planted)
    *_, (_, last) = oracle.along(body, lengths, lengths - 0.5 * float(trail.reached), 50)
    assert 0.0 < min(wrap_of(cable, planted, last, i) for i, cable in enumerate(planted.cables)) < 0.01


def wrap_of(cable: FloatCable, planted: Planted, body: Body, i: int) -> float:
    """Return the angle on the pulley at a pose, rad."""
    x = body.position + body.rotation @ planted.arms[i] - cable.exit
    k = cable.axis / np.linalg.norm(cable.axis)
    y = float(x @ k)
    side = float(np.linalg.norm(x - y * k)) - cable.arm
    psi = np.arctan2(y, side) + np.arccos(cable.radius / np.hypot(side, y))
    return float(np.pi - np.arccos(cable.radius / cable.arm) - psi)
