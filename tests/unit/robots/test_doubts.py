"""What is allowed and hardly meant: told of robots in millimetres, not of real ones."""

from __future__ import annotations

from fractions import Fraction

import pytest

from cdpr_interval import load_robot
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from cdpr_interval.robots.doubts import doubts
from cdpr_interval.robots.shipped import shipped_robots

FAR = "platform_anchor_m: that of c0"
WIDE = "from the platform's origin, the frame 7.81 m wide (also c1, c2, c3)"
CORNERS = ((3, 2.5, 0.2), (3, -2.5, -0.2), (-3, 2.5, 0.2), (-3, -2.5, -0.2))


def crane(frame=1, anchors=1, centre=1, mass=45.5, gravity=(0, 0, -9.81), spring=None, dup=False) -> Robot:
    """Return a robot of 7.8 m on four cables, some of its lengths multiplied."""
    cables = [
        Cable(
            f"c{i}",
            (frame * x, frame * y, frame * 4),
            (anchors * x / 8, anchors * y / 8, anchors * z),
            None if spring is None else Elasticity(**spring),
        )
        for i, (x, y, z) in enumerate(CORNERS)
    ]
    if dup:
        cables[1] = cables[0].replace(name="c1")
    return Robot("crane", Platform(mass, (0.01 * centre, -0.005 * centre, 0.08 * centre)), cables, gravity)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"frame": 1000}, ["frame_anchor_m: exit points are 7810 m apart: in millimetres?"]),
        ({"anchors": 1000}, [f"{FAR} is 527.5 m {WIDE}: in millimetres?"]),
        ({"anchors": 25}, [f"{FAR} is 13.19 m {WIDE}: in the base frame instead of the platform's?"]),
        (
            {"centre": 1000},
            ["centre_of_mass_m: is 80.78 m from the platform anchors, which are 1.055 m apart: in mill"],
        ),
        (
            {"frame": 1000, "anchors": 1000, "centre": 1000},
            ["frame_anchor_m: exit points", "platform anchors are 1055 m apart on a platform of 45.5 kg"],
        ),
        (
            {"frame": 100, "anchors": 100, "mass": 2},
            ["platform anchors are 105.5 m apart on a platform of 2 kg: in millimetres?"],
        ),
        (
            {"frame": 100, "anchors": Fraction(1, 20)},
            ["frame_anchor_m: exit points are 781 m apart, platform anchors 0.05275 m: are some in"],
        ),
        (
            {"anchors": 1e-9, "centre": 0},
            ["platform_anchor_m: all are within 1.055e-09 m of centre_of_mass_m, and not equal to it"],
        ),
        ({"gravity": (0, 0, -9810)}, ["gravity_m_s2: is 9810 m/s2 strong"]),
        (
            {"spring": {"stiffness": 10}},
            ["stiffness_N_per_m: all cables together stretch by 11.16 m under the weight"],
        ),
        (
            {"spring": {"axial_stiffness": 100}},
            ["axial_stiffness_N: under the weight the cables stretch by more than their length"],
        ),
        ({"dup": True}, ["c0 and c1 run between the same two points"]),
        ({}, []),
        ({"spring": {"stiffness": 1e5}}, []),
        ({"mass": (40, 50)}, []),
    ],
)
def test_what_is_hardly_meant(given: dict, said: list[str]):
    found = doubts(crane(**given))
    assert len(found) == len(said)
    assert all(doubt.startswith(start) for doubt, start in zip(found, said, strict=True))


@pytest.mark.parametrize("name", shipped_robots())
def test_no_shipped_robot_is_doubted(name: str):
    assert doubts(load_robot(name)) == []


def test_one_cable_has_no_frame_to_compare_with():
    robot = Robot("bob", Platform(1), (Cable("c", (0, 0, 5), (0, 0, 900)),))
    assert doubts(robot) == []
