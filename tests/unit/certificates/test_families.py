"""Families of taut cables that end in one platform point, and what turning a pose about an axis may claim."""

import random
from dataclasses import replace

import pytest
from flint import arb, ctx, fmpq

from certificates.arithmetic.balls import column, hull, norm
from certificates.claims import Pose, spoke
from certificates.families import check_one_point_family
from certificates.point_mass import IDENTITY
from certificates.turning import Circle, check_turning, circle, everywhere, never_slack, turned_about
from certificates.verdicts import Malformed, NotProved
from tests.support.point_certificates import case, robot

SEED = 20261124
EXITS = [(0, 0, 3), (2.5, 0.5, 3), (-2, 1.5, 3.5), (0.5, -2.5, 2.5)]
POINTS = [(0.3, -0.2, 0.4), (1.5, 0.2, 0.1), (-1.2, 0.9, 0.2), (0.2, -1.4, 0.3)]
LENGTHS = ["3.2", "5.2", "9", "4.2"]


def family(lengths=LENGTHS, taut=(0,), points=POINTS, exits=EXITS, **options):
    return case(robot(exits, points), lengths, taut=taut, **options)


@pytest.fixture(scope="module")
def swing():
    """One cable: a hanging and a balanced pose, both with a part of a turn."""
    found = family(LENGTHS)
    assert [k.family.kind for k in found.listed] == ["rotation", "rotation"]
    for one in found.listed:
        ((start, end),) = one.family.angle_ranges
        assert 0.5 < end[0] - start[1] < 6
    return found


def refused(found, kind=NotProved):
    with pytest.raises(kind):
        found.check()


def with_family(found, k=0, **fields):
    return found.other(k, family=replace(found.listed[k].family, **fields))


def test_hanging_and_balanced(swing):
    assert swing.entry["poses"] == [0, 1]
    assert swing.check() == {0, 1}
    assert [one.stability for one in swing.listed] == ["stable", "unstable"]


@pytest.mark.parametrize("poses", [[1, 0], [0, None], [None, 1], [None, None], [0, 0]])
def test_both_sides_must_be_right(swing, poses):
    refused(replace(swing, entry={**swing.entry, "poses": poses}))


@pytest.mark.parametrize("poses", [[0], [0, 1, 1], [0, 2], "01"])
def test_sides_that_are_malformed(swing, poses):
    refused(replace(swing, entry={**swing.entry, "poses": poses}), Malformed)


@pytest.mark.parametrize("k", [0, 1])
@pytest.mark.parametrize("by", [1e-6, -1e-6])
def test_angle_ranges_of_another_width(swing, k, by):
    ((start, end),) = swing.listed[k].family.angle_ranges
    refused(with_family(swing, k, angle_ranges=[((start[0] - by, start[1] - by), end)]))
    refused(with_family(swing, k, angle_ranges=[(start, (end[0] + by, end[1] + by))]))


def test_angle_ranges_that_miss_or_add_something(swing):
    ((start, end),) = swing.listed[0].family.angle_ranges
    middle = (start[1] + end[0]) / 2
    at = (middle, middle + 1e-3)
    assert with_family(swing, angle_ranges=[(start, at), (at, end)]).check() == {0, 1}
    for ranges in (
        [],
        [(start, at)],
        [(at, end)],
        [(start, (middle, middle)), ((middle + 1e-3, middle + 1e-3), end)],
        [(start, end), ((end[1] + 0.1, end[1] + 0.1), (end[1] + 0.2, end[1] + 0.2))],
        [(end, start)],
        [((start[0], 1.0), (-1.0, end[1]))],
        [((float("nan"),) * 2, end)],
        [((start[0], float("nan")), end)],
        [((-4.0, -4.0), (4.0, 4.0))],
    ):
        refused(with_family(swing, angle_ranges=ranges))


def test_wide_ends_claim_less(swing):
    ((start, end),) = swing.listed[0].family.angle_ranges
    less = [((start[0] - 0.1, start[1] + 0.1), (end[0] - 0.1, end[1] + 0.1))]
    assert with_family(swing, angle_ranges=less).check() == {0, 1}


def test_two_ranges():
    found = family(["3.2", "5", "9", "4.2"])
    assert found.check() == {0, 1}
    first, second = found.listed[1].family.angle_ranges
    for ranges in ([first], [second], [second, (second[1], first[0])]):
        refused(with_family(found, 1, angle_ranges=ranges))
    assert with_family(found, 1, angle_ranges=[second, first]).check() == {0, 1}


