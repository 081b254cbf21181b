"""Results as people use them in Python: short to look at, whole to go on with."""

from __future__ import annotations

import builtins
import copy
import html
import json
import pickle
import re
import subprocess
import sys
import types
from dataclasses import replace
from fractions import Fraction

import pytest

import certificates
from cdpr_interval import CdprError, InputError, NotSupportedError, load_robot
from cdpr_interval.robots.shipped import shipped_robots
from solvers import Result, forward_kinematics, inverse_kinematics, pose_from_tensions
from solvers.answers.rows import columns
from tests.support import hanging_mass
from tests.unit.answers.test_result import result_of

MERLET = ["3.1", "3.2", "3.3", "3.4"]


@pytest.fixture(scope="module")
def uc2():
    return forward_kinematics("uc2", ["7.5", "8"])


def test_it_is_short_to_look_at(uc2):
    assert repr(uc2) == "<Result uc2: 8 static poses, proved to be all>"
    assert len(repr(uc2.solutions)) < 2000
    assert repr(uc2.solutions[0]).startswith("<Solution stable, taut (0, 1), near (")
    open_result = result_of(hanging_mass.open_answer())
    assert "cells in [" in repr(open_result.undecided) and len(repr(open_result.undecided)) < 200


@pytest.mark.parametrize("name", shipped_robots())
def test_the_repr_of_a_result_is_short_for_every_robot(name):
    robot = load_robot(name)
    count = len(robot.cables)
    result = forward_kinematics(robot, [50.0] * count, cell_limit=1)
    assert len(repr(result)) < 2000


def test_the_text_is_the_table(uc2):
    lines = str(uc2).splitlines()
    assert lines[0] == "uc2 (six-dof, 2 cables): 8 static poses, proved to be all"
    assert len(lines) >= 10 and f"{uc2}" == str(uc2)


def test_inverse_kinematics_is_a_table_too():
    found = inverse_kinematics("uc2", (5, 0, -7), rpy=("0", "2deg", "0"), settle=True)
    assert len(repr(found)) < 200 and repr(found).startswith("<IkResult uc2: ")
    title, asked, settled, head, *rows, pose, lengths = str(found).splitlines()
    assert title == f"uc2 (six-dof): {found.message}"
    assert asked.startswith("pose asked for (5.000000, ") and settled.startswith("pose settled   (4.88")
    assert head.split()[:3] == ["cable", "distance", "m"] and [row.split()[0] for row in rows] == ["c1", "c2"]
    assert pose == f"--pose {found.pose_option}" and lengths == f"--lengths {found.lengths_option}"
    shown = found._repr_html_()
    assert shown.count("<tr>") == 3 and f"<code>{lengths}</code>" in shown and "remarks" not in shown
    named = replace(found, message="<script>", outside_tension_limits=("c2",))
    assert "<script>" not in named._repr_html_() and "outside its limits" in named._repr_html_()


def test_a_notebook_shows_a_table_without_anything_installed(uc2):
    shown = uc2._repr_html_()
    assert shown.count("<tr>") == 1 + len(uc2.solutions) and "8 static poses, proved to be all" in shown
    text = html.unescape(re.sub("<[^>]*>", " ", shown))
    assert "stable" in text and "tensions N" in text
    open_result = result_of(hanging_mass.open_answer())
    assert "Undecided regions" in open_result._repr_html_() and "singular" in open_result._repr_html_()
    named = replace(open_result, robot=replace(open_result.robot, name="<script>"))
    assert "<script>" not in named._repr_html_()


def test_results_travel_between_processes(uc2):
    assert pickle.loads(pickle.dumps(uc2)).to_json() == uc2.to_json()
    assert copy.deepcopy(uc2).to_json() == uc2.to_json()


def test_long_tables_are_cut_and_say_so(uc2):
    many = replace(uc2, solutions=uc2.solutions * 20)
    assert many._repr_html_().count("<tr>") == 101 and "and 60 more" in many._repr_html_()


