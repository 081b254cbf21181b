"""The path of a cable over a pulley: published geometry, independent numbers, balance and derivatives."""

from __future__ import annotations

import math
from fractions import Fraction as F
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pytest
from flint import arb, ctx

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.cables.law import law_of
from cdpr_interval.mechanics.cables.path import Balls, Floats, OffTheCable, Path
from cdpr_interval.robots.cable_robot import Cable, Elasticity
from cdpr_interval.robots.pulley import BISECTOR, EXACT, Pulley
from tests.support.pulleys import (
    KINDS,
    anchor_at,
    as_balls,
    near_or_far,
    random_point,
    random_pulley,
    route_of,
    unit_axis,
)

FLOATS, BALLS = Floats(), Balls()
CORNERS = {
    "CDPR4": ((-2.5, -2.5), (2.5, -2.5), (2.5, 2.5), (-2.5, 2.5)),
    "CDPR3": ((-2.5, -2.5 / math.sqrt(3)), (2.5, -2.5 / math.sqrt(3)), (0.0, 5 / math.sqrt(3))),
}
"""x and y of the points A, m; their z is 5."""


class Lengths(NamedTuple):
    """A case of the inverse problem, one joint, the rope arriving from the floor; m and rad."""

    robot: str
    arm: str
    radius: str
    anchor: tuple[float, float, float]
    length: tuple[float, ...]
    before: tuple[float, ...]
    wrap: tuple[float, ...]
    free: tuple[float, ...]
    centre: tuple[tuple[float, float, float], ...]
    entry: tuple[tuple[float, float, float], ...]
    exit: tuple[tuple[float, float, float], ...]


class Hanging(NamedTuple):
    """An equilibrium of 300 kg on elastic ropes of 4 mm; SR has one joint, DR two and the bisector."""

    robot: str
    joints: str
    cables: tuple[int, ...]
    """From 1."""
    arm: str | F
    radius: str
    lead_in: str
    modulus: float
    unstretched: tuple[float, ...]
    anchor: tuple[float, float, float]
    tensions: tuple[float, ...]


