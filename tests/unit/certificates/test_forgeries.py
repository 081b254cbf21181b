"""No structural lie is PROVED: honest certificates of every class, and everything that is done to them."""

from __future__ import annotations

import random

import pytest

import certificates
from certificates.container import pack
from certificates.verdicts import Verdict
from tests.support.certificate_truth import false_statements
from tests.support.forgeries import Forgery, forgeries, havoc
from tests.support.honest_certificates import CLASSES, Honest, made

SEED = 20261128
QUICK = (
    "point, each subset",
    "elastic",
    "swing, asked",
    "swing, ranges",
    "all rotations",
    "slings",
    "three cables",
)
"""Classes of the quick tests, each with so many forgeries."""
FEW = 12
HAVOC = 30


def require_truth(honest: Honest, forgery: Forgery) -> None:
    """Fail where a lie is PROVED, or a PROVED says what is not so."""
    report = certificates.check(pack(forgery.document))
    if forgery.is_lie:
        assert report.verdict in (Verdict.NOT_PROVED, Verdict.MALFORMED), (forgery.what, report.lines()[0])
    wrong = false_statements(forgery.document, report, honest.truth)
    assert not wrong, (forgery.what, wrong, report.lines()[0])


@pytest.mark.parametrize("name", QUICK)
def test_a_sample_of_lies_is_refused(name: str) -> None:
    honest, generator = made(name), random.Random(SEED)
    report = certificates.check(pack(honest.document))
    assert report.verdict is Verdict.PROVED and not false_statements(honest.document, report, honest.truth)
    for forgery in generator.sample(list(forgeries(honest, generator)), FEW):
        require_truth(honest, forgery)


@pytest.mark.slow
@pytest.mark.parametrize("name", CLASSES)
def test_every_lie_is_refused(name: str) -> None:
    honest, generator = made(name), random.Random(SEED)
    report = certificates.check(pack(honest.document))
    assert report.verdict is Verdict.PROVED and not false_statements(honest.document, report, honest.truth)
    tried = list(forgeries(honest, generator))
    print(name, len(tried), "forgeries")
    for forgery in tried:
        require_truth(honest, forgery)


@pytest.mark.slow
@pytest.mark.parametrize("name", CLASSES)
def test_random_changes_prove_nothing_false(name: str) -> None:
    print("seed", SEED)
    honest, generator = made(name), random.Random(SEED)
    for _ in range(HAVOC):
        require_truth(honest, havoc(honest.document, generator))
