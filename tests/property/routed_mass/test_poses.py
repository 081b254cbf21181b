"""Random point masses on routed cables: no static pose that plain floats find is missing."""

import itertools
from dataclasses import replace
from fractions import Fraction as F
from random import Random

import numpy as np
import pytest

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.cables.rows import ACROSS, ALONG, LENGTH, WAY
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Elasticity
from solvers import PointMass
from solvers.point_mass.cell_rows import WIDTH
from solvers.routed_mass import cells
from solvers.routed_mass.data import routed_mass
from solvers.routed_mass.over_ranges import find_all
from solvers.routed_mass.pose import Effort, data_for
from tests.support.kernel_callers import Callers
from tests.support.routed_robots import (
    BISECTOR,
    EXACT,
    FIXED,
    ONE,
    WEIGHT,
    Made,
    planted,
    random_line,
    random_place,
    way,
)

kernels = Callers(cells)
KINDS = [FIXED, ONE, ONE, EXACT, BISECTOR]
NEAR = 1e-6
"""m: floats are no better where two poses nearly meet."""


def effort(cells=12_000):
    """Cells that are not looked at are regions."""
    return Effort(Budget(None, cells), own_limit=True)


def is_within(boxes, x):
    return any(((b[:, 0] - NEAR <= x) & (x <= b[:, 1] + NEAR)).all() for b in boxes)


def is_kept(found, x):
    return is_within([*(f.position for f in found.poses), *(r.position for r in found.regions)], x)


def taut_sets(made):
    hard = [i for i, line in enumerate(made.lines) if not line.k]
    for m in range(min(3, len(hard)) + 1):
        if m or len(hard) < len(made.lines):
            yield from itertools.combinations(hard, m)


def settled(made, rng, starts):
    """Yield static poses that Newton steps find from near the pulleys and near the planted pose."""
    for taut in taut_sets(made):
        for _ in range(starts):
            x = made.pose + np.array([rng.gauss(0, 0.5) for _ in range(3)])
            if rng.random() < 0.6:
                x = random_place(rng, rng.choice(made.lines), True)
            found = made.settle(x, taut, 12)
            if found is not None:
                yield found[0]


def draw(seed, kinds=KINDS, most=3, stretchy=None):
    rng = Random(seed)
    chosen = [rng.choice(kinds) for _ in range(rng.randint(1, most))]
    share = rng.choice([0.0, 0.5, 1.0, 1.0]) if stretchy is None else stretchy
    return rng, planted(rng, chosen, rng.random() < 0.5, share)


@pytest.mark.parametrize("seed", range(20))
def test_no_planted_pose_is_lost(seed):
    rng, made = draw(seed)
    if made is None:
        return
    found = find_all(made.mass(), made.bounds(), effort())
    if found.families:
        return
    assert not found.pending
    assert is_kept(found, made.pose), (seed, made)
    for x in settled(made, rng, 2):
        assert is_kept(found, x), (seed, made, x)


@pytest.mark.parametrize("seed", range(100, 110))
def test_proved_poses_are_static_and_apart(seed):
    """Each box holds a pose of the plain floats, and no two boxes meet."""
    _, made = draw(seed)
    if made is None:
        return
    found = find_all(made.mass(), made.bounds(), effort(4000))
    if found.families:
        return
    for one, other in itertools.combinations(found.poses, 2):
        a, b = one.position, other.position
        assert (a[:, 0] > b[:, 1]).any() or (b[:, 0] > a[:, 1]).any(), seed
    for fields in found.poses:
        x = fields.position.mean(axis=1)
        rest, lengths, along = made.forces(x)
        assert (np.abs(lengths - fields.distances.mean(axis=1)) < 1e-5).all(), seed
        for i, line in enumerate(made.lines):
            if not line.k:
                rest = rest + fields.tensions[i].mean() * along[i]
                assert lengths[i] <= made.lengths[i] + 1e-5
        if not fields.is_open:
            assert np.abs(rest).max() < 1e-4, seed


@pytest.mark.parametrize("seed", range(200, 212))
def test_a_box_over_ranges_holds_the_pose_of_every_choice(seed):
    rng, made = draw(seed)
    if made is None:
        return
    spread = 10.0 ** rng.uniform(-6, -2)
    found = find_all(made.mass(), made.bounds(spread), effort(3000))
    if found.families:
        return
    choices = np.random.default_rng(seed).choice([-1.0, -0.3, 0.4, 1.0], (4, len(made.lines)))
    for choice in choices:
        moved = made.replace_lengths(made.lengths + spread * choice)
        for taut in taut_sets(moved):
            pose = moved.settle(made.pose, taut, 12)
            if pose is not None:
                assert is_kept(found, pose[0]), (seed, spread, choice)


