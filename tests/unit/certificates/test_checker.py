"""The verdict on a whole certificate: what must be there, and what a failure of any kind means."""

import copy
import importlib
import os
import re
import time
from pathlib import Path

import pytest

import certificates
from certificates import certificate, clock, lots, processes
from certificates.tree import Cell, Leaf, Node
from certificates.verdicts import Report, Verdict
from solvers.proofs.claimed import claimed
from tests.support.made_certificates import changed, hanging, leaf, platform, three_poses, written


def check(tmp_path, document, **options) -> Report:
    return certificates.check(written(tmp_path, document), **options)


def test_all_poses_are_proved(tmp_path):
    report = check(tmp_path, three_poses())
    assert report.verdict is Verdict.PROVED and report.complete
    assert (report.solutions, report.subsets, report.leaves, report.pending) == (3, 3, 0, 0)
    assert report.lines()[0] == "PROVED: 3 static poses (slackness ignored), and no other one"


def test_no_pose_and_one_subset(tmp_path):
    assert check(tmp_path, hanging(["1", "1"])).message == "no static pose"
    asked = check(tmp_path, hanging(["2", "3"], taut="c1,c2"))
    assert asked.message == "1 static pose of subset c1,c2, and no other one"


def not_proved(tmp_path, document, text):
    report = check(tmp_path, document)
    assert report.verdict is Verdict.NOT_PROVED and text in report.message, report
    assert not report.complete and report.lines()[0].startswith("NOT PROVED: ")


def test_a_missing_further_or_misplaced_subset(tmp_path):
    document = three_poses()
    a, b, both = document["subsets"]
    for subsets in ([], [a, b], [a, b, both, both], [b, a, both], [a, both, b], [a, a, both]):
        not_proved(tmp_path, changed(document, "subsets", value=subsets), "subsets")


def test_a_subset_without_a_proof(tmp_path):
    document = three_poses()
    del document["subsets"][1]["point"]
    not_proved(tmp_path, document, "subset c2: there is no proof")


def test_a_pending_subset(tmp_path):
    document = hanging(["1", "1"])
    document["subsets"][0] = {"taut": [0, 1], "pending": "no time"}
    report = check(tmp_path, document)
    assert report.verdict is Verdict.PROVED and not report.complete and report.pending == 1
    text = "PROVED (partial): 0 static poses; others may exist: 1 pending, 0 undecided, 0 not certified"
    assert report.lines()[0] == text


def test_why_something_is_left_open_is_counted_below(tmp_path):
    document = hanging(["1", "1"])
    document["subsets"][0] = {"taut": [0, 1], "pending": "no time"}
    reasons = ["torus"] * 3 + [f"reason {k}" for k in range(5)] + ["long" * 100, "\u03c0"]
    document["not_certified"] = [{"taut": [0], "reason": reason} for reason in reasons]
    lines = check(tmp_path, document).lines()
    assert "1 pending, 0 undecided, 10 not certified" in lines[0]
    below = lines[lines.index("1 pending, 0 undecided") + 1 :]
    assert below[0] == "3 poses not certified: torus" and below[1] == "1 pose not certified: reason 0"
    assert len(below) == 6 and below[-1] == "and 4 other reasons"
    document["not_certified"] = document["not_certified"][8:]
    *_, long, other, pending = check(tmp_path, document).lines()
    assert long.endswith("longl...") and len(long) < 130
    assert (other, pending) == ("1 pose not certified: \\u03c0", "1 subset pending: no time")
    assert claimed(document).reasons == tuple(check(tmp_path, document).reasons)


def test_cells_that_are_left_open_have_reasons_too(tmp_path):
    cells = [leaf(Node.PENDING, 1), leaf(Node.UNDECIDED), leaf(Node.PENDING), leaf(Node.PENDING)]
    report = check(tmp_path, platform(*cells))
    assert report.reasons == (
        "4 cells pending: the search has not come to it",
        "1 cell undecided: too small to be cut once more",
    )
    assert check(tmp_path, three_poses()).reasons == ()


class Ended(lots.Worker):
    """Checks two lots, and then something happens."""

    def check(self, lot):
        self.left = getattr(self, "left", 2) - 1
        if self.left < 0:
            raise self.error
        return len(lot[2])