# The geometry is that of Paty and others 2021 on pulleys and elasticity of cable robots. The numbers were
# computed independently of this package, three ways that agree.
IGM = (
    Lengths(
        "CDPR4",
        "0.1",
        "0.0665",
        (0.5, -0.75, 2.0),
        (9.66758648854228, 9.104849888092424, 9.926104963854888, 10.407264022482067),
        (5.000557743892175, 5.000557743892175, 5.000557743892175, 5.000557743892175),
        (2.305748945340399, 2.445811887162331, 2.2571983993753038, 2.183402729501353),
        (4.51369643978497, 3.9416456537039535, 4.775443526404255, 5.261509997078053),
        (
            (-2.4136221099101567, -2.4496128974475915, 5.0),
            (2.424742330529312, -2.434149539213148, 5.0),
            (2.4475902574335664, 2.414834168329546, 5.0),
            (-2.4321719897266934, 2.426519655537251, 5.0),
        ),
        (
            (-2.4710621177082635, -2.4831195686631538, 5.000445520151815),
            (2.4747875575748837, -2.4779391128780235, 5.000445520151815),
            (2.4824419540723883, 2.471468175367631, 5.000445520151815),
            (-2.477276604286929, 2.4753829879775067, 5.000445520151815),
        ),
        (
            (-2.3748201058354472, -2.4269783950706776, 5.049034006382669),
            (2.386115027935272, -2.400350649443363, 5.042282579682872),
            (2.4253220931450654, 2.3786484013607314, 5.051156320509777),
            (-2.4059895178480857, 2.3981553110020926, 5.054149719532208),
        ),
    ),
    Lengths(
        "CDPR3",
        "0.1",
        "0.0665",
        (0.3, 0.2, 2.5),
        (9.168641808834547, 8.79577788387051, 8.765488190707712),
        (5.000557743892175, 5.000557743892175, 5.000557743892175),
        (2.2520213138641836, 2.339394142361341, 2.3476524202935023),
        (4.018324647570404, 3.639650429511306, 3.6088115608660196),
        (
            (-2.4137570422155528, -1.3927579662639609, 5.0),
            (2.419884357218342, -1.3835301737140384, 5.0),
            (0.011096938612522853, 2.787368963437797, 5.0),
        ),
        (
            (-2.4711073220443134, -1.4264179858028323, 5.000445520151815),
            (2.4731600640148645, -1.4233265375821769, 5.000445520151815),
            (0.003717640046935735, 2.853456764615278, 5.000445520151815),
        ),
        (
            (-2.3773425159206982, -1.3713855567440187, 5.051375601077099),
            (2.3825943334571744, -1.3556749383077986, 5.047495157525315),
            (0.01630538479369513, 2.7407229641459203, 5.047109158753262),
        ),
    ),
    Lengths(
        "CDPR4",
        "0.15",
        "0.098",
        (-2.0, -1.5, 0.5),
        (9.891368162567476, 11.567954948317915, 12.615991836712249, 11.181696649741609),
        (5.001289433736064, 5.001289433736064, 5.001289433736064, 5.001289433736064),
        (2.9405968420359385, 2.36575453037308, 2.2276280667094, 2.4359953357489754),
        (4.60190023831189, 6.33482157060529, 7.396394852438664, 5.941679673102145),
        (
            (-2.4329179606750064, -2.3658359213500124, 5.0),
            (2.353571940972407, -2.4674604313272015, 5.0),
            (2.3878886021974512, 2.400345424175512, 5.0),
            (-2.4813947898116187, 2.3511583184929497, 5.0),
        ),
        (
            (-2.4767425235486695, -2.4534850470973386, 5.001019041050092),
            (2.4492331007089785, -2.4887184668242175, 5.001019041050092),
            (2.461130755407028, 2.4654495603618027, 5.001019041050092),
            (-2.493549536624372, 2.448396292994973, 5.001019041050092),
        ),
        (
            (-2.38988467863114, -2.2797693572622797, 5.018565645226204),
            (2.2845890653954415, -2.4521309034212093, 5.06789969404432),
            (2.342562979938901, 2.3600559821679123, 5.076982782682828),
            (-2.472060334081998, 2.276482672655982, 5.0627727317795195),
        ),
    ),
)
DEGM = (
    Hanging(
        "CDPR3",
        "SR",
        (1, 2, 3),
        "0.1",
        "0.0665",
        "5.0",
        1.022e11,
        (8.818813079129866, 8.818813079129866, 8.818813079129866),
        (0.0, 0.0, 2.601937155923026),
        (1473.2590550608634, 1473.2590550608634, 1473.2590550608634),
    ),
    Hanging(
        "CDPR3",
        "SR",
        (1, 2, 3),
        "0.1",
        "0.0665",
        "5.0",
        1.022e11,
        (9.097643664659357, 8.713580967546413, 8.682204882261995),
        (0.30165540122118745, 0.20123957467299503, 2.6024509182206996),
        (1179.3547292855592, 1593.8000331887304, 1621.3103798820707),
    ),
    Hanging(
        "CDPR3",
        "DR",
        (1, 2, 3),
        "0.1",
        "0.0665",
        "5.0",
        1.022e11,
        (9.427333568386784, 10.253692275511048, 10.366324156111993),
        (-0.8091782632593846, -0.6055396840553272, 0.963503355706418),
        (1838.9022983348768, 918.2502383200558, 751.0004332875071),
    ),
    Hanging(
        "CDPR4",
        "SR",
        (1, 2, 3),
        "0.1",
        "0.0665",
        "5.0",
        1.022e11,
        (10.244044240850759, 9.183300132670377, 8.535533905932738),
        (1.01609966247123, 0.49650245530883275, 2.5929867043678505),
        (1782.4020358362757, 499.1969908758557, 2463.667649076352),
    ),
    Hanging(
        "CDPR4",
        "DR",
        (1, 2, 3),
        "0.1",
        "0.0665",
        "5.0",
        1.022e11,
        (10.244044240850759, 9.183300132670377, 8.535533905932738),
        (1.0215784243732102, 0.4982046576773229, 2.4275194500903563),
        (1769.6291567522665, 500.5571681258066, 2444.0760542106123),
    ),
    Hanging(
        "CDPR4",
        "DR",
        (4, 1, 2),
        "0.1",
        "0.0665",
        "5.0",
        1.022e11,
        (11.123724356957945, 10.244044240850759, 11.89202437604511),
        (-2.017852381726601, -1.014084985866694, -0.03037736022140419),
        (1051.2924335474595, 1880.5267093323093, 382.14638451757696),
    ),
    Hanging(
        "CDPR4",
        "SR",
        (2, 3, 4),
        F(7, 65),
        "0.035",
        "5.0",
        1.022e11,
        (9.84767985741633, 9.301162633521313, 10.338539126015656),
        (1.0287432063755773, 0.5193447036298142, 1.5021576615954684),
        (1576.5724644859338, 1106.889144901873, 1282.0614844724355),
    ),
    Hanging(
        "CDPR4",
        "SR",
        (2, 3, 4),
        F(7, 65),
        "0.035",
        "5.0",
        6.72e10,
        (9.84767985741633, 9.301162633521313, 10.338539126015656),
        (1.0309199079039513, 0.521900685974007, 1.4949063281347004),
        (1573.2804629470352, 1109.1442673723104, 1278.7763553607094),
    ),
    Hanging(
        "CDPR4",
        "SR",
        (2, 3, 4),
        "0.1",
        "0.0665",
        "2.5",
        1.022e11,
        (6.683300132670378, 6.035533905932738, 7.243416490252569),
        (1.012283364075642, 0.5094291502857011, 2.5998969435044184),
        (1926.9262192047897, 1255.1861704960702, 1627.3553148004212),
    ),
)