@pytest.mark.parametrize("seed", range(300, 306))
def test_tiny_pulleys_are_exit_points(seed):
    """As the radius goes to zero the pose is that of the plain robot."""
    rng = Random(seed)
    lines = [random_line(rng, rng.choice([ONE, EXACT, BISECTOR])) for _ in range(3)]
    for line in lines:
        line.radius = line.arm = 1e-4
        line.axis = np.array([0.0, 0.0, 1.0])
        line.point[2] = 5.0
    x = np.array([0.1, -0.2, 1.0])
    away = [x - line.point for line in lines]
    load = sum((t * a / np.linalg.norm(a) for t, a in zip((5.0, 7.0, 9.0), away, strict=True)), np.zeros(3))
    lengths = np.array([np.linalg.norm(a) + line.lead for a, line in zip(away, lines, strict=True)])
    plain = [random_line(rng, FIXED) for _ in lines]
    for line, old in zip(plain, lines, strict=True):
        line.point, line.lead = old.point, old.lead
    over = find_all(Made(lines, load, lengths).mass(), Made(lines, load, lengths).bounds(), effort())
    straight = Made(plain, load, lengths - np.array([line.lead for line in lines]))
    exits = find_all(straight.mass(), straight.bounds(), effort())
    assert exits.complete and len(exits.poses) == 1 == len(over.poses)
    assert np.abs(over.poses[0].position - exits.poses[0].position).max() < 3e-3


@pytest.mark.parametrize("seed", range(400, 440))
def test_what_the_exit_point_tells_encloses_every_way(seed):
    """Boxes around points on all sides of a pulley, in its reach and far away."""
    rng = Random(seed)
    line = random_line(rng, rng.choice([ONE, EXACT, BISECTOR]))
    line.lead = rng.choice([0.0 if line.kind == ONE else 0.3, 0.7, 3.0])
    load = np.array([0.0, 0.0, -9.0])
    made = Made([line], load, np.array([1.0]))
    mass = made.mass()
    route, one = data_for(mass, made.bounds())[0][0], np.empty((WAY, 2))
    for _ in range(40):
        x = random_place(rng, line, rng.random() < 0.8)
        half = rng.choice([1e-9, 1e-3, 0.1])
        at = x + np.array([rng.uniform(-half, half) for _ in range(3)])
        found = way(line, at)
        if found is None:
            continue
        box = np.stack([x - half, x + half], axis=1) - line.point[:, None]
        kernels.rough_way(route, np.ascontiguousarray(box / mass.unit), one)
        assert one[LENGTH, 0] * mass.unit <= found[0] + 1e-9 <= one[LENGTH, 1] * mass.unit + 2e-9, seed
        for j in range(3):
            assert one[ALONG + j, 0] - 1e-9 <= found[1][j] <= one[ALONG + j, 1] + 1e-9, seed
        assert one[ACROSS, 0] * mass.unit <= line.flat(at)[2] + 1e-9, seed


@pytest.mark.parametrize("seed", range(500, 530))
def test_straight_cables_give_what_their_own_solver_gives(seed):
    """Cables of one kind, without pulleys: two proofs of one pose."""
    rng = Random(seed)
    made = planted(rng, [FIXED] * rng.randint(1, 6), stretchy=rng.choice([0.0, 1.0]))
    if made is None:
        return
    pose = PointMass(made.robot()).solve(
        made.lengths.tolist(), [F(made.load[0]), F(made.load[1]), F(made.load[2]) + F(WEIGHT)]
    )
    found = find_all(made.mass(), made.bounds(), effort())
    assert pose.proved and found.complete and len(found.poses) == 1, seed
    one, other = found.poses[0].position, pose.position
    assert (one[:, 0] <= other[:, 1]).all() and (other[:, 0] <= one[:, 1]).all(), seed
    assert found.by_convexity and found.stability == (Stability.STABLE,)


def blurred(x, share):
    """Return a range around a number, of a share of it."""
    return Range(F(x) * (1 - F(share)), F(x) * (1 + F(share))) if x else F(0)


def chosen(made, rng, share):
    """Return a robot whose numbers are within those of `with_data_ranges`."""
    lines = [replace(line) for line in made.lines]
    for line, old in zip(lines, made.lines, strict=True):
        for name in ("radius", "lead", "k"):
            setattr(line, name, getattr(line, name) * (1 + share * rng.choice([-0.99, -0.4, 0.5, 0.99])))
        if line.arm == old.radius:
            line.arm = line.radius
        else:
            line.arm *= 1 + share * rng.choice([-0.99, 0.3, 0.99])
    return replace(made, lines=lines)


