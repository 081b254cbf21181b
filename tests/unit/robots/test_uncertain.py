"""Numbers given as ranges: kept exactly, listed by their place, and refused by whatever needs one number."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction as F
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from cdpr_interval import InputError, NotSupportedError
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.cables.law import model_of
from cdpr_interval.mechanics.loaded import NO_FORCE, loaded
from cdpr_interval.mechanics.statics import static_model
from cdpr_interval.robots.cable_robot import Elasticity, Robot, Uncertain
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.robots.numbers import exact, exact_point
from solvers import (
    PointMass,
    Tracker,
    forward_kinematics,
    inverse_kinematics,
    polynomial_report,
    pose_from_tensions,
)
from solvers.answers.robot_data import robot_from_json, robot_to_json
from solvers.batch.expansion import stiffness_of
from solvers.batch.job_file import read_job_file
from solvers.point_mass.arrays import build_arrays
from solvers.proofs.text import robot_document
from solvers.report.scene import frame_points
from solvers.winches.where import whereabouts


class Place(NamedTuple):
    """A number of the robot below that may be a range."""

    path: str
    value: str
    of: Callable[[Robot], Any]
    """Return what a robot has there."""


PLACES = (
    Place("gravity_m_s2[0]", "0.5", lambda r: r.gravity[0]),
    Place("platform.mass_kg", "10", lambda r: r.platform.mass),
    Place("platform.centre_of_mass_m[1]", "0", lambda r: r.platform.centre_of_mass[1]),
    Place("cables[0].frame_anchor_m[0]", "0.1", lambda r: r.cables[0].frame_anchor[0]),
    Place("cables[0].platform_anchor_m[2]", "0", lambda r: r.cables[0].platform_anchor[2]),
    Place("cables[0].elasticity.stiffness_N_per_m", "1000", lambda r: r.cables[0].elasticity.stiffness),
    Place("cables[1].frame_anchor_m[1]", "0", lambda r: r.cables[1].frame_anchor[1]),
    Place("cables[1].elasticity.axial_stiffness_N", "5e3", lambda r: r.cables[1].elasticity.axial_stiffness),
)
"""In the order in which a robot lists them."""
TEXT = """\
format: cdpr-robot/1
name: vague
gravity_m_s2: [{}, 0, -9.81]
platform: {{mass_kg: {}, centre_of_mass_m: [0, {}, 0]}}
cables:
  - name: c1
    frame_anchor_m: [{}, 0, 3]
    platform_anchor_m: [0, 0, {}]
    elasticity: {{stiffness_N_per_m: {}}}
  - name: c2
    frame_anchor_m: [4, {}, 3]
    platform_anchor_m: [0, 0, 0]
    elasticity: {{axial_stiffness_N: {}}}
"""
FORMS = {"tolerance": "{{value: {}, tolerance: 0.01}}", "bounds": "[{}, 1e4]"}
ENTRIES: dict[str, Callable[[Robot], object]] = {
    "fk": lambda robot: forward_kinematics(robot, [3, 3]),
    "ik": lambda robot: inverse_kinematics(robot, (2, 0, 0)),
    "PointMass": lambda robot: PointMass(robot).solve([3, 3]),
    "Tracker": lambda robot: Tracker(robot).update([3, 3]),
    "tensions": lambda robot: pose_from_tensions(robot, [80, 80]),
    "polynomial": lambda robot: polynomial_report(robot, [3, 3]),
    "polynomial-tensions": lambda robot: polynomial_report(robot, tensions=[80, 80]),
    "winches": lambda robot: whereabouts(robot, [(3.0, 3.1), (3.0, 3.1)]),
}
"""What a user asks a robot."""
ASKERS = {
    "ik": "ik",
    "polynomial": "polynomial",
    "polynomial-tensions": "polynomial",
}
"""Those that take exact numbers only, as their refusals name them."""
each_place = pytest.mark.parametrize("place", PLACES, ids=lambda place: place.path)


def text(form: str = "{}", *places: Place) -> str:
    """Return the robot's file with some numbers in another form."""
    return TEXT.format(*(form.format(p.value) if p in places else p.value for p in PLACES))


