"""Gruebler's count and the rank of loops: published mechanisms, random ones, special ones, and bad files."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from click.testing import CliRunner

from cdpr_interval import InputError
from cdpr_interval.files.document import parse_document
from cdpr_interval.robots.formats.mechanism_reader import mechanism, shipped_mechanisms
from cdpr_interval.robots.mechanism import AXES, FREEDOMS, Joint, Mechanism
from solvers import mobility
from solvers.cli import cli

SEED = 20261201
PUBLISHED = {
    "delta_12_balls": (11, 15, 5, 9, 9, 3, 6),
    "delta_universal": (8, 9, 2, 3, 3, 3, 0),
    "delta_linear_universal": (8, 9, 2, 3, 3, 3, 0),
    "gough_ups": (14, 18, 5, 6, 6, 6, 0),
    "gough_sps": (14, 18, 5, 12, 12, 6, 6),
    "four_bar": (4, 4, 1, -2, 1, 1, 0),
}
"""Bodies, joints, loops and count as in EPFL, Les robots paralleles; by rank, of the platform, idle."""


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_mechanisms(name: str):
    bodies, joints, loops, count, by_rank, of_platform, idle = PUBLISHED[name]
    found = mobility(name)
    assert (found.count.bodies, found.count.joints, len(found.count.loops)) == (bodies, joints, loops)
    assert found.count.mobility == count == 6 * (bodies - joints - 1) + found.count.freedoms
    free = found.freedom
    assert (free.mobility, free.platform, free.idle) == (by_rank, of_platform, idle)
    assert free.redundant == by_rank - count
    assert set(PUBLISHED) == set(shipped_mechanisms())
    if idle:
        assert all(joint.startswith("S") for joint in free.idle_joints)


def drawn(generator: np.random.Generator) -> Mechanism:
    """Return a random connected mechanism of 2 to 6 bodies and up to four loops, at a generic pose."""

    def vector() -> tuple[Fraction, Fraction, Fraction]:
        x, y, z = (Fraction(int(v), 97) for v in generator.integers(-900, 901, 3))
        return x, y, z

    count = int(generator.integers(2, 7))
    bodies = tuple(f"b{k}" for k in range(count))
    pairs = [(bodies[int(generator.integers(k))], bodies[k]) for k in range(1, count)]
    every = list(itertools.combinations(bodies, 2))
    pairs += [every[int(generator.integers(len(every)))] for _ in range(int(generator.integers(0, 5)))]
    joints = []
    kinds = list(FREEDOMS) if generator.random() < 0.3 else ["R", "U", "U"]
    for k, pair in enumerate(pairs):
        kind = str(generator.choice(kinds))
        joints.append(Joint(f"j{k}", kind, pair, vector(), tuple(vector() for _ in range(AXES[kind]))))
    return Mechanism("drawn", bodies, tuple(joints), bodies[0], bodies[-1])


def has_special_loops(given: Mechanism) -> bool:
    """Return True where joints are special at every pose, or some have too few freedoms for their loops.

    Slides have rank 3 at most, and two balls between two bodies leave a spin that the count does not know.
    """
    kinds = [joint.kind for joint in given.joints]
    if "P" in kinds or "C" in kinds or kinds.count("S") > 1:
        return True
    for size in range(1, len(given.joints)):
        for some in itertools.combinations(given.joints, size):
            if sum(joint.freedoms for joint in some) < 6 * loops_among(some):
                return True
    return False


def loops_among(joints: tuple[Joint, ...]) -> int:
    """Return how many independent loops some joints close."""
    parts: dict[str, set[str]] = {}
    closed = 0
    for joint in joints:
        first, second = (parts.setdefault(body, {body}) for body in joint.bodies)
        if first is second:
            closed += 1
        else:
            first |= second
            parts.update(dict.fromkeys(first, first))
    return closed


def compare(rounds: int) -> tuple[int, int]:
    """Return how many mechanisms were compared, and how many of them were not special."""
    generator, plain = np.random.default_rng(SEED), 0
    for _ in range(rounds):
        given = drawn(generator)
        found = mobility(given)
        free = found.freedom
        assert free.mobility >= max(0, found.count.mobility), given
        assert free.platform + free.idle == free.mobility and 0 <= free.platform <= 6
        if not has_special_loops(given):
            plain += 1
            assert free.mobility == max(0, found.count.mobility), given
    return rounds, plain


def test_random_mechanisms_have_the_mobility_of_the_count_where_no_loop_is_special():
    assert compare(300)[1] > 60


def rank_in_floats(given: Mechanism) -> int:
    """Return the mobility from twists of bodies as unknowns, an assembly of another kind."""
    free = [b for b in given.bodies if b != given.base]
    columns = 6 * len(free) + sum(joint.freedoms for joint in given.joints)
    rows, at = [], 6 * len(free)
    for joint in given.joints:
        block = np.zeros((6, columns))
        for body, sign in zip(joint.bodies, (-1, 1), strict=True):
            if body != given.base:
                k = 6 * free.index(body)
                block[:, k : k + 6] += sign * np.eye(6)
        p = np.array([float(x) for x in joint.point])
        axes = np.eye(3) if joint.kind == "S" else np.array([[float(x) for x in a] for a in joint.axes])
        screws = [] if joint.kind == "P" else [[*a, *np.cross(p, a)] for a in axes]
        screws += [[0, 0, 0, *a] for a in axes] if joint.kind in ("P", "C") else []
        for screw in screws:
            block[:, at] = -np.array(screw)
            at += 1
        rows.append(block)
    return columns - int(np.linalg.matrix_rank(np.vstack(rows), tol=1e-8))


def test_twists_of_bodies_say_the_same():
    generator = np.random.default_rng(SEED)
    for _ in range(100):
        given = drawn(generator)
        assert mobility(given).freedom.mobility == rank_in_floats(given)


TEXT = """format: mechanism/1
name: slider
bodies: [base, crank, rod, block]
joints:
  - {kind: R, bodies: [base, crank], point_m: [0, 0, 0], axis: [0, 0, 1]}
  - {kind: R, bodies: [crank, rod], point_m: [1, 1, 0], axes: [[0, 0, 1]]}
  - {kind: R, bodies: [rod, block], point_m: [4, 0, 0], axis: [0, 0, 1]}
  - {kind: P, bodies: [block, base], axis: [1, 0, 0]}