def point_a(robot: str, cable: int) -> tuple[F, F, F]:
    """Return A of a cable (from 0), exactly as doubles have it."""
    x, y = CORNERS[robot][cable]
    return F(x), F(y), F(5)


def in_both(route: Any, anchor: tuple[float, float, float]) -> tuple[Path, Path]:
    """Return the path to an anchor in floats and the middles of that in balls."""
    with balls.precision():
        path = route.path(as_balls(np.array(anchor)), BALLS)
        found = [
            tuple(float(x.mid()) for x in part) if isinstance(part, tuple) else float(part.mid())
            for part in path[:-1]
        ]
    return route.path(anchor, FLOATS), Path(*found, is_past=path.is_past)


def close(a: Any, b: Any, within: float) -> bool:
    """Return True where no number of two tuples differs by more."""
    return bool(np.abs(np.asarray(a, dtype=float) - np.asarray(b, dtype=float)).max() <= within)


@pytest.mark.parametrize("case", IGM, ids=lambda case: f"{case.robot}-{case.anchor}")
def test_one_joint_has_the_independent_geometry(case: Lengths) -> None:
    for i in range(len(case.length)):
        route = route_of(Pulley(case.radius, case.arm, lead_in=5), point_a(case.robot, i))
        for path in in_both(route, case.anchor):
            assert abs(path.length - case.length[i]) < 1e-9
            assert abs(path.before - case.before[i]) < 1e-9
            assert abs(path.wrap - case.wrap[i]) < 1e-9
            assert abs(path.free - case.free[i]) < 1e-9
            assert close(path.centre, case.centre[i], 1e-9)
            assert close(path.entry, case.entry[i], 1e-9)
            assert close(path.exit, case.exit[i], 1e-9)