def test_random_families_are_proved():
    print("seed", SEED)
    rng = random.Random(SEED)
    counts = set()
    for _ in range(25):
        points = [POINTS[0], *([rng.uniform(-2, 2), rng.uniform(-2, 2), 0.1] for _ in range(3))]
        found = family(["3.2", *(f"{rng.uniform(3.5, 6):.3f}" for _ in range(3))], points=points)
        if found.result.outcome == "complete":
            assert found.check() == set(range(len(found.listed)))
            counts.add(len(found.listed))
    assert counts == {0, 1, 2}


def test_the_axis(swing):
    axis = swing.listed[0].family
    for fields in (
        {"axis_point": [(lo + 1e-6, hi + 1e-6) for lo, hi in axis.axis_point]},
        {"axis_direction": [(-hi, -lo) for lo, hi in axis.axis_direction]},
        {"axis_point": None},
        {"axis_direction": None},
        {"kind": "torus"},
        {"kind": "all-rotations"},
    ):
        refused(with_family(swing, **fields))
    refused(swing.other(family=None))


def test_claims_of_the_listed_pose_of_a_family(swing):
    one = swing.listed[0]
    for fields in (
        {"stability": "unstable"},
        {"states": ("taut", "taut", "slack", "slack"), "taut": (0, 1)},
        {"position": [(lo + 1e-6, hi + 1e-6) for lo, hi in one.position]},
        {"tensions": [(lo + 1e-6, hi + 1e-6) for lo, hi in one.tensions]},
        {"slack_respected": False},
    ):
        refused(swing.other(**fields))
    assert swing.other(stability="undecided").check() == {0, 1}


def test_changed_problems(swing):
    p = swing.problem
    small = fmpq(1, 10**6)
    for fields in (
        {"lengths": [(p.lengths[0][0] + small,) * 2, *p.lengths[1:]]},
        {"lengths": [*p.lengths[:3], (p.lengths[3][0] - fmpq(1, 2),) * 2]},
        {"load": [x * 2 for x in p.load]},
        {"load": [p.load[0] + 1, *p.load[1:]]},
        {"exits": [[x + small for x in p.exits[0]], *p.exits[1:]]},
        {"points": [[x + small for x in p.points[0]], *p.points[1:]]},
        {"centre": [x + small for x in p.centre]},
        {"ignore_tension_sign": True},
        {"stiffness": [(fmpq(10) ** 15, False)] * 4},
    ):
        refused(swing.asks(**fields))


def test_cables_that_end_elsewhere(swing):
    with pytest.raises(NotProved):
        check_one_point_family(swing.problem, (0, 1), swing.entry, swing.listed)


def test_two_cables_in_one_point():
    points = [POINTS[0], POINTS[0], *POINTS[2:]]
    found = family(["3.9", "3.9", "9", "9"], (0, 1), points)
    assert found.check() == set(range(len(found.listed))) == {0, 1}
    assert found.listed[0].states[:2] == ("taut", "taut")
    short = family(["1", "1", "5.3", "5.3"], (0, 1), points)
    assert short.entry["proof"]["kind"] == "weights"
    assert short.check() == set()
    loose = family(["3.9", "6", "9", "9"], (0, 1), points)
    assert loose.entry["proof"]["kind"] == "newton"
    assert loose.entry["poses"] == [None, None]
    assert loose.check() == set()
    refused(replace(loose, entry={**loose.entry, "poses": [0, None]}, listed=found.listed))


def test_no_angle_leaves_the_others_slack():
    short = family(["3.2", "1", "9", "9"])
    assert short.entry["poses"] == [None, None]
    assert short.check() == set()
    one = family(["3.2", "4.1", "4.6", "3.6"])
    assert one.check() == set(range(len(one.listed)))


def test_ignoring_slackness_nothing_can_be_absent(swing):
    ignoring = family(["3.2", "1", "5.6", "5.6"], ignore_slack=True)
    assert ignoring.entry["poses"] == [0, 1]
    assert ignoring.listed[0].slack_respected is False
    assert ignoring.check() == {0, 1}
    refused(replace(ignoring, entry={**ignoring.entry, "poses": [None, 1]}))
    refused(ignoring.other(slack_respected=True))


def test_ranges_of_lengths():
    found = family(["3.2+-0.0001", *LENGTHS[1:]])
    assert found.check() == {0, 1}
    wide = [
        (found.problem.lengths[0][0] - fmpq(1, 1000), found.problem.lengths[0][1]),
        *found.problem.lengths[1:],
    ]
    refused(found.asks(lengths=wide))


FREE = [(0, 0, 0), (0.5, 0.2, 0.1), (-0.2, 0.9, 0.2), (0.2, -0.4, 0.3)]