def test_rows(uc2):
    rows = uc2.to_rows()
    assert [row["solution"] for row in rows] == list(range(1, 9))
    assert list(rows[0]) == columns(uc2.cables)
    assert (rows[0]["taut"], rows[0]["stability"], rows[0]["proved"]) == ("c1 c2", "stable", True)
    assert all(isinstance(row["tension_c1_N"], float) for row in rows)
    assert json.loads(json.dumps(rows)) == rows


def test_a_data_frame_needs_pandas(uc2, monkeypatch):
    found = builtins.__import__

    def without_pandas(name, *rest):
        if name == "pandas":
            raise ImportError(name)
        return found(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without_pandas)
    with pytest.raises(CdprError, match="pandas is not installed: pip install pandas"):
        uc2.to_dataframe()


def test_a_data_frame_has_the_rows(uc2, monkeypatch):
    made = types.ModuleType("pandas")
    made.DataFrame = lambda rows, columns: (rows, columns)
    monkeypatch.setitem(sys.modules, "pandas", made)
    assert uc2.to_dataframe() == (uc2.to_rows(), columns(uc2.cables))
    assert replace(uc2, solutions=()).to_dataframe() == ([], columns(uc2.cables))


def test_a_real_data_frame(uc2):
    pytest.importorskip("pandas")
    frame = uc2.to_dataframe()
    assert list(frame.columns) == columns(uc2.cables) and len(frame) == 8
    assert frame["x_m"].dtype == float and frame["proved"].all()


def test_a_result_knows_where_it_comes_from(uc2):
    origin = uc2.provenance
    assert origin.lengths == ((Fraction(15, 2),) * 2, (Fraction(8),) * 2)
    assert origin.robot == uc2.source_robot == load_robot("uc2")
    assert {"cdpr-interval", "python", "numba", "numpy", "python-flint"} == set(origin.versions)
    assert origin.date.tzinfo is not None and origin.host


@pytest.mark.parametrize(
    ("lengths", "texts"),
    [
        (["7.1", "8"], ["7.1", "8"]),
        ([7.1, 8], ["7.0999999999999996447286321199499070644378662109375", "8"]),
        (["7.09..7.11", "8+-0.001"], ["7.09..7.11", "7.999..8.001"]),
        ([Fraction(64, 9), 8], ["64/9", "8"]),
    ],
)
def test_lengths_are_kept_exactly_as_given(lengths, texts):
    result = forward_kinematics("uc2", lengths, cell_limit=1)
    assert result.to_dict()["provenance"]["lengths_m"] == texts
    assert Result.from_json(result.to_json()).provenance.lengths == result.provenance.lengths
    if "/" not in texts[0]:
        again = forward_kinematics("uc2", texts, cell_limit=1)
        assert again.provenance.lengths == result.provenance.lengths


def test_a_robot_made_in_memory_is_kept_exactly():
    robot = load_robot("merlet_4_1").replace(gravity=(0, 0, Fraction(-29, 3)), notes="1/3 is a note")
    result = forward_kinematics(robot, MERLET)
    again = Result.from_json(result.to_json())
    assert again.source_robot == robot and again.robot.sha256 == robot.sha256
    assert again.to_dict()["provenance"]["robot"]["gravity_m_s2"] == ["0", "0", "-29/3"]
    assert again.to_json() == result.to_json()
    assert again.verify(robot) == []
    assert "another file" in again.verify("merlet_4_1")[0]


def test_a_robot_that_was_changed_in_the_file_is_found():
    document = forward_kinematics("merlet_4_1", MERLET).to_dict()
    file = document["provenance"]["robot"]
    document["provenance"]["robot"] = file.replace("mass_kg: 80", "mass_kg: 81")
    assert file != document["provenance"]["robot"]
    complaints = Result.from_json(document).verify()
    assert complaints == ["provenance: holds another robot than the one that is named (its digest differs)"]


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("robot", 3, "must be the text of a robot file, or the data of a robot"),
        ("robot", "name: r", "must be a robot (file:1:1: "),
        ("robot", {"name": "r"}, "must be a robot (robot: "),
        ("lengths_m", ["1/0"], "must be a list of numbers or ranges as texts"),
        ("lengths_m", [1.0], "must be a list of numbers or ranges as texts"),
        ("external_force_N", ["x", "0", "0"], "must be a list of numbers or ranges as texts"),
        ("host", 3, "must be a text"),
    ],
)
def test_a_broken_provenance_is_named(key, value, message):
    document = forward_kinematics("merlet_4_1", MERLET).to_dict()
    document["provenance"][key] = value
    with pytest.raises(InputError) as caught:
        Result.from_json(document)
    (line,) = caught.value.messages
    assert line.startswith(f"result.provenance.{key}: {message}")


