"""The benchmark measures what it says and refuses a wrong answer."""

import json
import re
from dataclasses import replace
from itertools import count

import pytest

from scripts import benchmark


def case(name):
    return next(c for c in benchmark.cases() if c.name == name)


def test_a_case_is_measured_and_written(tmp_path, capsys) -> None:
    file = tmp_path / "benchmark.json"
    assert benchmark.main(["uc2", "--runs", "2", "--json", str(file)]) == 0
    found = json.loads(file.read_text())
    (row,) = found["cases"]
    assert row["name"] == "uc2" and row["poses"] == 8 and row["runs"] == 2 and row["unit"] == "s"
    assert 0 < row["fastest_s"] <= row["median_s"] and row["cells"] > 0 and row["wall_median_s"] > 0
    assert row["ns_per_cell"] == pytest.approx(1e9 * row["median_s"] / row["cells"])
    assert found["machine"]["numba"] and "growth" not in found
    assert "uc2" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["point-mass-8-light", "point-mass-elastic-4-light"])
def test_the_time_of_many_calls_is_given_for_one(monkeypatch, name) -> None:
    asked, ticks = case(name), count()
    monkeypatch.setattr(benchmark, "now", lambda clock: float(next(ticks)))
    found = benchmark.measure(asked, 2)
    assert next(ticks) == 6
    assert (found.calls, found.poses, found.median_s) == (1000, 1, 1e-3)
    assert re.search(rf"{name} .* 1000 .* us ", benchmark.line(found))


def test_a_process_is_measured_in_its_own_time() -> None:
    found = benchmark.measure(case("process-help"), 1)
    assert found.clock == "child" and found.median_s > 0 and found.poses == 0


def test_cold_processes_are_not_run_unless_asked_for() -> None:
    rare = [c for c in benchmark.cases() if c.rare]
    assert len(rare) == 2 and not any(c.warm for c in rare)


def test_a_wrong_answer_ends_the_run() -> None:
    with pytest.raises(SystemExit, match="uc2: 8 poses, expected 7"):
        benchmark.measure(replace(case("uc2"), poses=7), 1)


def test_an_unknown_case_or_study_is_refused(capsys) -> None:
    with pytest.raises(SystemExit):
        benchmark.main(["nothing"])
    assert "unknown case nothing" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        benchmark.main(["uc2", "--runs", "1", "--growth", "nothing"])
    assert "unknown study nothing" in capsys.readouterr().err


def test_the_study_of_precision_tells_widths(monkeypatch, tmp_path, capsys) -> None:
    import benchmark_growth as growth

    monkeypatch.setattr(growth, "PRECISIONS", (1e-3, 1e-6))
    file = tmp_path / "benchmark.json"
    arguments = ["uc2", "--runs", "1", "--growth", "precision", "--json", str(file)]
    assert benchmark.main(arguments) == 0
    points = json.loads(file.read_text())["growth"]
    assert [p["value"] for p in points] == [1e-3, 1e-6]
    assert all(p["poses"] == 3 and p["complete"] == p["runs"] and 0 < p["widest_m"] < 1e-9 for p in points)
    assert "precision" in capsys.readouterr().out
