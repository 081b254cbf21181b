"""Units and brackets as people type them, on the command line."""

import json

import pytest
from click.testing import CliRunner

from solvers.cli import cli
from tests.support import hanging_mass


@pytest.fixture
def run(tmp_path):
    path = tmp_path / "hanging.yaml"
    path.write_text(hanging_mass.TEXT)

    def call(command, *args):
        return CliRunner().invoke(cli, [command, str(path), *map(str, args)])

    return call


def asked(done):
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def test_what_is_asked_is_the_same_with_units_and_brackets(run):
    plain = asked(run("fk", "--lengths", "2,5", "--external-force", "0,0,-10", "--json", "-"))
    typed = ("--lengths", "[2m,500cm]", "--external-force", "[0,0,-10N]", "--time-limit", "1min")
    with_units = asked(run("fk", *typed, "--json", "-"))
    assert with_units["solutions"] == plain["solutions"] and with_units["question"] == plain["question"]


def test_tensions_have_newtons(run):
    given = ("--external-force", "1N,0,0", "--json", "-")
    plain = asked(run("fk", "--tensions", "100,100", *given))
    assert asked(run("fk", "--tensions", "[100N,0.1kN]", *given))["solutions"] == plain["solutions"]
    done = run("fk", "--tensions", "100m,100", *given)
    assert done.exit_code == 2 and "'100m' is a length, not a force" in done.stderr


@pytest.mark.parametrize(
    ("command", "given"),
    [
        ("fk", ("--lengths", "2,5")),
        ("check", ()),
        ("polynomial", ("--lengths", "2,5")),
        ("report", ("--out", "x.html")),
    ],
)
def test_a_time_limit_is_read_alike_everywhere(run, command, given):
    for text, message in (
        ("10N", "--time-limit: '10N' is a force, not a time"),
        ("ten", "--time-limit: 'ten' is not a number"),
        ("0s", "--time-limit: must be a positive number, got 0.0"),
    ):
        done = run(command, *given, "--time-limit", text)
        assert (done.exit_code, done.stderr) == (2, f"{message}\n")


def test_polynomial_and_report_take_threads(run):
    for command, given in (("polynomial", ("--lengths", "2,5")), ("report", ("--out", "x.html"))):
        done = run(command, *given, "--threads", "0")
        assert (done.exit_code, done.stderr) == (2, "--threads: must be at least 1, got 0\n")


def test_nothing_is_counted_as_one_cables(tmp_path, run):
    path = tmp_path / "one.yaml"
    path.write_text("\n".join(hanging_mass.TEXT.splitlines()[:-1]) + "\n")
    done = CliRunner().invoke(cli, ["fk", str(path), "--lengths", "2"])
    assert done.exit_code == 0 and "1 cable)" in done.stdout and "1 cables" not in done.stdout
    done = CliRunner().invoke(cli, ["fk", str(path), "--lengths", "2,3"])
    assert done.stderr == "--lengths: 2 lengths for 1 cable (c1)\n"
