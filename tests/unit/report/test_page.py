"""Reports: what is drawn is what was found, nothing undecided is left out, nothing is fetched."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from datetime import UTC, datetime
from fractions import Fraction
from html import unescape
from html.parser import HTMLParser

import numpy as np
import pytest
from click.testing import CliRunner

from cdpr_interval import load_robot
from certificates.verdicts import Verdict
from solvers import forward_kinematics
from solvers.answers.data import CableState, Certainty, Outcome, Undecided
from solvers.answers.provenance import Provenance
from solvers.cli import cli
from solvers.proofs.check import Proof
from solvers.questions.force import ZERO
from solvers.report.judgement import Kind, judge, judge_batch, left_open
from solvers.report.page import result_page
from solvers.report.palette import TUBE
from solvers.report.plots import robot_figure, scatter_figure, step
from solvers.report.scene import axis_range, bins, hanging, labels, region, scene, space
from solvers.report.source import ResultSource
from tests.support.batch_workers import MONTE_CARLO, write

pytest.importorskip("plotly")
pytest.importorskip("matplotlib")

MERLET = ["2.692582403567252", "3.905124837953327", "3.354101966249685", "4.385"]
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def merlet():
    robot = load_robot("merlet_4_1")
    return robot, forward_kinematics(robot, MERLET)


@pytest.fixture(scope="module")
def platform():
    robot = load_robot("uc2")
    return robot, forward_kinematics(robot, ["4.5", "4.5"])


def measured(points):
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@pytest.mark.parametrize(
    ("end", "length"),
    [
        ((3, 0, 0), 3.5),
        ((3, 0, -2), 3.7),
        ((0.5, 0.2, 3), 8),
        ((1, 1, 1), 1.7321),
        ((1e-9, 0, -1), 3),
        ((0, 0, 2), 3),
    ],
)
def test_a_slack_cable_hangs_with_its_length(end, length):
    start, end = np.array([1.0, 2.0, 3.0]), np.array(end) + np.array([1.0, 2.0, 3.0])
    points = hanging(start, end, length, UP, 2001)
    assert points[0] == pytest.approx(start) and points[-1] == pytest.approx(end, abs=1e-8)
    assert measured(points) == pytest.approx(length, rel=1e-4)
    # It hangs: no point is above the straight line.
    share = np.linspace(0, 1, len(points))
    assert points[len(points) // 2, 2] <= (start + share[len(points) // 2] * (end - start))[2] + 1e-12


def test_a_cable_that_is_too_short_is_straight():
    points = hanging(np.zeros(3), np.array([3.0, 0.0, 0.0]), 2.9, UP)
    assert points.tolist() == [[0, 0, 0], [3, 0, 0]]


def test_a_scene_has_the_proved_geometry(platform):
    robot, result = platform
    for number, solution in enumerate(result.solutions, 1):
        drawn = scene(robot, solution, result.lengths, number)
        for i, cable in enumerate(drawn.cables):
            lo, hi = solution.distances[i]
            ends = float(np.linalg.norm(cable.points[-1] - cable.points[0]))
            assert lo - 1e-6 <= ends <= hi + 1e-6
            if cable.state is CableState.SLACK:
                assert measured(cable.points) == pytest.approx(result.lengths[i].mean(), rel=1e-2)


def test_what_switches_and_what_nothing_bounds(merlet):
    """A switching cable is dashed, an unbounded tension is said and drawn as its lower bound."""
    robot, result = merlet
    (solution,) = result.solutions
    tensions = solution.tensions.copy()
    tensions[0] = 50.0, math.inf
    states = (CableState.TAUT, CableState.SWITCHING, *solution.cable_states[2:])
    changed = replace(result, solutions=(replace(solution, tensions=tensions, cable_states=states),))
    first, second, *_ = scene(robot, changed.solutions[0], result.lengths, 1).cables
    assert first.text == "c1: taut, 50 N or more" and first.tension == 50.0
    assert second.text.startswith("c2: switching, ")
    dashed = [trace.text for trace in robot_figure(robot, changed).data if trace.line.dash == "dash"]
    assert dashed == [second.text]
    assert "switching, one pose either way: c2" in result_page(ResultSource(robot, changed, None))
    assert left_open(changed) == left_open(result)
    unproved = replace(changed.solutions[0], existence=Certainty.UNDECIDED, note="why")
    assert "1 entry not proved" in left_open(replace(changed, solutions=(unproved,)))


def test_a_tube_is_drawn_as_boxes_around_the_anchors():
    """Twelve edges for each; nothing of exact data."""
    robot = load_robot("uc3")
    ranged = forward_kinematics(robot, "7.5+-0.001,8,7", taut="c1,c2,c3")
    assert ranged.outcome == "complete"
    exact = forward_kinematics(robot, "7.5,8,7", taut="c1,c2,c3")
    assert all(not len(scene(robot, s, exact.lengths, 1).tube) for s in exact.solutions)
    for solution in ranged.solutions:
        drawn = scene(robot, solution, ranged.lengths, 1)
        boxes = drawn.tube.reshape(3, 24, 3)
        low, high = boxes.min(axis=1), boxes.max(axis=1)
        inside = [np.all((low - 1e-4 <= at) & (at <= high + 1e-4), axis=1).any() for at in drawn.platform]
        assert all(inside) and (high - low).max() < 0.05
        assert any(trace.line.color == TUBE for trace in robot_figure(robot, ranged).data)


def test_a_region_is_drawn_with_its_twelve_edges():
    edges = region(np.array([[0.0, 1.0], [0.0, 2.0], [0.0, 3.0]])).reshape(-1, 2, 3)
    assert sorted(np.linalg.norm(a - b) for a, b in edges) == [1] * 4 + [2] * 4 + [3] * 4


def test_every_solution_can_be_chosen(platform):
    robot, result = platform
    figure = robot_figure(robot, result)
    buttons = figure.layout.updatemenus[0].buttons
    assert len(buttons) == len(result.solutions) + 1
    shown = [sum(button.args[0]["visible"]) for button in buttons]
    # All together have no colour bars: each pose has a scale of its own.
    count = len(result.solutions)
    assert shown[-1] == len(figure.data) - count and all(0 < n < shown[-1] for n in shown[:-1])
    bars = [trace.marker.cmax for trace in figure.data if trace.marker.showscale]
    assert bars == [
        max(c.tension for c in scene(robot, s, result.lengths, 1).cables) for s in result.solutions
    ]


def test_a_robot_in_a_plane_is_drawn_in_space(platform):
    """All y are 0: the picture has a thickness all the same, and one scale for all axes."""
    drawn = robot_figure(*platform).layout.scene
    widths = [axis.range[1] - axis.range[0] for axis in (drawn.xaxis, drawn.yaxis, drawn.zaxis)]
    ratios = [drawn.aspectratio.x, drawn.aspectratio.y, drawn.aspectratio.z]
    assert min(widths) > 0.2 * max(widths)
    assert np.ptp(np.array(widths) / np.array(ratios)) < 1e-9 * max(widths)


def test_labels_of_close_cables_are_one(platform):
    robot, _ = platform
    assert labels(robot) == ["c1", "c2"]
    assert labels(load_robot("cogiro")) != list(load_robot("cogiro").cable_names)
    assert sorted(", ".join(filter(None, labels(load_robot("cogiro")))).split(", ")) == sorted(
        load_robot("cogiro").cable_names
    )


def test_a_thin_cloud_of_poses_is_drawn_in_a_cube():
    far = np.array([[2.0, 1.5, 1.5], [2.01, 1.52, 1.5], [2.0, 1.5, 3.1]])
    figure, is_stretched = scatter_figure({"branch 1: stable": far[:2], "branch 2: unstable": far[2:]}, None)
    assert is_stretched and figure.layout.scene.aspectmode == "cube"
    figure, is_stretched = scatter_figure({"branch 1: stable": np.array([[0, 0, 0], [1, 1, 1.0]])}, None)
    assert not is_stretched and figure.layout.scene.aspectmode == "data"


# The judgement: one colour for the solver's answer and the checker's verdict.

PROVED = Proof(Verdict.PROVED, True, "1 static pose, and no other one")
PARTIAL = Proof(Verdict.PROVED, False, "0 static poses; others may exist")


@pytest.mark.parametrize(
    ("proof", "complete", "incomplete"),
    [
        (None, Kind.GOOD, Kind.OPEN),
        (PROVED, Kind.GOOD, Kind.OPEN),
        (PARTIAL, Kind.OPEN, Kind.OPEN),
        (Proof(Verdict.SAMPLED, False, ""), Kind.OPEN, Kind.OPEN),
        (Proof(Verdict.OUT_OF_TIME, False, ""), Kind.OPEN, Kind.OPEN),
        (Proof(Verdict.NOT_PROVED, False, ""), Kind.BAD, Kind.BAD),
        (Proof(Verdict.MALFORMED, False, ""), Kind.BAD, Kind.BAD),
    ],
)
def test_the_worse_of_answer_and_verdict_gives_the_colour(merlet, proof, complete, incomplete):
    robot, result = merlet
    open_one = replace(result, outcome=Outcome.INCOMPLETE, pending=3)
    assert [judge(one, proof).kind for one in (result, open_one)] == [complete, incomplete]
    # Nothing else on the page is coloured.
    page = result_page(ResultSource(robot, result, proof))
    assert re.findall(r'class="judgement (\w+)"', page) == [complete.value]
    assert not re.search(r'class="(good|open|bad)"', page)


@pytest.mark.parametrize(
    ("jobs", "undecided", "verdicts", "unchecked", "kind"),
    [
        ({"done": 3, "failed": 0}, 0, {}, 0, Kind.GOOD),
        ({"done": 3}, 0, {"PROVED": 3}, 0, Kind.GOOD),
        ({"done": 3}, 0, {"PROVED": 2}, 1, Kind.OPEN),
        ({"done": 3}, 0, {"PROVED": 2, "PROVED (partial)": 1}, 0, Kind.OPEN),
        ({"done": 3}, 1, {}, 0, Kind.OPEN),
        ({"done": 3, "pending": 1}, 0, {}, 0, Kind.OPEN),
        ({"done": 3, "no-pose": 1}, 0, {}, 0, Kind.GOOD),
        ({"done": 3, "none-found": 1}, 0, {}, 0, Kind.OPEN),
        ({"done": 3, "failed": 1}, 0, {"PROVED": 3}, 0, Kind.BAD),
        ({"done": 3}, 0, {"PROVED": 2, "NOT PROVED": 1}, 0, Kind.BAD),
    ],
)
def test_a_batch_is_as_good_as_its_worst_job(jobs, undecided, verdicts, unchecked, kind):
    assert judge_batch(jobs, undecided, verdicts, unchecked).kind is kind


def test_the_page_says_where_it_comes_from(merlet):
    robot, result = merlet[0], replace(merlet[1])
    object.__setattr__(result, "provenance", None)
    page = unescape(result_page(ResultSource(robot, result, None)))
    assert result.robot.sha256 in page and robot.source in page
    lo, hi = result.lengths[0].tolist()
    assert f"in [{lo!r}, {hi!r}]" in page and "<td>4.385" not in page
    assert re.search(r"<footer>Report written \d{4}-\d\d-\d\d \d\d:\d\d UTC by cdpr-interval ", page)


def test_exact_lengths_are_shown_where_a_result_has_them(merlet):
    """Whatever a result says of its origin is in the report."""
    robot, result = merlet
    exact = [(Fraction(text), Fraction(text)) for text in MERLET[:3]] + [(Fraction(13, 3), Fraction(22, 5))]
    date = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    origin = Provenance(date, "bench", {"numba": "0.1"}, tuple(exact), ZERO, robot)
    known = replace(result, provenance=origin)
    page = result_page(ResultSource(robot, known, None))
    for text in (MERLET[0], "13/3 .. 4.4", "2026-01-02 03:04:05 UTC", "bench", "numba 0.1", robot.sha256):
        assert f"<td>{text}</td>" in page


class Requests(HTMLParser):
    """Collects everything that a browser would fetch."""

    def __init__(self):
        super().__init__()
        self.found, self.policy = [], ""

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.found += [given[key] for key in ("src", "href", "srcset", "data", "action") if key in given]
        if tag in ("link", "iframe", "object", "embed", "base"):
            self.found.append(tag)
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"]


def test_the_page_fetches_nothing(merlet):
    page = Requests()
    page.feed(result_page(ResultSource(*merlet, None)))
    assert page.found == []
    assert page.policy.startswith("default-src 'none'") and "http" not in page.policy


def test_names_are_no_markup(merlet):
    robot, result = merlet
    evil = replace(result, robot=replace(result.robot, name="<script>alert(1)</script>"))
    refused = Proof(Verdict.NOT_PROVED, False, "<script>alert(2)</script>")
    assert "<script>alert" not in result_page(ResultSource(robot, evil, refused))


def test_what_is_undecided_is_drawn_and_counted(platform):
    """A search that was stopped: its rest is told, drawn as boxes, and listed."""
    robot = load_robot("uc3")
    result = forward_kinematics(robot, ["7.5", "8", "7"], taut=[0, 1, 2], cell_limit=300)
    assert result.pending and f"{result.pending} cells not looked at" in left_open(result)
    page = result_page(ResultSource(robot, result, None))
    assert f"Left open: {result.pending} cells not looked at." in page and "nothing was left out" not in page
    rotation = np.broadcast_to(np.array([-1.0, 1.0]), (3, 3, 2))
    box = np.array([[1.0, 2.0], [3.0, 5.0], [-3.0, -2.0]])
    robot, result = platform
    left = replace(result, undecided=(Undecided((0, 1), 17, "a double root", box, rotation),))
    figure = robot_figure(robot, left)
    (boxes,) = [trace for trace in figure.data if trace.text == "undecided"]
    (names,) = [trace for trace in figure.data if trace.mode == "text"]
    assert list(names.text) == ["u1"] and names.z[0] == -2.5
    assert np.nanmin(boxes.y) == 3.0 and np.nanmax(boxes.y) == 5.0
    assert all(button.args[0]["visible"][1] for button in figure.layout.updatemenus[0].buttons)
    page = result_page(ResultSource(robot, left, None))
    assert "<h2>Undecided</h2>" in page and "1 undecided region (17 cells)" in page
    assert "<td>u1</td><td>c1,c2</td><td>17</td><td>2</td><td>180</td>" in page and "What helps" in page
    assert "a double root" in page


def test_small_helpers():
    assert (step(1000, 0.3), step(2, 1.0), step(5, 0.01), step(0, 1.0)) == (4, 1, 5, 1)
    assert (bins(1), bins(50), bins(10**6)) == (2, 8, 40)
    low, high = space(np.zeros(3), np.array([10.0, 0.0, 5.0]))
    assert (low < 0.0).all() and (high - low).min() >= 0.25 * 10.0
    low, high = axis_range([2.0, 2.0])
    assert low < 2.0 < high and axis_range([1.0, 3.0]) == (1.0, 3.0)
    assert math.isclose(high - low, 4e-6)


# The command.


def run(*arguments):
    done = CliRunner().invoke(cli, [*map(str, arguments)])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def test_report_of_a_result_with_its_certificate(tmp_path):
    result, proof, out, figures = (tmp_path / name for name in ("r.json", "r.cert", "r.html", "figures"))
    run("fk", "merlet_4_1", "--lengths", ",".join(MERLET), "--json", result, "--certificate", proof, "-q")
    done = run("report", result, "--out", out, "--figures", figures, "--certificate", proof)
    assert done.exit_code == 0, done.stderr
    text = out.read_text()
    assert "Independent check of the certificate: PROVED: 1 static pose, and no other one" in text
    assert "<td>c1,c3,c4</td>" in text and "1.002722" in text
    names = sorted(file.name for file in figures.iterdir())
    assert names == ["pose_1.png", "pose_1.svg", "tensions.png", "tensions.svg"]
    assert (figures / "pose_1.png").read_bytes().startswith(b"\x89PNG")
    paper = tmp_path / "new" / "paper.PDF"
    assert run("report", result, "--out", out, "--figures", paper).exit_code == 0
    assert paper.read_bytes().startswith(b"%PDF") and paper.read_bytes().count(b"/Type /Page ") == 2
    assert run("report", result, "--out", out, "--figures", proof).exit_code == 2
    # A certificate of other lengths proves nothing here, and the report says so.
    other = tmp_path / "other.cert"
    run("fk", "merlet_4_1", "--lengths", "2.7,3.9,3.35,4.4", "--certificate", other, "-q")
    done = run("report", result, "--out", out, "--certificate", other)
    assert done.exit_code == 5
    assert 'class="judgement bad"' in out.read_text() and 'class="judgement good"' not in out.read_text()
    assert "NOT PROVED: the certificate is not of this result: its lengths differ" in out.read_text()
    assert run("report", result, "--out", out, "--certificate", tmp_path / "none").exit_code == 2
    # Another robot's file is refused, and so is what is no result.
    done = run("report", result, "--out", out, "--robot", "merlet_4_1_k100")
    assert done.exit_code == 2 and "--robot: is not the robot of the result" in done.stderr
    done = run("report", proof, "--out", out)
    assert done.exit_code == 2 and len(done.stderr.splitlines()) == 1
    document = json.loads(result.read_text())
    document["robot"]["sha256"] = "0" * 64
    result.write_text(json.dumps(document))
    done = run("report", result, "--out", out)
    assert done.exit_code == 2 and "holds another robot than the one that it names" in done.stderr
    del document["provenance"]
    result.write_text(json.dumps(document))
    done = run("report", result, "--out", out)
    assert done.exit_code == 2 and "--robot: missing" in done.stderr


@pytest.mark.slow
def test_report_of_a_batch(tmp_path):
    text = MONTE_CARLO.format(samples=40) + 'name: "a <study>"\n'
    jobs, folder, out = write(tmp_path, text), tmp_path / "b", tmp_path / "b.html"
    assert run("batch", jobs, "--out", folder, "-q").exit_code == 0
    done = run("report", folder, "--out", out, "--figures", tmp_path / "f")
    assert done.exit_code == 0, done.stderr
    text = out.read_text()
    assert "<h1>a &lt;study&gt;</h1>" in text and "0 jobs left something undecided" in text
    assert "<title>a &lt;study&gt;</title>" in text and 'class="judgement good"' in text
    assert re.search(r"<td>z_m</td><td>40</td>", text)
    assert (tmp_path / "f" / "problem_0_merlet-4-1-k100_branch_1.svg").exists()
    assert json.loads((folder / "summary.json").read_text())["name"] == "a <study>"
    done = run("report", folder, "--out", out, "--robot", "uc2")
    assert done.exit_code == 2
    done = run("report", tmp_path, "--out", out)
    assert done.exit_code == 2 and "no batch there" in done.stderr
    assert run("report", folder, "--out", tmp_path).exit_code == 2
