"""The check of the wheel finds what it must."""

from scripts.check_wheel import expected_files, faults

GOOD = expected_files() | {"cdpr_interval-0.2.0.dist-info/METADATA"}


def test_a_complete_wheel_has_no_faults():
    assert faults(GOOD) == []


def test_a_fourth_top_level_name_is_a_fault():
    assert faults(GOOD | {"tests/unit/house/test_wheel.py"}) == ["top level holds tests"]


def test_a_missing_marker_robot_or_schema_is_a_fault():
    robot = "cdpr_interval/robots/library/uc2.yaml"
    schema = "cdpr_interval/robots/schemas/cdpr-robot-1.schema.json"
    assert faults(GOOD - {robot, schema}) == [f"{robot} is missing", f"{schema} is missing"]
    assert "solvers/py.typed is missing" in faults(GOOD - {"solvers/py.typed"})
