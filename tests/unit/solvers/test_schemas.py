"""The JSON Schemas of problems and results describe what is read and written, key by key."""

import json
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.mechanics.stability import Stability
from solvers import inverse_kinematics
from solvers.answers.data import Answer, CableState, Certainty, Family, Outcome, Proof, StopReason
from solvers.forward import build_result
from solvers.questions.problem import Options, Problem
from tests.support import hanging_mass
from tests.support.hanging_mass import around

KINDS = {"string": str, "boolean": bool, "array": list, "object": dict, "null": type(None)}


def schema(name):
    return json.loads(resources.files("solvers").joinpath("schemas", f"{name}.schema.json").read_text())


def faults(value, rule, root, path="$"):
    """Yield what breaks the schema, for the keywords our schemas use; unknown keys count as faults."""
    if "$ref" in rule:
        rule = root["$defs"][rule["$ref"].rpartition("/")[2]]
    options = rule.get("anyOf", []) + rule.get("oneOf", [])
    if options and all(list(faults(value, option, root, path)) for option in options):
        yield f"{path}: fits no option"
    if "enum" in rule and value not in rule["enum"]:
        yield f"{path}: {value!r} is not one of {rule['enum']}"
    if "const" in rule and value != rule["const"]:
        yield f"{path}: {value!r}"
    kinds = rule.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if kinds and not any(is_kind(value, kind) for kind in kinds):
        yield f"{path}: {value!r} is no {kinds}"
    if isinstance(value, list):
        if not rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", len(value)):
            yield f"{path}: {len(value)} entries"
        for i, entry in enumerate(value):
            own = rule["prefixItems"][i] if i < len(rule.get("prefixItems", ())) else rule.get("items", {})
            yield from faults(entry, own, root, f"{path}[{i}]")
    if isinstance(value, dict) and isinstance(rule.get("additionalProperties"), dict):
        for key, entry in value.items():
            yield from faults(entry, rule["additionalProperties"], root, f"{path}.{key}")
    if isinstance(value, dict) and "properties" in rule:
        yield from (f"{path}.{key}: missing" for key in set(rule["required"]) - set(value))
        yield from (f"{path}.{key}: not described" for key in set(value) - set(rule["properties"]))
        for key in set(value) & set(rule["properties"]):
            yield from faults(value[key], rule["properties"][key], root, f"{path}.{key}")


def is_kind(value, kind):
    if kind in ("number", "integer"):
        return isinstance(value, int if kind == "integer" else int | float) and not isinstance(value, bool)
    return isinstance(value, KINDS[kind])


def family(kind, shape):
    axis = None if shape is None else around(np.zeros(shape))
    return Family(kind, axis, axis, around(np.array([[-1.0, 1.0]])))


@pytest.mark.parametrize(
    "answer",
    [
        hanging_mass.answer(),
        hanging_mass.open_answer(),
        hanging_mass.no_answer(),
        *(
            Answer((replace(hanging_mass.solution(), family=family(kind, shape)),))
            for kind, shape in (("rotation", (3,)), ("torus", (2, 3)), ("all-rotations", None))
        ),
    ],
)
def test_results_follow_their_schema(answer):
    problem = Problem(hanging_mass.robot(), tuple(hanging_mass.exact("2", "5")), taut=(0,))
    document = json.loads(build_result(problem, Options(), answer, 0.5).to_json())
    rules = schema("cdpr-result-1")
    assert list(faults(document, rules, rules)) == []
    assert list(document) == list(rules["properties"]) == [*rules["required"], "provenance"]
    document["solutions"] = {}
    assert list(faults(document, rules, rules)) != []


def test_the_schema_knows_every_status():
    rules = schema("cdpr-result-1")
    for words in (Proof, Stability, CableState, Outcome, StopReason, Certainty):
        assert rules["$defs"][words.__name__]["enum"] == list(words)


@pytest.mark.parametrize("name", ["cdpr-result-1", "cdpr-ik-result-1", "cdpr-problem-1"])
def test_every_key_is_described(name):
    rules = schema(name)
    objects = [rules, *(one for one in rules.get("$defs", {}).values() if "properties" in one)]
    assert all(one["description"] for one in objects)
    keys = [(one["description"], key, rule) for one in objects for key, rule in one["properties"].items()]
    assert [(where, key) for where, key, rule in keys if not rule.get("description")] == []


@pytest.mark.parametrize("options", [{}, {"settle": True, "taut": [0, 1]}])
def test_ik_results_follow_their_schema(options):
    document = json.loads(inverse_kinematics(load_robot("uc3"), (5, 3, -6), **options).to_json())
    rules = schema("cdpr-ik-result-1")
    assert list(faults(document, rules, rules)) == []
    of_legs = [key for key in rules["properties"] if key == "outside_length_limits"]
    assert list(document) == [key for key in rules["properties"] if key not in of_legs]
    assert list(document) == [*rules["required"], "provenance"] and len(of_legs) == 1


def test_ik_results_of_legs_follow_their_schema():
    robot = load_robot("gough_40")
    cables = [cable.replace(length_limits=("0.5", "1.2")) for cable in robot.cables]
    document = json.loads(inverse_kinematics(robot.replace(cables=cables), (0.1, 0.2, 0.5)).to_json())
    rules = schema("cdpr-ik-result-1")
    assert list(faults(document, rules, rules)) == [] and document["outside_length_limits"]
    assert list(document) == list(rules["properties"])


def test_problems_follow_their_schema():
    rules = schema("cdpr-problem-1")
    lengths = [2, "2.69+-0.01", [2.68, 2.7], {"value": 2.69, "tolerance": 0.01}]
    for given in (lengths, dict(zip("abcd", lengths, strict=True))):
        problem = {"format": "cdpr-problem/1", "lengths_m": given, "external_force_N": [0, 0, 1.5]}
        assert list(faults(problem, rules, rules)) == []
    assert list(faults({"format": "cdpr-problem/1", "lengths_m": [[1, 2, 3]]}, rules, rules)) != []