def vague(place: Place) -> Robot:
    """Return the robot with a range at a place."""
    return parse_robot(text(FORMS["tolerance"], place))


@each_place
@pytest.mark.parametrize("form", FORMS)
def test_a_range_of_a_file_is_one_in_the_data(place: Place, form: str) -> None:
    value = F(place.value)
    wanted = Range(value - F(1, 100), value + F(1, 100)) if form == "tolerance" else Range(value, F(10000))
    robot = parse_robot(text(FORMS[form], place))
    assert place.of(robot) == wanted and isinstance(place.of(robot), Range)
    assert robot.uncertain == (Uncertain(place.path, *wanted),)
    assert sum(isinstance(other.of(robot), Range) for other in PLACES) == 1


def test_ranges_are_listed_in_the_order_of_the_data() -> None:
    robot = parse_robot(text(FORMS["bounds"], *PLACES))
    assert [scalar.path for scalar in robot.uncertain] == [place.path for place in PLACES]
    assert parse_robot(text()).uncertain == ()


TAKES_RANGES = ("fk", "tensions", "winches")
"""All data may be ranges."""
OF_ANCHORS = ("platform.centre_of_mass_m[1]", "cables[0].platform_anchor_m[2]")
"""Places whose ranges make a platform."""


@each_place
@pytest.mark.parametrize("entry", ASKERS)
def test_what_takes_numbers_only_refuses_by_name(entry: str, place: Place) -> None:
    by = ASKERS[entry]
    message = f"^robot 'vague': uncertain scalars are not supported by {by} yet: {re.escape(place.path)}$"
    with pytest.raises(NotSupportedError, match=message):
        ENTRIES[entry](vague(place))


@pytest.mark.parametrize("path", OF_ANCHORS)
@pytest.mark.parametrize("entry", TAKES_RANGES)
def test_a_range_that_makes_a_platform_makes_one(entry: str, path: str) -> None:
    """It is refused as that of a platform on springs."""
    (place,) = [place for place in PLACES if place.path == path]
    reason = "for point masses" if entry == "tensions" else "by platforms on pulleys or elastic cables yet"
    with pytest.raises(NotSupportedError, match=reason):
        ENTRIES[entry](vague(place))


def test_the_questions_are_answered_of_exact_numbers() -> None:
    """But those to the other class: what is refused above is the range."""
    robot = parse_robot(text())
    for entry in ENTRIES.keys() - {"Tracker"}:
        ENTRIES[entry](robot)


@each_place
@pytest.mark.parametrize("entry", TAKES_RANGES)
def test_point_masses_take_ranges_of_all_data(entry: str, place: Place) -> None:
    robot = vague(place)
    if robot.is_point_mass:
        ENTRIES[entry](robot)


@each_place
def test_a_batch_that_draws_is_refused(tmp_path: Path, place: Place) -> None:
    (tmp_path / "vague.yaml").write_text(text(FORMS["tolerance"], place), encoding="utf-8")
    job = tmp_path / "job.yaml"
    rest = "lengths_m: [3, 3]\n    samples: 2\n    seed: 1\n    perturb: "
    drawn = "{lengths_m: {distribution: uniform, half_width: 0.1}, " + (
        "frame_anchors_m: {distribution: uniform, half_width: 0.1}, "
        "stiffness: {distribution: uniform, relative_half_width: 0.1}}"
    )
    problem = f"type: monte-carlo\n    {rest}{drawn}"
    job.write_text(
        f"format: cdpr-batch/1\nrobots: [vague.yaml]\nproblems:\n  - {problem}\n", encoding="utf-8"
    )
    reason = re.escape(place.path)
    with pytest.raises(NotSupportedError, match=reason):
        read_job_file(job)


def test_the_gate_lets_no_range_through() -> None:
    half = Range(F(1, 2), F(1, 2))
    assert exact(F(1, 2)) == F(1, 2) and exact_point((F(1), F(2), F(3))) == (1, 2, 3)
    with pytest.raises(NotSupportedError, match=r"\[1/2, 1/2\]"):
        exact(half)
    with pytest.raises(NotSupportedError, match="range"):
        exact_point((F(1), F(2), half))


