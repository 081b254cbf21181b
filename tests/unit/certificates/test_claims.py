"""Every claim about a listed pose is refused when it is changed."""

import random
from dataclasses import replace

import pytest
from flint import arb, arb_mat, ctx, fmpq

from cdpr_interval import load_robot
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof.frame import Pose as SolverPose
from certificates.arithmetic.balls import BITS
from certificates.claims import Pose, check_pose
from certificates.point_mass import IDENTITY, lowest_points
from certificates.stability import check_stability, second_variation
from certificates.verdicts import NotProved
from solvers.forward import answer_question, pose_problem
from solvers.proofs.listed import certificate_question, listed_solution
from solvers.questions.problem import Options, Problem
from solvers.six_dof.solution import pose_solution
from tests.support.point_certificates import case, robot

SEED = 20261125
MERLET = "2.69,3.90,3.35,4.38"


@pytest.fixture(scope="module")
def merlet():
    return case(load_robot("merlet_4_1"), MERLET)


def shifted(bounds, by):
    return (bounds[0] + by, bounds[1] + by)


def test_the_listed_pose_is_taken(merlet):
    assert merlet.listed[0].states == ("taut", "slack", "taut", "taut")
    assert merlet.check() == {0}


@pytest.mark.parametrize("by", [1e-9, -1e-9])
def test_shifted_bounds(merlet, by):
    one = merlet.listed[0]
    changes = [{"height": shifted(one.height, by)}]
    for name in ("position", "tensions", "distances"):
        for k in range(len(getattr(one, name))):
            values = list(getattr(one, name))
            values[k] = shifted(values[k], by)
            changes.append({name: values})
    for i in range(3):
        for j in range(3):
            rotation = [list(row) for row in one.rotation]
            rotation[i][j] = shifted(rotation[i][j], by)
            changes.append({"rotation": rotation})
    assert len(changes) == 1 + 3 + 4 + 4 + 9
    for change in changes:
        with pytest.raises(NotProved):
            merlet.other(**change).check()


def test_bounds_that_are_no_numbers(merlet):
    nan = (float("nan"), float("nan"))
    one = merlet.listed[0]
    for change in (
        {"height": nan},
        {"position": [nan, *one.position[1:]]},
        {"tensions": [nan, *one.tensions[1:]]},
        {"distances": [nan, *one.distances[1:]]},
    ):
        with pytest.raises(NotProved):
            merlet.other(**change).check()


@pytest.mark.parametrize(
    "change",
    [
        {"states": ("taut", "taut", "taut", "taut"), "taut": (0, 1, 2, 3)},
        {"states": ("slack", "slack", "taut", "taut"), "taut": (2, 3)},
        {"states": ("taut", "slack", "taut", "tight"), "taut": (0, 2)},
        {"taut": (0, 2)},
        {"taut": (0, 1, 2, 3)},
        {"taut": (2, 0, 3)},
        {"slack_respected": False},
        {"stability": "unstable"},
        {"stability": "metastable"},
    ],
)
def test_other_words(merlet, change):
    with pytest.raises(NotProved):
        merlet.other(**change).check()


def test_less_may_be_claimed(merlet):
    wide = (-1e9, 1e9)
    less = merlet.other(
        states=("undecided",) * 4,
        taut=(),
        stability="undecided",
        slack_respected=None,
        height=wide,
        position=[wide] * 3,
        tensions=[(7.0, 7.0)] * 4,
    )
    assert less.check() == {0}


def test_without_slackness_a_pose_may_have_cables_too_long():
    found = case(load_robot("merlet_4_1"), MERLET, subset=(0, 2), ignore_slack=True)
    (k,) = found.check()
    assert found.listed[k].slack_respected is False
    for respected in (True,):
        with pytest.raises(NotProved):
            found.other(k, slack_respected=respected).check()
    right = case(load_robot("merlet_4_1"), MERLET, subset=(0, 2, 3), ignore_slack=True)
    (k,) = right.check()
    assert right.listed[k].slack_respected is True
    with pytest.raises(NotProved):
        right.other(k, slack_respected=False).check()
    states = ("taut", "slack", "taut", "slack")
    with pytest.raises(NotProved):
        right.other(k, states=states, taut=(0, 2)).check()