def with_data_ranges(made, share):
    """Return a mass with ranges around radii, arms, lead-ins and springs."""
    cables = []
    for cable, line in zip(made.robot().cables, made.lines, strict=True):
        if cable.elasticity is not None:
            cable = replace(cable, elasticity=Elasticity(stiffness=blurred(line.k, share)))
        if cable.pulley is not None:
            pulley = replace(
                cable.pulley, radius=blurred(line.radius, share), lead_in=blurred(line.lead, share)
            )
            arm = None if pulley.arm is None else blurred(line.arm, share)
            cable = replace(cable, pulley=replace(pulley, arm=arm))
        cables.append(cable)
    x, y, z = made.load.tolist()
    robot = replace(made.robot(), cables=tuple(cables))
    return routed_mass(loaded(robot, (F(x), F(y), F(z) + F(WEIGHT))))


@pytest.mark.parametrize("seed", range(600, 616))
def test_a_box_over_data_holds_the_pose_of_every_choice(seed):
    rng, made = draw(seed, [FIXED, ONE, ONE, EXACT], 4)
    if made is None:
        return
    share = 10.0 ** rng.uniform(-7, -4)
    found = find_all(with_data_ranges(made, share), made.bounds(), effort(3000))
    if found.families:
        return
    for _ in range(3):
        moved = chosen(made, rng, share)
        for taut in taut_sets(moved):
            pose = moved.settle(made.pose, taut, 12)
            if pose is not None:
                assert is_kept(found, pose[0]), (seed, share)


NOWHERE = np.column_stack([np.full(3, np.inf), np.full(3, -np.inf)])
NO_CABLES = np.empty(0, dtype=np.int64)


def keeps_the_pose(made, rng, spread):
    """Return True when no cell around the planted pose is proved empty, and the first cells hold it."""
    mass = made.mass()
    data = data_for(mass, made.bounds(spread))
    pose = (made.pose - made.lines[0].point) / mass.unit
    stack, children = np.empty((64, WIDTH)), np.empty((4, WIDTH))
    count = cells.first_cells(data, False, stack)
    edge = 1e-9
    first = (stack[:count, 0:6:2] - edge <= pose) & (pose <= stack[:count, 1:6:2] + edge)
    if not first.all(axis=1).any():
        return False
    context = (data, False, NO_CABLES, NOWHERE, -1, 1e-12)
    for _ in range(4):
        cell, half = np.empty(WIDTH), 10.0 ** rng.uniform(-8, -0.3)
        shift = np.array([rng.uniform(-0.999, 0.999) for _ in range(3)]) * half
        cell[0:6:2], cell[1:6:2], cell[6] = pose + shift - half, pose + shift + half, 1.0
        if cells.process(context, cell, children) == 0:
            return False
    return True


@pytest.mark.parametrize("seed", range(700, 720))
def test_no_cell_with_a_pose_is_proved_empty(seed):
    """Many robots each, without a search."""
    rng = Random(seed)
    looked = 0
    for _ in range(12):
        made = planted(rng, [rng.choice(KINDS) for _ in range(rng.randint(1, 6))], rng.random() < 0.6)
        if made is not None:
            looked += 1
            assert keeps_the_pose(made, rng, rng.choice([1e-10, 1e-5, 1e-2])), (seed, made)
    assert looked > 2


@pytest.mark.parametrize("seed", range(800, 830))
def test_lengths_are_convex_where_ropes_leave_outward(seed):
    """No tangent plane from beyond arm and radius lies above the length there, or above what hangs loose."""
    rng = Random(seed)
    line = random_line(rng, rng.choice([ONE, ONE, EXACT]))
    line.lead = rng.choice([0.0 if line.kind == ONE else 0.3, 0.7, 3.0])
    places = []
    while len(places) < 12:
        x = line.point + np.array([rng.gauss(0, 1) for _ in range(3)]) * rng.choice([0.3, 1, 3])
        s = line.flat(x)[2]
        found = way(line, x)
        if found is not None:
            places.append((x, s > line.wide, found))
    loop = 4 * line.arm + 9 * line.radius
    for x, outward, (length, along) in places:
        if not outward:
            continue
        assert along @ line.flat(x)[0] >= 0
        for other, beyond, (longer, _) in places:
            plane = length + along @ (other - x)
            assert plane <= np.linalg.norm(other - line.point) + line.lead + loop
            if beyond:
                assert plane <= longer + 1e-9, seed