VIEWS: dict[str, Callable[[Robot], object]] = {
    "load": lambda robot: loaded(robot).load,
    "gravity": lambda robot: loaded(robot).gravity,
    "exits": lambda robot: loaded(robot).exits,
    "centre": lambda robot: loaded(robot).centre,
    "anchors": lambda robot: loaded(robot).anchors,
    "arms": lambda robot: loaded(robot).arms,
    "models": lambda robot: [model_of(cable, robot.gravity) for cable in robot.cables],
    "statics": lambda robot: static_model(robot, NO_FORCE),
    "arrays": lambda robot: build_arrays(robot, (F(0), F(0), F(-1))),
    "certificate": robot_document,
    "stiffness": stiffness_of,
}
"""What takes numbers out of a robot."""
MET = {
    "load": (0, 1),
    "gravity": (0,),
    "exits": (3, 5, 6, 7),
    "centre": (2,),
    "anchors": (4,),
    "arms": (2, 4),
    "models": (3, 5, 6, 7),
    "statics": (0, 1, 2, 3, 4, 5, 6, 7),
    "arrays": (0, 2, 3, 5, 6, 7),
    "certificate": (0, 1, 2, 3, 4, 5, 6, 7),
    "stiffness": (5, 7),
}
"""The places whose ranges each of them meets, as numbers in `PLACES`."""


@pytest.mark.parametrize("view", VIEWS)
def test_no_view_of_the_data_takes_a_number_out_of_a_range(view: str) -> None:
    VIEWS[view](parse_robot(text()))
    for k, place in enumerate(PLACES):
        if k in MET[view]:
            with pytest.raises(NotSupportedError, match="range"):
                VIEWS[view](vague(place))
        else:
            VIEWS[view](vague(place))


def test_equal_ranges_are_not_known_to_be_one_point() -> None:
    """A centre of mass and anchors within the same bounds may all differ: that is a platform."""
    lines = text().replace("centre_of_mass_m: [0, 0, 0]", "centre_of_mass_m: [0, 0, [0, 1]]")
    lines = lines.replace("platform_anchor_m: [0, 0, 0]", "platform_anchor_m: [0, 0, [0, 1]]")
    robot = parse_robot(lines)
    assert len(robot.uncertain) == 3
    assert not robot.is_point_mass and robot.model == "six-dof"
    assert parse_robot(text()).is_point_mass


def test_robots_with_ranges_are_written_as_they_are() -> None:
    robot = parse_robot(text(FORMS["bounds"], *PLACES))
    for again in (Robot.from_dict(robot.to_dict()), parse_robot(robot.to_yaml())):
        assert again == robot and again.uncertain == robot.uncertain
    changed = robot.replace(name="other", platform=robot.platform.replace(mass=("9.5", "10.5")))
    assert changed.platform.mass == Range(F("9.5"), F("10.5"))
    again = parse_robot(changed.to_yaml())
    assert again == changed and again.sha256 == changed.sha256 != robot.sha256
    assert robot_from_json(robot_to_json(changed)) == changed
    assert not changed.is_exact and changed.middle().is_exact


@pytest.mark.parametrize("key", ["stiffness", "axial_stiffness"])
def test_stiffness_is_positive_for_every_choice(key: str) -> None:
    with pytest.raises(InputError, match=f"^{key}: must be greater than 0"):
        Elasticity(**{key: (-1, 5)})
    with pytest.raises(InputError, match=r"mass: must not be negative"):
        robot = parse_robot(text())
        robot.platform.replace(mass=(-1, 5))


def test_a_force_with_a_range_is_refused_where_one_number_is_needed() -> None:
    force = (0, (1, 2), 0)
    for entry in (
        lambda: inverse_kinematics("uc2", (5, 0, -7), external_force=force),
        lambda: polynomial_report("uc2", [7.5, 8], external_force=force),
    ):
        with pytest.raises(InputError, match=r"^external_force\[1\]: must be one number here, got a range$"):
            entry()


def test_a_range_is_drawn_at_its_middle() -> None:
    robot = parse_robot(text(FORMS["bounds"], PLACES[6]))
    assert np.array_equal(frame_points(robot), [[0.1, 0.0, 3.0], [4.0, 5000.0, 3.0]])
