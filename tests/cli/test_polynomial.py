"""``cdpr-solve polynomial`` and ``cdpr-solve fk --tensions`` as users call them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from solvers.cli import cli

SQUARE = "2.99558,2.99558,4.121083,4.121083"


def run(*words: str) -> tuple[int, str, str]:
    """Return exit code, standard output and standard error of a command."""
    result = CliRunner().invoke(cli, list(words))
    return result.exit_code, result.stdout, result.stderr


def test_three_springs(tmp_path: Path):
    words = ("polynomial", "merlet_4_1_k1000", "--lengths", SQUARE, "--taut", "c1,c2,c3")
    tex, data = tmp_path / "d.tex", tmp_path / "d.json"
    code, out, _ = run(*words, "--latex", str(tex), "--json", str(data))
    assert (
        code == 0
        and "degree  22  true" in out
        and "agreement with fk: yes, 1 static pose in 1 box, one" in out
    )
    document = json.loads(data.read_text())
    (factor,) = [f for f in document["factors"] if f["true"]]
    assert factor["degree"] == 22 and len(factor["coefficients"]) == 23
    # The coefficients are those of a polynomial with the printed roots.
    for found in document["real_solutions"]:
        x, value, size = found["root"][0], 0.0, 0.0
        for c in reversed([int(v) for v in factor["coefficients"]]):
            value, size = value * x + float(c), size * abs(x) + abs(float(c))
        assert abs(value) < 1e-9 * size
    assert tex.read_text().startswith(r"\documentclass") and "true" in tex.read_text()


def test_platform_and_json_on_standard_output():
    code, out, _ = run("polynomial", "uc2", "--lengths", "7.5,8", "--json", "-")
    assert code == 0 and json.loads(out)["agreement"] is True


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("uc3", "--lengths", "7.5,8,7"), "two taut cables, not 3"),
        (("merlet_4_1", "--lengths", SQUARE), "at most 3 taut, not 4"),
        (("merlet_4_1", "--lengths", "3..3.1,3,4,4", "--taut", "c1,c2"), "exact numbers are needed"),
        (("merlet_4_1",), "--lengths: missing"),
        (("merlet_4_1", "--given", "tensions", "--lengths", SQUARE), "--tensions: missing"),
        (("merlet_4_1", "--tensions", "1,2,3,4", "--lengths", SQUARE), "not together"),
        (("merlet_4_1", "--tensions", "785", "--taut", "c1"), "no eliminant"),
        (("uc2", "--lengths", "7.5,8", "--latex", "/dev/null"), "--latex"),
    ],
)
def test_what_cannot_be_done_is_said(words: tuple[str, ...], message: str):
    code, out, err = run("polynomial", *words)
    assert code == 2 and message in err and not out


def test_fk_takes_tensions():
    words = ("fk", "merlet_4_1", "--tensions", "441.45,441.45,202.2383,202.2383")
    code, out, _ = run(*words, "--json", "-")
    document = json.loads(out)
    assert code == 0 and document["question"]["tensions_given_N"][0][0] <= 441.45
    assert len(document["solutions"]) == 1 and document["solutions"][0]["proof"] == "convexity"
    code, out, err = run(*words, "--lengths", "1,2,3,4", "--certificate", "x")
    assert code == 2 and "--lengths: not together" in err and "--certificate: not together" in err
    assert run("fk", "merlet_4_1", "--tensions", "1,1,1,1")[0] == 4