def test_results_without_provenance_are_read():
    document = forward_kinematics("merlet_4_1", MERLET).to_dict()
    del document["provenance"]
    result = Result.from_json(document)
    assert "provenance" not in result.to_dict() and result.verify("merlet_4_1") == []
    for ask in (lambda: result.source_robot, lambda: result.certificate("x"), result.plot):
        with pytest.raises(InputError, match=r"result: the .* not in it"):
            ask()


def test_every_error_of_a_document_is_said():
    document = forward_kinematics("merlet_4_1", MERLET).to_dict()
    document["pending"] = -1
    document["solutions"][0]["nominal"]["rpy_rad"] = [0.0]
    del document["solutions"][0]["existence"]
    document["statistics"]["time_s"] = True
    with pytest.raises(InputError) as caught:
        Result.from_json(document)
    assert sorted(caught.value.messages) == [
        "result.pending: input should be greater than or equal to 0",
        "result.solutions[0].existence: missing",
        "result.solutions[0].nominal.rpy_rad[1]: missing",
        "result.solutions[0].nominal.rpy_rad[2]: missing",
        "result.statistics.time_s: must be a number",
    ]
    document["solutions"] = [{} for _ in range(30)]
    with pytest.raises(InputError) as caught:
        Result.from_json(document)
    assert len(caught.value.messages) == 21 and re.match("result: and [0-9]+ more", caught.value.messages[-1])


def test_a_certificate_is_written_from_the_result_alone(uc2, tmp_path):
    own, read = tmp_path / "own.cert", tmp_path / "read.cert"
    assert uc2.certificate(own) == own
    Result.from_json(uc2.to_json()).certificate(read)
    assert own.read_bytes() == read.read_bytes()
    report = certificates.check(own)
    assert report.verdict == "PROVED" and report.complete and report.solutions == 8
    with pytest.raises(InputError, match="time_limit: must be a positive number, got -1"):
        uc2.certificate(own, time_limit=-1)


def test_a_partial_certificate_is_warned_of(tmp_path):
    result = forward_kinematics("uc2", ["7.5+-0.001", "8"])
    with pytest.warns(UserWarning, match=r"c\.cert: the certificate is partial: "):
        result.certificate(tmp_path / "c.cert", time_limit=0.05)
    assert not certificates.check(tmp_path / "c.cert").complete


def test_no_certificate_of_given_tensions(tmp_path):
    result = pose_from_tensions("merlet_4_1", [300, 300, 300, 300])
    assert result.provenance.lengths == ()
    assert Result.from_json(result.to_json()).to_json() == result.to_json()
    with pytest.raises(NotSupportedError, match="certificates are for given lengths"):
        result.certificate(tmp_path / "c")
    assert list(tmp_path.iterdir()) == []


def test_a_report_is_written_from_the_result_alone(uc2, tmp_path):
    pytest.importorskip("plotly")
    pytest.importorskip("jinja2")
    again = Result.from_json(uc2.to_json())
    certificate = again.certificate(tmp_path / "c.cert")
    page = again.report(tmp_path / "r.html", certificate=certificate).read_text(encoding="utf-8")
    assert "PROVED" in page and uc2.robot.sha256 in page and uc2.provenance.host in page
    assert len(again.plot().data) == len(uc2.plot("uc2").data) > 0


def test_looking_at_a_result_loads_nothing_heavy():
    code = (
        "import sys; from solvers.answers.result import Result; from solvers import Outcome, CableState;"
        "print([m for m in ('numba', 'pydantic', 'plotly', 'pandas', 'solvers.forward') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
