"""A corrupted document is refused with its place, or read as a whole: nothing in between."""

from __future__ import annotations

import copy
import math
import random

import pytest

from cdpr_interval import InputError
from solvers import IkResult, Motion, Result, forward_kinematics, inverse_kinematics, motion

JUNK = [
    None, True, False, 0, -1, 1.5, math.inf, math.nan, "x", "", [], {}, [1], [[1, 2]], {"a": 1}, "c1", 10**30,
    "1/2", "7..8", [None], -0.0, "complete", "2026-11-28T23:47:56Z",
]  # fmt: skip
CHANGES = 600


@pytest.fixture(params=["fk", "ik", "motion"])
def whole(request):
    """A document and its class."""
    if request.param == "fk":
        return forward_kinematics("uc2", ["7.5+-0.001", "8"]).to_dict(), Result
    if request.param == "motion":
        return motion("uc4", [(0, [7.5, 8, 7, 9]), (1, [7.5, 8, 7, 9.3])]).to_dict(), Motion
    return inverse_kinematics("uc2", (5, 0, -7), settle=True).to_dict(), IkResult


def paths(value, path=()):
    """Yield the way to everything in a document."""
    yield path
    entries = (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    )
    for key, entry in entries:
        yield from paths(entry, (*path, key))


def test_one_change_in_a_document(whole):
    document, kind = whole
    draw = random.Random(20261128)
    places = [path for path in paths(document) if path]
    refused = 0
    for _ in range(CHANGES):
        changed = copy.deepcopy(document)
        path = draw.choice(places)
        place = changed
        for step in path[:-1]:
            place = place[step]
        if isinstance(place, dict) and draw.random() < 0.15:
            del place[path[-1]]
        else:
            place[path[-1]] = draw.choice(JUNK)
        try:
            found = kind.from_json(changed)
        except InputError as error:
            refused += 1
            assert 1 <= len(error.messages) <= 21
            label = "motion" if kind is Motion else "result"
            assert all(label in line for line in error.messages), error
            continue
        text = found.to_json()
        assert kind.from_json(text).to_json() == text
        assert len(repr(found)) < 2000 and str(found)
        if kind is Result:
            found.verify()
            assert found._repr_html_() and len(found.to_rows()) == len(found.solutions)
    assert CHANGES / 2 < refused < CHANGES


def test_names_of_cables_differ(whole):
    document, kind = whole
    document["cables"] = ["c1", "c1"]
    with pytest.raises(InputError, match=r"(result|motion).cables: names must differ"):
        kind.from_json(document)
