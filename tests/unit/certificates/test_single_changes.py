"""One change of a certificate proves nothing false; what is remembered of other files changes no verdict."""

from __future__ import annotations

import random

import pytest

import certificates
from certificates.container import pack
from certificates.verdicts import Verdict
from tests.support.certificate_truth import false_statements
from tests.support.honest_certificates import made
from tests.support.single_changes import Remembered, changed

SEED = 20261130
CHANGES, AGAIN = 150, 10


def test_no_single_change_proves_anything_false(monkeypatch: pytest.MonkeyPatch) -> None:
    print("seed", SEED)
    honest = made("plane")
    plain = [certificates.check(pack(honest.document), seed=SEED)]
    documents = [changed(honest.document, random.Random(f"{SEED} {k}"))[1] for k in range(CHANGES)]
    plain += [certificates.check(pack(document), seed=SEED) for document in documents[:AGAIN]]
    checker = Remembered(monkeypatch)
    reports = [checker.check(document, SEED) for document in (honest.document, *documents)]
    for one, other in zip(plain, reports, strict=False):
        assert (one.verdict, one.message) == (other.verdict, other.message)
    assert reports[0].complete
    for document, report in zip(documents, reports[1:], strict=True):
        wrong = false_statements(document, report, honest.truth)
        if report.verdict is Verdict.PROVED and document["lengths_m"] != honest.document["lengths_m"]:
            wrong.append("other lengths")
        assert not wrong, (wrong, report.lines()[0])
    verdicts = {str(report.verdict) for report in reports}
    assert {"PROVED", "NOT PROVED", "MALFORMED"} <= verdicts