def platform(name, lengths, taut, **options):
    """Return problem, solver's solution boxes as poses for the checker, of cables proved by the solver."""
    chosen = Options(**options)
    problem = pose_problem(load_robot(name), lengths, taut, None, chosen)
    return problem, chosen, answer_question(problem, chosen)


def centre_pose(solution, taut, problem):
    """Return the middle of a listed pose, refined to an enclosure by Newton's method on the square system."""
    with balls.precision():
        return refine(problem, taut, solution)


def refine(problem: Problem, taut, solution):
    """Iterate (small turn, shift, t) on lengths and balance; return balls of the size of the last step."""
    r = arb_mat([[(lo + hi) / 2 for lo, hi in row] for row in solution.rotation.tolist()])
    c = balls.fractions(problem.robot.platform.centre_of_mass)
    p = balls.vector([arb((lo + hi) / 2) for lo, hi in solution.position.tolist()]) + r * c
    t = [arb(float(solution.tensions[i].mean() / solution.distances[i].mean())) for i in taut]
    n = len(taut)
    for _ in range(8):
        # Bring r back to a rotation: one step of Newton's polar iteration.
        for _ in range(3):
            r = ((r + r.transpose().inv()) * arb(0.5)).mid()
        arms = [r * balls.fractions(problem.loaded.arms[i]) for i in taut]
        exits = [balls.fractions(problem.robot.cables[i].frame_anchor) for i in taut]
        e = [(a - p - arm).mid() for a, arm in zip(exits, arms, strict=True)]
        lengths = [balls.from_fraction(problem.lengths[i][0]) for i in taut]
        load = balls.fractions(problem.load)
        value = [*balls.entries(sum_of([x * y for x, y in zip(e, t, strict=True)], 3) + load)]
        value += balls.entries(sum_of([balls.cross(a, x) * y for a, x, y in zip(arms, e, t, strict=True)], 3))
        value += [(balls.dot(x, x) - s * s) / 2 for x, s in zip(e, lengths, strict=True)]
        columns = []
        for k in range(6 + n):
            d = [arb(int(j == k)) for j in range(6 + n)]
            v, w, dt = balls.vector(d[:3]), balls.vector(d[3:6]), d[6:]
            da = [balls.cross(w, a) for a in arms]
            de = [x * arb(-1) - v for x in da]
            force = sum_of([x * y + z * s for x, y, z, s in zip(de, t, e, dt, strict=True)], 3)
            moment = sum_of(
                [
                    (balls.cross(x, z) + balls.cross(a, y)) * u + balls.cross(a, z) * s
                    for x, y, z, a, u, s in zip(da, de, e, arms, t, dt, strict=True)
                ],
                3,
            )
            columns.append(
                [*balls.entries(force), *balls.entries(moment)]
                + [balls.dot(z, y) for z, y in zip(e, de, strict=True)]
            )
        step = arb_mat(columns).transpose().mid().solve(balls.vector(value)).mid()
        s = balls.entries(step)
        p = (p - balls.vector(s[:3])).mid()
        x, y, z = (-q for q in s[3:6])
        r = (r + arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]]) * r).mid()
        t = [(a - b).mid() for a, b in zip(t, s[6:], strict=True)]
    assert all(abs(x) < 1e-25 for x in s)
    tiny = arb(0, 1e-24)
    spread = lambda m: arb_mat(m.nrows(), m.ncols(), [x + tiny for x in m.entries()])  # noqa: E731
    return spread(r), spread(p), [x + tiny for x in t]


def sum_of(vectors, size):
    total = balls.vector([0] * size)
    for v in vectors:
        total += v
    return total


@pytest.fixture(scope="module")
def uc3():
    problem, options, result = platform("uc3", ["7.5", "9", "6"], (0, 1, 2))
    assert result.outcome == "complete"
    assert {str(s.stability) for s in result.solutions} == {"stable", "unstable"}
    poses = []
    for s in result.solutions:
        r, p, t = centre_pose(s, (0, 1, 2), problem)
        with balls.precision():
            again = pose_solution(problem, options, (0, 1, 2), SolverPose(r, p, tuple(t)))
        assert again.stability == s.stability
        poses.append((listed_solution(again), Pose(r, p, dict(enumerate(t)))))
    return certificate_question(problem, options), poses


