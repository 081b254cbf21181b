"""The page on adding things, walked: each recipe is carried out with a toy, and nothing else is touched."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables import law
from cdpr_interval.robots.cable_robot import Cable, Elasticity
from cdpr_interval.robots.formats import reader
from solvers import Outcome, Result, classes, forward_kinematics, inverse_kinematics, motion
from solvers.cli import main
from tests.support import hanging_mass, toy_class

PAGE = Path(__file__).resolve().parents[3] / "docs" / "inside" / "adding.md"
MOST_STEPS = 5


@pytest.fixture
def bob(monkeypatch, tmp_path) -> str:
    """Register the toy class and its format, and write a file of it."""
    monkeypatch.setitem(reader.FORMATS, toy_class.FORMAT, toy_class.read)
    monkeypatch.setattr(classes, "CLASSES", (*classes.CLASSES, toy_class.PlumbClass()))
    path = tmp_path / "bob.yaml"
    path.write_text(toy_class.FILE, encoding="utf-8")
    return str(path)


def test_every_recipe_has_at_most_five_steps() -> None:
    recipes = re.split(r"^## ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    assert [recipe.partition("\n")[0] for recipe in recipes] == [
        "A class of robots",
        "A cable model",
        "A condition on cells",
        "A file format",
    ]
    for recipe in recipes:
        steps = re.findall(r"^(\d+)\. ", recipe, flags=re.MULTILINE)
        assert [int(step) for step in steps] == list(range(1, len(steps) + 1))
        assert 1 <= len(steps) <= MOST_STEPS


def test_a_class_of_robots(bob) -> None:
    robot = load_robot(bob)
    result = forward_kinematics(robot, ["2"])
    assert result.outcome is Outcome.COMPLETE and result.model == "plumb"
    assert result.solutions[0].position.tolist() == [[1.0, 1.0], [2.0, 2.0], [0.5, 0.5]]
    assert Result.from_json(result.to_json()).to_json() == result.to_json()
    assert result.verify(robot) == []
    followed = classes.class_of(robot).follower(robot, result.solutions[0])(np.array([[1.0, 2.0]]))
    assert followed.proved and followed.states == result.solutions[0].cable_states
    moved = motion(robot, [(0, ["2"]), (1, ["3"])])
    assert moved.outcome is Outcome.COMPLETE
    assert moved.segments[-1].tube.position[2] == pytest.approx([-0.5, 0.5])
    with pytest.raises(InputError, match="method: a plumb bob has none"):
        forward_kinematics(robot, ["2"], method="search")


def test_a_class_says_what_it_refuses(bob, monkeypatch) -> None:
    robot = load_robot(bob)
    monkeypatch.setattr(toy_class.PlumbClass, "refuses", lambda self, robot, force=None: "it is too windy")
    with pytest.raises(NotSupportedError, match="robot 'bob': it is too windy"):
        forward_kinematics(robot, ["2"])


def test_the_commands_know_a_new_class(bob, capsys, monkeypatch) -> None:
    for arguments, said in (
        (["validate", bob], "bob: valid, plumb bob on 1 cable,"),
        (["fk", bob, "--lengths", "2"], "1 static pose, proved to be all"),
    ):
        monkeypatch.setattr("sys.argv", ["cdpr-solve", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 0
        assert said in capsys.readouterr().out


def test_a_robot_of_no_class_is_refused(bob, monkeypatch) -> None:
    robot = load_robot(bob)
    monkeypatch.setattr(classes, "CLASSES", classes.CLASSES[:-1])
    monkeypatch.setattr(toy_class.Plumb, "model", "unheard-of")
    with pytest.raises(NotSupportedError, match="no class of robots"):
        forward_kinematics(robot, ["2"])


def test_a_file_format_that_is_not_known_names_those_that_are(bob, tmp_path) -> None:
    path = tmp_path / "other.yaml"
    path.write_text("format: delta/7\nname: x\n", encoding="utf-8")
    with pytest.raises(InputError, match="must be 'cdpr-robot/1' or 'delta-robot/1' or 'plumb-robot/1', got"):
        load_robot(path)


class Rubber(Elasticity):
    """Data of a toy law."""


class RubberLaw:
    """A cable that is always stretched by a tenth, whatever it carries."""

    stretches = True

    @staticmethod
    def of(cable: Cable) -> RubberLaw | None:
        return RubberLaw() if isinstance(cable.elasticity, Rubber) else None

    def stretch(self, length: Any, tension: Any, number: law.Number) -> Any:
        return length * number(Fraction(1, 10))

    def unstretched(self, distance: Any, tension: Any, number: law.Number) -> Any:
        return distance / number(Fraction(11, 10))

    def spring_constant(self, length: Fraction) -> Fraction | None:
        return None


def test_a_cable_law(monkeypatch) -> None:
    """One entry in the list: lengths, and the check of a result against its robot, follow it."""
    robot = hanging_mass.robot()
    stretched = replace(robot, cables=tuple(replace(c, elasticity=Rubber()) for c in robot.cables))
    monkeypatch.setattr(law, "LAWS", (RubberLaw.of, *law.LAWS))
    found = inverse_kinematics(stretched, [0, 0, -2.2], taut=["c1"])
    assert found.lengths is not None and found.lengths[0] == pytest.approx(2.0)
    result = forward_kinematics(robot, ["2", "5"])
    assert result.verify(hanging_mass.robot()) == []
    assert any("not the length of the taut cable" in text for text in result.verify(stretched))


@dataclass(frozen=True)
class Ring:
    """A toy route: the cable leaves from a ring half a metre below its exit point."""

    fixed_exit: Vector

    @staticmethod
    def of(cable: Cable, up: Vector | None) -> Ring:
        x, y, z = cable.frame_anchor
        return Ring((x, y, z - Fraction(1, 2)))


def test_a_cable_route(monkeypatch) -> None:
    robot = hanging_mass.robot()
    before = inverse_kinematics(robot, [0, 0, -2], taut=["c1"]).lengths
    monkeypatch.setattr(law, "ROUTES", (Ring.of,))
    after = inverse_kinematics(replace(robot), [0, 0, -2], taut=["c1"]).lengths
    assert before is not None and after is not None
    assert (before[0], after[0]) == (2.0, 1.5)
