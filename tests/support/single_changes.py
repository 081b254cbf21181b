"""Certificates in which one thing is changed: a value, an entry, a byte of a tree.

What is changed lies in the solutions, in the proofs of the subsets or in the lengths. `Remembered` checks
many such files of one certificate: what a change leaves as it is was confirmed before, and is not computed
again.
"""

from __future__ import annotations

import base64
import copy
import math
import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import certificates
from certificates.container import pack
from certificates.leaves import Cells, check_cells
from certificates.root_claims import check_root, require_one_zero_at_most
from certificates.search import Root, Search
from certificates.verdicts import Report
from tests.support.forgeries import inner_places
from tests.support.honest_certificates import Document

Place = tuple[Any, Any]
"""A list or an object, and the key of a value in it."""
STRANGE = (None, 0, 1, True, False, [], {}, "undecided", "")
"""What is put anywhere."""
FACTORS = ("1.000001", "0.9", "-1", "2")
"""Of exact numbers."""


def changed(document: Document, generator: random.Random) -> tuple[str, Document]:
    """Return what was done, and a copy of a document with one change; every kind of change is as likely."""
    found = copy.deepcopy(document)
    by_kind: dict[str, list[Place]] = {}
    for place, key in inner_places(found, "solutions", "subsets", "lengths_m"):
        by_kind.setdefault(kind_of(place, key), []).append((place, key))
    kind = generator.choice(sorted(by_kind))
    place, key = generator.choice(by_kind[kind])
    value = place[key]
    others = [p[k] for p, k in by_kind[kind] if p[k] != value]
    ways: list[Callable[[], Any]] = [
        lambda: generator.choice([None, 0, 1, True, False, [], {}, "undecided", ""])
    ]
    if others:
        ways.append(lambda: copy.deepcopy(generator.choice(others)))
    if kind == "tree":
        ways = [lambda: with_another_byte(value, generator)]
    elif kind == "double":
        ways += [lambda: nudged(value, generator)] * 3
    elif kind == "exact":
        ways += [
            lambda: str(Fraction(value) * Fraction(generator.choice(["1.000001", "0.9", "-1", "2"])))
        ] * 2
    elif kind == "int":
        ways.append(lambda: value + generator.choice([-1, 1]))
    elif kind == "bool":
        ways.append(lambda: not value)
    if generator.random() < 0.1:
        if isinstance(place, list) and generator.random() < 0.5:
            place.insert(key, copy.deepcopy(value))
            return f"{kind} doubled", found
        del place[key]
        return f"{kind} dropped", found
    place[key] = generator.choice(ways)()
    return kind, found


def kind_of(place: Any, key: Any) -> str:
    """Return what a value is."""
    value = place[key]
    if not isinstance(value, str):
        return type(value).__name__
    if "0x" in value:
        return "double"
    if len(value) > 40 or (isinstance(place, list) and value.endswith("=")):
        return "tree"
    return "exact" if value[:1].isdigit() else "word"


def nudged(value: str, generator: random.Random) -> str:
    """Return another double, near or not."""
    x = float.fromhex(value)
    near = [math.nextafter(x, s * math.inf) for s in (-1, 1)]
    far = [x * (1.0 + s * 10.0 ** -generator.uniform(0, 15)) for s in (-1, 1)]
    return float(generator.choice([*near, *far, -x, 2.0 * x, 0.0])).hex()


def with_another_byte(tree: str, generator: random.Random) -> str:
    """Return a tree with a byte more, less, or another one."""
    content = bytearray(base64.b64decode(tree))
    k = generator.randrange(len(content))
    new = generator.choice(
        [generator.randrange(256), generator.randrange(23), content[k] ^ 1 << generator.randrange(8)]
    )
    way = generator.random()
    if way < 0.8:
        content[k] = new
    elif way < 0.9:
        content.insert(k, new)
    else:
        del content[k]
    return base64.b64encode(bytes(content)).decode()


class Remembered:
    """Checks documents; roots and cells that were confirmed are not looked at again.

    Each is remembered with all that it depends on: the question, the order and boxes of the search, the
    solution that is listed for it. What is refused is never remembered.
    """

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.roots: dict[str, Any] = {}
        self.boxes: set[str] = set()
        self.cells: set[tuple[Any, ...]] = set()
        patch.setattr("certificates.root_claims.check_root", self.check_root)
        patch.setattr("certificates.root_claims.require_one_zero_at_most", self.require_one_zero_at_most)
        patch.setattr("certificates.searches.check_cells", self.check_cells)

    def check(self, document: Document, seed: int) -> Report:
        """Check a document; ``seed`` draws the cells that are checked in both arithmetics."""
        return certificates.check(pack(document), seed=seed)

    def check_root(self, search: Search, root: Root, solutions: list[Any]) -> Any:
        """As `root_claims.check_root`."""
        listed = None if root.pose is None else solutions[root.pose]
        key = repr((asked(search), root.chart, root.box, listed))
        if key not in self.roots:
            self.roots[key] = check_root(search, root, solutions)
        return self.roots[key]

    def require_one_zero_at_most(self, search: Search) -> None:
        """As `root_claims.require_one_zero_at_most`."""
        key = repr((asked(search), boxes(search)))
        if key not in self.boxes:
            require_one_zero_at_most(search)
            self.boxes.add(key)

    def check_cells(self, search: Search, cells: Cells, twice: Any) -> int:
        """As `leaves.check_cells`."""
        about = hash(repr((asked(search), boxes(search)))), cells.node, cells.side
        arrays = cells.chart, cells.bounds, cells.data, cells.kept, twice
        keys = [(*about, *(v[..., i].tobytes() for v in arrays)) for i in range(len(cells))]
        new = np.array([k for k, key in enumerate(keys) if key not in self.cells], dtype=int)
        if not len(new):
            return 0
        parts = check_cells(search, cells.at(new), twice[new])
        self.cells |= {keys[k] for k in new}
        return parts


def asked(search: Search) -> Any:
    """Return what a search is about."""
    return search.problem, search.setting, search.order


def boxes(search: Search) -> Any:
    """Return the boxes of a search's roots."""
    return [(root.chart, root.box) for root in search.roots]