def test_all_rotations():
    found = family(LENGTHS, points=FREE, exits=EXITS)
    assert found.entry["poses"] == [0]
    one = found.listed[0]
    assert one.family.kind == "all-rotations" and one.states == ("taut", "slack", "slack", "slack")
    assert found.check() == {0}
    lengths = found.problem.lengths
    # Possibly too short at the listed rotation.
    short = fmpq(*one.distances[3][0].as_integer_ratio())
    refused(found.asks(lengths=[*lengths[:3], (short, short)]))
    refused(replace(found, entry={**found.entry, "poses": [None]}))
    refused(with_family(found, kind="rotation"))
    refused(with_family(found, angle_ranges=[((0.0, 0.0), (1.0, 1.0))]))
    refused(found.other(stability="unstable"))
    turned_row = [(0.0, 0.0), (0.0, 0.0), (1.0, 1.0)]
    for rows in ([turned_row, *one.rotation[1:]], [one.rotation[1], one.rotation[0], one.rotation[2]]):
        refused(found.other(rotation=rows))


def test_slack_is_said_of_the_listed_rotation_and_of_all_with_slackness_ignored():
    found = family(["3.2", "4.2", "5.6", "5.6"], points=FREE)
    one = found.listed[0]
    assert one.states == ("taut", "slack", "slack", "slack") and one.distances[1][1] < 4.2
    assert found.check() == {0}
    assert found.other(states=("taut", "undecided", "slack", "slack"), slack_respected=None).check() == {0}
    ignoring = found.asks(ignore_slack=True)
    refused(ignoring)
    assert ignoring.other(slack_respected=False).check() == {0}
    refused(ignoring.other(slack_respected=True))


def test_all_rotations_with_a_cable_too_short():
    found = family(["3.2", "1", "5.6", "5.6"], points=FREE)
    assert found.entry["poses"] == [None]
    assert found.check() == set()
    ignoring = family(["3.2", "1", "5.6", "5.6"], points=FREE, ignore_slack=True)
    assert ignoring.check() == {0}
    refused(ignoring.other(slack_respected=True))
    refused(replace(ignoring, entry={**ignoring.entry, "poses": [None]}))


@pytest.fixture(scope="module")
def turning():
    """A pose of the first cable's family, its axis, and the problem."""
    found = family(LENGTHS)
    with ctx.workprec(200):
        up = column([arb(0), arb(0), arb(1)])
        point = column([arb(0), arb(0), arb(3) - arb(fmpq(16, 5))])
        b = column(found.problem.points[0])
        # Any rotation will do here.
        pose = turned_about(
            Pose(IDENTITY, point - b, {0: arb(1)}), point, column([arb(1), arb(0), arb(0)]), arb("0.7")
        )
    return found.problem, pose, point, up


def test_a_circle_is_the_distance(turning):
    problem, pose, point, up = turning
    with ctx.workprec(200):
        for i in range(4):
            around = circle(problem, i, pose, point, up)
            for angle in (0.0, 0.5, 3.0, -2.0):
                there = turned_about(pose, point, up, arb(angle))
                excess = norm(spoke(problem, there, i)[1]) ** 2 - hull(*problem.lengths[i]) ** 2
                assert abs(around.over(arb(angle), arb(angle)) - excess) < 1e-40
            value = around.over(arb(0.4), arb(0.6))
            assert value.contains(around.over(arb(0.45), arb(0.45)))
            assert value.contains(around.over(arb(0.6), arb(0.6)))


def test_never_slack(turning):
    problem, pose, point, up = turning
    short = replace(problem, lengths=[problem.lengths[0], (fmpq(1, 2),) * 2, *problem.lengths[2:]])
    never_slack(short, (0,), pose, point, up)
    with pytest.raises(NotProved):
        never_slack(replace(short, ignore_slack=True), (0,), pose, point, up)
    long = replace(problem, lengths=[(fmpq(50), fmpq(50))] * 4)
    with pytest.raises(NotProved):
        never_slack(long, (0,), pose, point, up)
    with pytest.raises(NotProved):
        never_slack(long, (0, 1, 2, 3), pose, point, up)


def test_pieces_cover_the_range_and_end():
    with ctx.workprec(200):
        cosine = Circle(arb(0), arb(-1), arb(0))  # excess cos(theta)
        assert everywhere(lambda a, b: cosine.over(a, b) > 0, arb(-1.57), arb(1.57))
        assert not everywhere(lambda a, b: cosine.over(a, b) > 0, arb(-1.57), arb(1.58))
        assert not everywhere(lambda a, b: cosine.over(a, b) < 0, arb(1.57), arb(4.71))
        assert everywhere(lambda a, b: cosine.over(a, b) < 0, arb(1.571), arb(4.71))


def test_check_turning_of_the_wrong_pose(swing, turning):
    problem, pose, point, up = turning
    with pytest.raises(NotProved):
        check_turning(problem, swing.listed[0], (0,), pose, point, up)