def test_platform_poses_and_their_stability(uc3):
    question, poses = uc3
    for listed, pose in poses:
        check_pose(question, listed, (0, 1, 2), pose)
        other = "stable" if listed.stability == "unstable" else "unstable"
        for changed in (
            replace(listed, stability=other),
            replace(listed, rotation=[listed.rotation[1], *listed.rotation[1:]]),
            replace(listed, states=("taut", "taut", "slack"), taut=(0, 1)),
        ):
            with pytest.raises(NotProved):
                check_pose(question, changed, (0, 1, 2), pose)
        check_pose(question, replace(listed, stability="undecided"), (0, 1, 2), pose)
        with pytest.raises(NotProved):
            check_pose(question, listed, (0, 1, 2), pose, [[arb(int(k == 5)) for k in range(6)]])


def test_the_centre_of_mass_shifts_the_origin(uc3):
    question, poses = uc3
    moved = replace(question, centre=[x + fmpq(1, 100) for x in question.centre])
    with pytest.raises(NotProved):
        check_pose(moved, poses[0][0], (0, 1, 2), poses[0][1])


def test_unstable_needs_every_state_decided(uc3):
    question, poses = uc3
    listed, pose = next((one, p) for one, p in poses if one.stability == "unstable")
    open_state = replace(listed, states=("taut", "taut", "undecided"), taut=(0, 1))
    with pytest.raises(NotProved):
        check_pose(question, open_state, (0, 1, 2), pose)
    check_pose(question, replace(open_state, stability="undecided"), (0, 1, 2), pose)


def test_tensions_must_be_positive(uc3):
    question, poses = uc3
    listed, pose = poses[0]
    with ctx.workprec(200):
        densities = {**pose.densities, 1: -pose.densities[1]}
    flipped = [*listed.tensions]
    flipped[1] = (-flipped[1][1], -flipped[1][0])
    claimed = replace(listed, tensions=flipped, stability="undecided")
    with pytest.raises(NotProved, match="taut"):
        check_pose(question, claimed, (0, 1, 2), replace(pose, densities=densities))
    rigid = replace(question, ignore_tension_sign=True)
    check_pose(rigid, claimed, (0, 1, 2), replace(pose, densities=densities))


@pytest.fixture
def leaning():
    """Six independent cables that leave no freedom, of a platform that would fall without them."""
    print("seed", SEED)
    rng = random.Random(SEED)
    cables = []
    for _ in range(6):
        r = [arb(rng.uniform(-1, 1)) for _ in range(3)]
        cables.append((r, [-10 * x + rng.uniform(-1, 1) for x in r], arb(1)))
    return cables


def test_six_independent_cables_are_stable(uc3, leaning):
    question, listed = uc3[0], uc3[1][0][0]
    with ctx.workprec(BITS):
        assert second_variation(leaning)[5, 5] < 0
        assert check_stability(question, replace(listed, stability="stable"), leaning, ())
        assert not check_stability(question, replace(listed, stability="unstable"), leaning, ())
        five = leaning[:5]
        assert not check_stability(question, replace(listed, stability="stable"), five, ())
        assert check_stability(question, replace(listed, stability="unstable"), five, ())


def test_a_cable_with_perhaps_no_tension_holds_nothing_back(uc3, leaning):
    question, listed = uc3[0], replace(uc3[1][0][0], stability="stable")
    loose = [*leaning[:5], (*leaning[5][:2], arb(0, 1e-30))]
    with ctx.workprec(BITS):
        assert not check_stability(question, listed, loose, ())
        assert check_stability(replace(question, ignore_tension_sign=True), listed, loose, ())


def test_a_pose_with_a_cable_too_long_is_none():
    found = case(load_robot("merlet_4_1"), MERLET, subset=(0, 2), ignore_slack=True)
    (k,) = found.check()
    states = tuple("taut" if i in (0, 2) else "undecided" for i in range(4))
    claimed = replace(found.listed[k], states=states, taut=(0, 2))
    with ctx.workprec(BITS):
        one = Pose(IDENTITY, *next(lowest_points(found.problem, (0, 2), found.entry["proof"]))[1])
    check_pose(found.problem, claimed, (0, 2), one)
    with pytest.raises(NotProved, match="c2 undecided"):
        check_pose(replace(found.problem, ignore_slack=False), claimed, (0, 2), one)


def test_robots_made_here_are_point_masses():
    assert case(robot([(0, 0, 3)]), ["2"]).check() == {0}