@pytest.mark.parametrize("case", DEGM, ids=lambda case: f"{case.robot}-{case.joints}-{case.unstretched[0]}")
def test_elastic_ropes_hang_as_computed_independently(case: Hanging) -> None:
    """Balance of forces and the stretch of the whole length; exact balance of the arm is 2e-5 m from that."""
    axial = case.modulus * math.pi * 0.004**2 / 4
    joints = 1 if case.joints == "SR" else 2
    force = np.array([0.0, 0.0, -300 * 9.81])
    for balance in (EXACT, BISECTOR) if joints == 2 else (EXACT,):
        pulley = Pulley(case.radius, case.arm, joints, lead_in=case.lead_in, balance=balance)
        law = law_of(Cable("c", (0, 0, 0), (0, 0, 0), Elasticity(axial_stiffness=axial)))
        total = force.copy()
        for i, unstretched, tension in zip(case.cables, case.unstretched, case.tensions, strict=True):
            path = route_of(pulley, point_a(case.robot, i - 1)).path(case.anchor, FLOATS)
            total -= tension * np.array(path.direction)
            if joints == 2 and balance == EXACT:
                wanted = unstretched * (1 + tension / axial)
                # The arm of least length: the bisector's is longer, by what its error costs.
                assert -2e-5 < path.length - wanted < 1e-10
                continue
            assert abs(path.length - unstretched * (1 + tension / axial)) < 1e-8
            assert abs(law.unstretched(path.length, tension, float) - unstretched) < 1e-8
            assert abs(law.stretch(unstretched, tension, float) - (path.length - unstretched)) < 1e-8
        assert np.abs(total).max() < (1e-8 * 2943 if balance == BISECTOR or joints == 1 else 0.2)


def test_the_bisector_is_that_of_the_angle_at_a() -> None:
    rng = Random(5)
    for _ in range(100):
        point, pulley = random_point(rng), random_pulley(rng, (2, BISECTOR), roomy=True)
        anchor = anchor_at(pulley, point, rng.uniform(0.5, 4), rng.uniform(-4, 2), rng)
        path = route_of(pulley, point).path(tuple(anchor), FLOATS)
        a = np.array([float(x) for x in point])
        along = (anchor - a) / np.linalg.norm(anchor - a) - unit_axis(pulley)
        wanted = a + float(pulley.arm_length) * along / np.linalg.norm(along)
        assert close(path.centre, wanted, 1e-12)


def test_exact_balance_is_near_the_bisector_and_never_longer() -> None:
    """Of pulleys as they are built: by less than 1e-5 m in the length."""
    rng, worst = Random(6), 0.0
    for _ in range(100):
        point = random_point(rng)
        anchor = (float(point[0]) + rng.uniform(1, 4), float(point[1]), float(point[2]) - rng.uniform(1, 4))
        exact, bisector = (
            route_of(Pulley("0.0665", "0.1", 2, lead_in=5, balance=b), point).path(anchor, FLOATS)
            for b in (EXACT, BISECTOR)
        )
        assert -1e-14 < bisector.length - exact.length < 2e-5
        worst = max(worst, bisector.length - exact.length)
    assert worst > 1e-7, "both are the same"


def legs_moment(path: Path, pulley: Pulley, point: Any) -> Any:
    """Return the moment of the pulls of both legs on the pulley about A, for unit tension, m."""
    a = np.array([float(x) for x in point])
    start = a - float(pulley.lead_in) * unit_axis(pulley)
    entry, leaving = np.array(path.entry), np.array(path.exit)
    arriving = (start - entry) / np.linalg.norm(start - entry)
    return np.cross(entry - a, arriving) + np.cross(leaving - a, np.array(path.direction))


def test_the_legs_have_no_moment_about_a_in_exact_balance() -> None:
    rng = Random(7)
    largest = 0.0
    for _ in range(200):
        point, pulley = random_point(rng), random_pulley(rng, (2, EXACT), roomy=True)
        anchor = anchor_at(pulley, point, rng.uniform(0.5, 4), rng.uniform(-4, 2), rng)
        path = route_of(pulley, point).path(tuple(anchor), FLOATS)
        if path.wrap == 0:
            continue
        assert np.abs(legs_moment(path, pulley, point)).max() < 1e-13
        bisector = pulley.replace(balance=BISECTOR)
        other = route_of(bisector, point).path(tuple(anchor), FLOATS)
        largest = max(largest, np.abs(legs_moment(other, bisector, point)).max())
    assert largest > 1e-4, "the bisector is in balance too"