@pytest.mark.parametrize("error", [clock.OutOfTime, KeyboardInterrupt])
def test_how_far_it_came_is_said(tmp_path, monkeypatch, error):
    monkeypatch.setattr(Ended, "error", error, raising=False)
    monkeypatch.setattr(lots, "Worker", Ended)
    monkeypatch.setattr(lots, "MOST", 16)
    monkeypatch.setattr(certificate.Certificate, "check_entry", lambda self, k: (set(), 100, 0, 0))
    cell = Leaf(Cell(0, ((-1.0, 1.0),) * 3), Node.UNDECIDED)
    monkeypatch.setattr(certificate.Certificate, "leaves", lambda self, k: [(0, cell)] * 100)
    for sample, of_them in ((None, "32 of 100 cells"), (50, "32 of 50 cells")):
        document = platform(*[leaf(Node.UNDECIDED)] * 4)
        if error is KeyboardInterrupt:
            with pytest.raises(KeyboardInterrupt, match=f"^{of_them} checked$"):
                check(tmp_path, document, sample=sample)
        else:
            report = check(tmp_path, document, sample=sample)
            assert report.lines()[0] == f"OUT OF TIME: the time limit has passed: {of_them} checked"

    def ended(self, k):
        raise error

    monkeypatch.setattr(certificate.Certificate, "check_entry", ended)
    text = "0 of 1 subset examined, no cell checked"
    if error is KeyboardInterrupt:
        with pytest.raises(KeyboardInterrupt, match=text):
            check(tmp_path, document)
    else:
        assert text in check(tmp_path, document).message


def test_a_pending_subset_backs_no_solution(tmp_path):
    document = three_poses()
    document["subsets"][2] = {"taut": [0, 1], "pending": "no time"}
    k = next(k for k, s in enumerate(document["solutions"]) if s["taut"] == [0, 1])
    not_proved(tmp_path, document, f"solution {k + 1} is backed by no proof")


def test_pending_with_a_proof(tmp_path):
    document = three_poses()
    document["subsets"][0]["pending"] = "half done"
    report = check(tmp_path, document)
    assert report.verdict is Verdict.PROVED and not report.complete and report.solutions == 3


def test_dependent_wrenches_need_no_proof_unless_asked_for(tmp_path):
    document = platform(*[leaf(Node.UNDECIDED)] * 4)
    for cable in document["robot"]["cables"][:2]:
        cable.update({"frame_anchor_m": ["0", "0", "9"], "platform_anchor_m": ["0", "0", "0"]})
    document["subsets"] = [{"taut": [0, 1, 2]}]
    not_proved(tmp_path, document, "there is no proof")
    document["subsets"][0]["pending"] = "dependent"
    assert check(tmp_path, document).lines()[0].startswith("PROVED (partial)")
    document["subsets"][0]["searches"] = []
    assert check(tmp_path, document).verdict is Verdict.MALFORMED
    document["question"]["taut"] = None
    subsets = [(0,), (1,), (2,), (3,), (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    subsets += [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3), (0, 1, 2, 3)]
    document["subsets"] = [{"taut": list(t), **({} if {0, 1} <= {*t} else {"pending": "x"})} for t in subsets]
    report = check(tmp_path, document)
    assert report.verdict is Verdict.PROVED and report.pending == 11
    del document["subsets"][0]["pending"]
    not_proved(tmp_path, document, "subset c0: there is no proof")


def test_the_same_solution_twice(tmp_path):
    document = three_poses()
    document["solutions"].append(copy.deepcopy(document["solutions"][0]))
    not_proved(tmp_path, document, "solution 4 is backed by no proof")
    document = three_poses()
    for solution in document["solutions"][:2]:
        for k in range(3):
            solution["position_m"][k] = [(-10.0).hex(), (10.0).hex()]
    not_proved(tmp_path, document, "solutions 1 and 2 may be the same")


def test_what_is_left_open_is_not_complete(tmp_path):
    left = [{"taut": [0], "reason": "not recorded"}]
    report = check(tmp_path, changed(hanging(), "not_certified", value=left))
    assert report.verdict is Verdict.PROVED and not report.complete
    assert report.lines()[0].startswith("PROVED (partial): 1 static pose; others may exist")


def test_nothing_is_counted_where_something_is_undecided(tmp_path):
    for keys, value in ((("slack_respected",), None), (("states", 1), "undecided")):
        report = check(tmp_path, changed(hanging(), "solutions", 0, *keys, value=value))
        assert report.verdict is Verdict.PROVED and not report.complete, keys
        assert not re.search(r"\d+ static|no static|no other", report.message), report.message


def test_what_fails_says_where(tmp_path):
    not_proved(tmp_path, changed(hanging(), "solutions", 0, "stability", value="unstable"), "subset c1,c2: ")
    report = check(tmp_path, changed(hanging(), "subsets", 0, "point", "poses", 0, value=7))
    assert report.verdict is Verdict.MALFORMED and report.message.startswith("subset c1,c2: poses: 7")


@pytest.mark.parametrize(
    "error",
    [ZeroDivisionError, OverflowError, ValueError, MemoryError, RecursionError, AssertionError, KeyError],
)
def test_a_computation_that_fails_proves_nothing(tmp_path, monkeypatch, error):
    def fail(*given):
        raise error("by test")

    monkeypatch.setattr(certificate, "check_point", fail)
    not_proved(tmp_path, hanging(), f"subset c1,c2: {error.__name__}: ")


def test_trees_are_checked_cell_by_cell(tmp_path):
    seen = []
    document = platform(*[leaf(Node.NO_POSITION, 4)] * 4)
    report = check(tmp_path, document, progress=lambda done, total: seen.append((done, total)))
    assert report.verdict is Verdict.PROVED and report.complete
    assert report.leaves == report.checked == 64 <= report.parts
    assert seen == sorted(seen) and seen[-1] == (64, 64)


def test_open_cells_are_counted(tmp_path):
    document = platform(leaf(Node.PENDING, 1), *[leaf(Node.UNDECIDED)] * 3)
    report = check(tmp_path, document)
    assert report.verdict is Verdict.PROVED and not report.complete
    assert (report.pending, report.undecided) == (2, 3)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_wrong_cell_is_named(tmp_path, threads):
    trees = [
        leaf(Node.UNDECIDED, 3),
        leaf(Node.UNDECIDED, 2),
        leaf(Node.NO_POSITION),
        leaf(Node.UNDECIDED, 4),
    ]
    report = check(tmp_path, platform(*trees, length="120"), threads=threads)
    assert report.verdict is Verdict.NOT_PROVED
    assert report.message.startswith("subset c0,c1,c2: cell 13: ")


def test_processes_agree_with_one(tmp_path):
    document = platform(*[leaf(Node.NO_POSITION, 3)] * 4)
    one, two = (check(tmp_path, document, threads=threads) for threads in (1, 2))
    assert one.verdict is two.verdict is Verdict.PROVED
    assert (one.checked, one.parts) == (two.checked, two.parts)


def die(*given):
    os._exit(1)


def test_a_worker_that_dies_proves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "WORTH", 1)
    monkeypatch.setattr(processes, "start_worker", die)
    report = check(tmp_path, platform(*[leaf(Node.UNDECIDED, 4)] * 4), threads=2)
    assert report.verdict is Verdict.NOT_PROVED and report.message


