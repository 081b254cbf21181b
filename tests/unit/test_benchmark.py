"""The benchmark measures what it says and refuses a wrong answer."""

import json
from dataclasses import replace

import pytest

from scripts import benchmark


def test_a_case_is_measured_and_written(tmp_path, capsys) -> None:
    file = tmp_path / "benchmark.json"
    assert benchmark.main(["uc2", "--runs", "2", "--json", str(file)]) == 0
    found = json.loads(file.read_text())
    (case,) = found["cases"]
    assert case["name"] == "uc2" and case["poses"] == 8 and case["runs"] == 2
    assert 0 < case["fastest_s"] <= case["median_s"] and case["cells"] > 0
    assert found["machine"]["numba"]
    assert "uc2" in capsys.readouterr().out


def test_a_wrong_answer_ends_the_run() -> None:
    case = next(c for c in benchmark.cases() if c.name == "uc2")
    with pytest.raises(SystemExit, match="uc2: 8 poses"):
        benchmark.measure(replace(case, poses=7), 1)


def test_an_unknown_case_is_refused(capsys) -> None:
    with pytest.raises(SystemExit):
        benchmark.main(["nothing"])
    assert "unknown case nothing" in capsys.readouterr().err