"""


def read(text: str) -> Mechanism:
    return mechanism(parse_document(text, "m.yaml"))


def test_a_slider_crank_is_over_constrained_and_stuck_at_no_pose():
    found = mobility(read(TEXT))
    assert (found.count.mobility, found.freedom.mobility, found.freedom.redundant) == (-2, 1, 3)
    # At the dead centre the block cannot move, the crank can.
    dead = mobility(
        read(TEXT.replace("[1, 1, 0]", "[2, 0, 0]").replace("name: slider", "name: slider\nplatform: block"))
    )
    assert (dead.freedom.mobility, dead.freedom.platform, dead.freedom.idle) == (1, 0, 1)


def test_without_axes_there_is_no_rank():
    found = mobility(read(TEXT.replace(", axis: [1, 0, 0]", "")))
    assert found.freedom is None and found.to_dict()["rank"] is None and found.count.mobility == -2
    assert "rank         not asked for" in str(found)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("kind: P", "kind: X", "must be one of R, P, C, U, S"),
        ("[block, base]", "[block, wall]", r"m.yaml:8:\d+: joints\[3\].bodies\[1\]: 'wall' is no body"),
        ("[block, base]", "[block, block]", "must be two different bodies"),
        ("[crank, rod]", "[crank, base]", "not connected to 'base'"),
        ("axis: [1, 0, 0]", "axis: [0, 0, 0]", "must not be the zero vector"),
        ("axis: [1, 0, 0]", "axes: [[1, 0, 0], [0, 1, 0]]", "P has 1 axis, got 2"),
        ("kind: P", "axes: [[1, 0, 0], [2, 0, 0]], kind: U", "must not be parallel"),
        ("name: slider", "name: slider\nplatform: base", "must not be the base"),
        ("name: slider", "name: slider\nbase: wall", "'wall' is no body"),
        ("[base, crank, rod, block]", "[base, crank, rod, block, rod]", "'rod' is there twice"),
        ("kind: P", "name: R1, kind: P", r"'R1' is the name of joints\[0\] already"),
        ("axis: [1, 0, 0]", "axis: [1, 0, 0], axes: [[1, 0, 0]]", "not together with axis"),
    ],
)  # fmt: skip
def test_bad_files(old: str, new: str, message: str):
    assert old in TEXT
    text = TEXT.replace(old, new)
    if "[crank, base]" in new:
        text = text.replace("  - {kind: R, bodies: [rod, block], point_m: [4, 0, 0], axis: [0, 0, 1]}\n", "")
    if "kind: U" in new:
        text = text.replace(", axis: [1, 0, 0]", "")
    with pytest.raises(InputError, match=message):
        read(text)


def test_the_command(tmp_path):
    result = CliRunner().invoke(cli, ["mobility", "four_bar"])
    assert (
        result.exit_code == 0 and "loop  base -R1- crank -R2- coupler -R3- rocker -R4- base" in result.stdout
    )
    assert "4 - 6 * 1 = 6 (4 - 4 - 1) + 4 = -2" in result.stdout and "over-constrained" in result.stdout
    missing = CliRunner().invoke(cli, ["mobility", str(tmp_path / "none.yaml")])
    assert missing.exit_code == 2 and "no such file or shipped mechanism" in missing.stderr
    document = CliRunner().invoke(cli, ["mobility", "gough_sps", "--json", "-"]).stdout
    assert '"gruebler": 12' in document and '"rank": 30' in document
