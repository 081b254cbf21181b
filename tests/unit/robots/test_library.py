"""The robots that ship, and the JSON Schemas."""

from fractions import Fraction

import pytest

from cdpr_interval import load_robot
from cdpr_interval.mechanics.cables.law import law_of
from cdpr_interval.robots.shipped import shipped_robots
from scripts.make_schemas import ROOT, schemas

CABLES = {
    "acrobot": 8,
    "cogiro": 8,
    "fast": 6,
    "four_winches": 4,
    "gough_40": 6,
    "grab33": 3,
    "irma4u": 4,
    "merlet_4_1": 4,
    "merlet_4_1_k100": 4,
    "merlet_4_1_k1000": 4,
    "nist_robocrane": 6,
    "paty_cdpr4": 4,
    "six_leg_40": 6,
    "uc2": 2,
    "uc3": 3,
    "uc4": 4,
}


def test_the_list_is_complete():
    assert shipped_robots() == tuple(sorted(CABLES))


@pytest.mark.parametrize("name", sorted(CABLES))
def test_every_robot_loads_and_names_its_source(name: str):
    robot = load_robot(name)
    assert robot.name == name.replace("_", "-")
    assert robot.source
    assert len(robot.cables) == CABLES[name]
    assert robot.uncertain == ()
    assert robot.is_point_mass == name.startswith(("merlet", "four", "paty"))


def test_merlet_2012_equation_2():
    robot = load_robot("merlet_4_1")
    assert [cable.frame_anchor for cable in robot.cables] == [(0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0)]
    assert robot.platform.mass * -robot.gravity[2] == Fraction("784.8")
    assert not robot.is_elastic


@pytest.mark.parametrize(("name", "newton_per_cm"), [("merlet_4_1_k100", 100), ("merlet_4_1_k1000", 1000)])
def test_merlet_2012_section_4_exchanges_labels_2_and_3(name: str, newton_per_cm: int):
    robot, inextensible = load_robot(name), load_robot("merlet_4_1")
    anchors = [cable.frame_anchor for cable in robot.cables]
    assert [anchors[i] for i in (0, 2, 1, 3)] == [cable.frame_anchor for cable in inextensible.cables]
    stiffness = {cable.elasticity.stiffness for cable in robot.cables if cable.elasticity}
    assert stiffness == {newton_per_cm * 100}
    assert not robot.is_mixed


def test_merlet_2012_section_4_nominal_lengths_fit_the_exchanged_labels():
    """Equilibrium at (1, 2, -2) m with the printed lengths, tensions and k = 1000 N/cm."""
    robot = load_robot("merlet_4_1_k1000")
    lengths, tensions = [2.99558, 2.99558, 4.121083, 4.121083], [441.45, 441.45, 202.2383, 202.2383]
    pose, force = (1.0, 2.0, -2.0), [0.0, 0.0, -784.8]
    for cable, length, tension in zip(robot.cables, lengths, tensions, strict=True):
        constant = law_of(cable).spring_constant(Fraction(1))
        assert constant is not None
        pull = [float(a) - p for a, p in zip(cable.frame_anchor, pose, strict=True)]
        distance = sum(e * e for e in pull) ** 0.5
        assert distance == pytest.approx(length + tension / float(constant), abs=2e-5)
        force = [f + tension * e / distance for f, e in zip(force, pull, strict=True)]
    assert force == pytest.approx([0, 0, 0], abs=0.01)


@pytest.mark.parametrize("name", ["uc2", "uc3", "uc4"])
def test_uc_robots_weigh_one_newton_and_extend_each_other(name: str):
    robot, largest = load_robot(name), load_robot("uc4")
    assert robot.platform.mass * -robot.gravity[2] == 1
    assert robot.cables == largest.cables[: len(robot.cables)]


def test_schemas_are_current():
    for name, text in schemas().items():
        assert (ROOT / name).read_text(encoding="utf-8") == text, "run make schemas"
