"""``cdpr-solve`` as a user calls it: options, messages, files and exit codes."""

import json
import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner

from cdpr_interval import load_robot
from cdpr_interval.robots.pulley import Pulley
from solvers.answers.data import Answer, StopReason
from solvers.answers.result import Result
from solvers.cli import COMMANDS, cli
from tests.support import hanging_mass


@pytest.fixture
def hanging(tmp_path):
    path = tmp_path / "hanging.yaml"
    path.write_text(hanging_mass.TEXT, encoding="utf-8")
    return str(path)


@pytest.fixture
def asked(monkeypatch):
    """Replace the solver; the answer can be changed, the questions are kept."""

    class Asked(list):
        answer = hanging_mass.answer()

    asked = Asked()

    def solve(problem, options):
        asked.append((problem, options))
        return asked.answer

    monkeypatch.setattr("solvers.point_mass.robot_class.CLASS.forward", solve)
    return asked


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


def lines(result):
    return result.stderr.splitlines()


def test_help_names_the_commands_that_exist():
    result = run("--help")
    assert result.exit_code == 0 and result.stderr == ""
    assert all(f"\n  {name} " in result.stdout for name in COMMANDS)

    assert run().stdout == result.stdout


@pytest.mark.parametrize("args", [["--help"], ["fk", "--help"], ["ik", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(args):
    code = f"""
import sys
from solvers.cli import (cli)
try:
    cli.main({args!r})
except SystemExit as stop:
    assert stop.code == 0
heavy = {{"numpy", "numba", "sympy", "flint", "matplotlib", "rich", "pydantic"}} & set(sys.modules)
assert not heavy, heavy
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


def test_importing_solvers_imports_nothing_heavy():
    code = "import sys, solvers; assert not {'numpy', 'numba'} & set(sys.modules); solvers.Result"
    assert subprocess.run([sys.executable, "-c", code], timeout=60).returncode == 0


def test_a_missing_file_as_a_process(tmp_path):
    command = [sys.executable, "-m", "solvers", "fk", "nowhere.yaml", "--lengths", "1"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 1 and done.stderr.startswith("nowhere.yaml: ")
    assert not list(tmp_path.iterdir())


def test_the_table(asked, hanging):
    result = run("fk", hanging, "--lengths", "2,5")
    assert (result.exit_code, result.stderr) == (0, "")
    title, head, row = result.stdout.splitlines()
    assert title == "hanging (point-mass, 2 cables): 1 static pose, proved to be all"
    assert " ".join(head.split()) == "# taut stability x m y m z m tensions N"
    assert row.split() == ["1", "c1", "*", "stable", "0.000000", "0.000000", "-2.000000", "c1", "98.1000"]


def test_fk_may_be_left_out(asked, hanging):
    expected = run("fk", hanging, "--lengths", "2,5").stdout
    assert run(hanging, "--lengths", "2,5").stdout == expected
    assert run("--lengths", "c2=5,c1=2", hanging).stdout == expected


def test_options_reach_the_solver(asked, hanging):
    budgets = ["--time-limit", "3", "--cell-limit", "1e6", "--threads", "2"]
    switches = ["--taut", "c1", "--ignore-slack", "--method", "search", "--precision", "1e-6"]
    run(hanging, "--lengths=1.9+-0.1,[4,5]", *switches, *budgets)
    ((problem, options),) = asked
    assert [float(x) for pair in problem.lengths for x in pair] == [1.8, 2.0, 4.0, 5.0]
    assert problem.taut == (0,) and options.ignore_slack and options.method == "search"
    assert (options.precision, options.time_limit, options.cell_limit, options.threads) == (
        1e-6,
        3.0,
        10**6,
        2,
    )


FORCED = """format: cdpr-problem/1
lengths_m: [2, 5]
external_force_N: [0, 0, 1]
"""


@pytest.mark.parametrize(
    "args",
    [["--external-force=-1,0.1,.5"], ["--external-force", "-1, 0.1, .5"], ["--external-force", "-1 0.1 .5"]],
)
def test_the_external_force_reaches_the_solver(asked, hanging, args):
    assert run(hanging, "--lengths", "2,5", *args).exit_code == 0
    ((problem, _),) = asked
    assert problem.external_force == (-1, Fraction(1, 10), Fraction(1, 2))


def test_the_external_force_acts(hanging):
    side = run(hanging, "--lengths", "2,9", "--external-force", "-98.1,0,0", "--json", "-")
    (pose,) = Result.from_json(side.stdout).solutions
    assert side.exit_code == 0 and pose.position.mean(axis=1) == pytest.approx([-(2**0.5), 0, -(2**0.5)])
    assert json.loads(side.stdout)["question"]["external_force_N"] == [-98.1, 0, 0]


@pytest.mark.parametrize(
    ("args", "messages"),
    [
        (["--external-force", "1,2"], ["--external-force: must hold 3 numbers, got 2"]),
        (
            ["--external-force", "1,x,nan", "--precision", "-1"],
            ["--external-force[1]: 'x' is not a number", "--external-force[2]: 'nan' is not a finite number"],
        ),
        (
            ["--external-force", "0,0,98.1"],
            ["the weight and the external force cancel; without a load there are no statics"],
        ),
    ],
)
def test_a_wrong_external_force(asked, hanging, args, messages):
    result = run(hanging, "--lengths", "2,5", *args)
    assert result.exit_code == 2 and not asked
    assert [line for line in lines(result) if "precision" not in line] == messages


def test_one_place_for_the_external_force(asked, hanging, tmp_path):
    problem = tmp_path / "problem.yaml"
    problem.write_text(FORCED, encoding="utf-8")
    both = run(hanging, "--problem", problem, "--external-force", "1,0,0")
    assert both.exit_code == 2
    assert lines(both) == ["--external-force: not together with external_force_N of --problem"]
    problem.write_text(FORCED.replace("external_force_N: [0, 0, 1]\n", ""), encoding="utf-8")
    assert run(hanging, "--problem", problem, "--external-force", "1,0,0").exit_code == 0
    assert asked[-1][0].external_force == (1, 0, 0)


def test_other_commands_take_the_external_force(hanging):
    found = run("ik", hanging, "--pose", "-1,0,-1", "--external-force", "-98.1,0,0", "--json", "-")
    document = json.loads(found.stdout)
    assert document["question"]["external_force_N"] == [-98.1, 0, 0] and "is static" in document["message"]
    wrong = run("ik", hanging, "--pose", "-1,0,-1", "--external-force", "a,0,0")
    assert lines(wrong) == ["--external-force[0]: 'a' is not a number"]
    pulled = run("fk", hanging, "--tensions", "98.1,98.1", "--external-force", "0,0,-1", "--json", "-")
    assert json.loads(pulled.stdout)["question"]["external_force_N"] == [0, 0, -1]
    exact = run("polynomial", hanging, "--lengths", "3,3", "--external-force", "-1,0,0")
    assert exact.exit_code == 0 and "agreement with fk: yes" in exact.stdout


LINE = """format: cdpr-robot/1
name: line
gravity_m_s2: [0, 0, -1]
platform: {mass_kg: 1}
cables:
  - {name: c0, frame_anchor_m: [0, 0, 0], platform_anchor_m: [0, 0, 0]}
  - {name: c1, frame_anchor_m: [2, 0, 0], platform_anchor_m: [0, 0, 0]}
  - {name: c2, frame_anchor_m: [4, 0, 0], platform_anchor_m: [0, 0, 0]}
"""


def test_what_is_open_what_switches_and_what_only_touches(tmp_path):
    file = tmp_path / "line.yaml"
    file.write_text(LINE, encoding="utf-8")
    dependent = run(file, "--lengths", "2.5,1.5,2.5", "--taut", "c0,c1,c2", "--ignore-slack")
    assert dependent.exit_code == 3 and "1 static pose proved, with an undecided cable" in dependent.stdout
    assert (
        "taut or slack undecided: c0,c1,c2; cables {c0, c1, c2} tight, tensions not unique"
        in dependent.stdout
    )
    just = run(file, "--lengths", "2.5,2.5,5")
    assert just.exit_code == 0
    assert "switching" not in just.stdout
    changing = run(file, "--lengths", "2.5,1.5+-0.1,2.5")
    assert changing.exit_code == 0 and "1 static pose, proved to be all" in changing.stdout
    assert "switching, one pose either way: c0,c1,c2" in changing.stdout
    touching = run(file, "--lengths", "1,9,3")
    assert touching.exit_code == 4
    assert "cables c0 and c2 only just reach each other: no finite tensions hold the load" in touching.stdout


def test_json_on_stdout_is_alone(asked, hanging):
    result = run(hanging, "--lengths", "2,5", "--json", "-")
    assert result.exit_code == 0 and result.stderr == ""
    assert Result.from_json(result.stdout).to_json() == result.stdout


def test_json_file_and_table(asked, hanging, tmp_path):
    target = tmp_path / "r.json"
    target.write_text("old", encoding="utf-8")
    loud = run(hanging, "--lengths", "2,5", "--json", target)
    assert loud.stdout.startswith("hanging") and json.loads(target.read_text())["format"] == "cdpr-result/1"
    quiet = run(hanging, "--lengths", "2,5", "--json", target, "-q")
    assert (quiet.exit_code, quiet.stdout, quiet.stderr) == (0, "", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hanging.yaml", "r.json"]


def test_a_link_stays_a_link(asked, hanging, tmp_path):
    target, link = tmp_path / "r.json", tmp_path / "link.json"
    link.symlink_to(target)
    assert run(hanging, "--lengths", "2,5", "--json", link).exit_code == 0
    assert link.is_symlink() and target.is_file()


@pytest.mark.parametrize("target", ["", ".", "missing/r.json", "hanging.yaml/r.json"])
def test_a_target_that_cannot_be_written_ends_before_solving(asked, hanging, tmp_path, monkeypatch, target):
    monkeypatch.chdir(tmp_path)
    result = run(hanging, "--lengths", "2,5", "--json", target)
    assert (result.exit_code, result.stdout) == (2, "") and not asked
    assert len(lines(result)) == 1 and lines(result)[0].startswith("--json: ")
    assert [path.name for path in tmp_path.iterdir()] == ["hanging.yaml"]


def test_no_pose_is_exit_4_with_its_message(asked, hanging, tmp_path):
    asked.answer = hanging_mass.no_answer()
    result = run(hanging, "--lengths", "1,1", "--json", tmp_path / "r.json")
    assert result.exit_code == 4 and "cables c1 and c2 are too short to meet" in result.stdout
    assert json.loads((tmp_path / "r.json").read_text())["solutions"] == []
    quiet = run(hanging, "--lengths", "1,1", "-q")
    assert (quiet.exit_code, quiet.stdout) == (4, "") and lines(quiet) == [
        "cables c1 and c2 are too short to meet"
    ]


def test_something_undecided_is_exit_3(asked, hanging, tmp_path):
    asked.answer = hanging_mass.open_answer()
    result = run(hanging, "--lengths", "2,5", "--json", tmp_path / "r.json", "-v")
    assert result.exit_code == 3 and (tmp_path / "r.json").is_file()
    assert "taut or slack undecided: c2; c2 is just taut" in result.stdout
    region = next(line for line in result.stdout.splitlines() if line.startswith("u1 "))
    assert region.split() == ["u1", "c2,c1", "3", "1.1e-9", "0.333333", "0.000000", "-2.000000"]
    assert "\nu1: singular\n" in result.stdout
    assert "100 cells" in result.stderr and " UTC on " in result.stderr and "robot sha256 " in result.stderr


def test_an_interrupt_is_exit_130_with_its_result(asked, hanging, tmp_path):
    asked.answer = Answer((hanging_mass.solution(),), pending=4, stop_reason=StopReason.INTERRUPTED)
    result = run(hanging, "--lengths", "2,5", "--json", tmp_path / "r.json")
    assert result.exit_code == 130 and "interrupted: 1 static pose proved" in result.stdout
    assert json.loads((tmp_path / "r.json").read_text())["stop_reason"] == "interrupted"


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_signals_end_the_search_with_what_it_found(hanging, tmp_path, name):
    code = f"""
import os, signal, sys, time
from dataclasses import (replace)
import solvers.point_mass.robot_class
from solvers.cli import (main)
from solvers.answers.data import (StopReason)
from tests.support import hanging_mass
def solve(problem, options):
    try:
        os.kill(os.getpid(), signal.{name})
        time.sleep(60)
    except KeyboardInterrupt:
        return replace(hanging_mass.answer(), pending=1, stop_reason=StopReason.INTERRUPTED)
solvers.point_mass.robot_class.CLASS.forward = solve
sys.argv[1:] = [{hanging!r}, "--lengths", "2,5", "--json", "-"]
main()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 130, done.stderr
    result = Result.from_json(done.stdout)
    assert result.stop_reason == "interrupted" and len(result.solutions) == 1


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--lengths", "2"], "--lengths: 1 length for 2 cables (c1, c2)"),
        (["--lengths", "2,5,6"], "--lengths: 3 lengths for 2 cables (c1, c2)"),
        (["--lengths", "2,-5"], "--lengths[1]: must be positive, got -5"),
        (["--lengths", "0,5"], "--lengths[0]: must be positive, got 0"),
        (["--lengths", "2,nan"], "--lengths[1]: 'nan' is not a finite number"),
        (["--lengths", "2,inf"], "--lengths[1]: 'inf' is not a finite number"),
        (["--lengths", "2,abc"], "--lengths[1]: 'abc' is not a number"),
        (["--lengths", "2,"], "--lengths[1]: '' is not a number"),
        ([], "--lengths: missing (or --problem FILE)"),
        (
            ["--lengths", "2,5", "--problem", "p.yaml"],
            "--lengths: not together with --problem, which holds the lengths",
        ),
        (["--problem", "nowhere.yaml"], "nowhere.yaml: cannot be read: No such file or directory"),
        (["--lengths", "2,5", "--taut", "c1,c9"], "--taut[1]: unknown cable 'c9'"),
        (["--lengths", "2,5", "--taut", ""], "--taut[0]: unknown cable ''"),
        (
            ["--lengths", "2,5", "--method", "newton"],
            "--method: must be one of auto, search, convex, got 'newton'",
        ),
        (["--lengths", "2,5", "--precision", "0"], "--precision: must be a positive number, got 0.0"),
        (["--lengths", "2,5", "--precision", "x"], "--precision: 'x' is not a number"),
        (["--lengths", "2,5", "--time-limit", "nan"], "--time-limit: 'nan' is not a finite number"),
        (["--lengths", "2,5", "--time-limit", "-1"], "--time-limit: must be a positive number, got -1.0"),
        (["--lengths", "2,5", "--cell-limit", "2.5"], "--cell-limit: '2.5' is not a whole number"),
        (["--lengths", "2,5", "--threads", "0"], "--threads: must be at least 1, got 0"),
        (
            ["--lengths", "2,5", "--ignore-tension-sign"],
            "--ignore-tension-sign: needs exactly six taut cables of a platform, got a point mass",
        ),
        (
            ["--lengths", "2,5", "--certificate", "no/c"],
            "--certificate: 'no/c' cannot be written: No such file or directory",
        ),
        # In the words of the newest and of the oldest click.
        (["--lengths", "2,5", "--colour"], ("No such option '--colour'.", "No such option: --colour")),
        (["--lengths", "2,5", "--taut"], "Option '--taut' requires an argument."),
        (["--lengths", "2,5", "extra"], "Got unexpected extra argument"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(asked, hanging, tmp_path, monkeypatch, args, message):
    monkeypatch.chdir(tmp_path)
    result = run("fk", hanging, *args)
    assert (result.exit_code, result.stdout) == (2, "") and not asked
    (line,) = lines(result)
    assert line.startswith(message)
    assert [path.name for path in tmp_path.iterdir()] == ["hanging.yaml"]


def test_all_errors_at_once_and_nothing_written(asked, hanging, tmp_path):
    target = tmp_path / "r.json"
    result = run(hanging, "--lengths", "x,-1", "--taut", "c3", "--threads", "none", "--json", target)
    assert result.exit_code == 2 and not target.exists()
    assert sorted(line.split(":")[0] for line in lines(result)) == [
        "--lengths[0]", "--lengths[1]", "--taut[0]", "--threads",
    ]  # fmt: skip


def test_errors_of_a_robot_file_have_line_and_column(tmp_path):
    path = tmp_path / "r.yaml"
    path.write_text(hanging_mass.TEXT.replace("mass_kg", "mass"), encoding="utf-8")
    result = run("fk", path, "--lengths", "2,5")
    assert result.exit_code == 2 and lines(result)[0].startswith(f"{path}:3:")


def test_a_problem_file(asked, hanging, tmp_path):
    problem = tmp_path / "p.yaml"
    problem.write_text(
        "format: cdpr-problem/1\nlengths_m: [2, 5]\nexternal_force_N: [0, 0, -1.5]\n", encoding="utf-8"
    )
    result = run(hanging, "--problem", problem, "--json", "-")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["question"]["external_force_N"] == [0.0, 0.0, -1.5]


def test_an_internal_error_is_one_line_and_a_traceback_with_v(monkeypatch, hanging, tmp_path):
    def broken(problem, options):
        raise RuntimeError("two\nlines")

    monkeypatch.setattr("solvers.point_mass.robot_class.CLASS.forward", broken)
    result = run(hanging, "--lengths", "2,5", "--json", tmp_path / "r.json")
    assert result.exit_code == 1 and lines(result) == ["internal error: RuntimeError: two lines"]
    assert not (tmp_path / "r.json").exists()
    assert "Traceback" in run(hanging, "--lengths", "2,5", "-v").stderr


def test_validate(hanging, tmp_path):
    good = run("validate", hanging)
    assert good.exit_code == 0 and good.stdout.startswith(
        "hanging: valid, point mass on 2 cables, inextensible\n"
    )
    bad = tmp_path / "bad.yaml"
    bad.write_text(hanging_mass.TEXT.replace("c2", "c1").replace("10}", "-1}"), encoding="utf-8")
    result = run("validate", bad)
    assert (result.exit_code, result.stdout, len(lines(result))) == (2, "", 2)


def test_validate_shows_ranges_as_ranges(tmp_path):
    vague = tmp_path / "vague.yaml"
    text = hanging_mass.TEXT.replace("mass_kg: 10", "mass_kg: {value: 10, tolerance: 0.5}")
    vague.write_text(text.replace("[4, 0, 0]", "[4, [0, 0.25], 0]"), encoding="utf-8")
    result = run("validate", vague)
    assert (result.exit_code, result.stdout) == (
        0,
        "hanging: valid, point mass on 2 cables, inextensible\n"
        "  mass [9.5, 10.5] kg\n"
        "  centre of mass (0, 0, 0) m\n"
        "  gravity (0, 0, -9.81) m/s2\n"
        "  c1: from (0, 0, 0) m to (0, 0, 0) m\n"
        "  c2: from (4, [0, 0.25], 0) m to (0, 0, 0) m\n"
        "  uncertain: 2 numbers are ranges\n"
        "  uncertain: platform.mass_kg in [9.5, 10.5]\n"
        "  uncertain: cables[1].frame_anchor_m[1] in [0, 0.25]\n",
    )
    assert lines(result) == []
    platform = tmp_path / "platform.yaml"
    platform.write_text(vague.read_text().replace("[0, 0, 0]", "[0, 0, 1]", 2), encoding="utf-8")
    assert lines(run("validate", platform)) == []


def test_validate_warns_of_what_is_hardly_meant_and_prints_notes(tmp_path):
    crane = tmp_path / "crane.yaml"
    text = hanging_mass.TEXT.replace("[4, 0, 0]", "[4000, 0, 0]")
    crane.write_text(text + "notes: [the mass is a placeholder, 'measured: no']\n", encoding="utf-8")
    result = run("validate", crane)
    assert result.exit_code == 0
    assert "  notes: the mass is a placeholder\n  notes: measured: no\n" in result.stdout
    (warning,) = lines(result)
    assert warning.startswith("warning: frame_anchor_m: exit points are 4000 m apart: in millimetres?")
    quiet = run("validate", crane, "-q")
    assert (quiet.exit_code, quiet.stdout, lines(quiet)) == (0, "", [warning])


def test_validate_says_what_this_version_cannot_solve(tmp_path):
    robot = load_robot("uc2")
    pulley = Pulley("0.02", joints=2, lead_in=1, balance="bisector")
    path = tmp_path / "swinging.yaml"
    robot.replace(cables=[cable.replace(pulley=pulley) for cable in robot.cables]).save(path)
    result = run("validate", path)
    assert result.exit_code == 0 and ": valid, " in result.stdout
    (warning,) = lines(result)
    reason = "c1: a platform needs balance: exact"
    assert warning.startswith(f"warning: this version cannot solve it: {reason}")
    assert run(path, "--lengths", "7.5,8").exit_code == 2


def test_validate_as_json(tmp_path):
    result = run("validate", "six_leg_40", "--json", "-")
    document = json.loads(result.stdout)
    assert (result.exit_code, result.stderr, document["format"]) == (0, "", "cdpr-validation/1")
    assert document["model"] == "six-dof" and document["cables"] == [f"c{i}" for i in range(1, 7)]
    assert (document["warnings"], document["not_supported"]) == ([], None)
    assert document["notes"].endswith("The mass is a placeholder.")
    both = run("validate", "uc2", "--json", tmp_path / "v.json")
    assert both.stdout.startswith("uc2: valid") and json.loads((tmp_path / "v.json").read_text())
    (tmp_path / "bad.yaml").write_text("name: x\n", encoding="utf-8")
    wrong = run("validate", tmp_path / "bad.yaml", "--json", tmp_path / "w.json")
    assert wrong.exit_code == 2 and not (tmp_path / "w.json").exists()
    assert any(line.endswith("format: missing: write 'format: cdpr-robot/1'") for line in lines(wrong))


def test_the_template_is_a_valid_robot_whose_comments_hold(tmp_path):
    template = run("validate", "--template")
    assert template.exit_code == 0
    for text in (
        template.stdout,
        re.sub(r"^( *)# (notes|elasticity|tension_limits_N):", r"\1\2:", template.stdout, flags=re.M),
    ):
        path = tmp_path / "my.yaml"
        path.write_text(text, encoding="utf-8")
        result = run("validate", path)
        assert result.exit_code == 0 and "my-robot: valid, six-dof platform on 3 cables" in result.stdout
        assert "in millimetres" not in result.stderr


def test_where_the_schema_is():
    result = run("validate", "--schema")
    document = json.loads(Path(result.stdout.strip()).read_text(encoding="utf-8"))
    assert result.exit_code == 0 and document["title"] == "cdpr-robot/1"


@pytest.mark.parametrize("args", [[], ["uc2", "--schema"], ["--template", "--schema"]])
def test_validate_needs_one_thing_to_do(args):
    result = run("validate", *args)
    assert (result.exit_code, result.stdout) == (2, "") and lines(result)[0].startswith("validate: ")


def test_no_pose_says_by_how_much(hanging):
    result = run(hanging, "--lengths", "1,1.5")
    assert result.exit_code == 4
    assert result.stdout.strip().endswith("; made longer alike, each needs at least 0.749 m more")


@pytest.mark.parametrize("name", ["cogiro", "merlet_4_1_k100"])
def test_validate_shipped_robots(name):
    result = run("validate", name)
    assert result.exit_code == 0 and "source: " in result.stdout


@pytest.mark.parametrize("args", [["--help"], ["--lengths", "2,5"], ["--lengths", "2,5", "--json", "-"]])
def test_a_reader_that_goes_away_ends_the_command_quietly(hanging, tmp_path, args):
    code = f"""
import sys
import solvers.point_mass.robot_class
from solvers.cli import (main)
from tests.support import hanging_mass
solvers.point_mass.robot_class.CLASS.forward = lambda problem, options: hanging_mass.answer()
sys.argv[1:] = {args!r}
if sys.argv[1] != "--help":
    sys.argv[1:] = [{hanging!r}, *sys.argv[1:]]
sys.stdin.readline()
main()
"""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", code], text=True, **pipes) as process:
        process.stdout.close()
        process.stdin.write("go\n")
        process.stdin.close()
        assert process.stderr.read() == ""
        assert process.wait(60) == 141


def test_the_result_file_is_written_before_the_output_is_closed(hanging, tmp_path):
    target = tmp_path / "r.json"
    code = f"""
import os, sys
import solvers.point_mass.robot_class
from solvers.cli import (main)
from tests.support import hanging_mass
solvers.point_mass.robot_class.CLASS.forward = lambda problem, options: hanging_mass.answer()
read, write = os.pipe()
os.close(read)
os.dup2(write, 1)
sys.argv[1:] = [{hanging!r}, "--lengths", "2,5", "--json", {str(target)!r}]
main()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (141, "")
    assert Result.from_json(target.read_text()).solutions
