"""Finding one's way: examples in every help text, shipped robots, completion, misspelt commands."""

import json
import os
import shlex
import subprocess
import sys

import click
import pytest
from click.testing import CliRunner

from cdpr_interval.robots.formats.reader import load_machine
from cdpr_interval.robots.shipped import shipped_machines
from solvers.cli import COMMANDS, cli
from solvers.shell.examples import HEAD
from tests.support.batch_workers import listed

ON_A_BUS = ("home", "stop", "simulate")
"""Examples that need drives: they are parsed only."""
EXIT_CODES = {"fk merlet_4_1 --lengths 2.69+-0.01,3.9+-0.01,3.35+-0.01,4.5": {0, 3}, "batch check run": {3}}
"""Of examples that do not end with 0."""


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


def commands(group, name=()):
    """Yield every command with the words that call it."""
    yield name, group
    if isinstance(group, click.Group):
        context = click.Context(group)
        for word in group.list_commands(context):
            yield from commands(group.get_command(context, word), (*name, word))


COMMAND_HELP = dict(commands(cli))


def lines_of(command):
    head, *lines = command.epilog.removeprefix("\b\n").splitlines()
    assert head == HEAD and 1 <= len(lines) <= 3
    program = "  cdpr-solve "
    assert all(line.startswith(program) for line in lines)
    return [line.removeprefix(program) for line in lines]


@pytest.mark.parametrize("name", COMMAND_HELP, ids=" ".join)
def test_every_help_text_has_examples(name):
    lines = lines_of(COMMAND_HELP[name])
    printed = run(*name, "--help").stdout
    assert all(f"    cdpr-solve {line}\n" in printed for line in lines)
    # The examples are of the command itself, after what they need.
    assert name == () or lines[-1].split()[: len(name)] == list(name) or name == ("robots",)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with what examples read."""
    path = tmp_path_factory.mktemp("examples")
    (path / "jobs.yaml").write_text(listed([[2.7, 3.9, 3.35, 4.4], [3, 3, 3, 3.1]]))
    (path / "lengths.csv").write_text("t_s,c1,c2,c3,c4\n0,7.5,8,7,9\n1,7.5,8,7,9.3\n")
    return path


@pytest.mark.parametrize("name", COMMAND_HELP, ids=" ".join)
def test_examples_run_as_they_stand(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    if name[:1] == ("batch",) and not (folder / "run").exists():
        assert run("batch", "jobs.yaml", "--out", "run", "--threads", 1, "-q").exit_code == 0
    for line in lines_of(COMMAND_HELP[name]):
        words = shlex.split(line)
        if name[-1:] and name[-1] in ON_A_BUS:
            command = COMMAND_HELP[name]
            command.make_context(" ".join(name), words[len(name) :])
            continue
        done = run(*words)
        assert done.exit_code in EXIT_CODES.get(line, {0}), done.output


def test_robots_lists_what_ships():
    lines = run("robots").stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["name", *shipped_machines()]
    rows = json.loads(run("robots", "--json").stdout)
    for row, name in zip(rows, shipped_machines(), strict=True):
        robot = load_machine(name)
        assert row == {
            "name": name,
            "model": robot.model,
            "cables": len(robot.cable_names),
            "mass_kg": float(robot.platform.mass) if robot.cable_names else None,
            "source": " ".join(robot.source.split()),
        }
    (fast,) = (line for line in lines if line.startswith("fast "))
    assert fast.split()[:4] == ["fast", "six-dof", "6", "30091.8"] and "\n" not in fast


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["valdate", "crane8.yaml"], "No such command 'valdate'. Did you mean 'validate'?"),
        (["robot"], "No such command 'robot'. Did you mean 'robots'?"),
        (["winch", "wher", "x"], "No such command 'wher'. Did you mean 'where'?"),
        (["batch", "resum", "x"], "No such command 'resum'. Did you mean 'resume'?"),
        (["ik", "uc3", "--pos", "1,2,3"], "No such option '--pos'. Did you mean '--pose'?"),
        (["check", "x", "--jobs", "2"], "No such option '--jobs'. Did you mean '--threads'?"),
        (["check", "x", "-j", "2"], "No such option '-j'. Did you mean '--threads'?"),
        (["check", "x", "--robt", "uc2"], "No such option '--robt'. Did you mean '--robot'?"),
        (
            ["ik", "uc3", "--pose", "1", "-2", "3"],
            "No such option '-2': a value that holds spaces needs quotes",
        ),
        (
            ["ik", "uc3", "--pose", "1", "2", "3"],
            "Got unexpected extra arguments (2 3): a value that holds spaces needs quotes",
        ),
        (["uc5", "--lengths", "1"], "uc5: no such file or shipped robot (did you mean"),
        (["valdate.yaml", "--lengths", "1"], "valdate.yaml: no such file or shipped robot"),
        (["batch", "resum.yaml", "--out", "x"], "resum.yaml: cannot be read"),
    ],
)
def test_what_was_meant(args, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run(*args)
    assert done.exit_code == 2 and done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith(message)


@pytest.mark.parametrize(("command", "option"), [("robots", "--jobs"), ("ik", "--jobs"), ("check", "--zoom")])
def test_nothing_is_suggested_where_nothing_is_alike(command, option):
    """`--jobs` and `--robot` have their dashes in common, and little else."""
    done = run(command, option, "2")
    assert (done.exit_code, done.stderr) == (2, f"No such option {option!r}.\n")


def test_a_robot_file_may_be_named_like_a_misspelt_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "valdate").write_text("format: cdpr-robot/1\n")
    done = run("valdate", "--lengths", "1")
    assert done.exit_code == 2 and done.stderr.startswith("valdate:1:1: ")


def complete(line, folder, count=None):
    words = line.split()
    settings = {
        "_CDPR_SOLVE_COMPLETE": "bash_complete",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1 if count is None else count),
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
    }
    code = """
import sys
from solvers.cli import main
try:
    main()
finally:
    heavy = {"numpy", "numba", "pydantic", "yaml", "rich"} & set(sys.modules)
    assert not heavy, heavy
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **settings},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def test_completion(tmp_path):
    (tmp_path / "crane8.yaml").touch()
    (tmp_path / "crane.txt").touch()
    (tmp_path / ".hidden.yaml").touch()
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "uc9.json").touch()
    uc = ["plain,uc2", "plain,uc3", "plain,uc4"]
    for line in (
        "cdpr-solve fk uc",
        "cdpr-solve uc",
        "cdpr-solve winch move uc",
        "cdpr-solve check --robot uc",
    ):
        assert complete(line, tmp_path) == uc
    assert complete("cdpr-solve ik cr", tmp_path) == ["plain,crane8.yaml"]
    assert complete("cdpr-solve validate robots/u", tmp_path) == ["plain,robots/uc9.json"]
    assert complete("cdpr-solve validate ./rob", tmp_path) == ["file,./rob"]
    assert complete("cdpr-solve va", tmp_path) == ["plain,validate"]
    assert complete("cdpr-solve winch mo", tmp_path) == ["plain,move"]
    assert complete("cdpr-solve uc2 --le", tmp_path) == ["plain,--lengths"]
    assert complete("cdpr-solve fk uc2 --certificate x", tmp_path) == ["file,x"]
    assert complete("cdpr-solve batch status r", tmp_path) == ["dir,r"]
    everything = complete("cdpr-solve ", tmp_path, 1)
    wanted = [*COMMANDS, *shipped_machines(), "crane8.yaml"]
    assert everything == [f"plain,{word}" for word in wanted]