def test_both_legs_touch_the_pulley() -> None:
    rng = Random(8)
    for _ in range(200):
        point, pulley = random_point(rng), random_pulley(rng)
        anchor = anchor_at(pulley, point, *near_or_far(pulley, rng), rng)
        try:
            path = route_of(pulley, point).path(tuple(anchor), FLOATS)
        except OffTheCable:
            continue
        reached = np.array(path.exit) + path.free * np.array(path.direction)
        assert close(reached, anchor, 1e-9)
        if path.wrap > 0:
            r = float(pulley.radius)
            for touching in (path.entry, path.exit):
                assert abs(np.linalg.norm(np.array(touching) - path.centre) - r) < 1e-9
            spoke = (np.array(path.exit) - path.centre) / r
            assert abs(spoke @ np.array(path.direction)) < 1e-6
            # The centre is as far from A as the arm is long.
            out = np.array(path.centre) - [float(x) for x in point]
            assert abs(np.linalg.norm(out) - float(pulley.arm_length)) < 1e-9


def test_no_path_is_shorter_than_the_straight_line() -> None:
    """And where the pulley is not touched, it is that line."""
    rng, straight = Random(9), dict.fromkeys(KINDS, 0)
    for _ in range(1500):
        point, pulley = random_point(rng), random_pulley(rng)
        anchor = anchor_at(pulley, point, *near_or_far(pulley, rng), rng)
        try:
            path = route_of(pulley, point).path(tuple(anchor), FLOATS)
        except OffTheCable:
            continue
        start = np.array([float(x) for x in point]) - float(pulley.lead_in) * unit_axis(pulley)
        least = float(np.linalg.norm(anchor - start))
        assert path.wrap >= 0 and path.length > least - 1e-9
        if path.wrap == 0 and path.before == 0 and path.free > 0 and path.exit == path.entry:
            straight[pulley.joints, pulley.balance] += 1
            assert abs(path.length - least) < 1e-12
            assert close(path.direction, (anchor - start) / least, 1e-9)
    assert min(straight.values()) > 10, straight


def test_a_long_arm_lets_the_rope_pass() -> None:
    """The line from the winch, 0.2 m below A, passes A at 0.1 m: the pulley can hang beside it."""
    for kind in KINDS:
        joints, balance = kind
        pulley = Pulley("0.05", "0.5", joints, lead_in="0.2", balance=balance)
        for anchor in ((0.25, 0.0, 0.4), (0.0, -0.2, 0.3)):
            path = route_of(pulley).path(anchor, FLOATS)
            assert abs(path.length - math.dist(anchor, (0, 0, -0.2))) < 1e-12, kind
            assert path.wrap == 0 and close(path.exit, (0, 0, -0.2), 1e-15)


def test_a_rope_that_hangs_over_a_pulley_stays_there() -> None:
    """The line from the winch would pass A at 3 cm, beside the pulley; but the arm is in balance below A."""
    anchor = (0.02, 0.0, -2.0)
    for path in in_both(route_of(Pulley("0.0665", "0.1", 2, lead_in=5)), anchor):
        assert path.length > 7 and 3 < path.wrap < 3.3


@pytest.mark.parametrize("kind", KINDS)
def test_length_and_direction_go_on_where_the_rope_leaves_the_pulley(kind: tuple[int, str]) -> None:
    joints, balance = kind
    route = route_of(Pulley("0.05", "0.3", joints, lead_in="0.4", balance=balance))
    low, high = -0.5, 3.0

    def at(z: float) -> Path:
        return route.path((1.0, 0.0, z), FLOATS)

    assert at(low).wrap > 0 == at(high).wrap
    while high - low > 1e-9:
        half = (low + high) / 2
        low, high = (half, high) if at(half).wrap > 0 else (low, half)
    touching, past = at(low - 1e-9), at(high + 1e-9)
    assert touching.wrap > 0 == past.wrap
    assert abs(touching.length - past.length) < 1e-8
    assert close(touching.direction, past.direction, 1e-6)


