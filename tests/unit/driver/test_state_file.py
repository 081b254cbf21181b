"""The state of winches between two runs."""

from __future__ import annotations

import json

import pytest

from cdpr_interval import load_robot
from cdpr_interval.driver.state_file import read_state, write_state
from cdpr_interval.errors import InputError
from tests.support.winch_robots import Bench

ROBOT = load_robot("four_winches")


@pytest.fixture
def written(tmp_path):
    bench = Bench(ROBOT).homed()
    path = tmp_path / "state.json"
    write_state(path, ROBOT, bench.group.known())
    return bench, path


def test_references_round_trip_exactly(written):
    bench, path = written
    assert read_state(path, ROBOT) == bench.group.known()
    assert [entry.name for entry in path.parent.iterdir()] == ["state.json"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda root: root.update(format="cdpr-winch-state/9"), "format: must be 'cdpr-winch-state/1'"),
        (lambda root: root["robot"].update(sha256="0"), "of another robot file"),
        (lambda root: root["cables"]["c1"].update(counts="x"), "no state of winches"),
        (lambda root: root["cables"]["c1"].update(reference_length_m=["2", "1"]), "positive and ascending"),
        (lambda root: root["cables"]["c1"].update(reference_length_m=["1/0", "1"]), "no state of winches"),
        (lambda root: root["cables"]["c1"].update(state="fine"), "no state of winches"),
        (lambda root: root.pop("cables"), "no state of winches"),
    ],
)
def test_what_is_wrong_is_refused(written, change, message):
    _, path = written
    root = json.loads(path.read_text())
    change(root)
    path.write_text(json.dumps(root))
    with pytest.raises(InputError, match=message):
        read_state(path, ROBOT)


def test_text_that_is_no_json_is_refused(tmp_path):
    path = tmp_path / "state.json"
    path.write_text("{")
    with pytest.raises(InputError, match="no state of winches"):
        read_state(path, ROBOT)


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        write_state(tmp_path / "missing" / "state.json", ROBOT, [None] * 4)