def test_a_small_certificate_needs_no_other_process(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "start_worker", die)
    report = check(tmp_path, platform(*[leaf(Node.NO_POSITION, 2)] * 3, leaf(Node.NO_POSITION)), threads=9)
    assert report.verdict is Verdict.PROVED and report.checked == report.leaves == 13


def test_a_sample_is_not_a_proof(tmp_path):
    document = platform(*[leaf(Node.NO_POSITION, 4)] * 4)
    report = check(tmp_path, document, sample=5)
    assert report.verdict is Verdict.SAMPLED and not report.complete and report.checked == 5
    again = check(tmp_path, document, sample=5, seed=report.seed)
    assert again.parts == report.parts and f"--seed {report.seed}" in again.lines()[-2]
    assert check(tmp_path, document, sample=64).verdict is Verdict.PROVED
    assert check(tmp_path, document, sample=0).verdict is Verdict.SAMPLED


def test_a_sample_does_not_spare_points(tmp_path):
    document = changed(hanging(), "solutions", 0, "stability", value="unstable")
    assert check(tmp_path, document, sample=1).verdict is Verdict.NOT_PROVED


@pytest.mark.parametrize("threads", [1, 2])
def test_the_time_limit(tmp_path, threads):
    document = platform(*[leaf(Node.NO_LENGTH, 5)] * 4)
    start = time.monotonic()
    report = check(tmp_path, document, time_limit=0.2, threads=threads)
    assert report.verdict is Verdict.OUT_OF_TIME and not report.complete
    assert report.checked < report.leaves == 128 and time.monotonic() - start < 30
    assert check(tmp_path, hanging(), time_limit=0.0).verdict is Verdict.OUT_OF_TIME


def test_an_interrupt_is_not_a_verdict(tmp_path, monkeypatch):
    def interrupt(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(certificate, "check_point", interrupt)
    with pytest.raises(KeyboardInterrupt):
        check(tmp_path, hanging())


def test_every_function_in_the_table_of_rules_exists():
    page = (Path(__file__).parents[3] / "docs" / "certificate.md").read_text(encoding="utf-8")
    table = page.split("| rule | theorem |")[1].split("\n\n")[0]
    names = [
        name for row in table.splitlines()[2:] for name in re.findall(r"`([\w.]+)`", row.rsplit("|", 2)[1])
    ]
    assert len(names) > 30
    for name in names:
        module, *path = name.split(".")
        found = importlib.import_module(f"certificates.{module}")
        for part in path:
            found = getattr(found, part)
        assert found.__doc__, name


def test_lines_are_ascii():
    report = Report(Verdict.MALFORMED, "x\ud800\n\u00e9", False, 0, 0, 0, 0, 0, 0, 0, 0.0)
    assert report.lines()[0].isascii()