def held_length(x: float, y: float, r: float, h: float, lead: float, delta: float) -> float | None:
    """Return the length over a pulley held at an angle, by plane geometry alone; None where there is none."""
    hx, hy = h * math.sin(delta), -h * math.cos(delta)
    spans = [(-hx, -lead - hy), (x - hx, y - hy)]
    if any(math.hypot(*span) <= r for span in spans):
        return None
    towards = [math.atan2(span[1], span[0]) for span in spans]
    # Clockwise over the outside: from one direction to the other less both triangles.
    turn = (towards[0] - towards[1]) % (2 * math.pi)
    wrap = turn - sum(math.acos(r / math.hypot(*span)) for span in spans)
    if wrap < 0:
        return None
    return sum(math.sqrt(span[0] ** 2 + span[1] ** 2 - r * r) for span in spans) + r * wrap


def test_exact_balance_is_the_least_length() -> None:
    """Against a search over angles of the arm, also close to the pulley and with the winch close to it."""
    rng, seen = Random(10), 0
    for _ in range(150):
        r, h = 0.05, rng.choice([0.05, 0.08, 0.2])
        lead, x, y = rng.uniform(0.02, 0.6), rng.uniform(0.01, 0.5), rng.uniform(-0.5, 0.5)
        route = route_of(Pulley(r, h, 2, lead_in=lead))
        try:
            path = route.path((x, 0.0, y), FLOATS)
        except OffTheCable:
            continue
        if path.wrap == 0:
            continue
        seen += 1
        around = [math.atan2(x, -y) / 2 + turn for turn in np.linspace(-0.5, 0.5, 401)]
        lengths = [found for d in around if (found := held_length(x, y, r, h, lead, d)) is not None]
        assert path.length < min(lengths) + 1e-12, (x, y, h, lead)
        a = np.array(path.centre)
        own = held_length(x, y, r, h, lead, math.atan2(a[0], -a[2]))
        assert own is not None and abs(own - path.length) < 1e-9, (x, y, h, lead)
    assert seen > 60


def test_a_winch_close_to_a_hanging_pulley() -> None:
    """The rope arrives from below, almost at the pulley: its touching point is at the pulley's bottom."""
    r, h, lead, x, y = 0.0665, 0.1, 0.17, 0.02, -1.0
    path = route_of(Pulley(r, h, 2, lead_in=lead, balance=BISECTOR)).path((x, 0.0, y), FLOATS)
    wanted = held_length(x, y, r, h, lead, math.atan2(x, -y) / 2)
    assert wanted is not None and path.wrap > 3.5
    assert abs(path.length - wanted) < 1e-12


def derivatives(route: Any, anchor: Any, e: arb) -> tuple[list[arb], list[list[arb]]]:
    """Return the differences of length and direction in balls."""
    gradient, turning = [], []
    for j in range(3):
        ends = []
        for side in (1, -1):
            moved = list(anchor)
            moved[j] = anchor[j] + side * e
            ends.append(route.path(tuple(moved), BALLS))
        gradient.append((ends[0].length - ends[1].length) / (2 * e))
        turning.append([(ends[0].direction[i] - ends[1].direction[i]) / (2 * e) for i in range(3)])
    return gradient, [[turning[j][i] for j in range(3)] for i in range(3)]


@pytest.mark.parametrize("kind", [None, *KINDS], ids=str)
def test_derivatives_against_differences_of_many_digits(kind: tuple[int, str] | None) -> None:
    rng, seen, tilted = Random(11), 0, 0
    with ctx.workprec(400):
        e = arb(10) ** -30
        for _ in range(60):
            point = random_point(rng)
            pulley = random_pulley(rng, kind) if kind else None
            place = near_or_far(pulley, rng) if pulley else (rng.uniform(0, 3), rng.uniform(-3, 3))
            anchor = as_balls(anchor_at(pulley or Pulley(1), point, *place, rng))
            route = route_of(pulley, point)
            try:
                path = route.path(anchor, BALLS)
                gradient, turning = derivatives(route, anchor, e)
            except OffTheCable:
                continue
            seen += 1
            claimed = route.turning(path, anchor, BALLS)
            size = 1 + max(abs(float(x.mid())) for row in claimed for x in row)
            for i in range(3):
                if kind != (2, BISECTOR):
                    assert abs(gradient[i] - path.direction[i]) < arb(10) ** -20
                elif not abs(gradient[i] - path.direction[i]) < arb(10) ** -9:
                    tilted += 1
                for j in range(3):
                    assert abs(turning[i][j] - claimed[i][j]) < arb(10) ** -20 * size**3, (pulley, place)
    assert seen > 30 and (tilted > 0) == (kind == (2, BISECTOR))


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_a_small_pulley_is_a_fixed_exit_point(kind: tuple[int, str]) -> None:
    rng = Random(12)
    joints, balance = kind
    for _ in range(20):
        point = random_point(rng)
        anchor = anchor_at(Pulley(1), point, rng.uniform(0.5, 3), rng.uniform(-3, 2), rng)
        plain = route_of(Pulley(0, lead_in=2), point).path(tuple(anchor), FLOATS)
        assert plain.wrap == 0 and plain.before == 2
        for r in (1e-3, 1e-5, 1e-7):
            path = route_of(Pulley(r, 2 * r, joints, lead_in=2, balance=balance), point)
            found = path.path(tuple(anchor), FLOATS)
            assert abs(found.length - plain.length) < 8 * r
            assert close(found.direction, plain.direction, 10 * r)
            assert close(found.exit, plain.exit, 3.1 * r)
        fixed = route_of(None, point).path(tuple(anchor), FLOATS)
        assert abs(plain.length - fixed.length - 2) < 1e-13 and fixed.direction == plain.direction


@pytest.mark.parametrize(
    ("pulley", "anchor"),
    [
        (None, (0, 0, 0)),
        (Pulley("0.1"), (0.1, 0.0, 0.0)),
        (Pulley("0.1"), (0.15, 0.02, 0.05)),
        (Pulley("0.1", lead_in=1), (0.0, 0.0, -1.0)),
        (Pulley("0.1", "0.2", axis=(1, 0, 0)), (3.0, 0.0, 0.0)),
        # The rope would have to run around the whole pulley.
        (Pulley("0.1"), (0.005, 0.0, -0.04)),
        (Pulley("0.1", joints=2, lead_in=1), (0.0, 0.0, 0.0)),
        (Pulley("0.1", joints=2, lead_in=1, balance=BISECTOR), (0.12, 0.0, 0.02)),
        # The winch would lie inside the pulley.
        (Pulley("0.1", joints=2, lead_in="0.05"), (1.0, 0.0, 0.0)),
        (Pulley("0.1", joints=2, lead_in="0.05", balance=BISECTOR), (1.0, 0.0, 0.0)),
    ],
)
def test_there_is_no_path(pulley: Pulley | None, anchor: tuple[float, float, float]) -> None:
    with pytest.raises(OffTheCable):
        route_of(pulley).path(anchor, FLOATS)
    with balls.precision(), pytest.raises(OffTheCable):
        route_of(pulley).path(as_balls(np.array(anchor, dtype=float)), BALLS)


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_a_ball_of_anchors_holds_the_paths_to_its_points(kind: tuple[int, str]) -> None:
    """Also across the end of contact: either the ball's path is refused or it holds both."""
    rng, seen = Random(13), 0
    with balls.precision():
        for _ in range(150):
            point, pulley = random_point(rng), random_pulley(rng, kind)
            middle = anchor_at(pulley, point, *near_or_far(pulley, rng), rng)
            radius = 10 ** rng.uniform(-9, -2)
            route = route_of(pulley, point)
            try:
                wide = route.path(tuple(arb(float(x), radius) for x in middle), BALLS)
            except OffTheCable:
                continue
            for _ in range(4):
                anchor = middle + radius * np.array([rng.uniform(-1, 1) for _ in range(3)])
                try:
                    path = route.path(as_balls(anchor), BALLS)
                except OffTheCable:
                    continue
                seen += 1
                assert wide.length.overlaps(path.length) and wide.wrap.overlaps(path.wrap), pulley
                assert all(a.overlaps(b) for a, b in zip(wide.direction, path.direction, strict=True)), pulley
    assert seen > 100
