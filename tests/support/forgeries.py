"""Certificates with structural lies: what is dropped, added, doubled, shared, widened, flattened or swapped.

Every forgery has a right digest. `Forgery.is_lie` is True where something in the document is false by
construction, whatever the robot: such a one must never be PROVED, not even in part. Of the others (wider
bounds, other trees, random changes) `tests/support/certificate_truth.py` judges what a PROVED claims, by
what the solver found.
"""

from __future__ import annotations

import base64
import copy
import math
import random
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from certificates.tree import Node
from tests.support import plain_certificate_reader as reader
from tests.support.honest_certificates import Document, Honest
from tests.support.listed_bounds import (
    BOUNDS,
    all_moved,
    apart,
    at_middle,
    differ,
    every_bound,
    hexed,
    undecided,
    widen_all,
    with_hull,
    zero,
)

WIDER = 0.2
"""How much a listed box grows that its chart still reaches."""
BY = 1e-3
"""How far things are moved: more than any bounds are wide, but where lengths are ranges."""


@dataclass(frozen=True)
class Forgery:
    """A changed certificate."""

    what: str
    document: Document
    is_lie: bool


def forgeries(honest: Honest, generator: random.Random) -> Iterator[Forgery]:
    """Yield every forgery of a certificate that is known here."""
    for kind in (
        pointers_changed,
        roots_changed,
        claims_changed,
        families_changed,
        trees_changed,
        question_changed,
    ):
        yield from kind(honest.document, generator)


# What points to solutions.


def pointers(document: Document) -> Iterator[tuple[Any, Any]]:
    """Yield the places (list or object, key) that hold the number of a solution or null."""
    for entry in document["subsets"]:
        poses = entry.get("point", {}).get("poses", [])
        yield from ((poses, i) for i in range(len(poses)))
        yield from ((root, "pose") for search in entry.get("searches", []) for root in search["roots"])


def renumbered(document: Document, number: Callable[[int | None], int | None]) -> Document:
    """Return a document whose pointers are changed."""
    found = copy.deepcopy(document)
    for place, key in pointers(found):
        place[key] = number(place[key])
    return found


def dropped(document: Document, k: int, instead: int | None = None) -> Document:
    """Return a document without a solution; what pointed to it points to another one or to none."""
    found = renumbered(document, lambda p: instead if p == k else p)
    found = renumbered(found, lambda p: p - 1 if p is not None and p > k else p)
    del found["solutions"][k]
    return found


def forgotten(document: Document, k: int) -> Document:
    """Return a document without a solution and without the roots that pointed to it."""
    found = copy.deepcopy(document)
    for search in searches(found):
        search["roots"] = [root for root in search["roots"] if root["pose"] != k]
    return dropped(found, k)


def searches(document: Document) -> Iterator[Document]:
    """Yield the searches of all subsets."""
    for entry in document["subsets"]:
        yield from entry.get("searches", [])


def with_another(document: Document, k: int, solution: Document) -> Document:
    """Return a document with one more solution: roots point to it as to solution k, or a null does."""
    found = copy.deepcopy(document)
    found["solutions"].append(solution)
    new = len(found["solutions"]) - 1
    for search in searches(found):
        search["roots"] += [{**root, "pose": new} for root in search["roots"] if root["pose"] == k]
    for place, key in pointers(found):
        if isinstance(place, list) and place[key] is None:
            place[key] = new
            break
    return found


def pointers_changed(document: Document, generator: random.Random) -> Iterator[Forgery]:
    """Yield lists of solutions that are not the list of poses."""
    solutions = document["solutions"]
    whole = not any("pending" in entry for entry in document["subsets"]) and all(
        Node.PENDING not in reader.leaves(tree) for tree in reader.trees(document)
    )
    for k, solution in some(solutions, generator):
        yield Forgery(f"drop {k}", dropped(document, k), True)
        for n, entry in enumerate(document["subsets"]):
            if k in entry.get("point", {}).get("poses", []):
                less = dropped(document, k)
                less["subsets"][n]["point"]["proof"] = {"kind": "dependent"}
                yield Forgery(f"drop {k} as dependent", less, True)
        if any(root["pose"] == k for search in searches(document) for root in search["roots"]):
            yield Forgery(f"forget {k}", forgotten(document, k), whole)
        yield Forgery(f"duplicate {k}", with_another(document, k, copy.deepcopy(solution)), True)
        moved = all_moved(solution, BY)
        yield Forgery(f"add {k}", with_another(document, k, moved), True)
        backless = copy.deepcopy(document)
        backless["solutions"].append(moved)
        yield Forgery(f"add {k} without a proof", backless, True)
    for j, k in some_pairs(len(solutions), generator):
        shared = dropped(with_hull(document, j, k), k, j)
        yield Forgery(f"share {j} for {k}", shared, True)
        yield Forgery(f"share {j} for {k}, undecided", undecided(shared, j - (k < j)), False)
        yield Forgery(f"two undecided {j} {k}", undecided(undecided(with_hull(document, j, k), j), k), False)
        single = solutions[j]["family"] is None and solutions[k]["family"] is None
        yield Forgery(f"widen {j} over {k}", with_hull(document, j, k), single)
        swap = {j: k, k: j}
        yield Forgery(f"swap {j} and {k}", renumbered(document, lambda p, s=swap: s.get(p, p)), True)
        crossed = copy.deepcopy(document)
        a, b = crossed["solutions"][j], crossed["solutions"][k]
        a["position_m"], b["position_m"] = b["position_m"], a["position_m"]
        a["height_m"], b["height_m"] = b["height_m"], a["height_m"]
        yield Forgery(f"swap positions of {j} and {k}", crossed, differ(a["position_m"], b["position_m"]))


def some(values: list[Any], generator: random.Random, most: int = 3) -> list[tuple[int, Any]]:
    """Return some values of a list, each with its place."""
    return generator.sample(list(enumerate(values)), min(most, len(values)))


def some_pairs(count: int, generator: random.Random, most: int = 4) -> list[tuple[int, int]]:
    """Return some pairs of different numbers."""
    pairs = [(j, k) for j in range(count) for k in range(count) if j != k]
    return generator.sample(pairs, min(most, len(pairs)))


# Roots.


def roots_changed(document: Document, generator: random.Random) -> Iterator[Forgery]:
    """Yield boxes of roots that say nothing, or too much."""
    for n, search in enumerate(searches(document)):
        for i, root in some(search["roots"], generator):
            k = root["pose"]

            def other(
                changed: Document, by: float | None = None, k: int | None = k, n: int = n, i: int = i
            ) -> Document:
                """Return the document with another root, and the listed box wider, or as wide as can be."""
                found = copy.deepcopy(document)
                list(searches(found))[n]["roots"][i] = changed
                if k is not None:
                    widen_all(found["solutions"][k], by)
                return found

            flat = {key: [at_middle(b) for b in root[key]] for key in ("u", "x")}
            yield Forgery(f"flatten root {n} {i}", other({**root, **flat}), True)
            yield Forgery(f"flatten root {n} {i}, wider box", other({**root, **flat}, WIDER), True)
            part = {"x": [at_middle(root["x"][0]), *root["x"][1:]]}
            yield Forgery(f"flatten x of root {n} {i}", other({**root, **part}), True)
            wide = {"u": [b if zero(b) else hexed(-1, 1) for b in root["u"]]}
            wide["x"] = [b if zero(b) else hexed(-99, 99) for b in root["x"]]
            yield Forgery(f"widen root {n} {i}", other({**root, **wide}), True)
            yield Forgery(f"an end at root {n} {i}", other({**root, "end": 0, "pose": None}), True)
            yield Forgery(f"chart of root {n} {i}", other({**root, "chart": (root["chart"] + 2) % 4}), True)
            if k is not None:
                yield Forgery(f"widen the box of root {n} {i}", other(root), True)


# Claims.


def claims_changed(document: Document, generator: random.Random) -> Iterator[Forgery]:
    """Yield solutions of which something else is claimed."""
    for k, solution in some(document["solutions"], generator):

        def other(k: int = k, **fields: Any) -> Document:
            """Return the document with other claims of a solution."""
            found = copy.deepcopy(document)
            found["solutions"][k] |= fields
            return found

        for key in BOUNDS:
            # The writer's bounds are wider than the pose's on either side.
            flat = every_bound(solution[key], lambda lo, hi: (lo, lo))
            yield Forgery(f"flatten {key} of {k}", other(**{key: flat}), True)
            wide = every_bound(solution[key], lambda lo, hi: (lo - 1e-13, hi + 1e-13))
            yield Forgery(f"widen {key} of {k} a little", other(**{key: wide}), False)
        tensions = solution["tensions_N"]
        swapped = [tensions[-1], *tensions[1:-1], tensions[0]]
        if len(tensions) > 1 and apart(tensions[0], tensions[-1]):
            yield Forgery(f"swap tensions of {k}", other(tensions_N=swapped), True)
        for i, state in enumerate(solution["states"]):
            for word in {"taut", "slack", "undecided"} - {state}:
                states = [*solution["states"][:i], word, *solution["states"][i + 1 :]]
                taut = [j for j, s in enumerate(states) if s == "taut"]
                changed = other(states=states, taut=taut)
                yield Forgery(f"cable {i} of {k} {word}", changed, word != "undecided")
        for word in {"stable", "unstable"} - {solution["stability"]}:
            # What the solver leaves undecided over ranges may be one of them for all lengths.
            yield Forgery(f"{k} {word}", other(stability=word), solution["stability"] != "undecided")
        yield Forgery(f"{k} of unknown stability", other(stability="undecided"), False)
        for value in {True, False} - {solution["slack_respected"]}:
            yield Forgery(f"slack of {k} {value}", other(slack_respected=value), True)
        yield Forgery(f"slack of {k} unknown", other(slack_respected=None), False)


# Families.


def families_changed(document: Document, generator: random.Random) -> Iterator[Forgery]:
    """Yield other families, and families where there are none."""
    everything = {
        "kind": "all-rotations",
        "axis_point_m": None,
        "axis_direction": None,
        "angle_ranges_rad": [],
    }
    for k, solution in some(document["solutions"], generator):
        family = solution["family"]

        def other(k: int = k, family: Any = family, **fields: Any) -> Document:
            """Return the document with another family."""
            found = copy.deepcopy(document)
            found["solutions"][k]["family"] = {**family, **fields} if fields else family
            return found

        if family is None or family["kind"] != "all-rotations":
            yield Forgery(f"all rotations of {k}", other(family=everything), True)
        if family is not None:
            yield Forgery(f"no family of {k}", other(family=None), True)
        if family is None or family["kind"] != "rotation":
            continue
        ranges = [[list(map(float.fromhex, b)) for b in pair] for pair in family["angle_ranges_rad"]]
        full = len(ranges) == 1 and ranges[0][1][1] - ranges[0][0][0] > 6.28
        by = BY + 3 * max(hi - lo for pair in ranges for lo, hi in pair)
        for what, first, second in (("shrink", by, -by), ("grow", -by, by), ("turn", by, by)):
            moved = [
                [[(v + first).hex() for v in start], [(v + second).hex() for v in end]]
                for start, end in ranges
            ]
            # A full turn that is turned or overlaps is one still.
            lie = what == "shrink" or not full
            yield Forgery(f"{what} the ranges of {k}", other(angle_ranges_rad=moved), lie)
        yield Forgery(f"no ranges of {k}", other(angle_ranges_rad=[]), True)
        nothing = [[hexed(0, 0), hexed(0, 0)]]
        yield Forgery(f"one angle of {k}", other(angle_ranges_rad=nothing), True)
        turn = [[hexed(-math.pi, -math.pi), hexed(3.2, 3.2)]]
        yield Forgery(f"a full turn of {k}", other(angle_ranges_rad=turn), not full)
        axis = [float.fromhex(lo) for lo, _ in family["axis_direction"]]
        across = min(range(3), key=lambda i: abs(axis[i]))
        point = list(map(list, family["axis_point_m"]))
        point[across] = hexed(*(float.fromhex(v) + BY for v in point[across]))
        yield Forgery(f"axis of {k} elsewhere", other(axis_point_m=point), True)
        back = [hexed(-float.fromhex(hi), -float.fromhex(lo)) for lo, hi in family["axis_direction"]]
        yield Forgery(f"axis of {k} the other way", other(axis_direction=back), False)


# Trees.


def trees_changed(document: Document, generator: random.Random) -> Iterator[Forgery]:
    """Yield trees that exclude what is there, a pose being dropped."""
    y = struct.pack("<6i", *(generator.randrange(-(2**31), 2**31) for _ in range(6)))
    false = {
        "no position": bytes([Node.NO_POSITION]),
        "no length": bytes([Node.NO_LENGTH]),
        "unbalanced": bytes([Node.UNBALANCED]) + y,
        "too long": bytes([Node.TOO_LONG, 0]),
        "nothing": b"",
    }
    pointed = {root["pose"] for search in searches(document) for root in search["roots"]} - {None}
    for _, k in some(sorted(pointed), generator):
        less = forgotten(document, k)
        for name, leaf in false.items():
            found = copy.deepcopy(less)
            if replace_roots(found, leaf):
                yield Forgery(f"{name} instead of {k}", found, True)
        found = copy.deepcopy(less)
        if replace_roots(found, bytes([Node.UNDECIDED])):
            yield Forgery(f"undecided instead of {k}", found, False)
        for chart in range(4):
            found = copy.deepcopy(less)
            charts = [search["trees"] for search in searches(found) if search["trees"][chart] is not None]
            if any(bytes([Node.ROOT]) in base64.b64decode(trees[chart]) for trees in charts):
                for trees in charts:
                    trees[chart] = None
                yield Forgery(f"without chart {chart} and {k}", found, True)
                cut = bytes([Node.HAND_ON, Node.CUT, 8]) + struct.pack("<dd", 0.0, 0.0) + bytes([Node.ROOT])
                for trees in charts:
                    trees[chart] = base64.b64encode(cut).decode()
                yield Forgery(f"chart {chart} cut to nothing, without {k}", copy.deepcopy(found), True)
    for n, search in enumerate(searches(document)):
        found = copy.deepcopy(document)
        trees = list(searches(found))[n]["trees"]
        used = [c for c in range(4) if trees[c] is not None]
        trees[used[0]], trees[used[-1]] = trees[used[-1]], trees[used[0]]
        yield Forgery(f"charts of search {n} swapped", found, False)
        del search


def replace_roots(document: Document, leaf: bytes) -> bool:
    """Put something in the place of all leaves that are settled by roots; return whether there are any."""
    some = False
    for search in searches(document):
        for chart, text in enumerate(search["trees"]):
            if text is None:
                continue
            tree = base64.b64decode(text)
            places = [place for place in reader.nodes(tree) if tree[place] == Node.ROOT]
            for place in reversed(places):
                tree = tree[:place] + leaf + tree[place + 1 :]
            some |= bool(places)
            search["trees"][chart] = base64.b64encode(tree).decode()
    return some


# Question and robot.


def question_changed(document: Document, generator: random.Random) -> Iterator[Forgery]:
    """Yield certificates of another robot, other lengths, or other subsets."""

    def other(*path: Any, value: Any) -> Document:
        """Return the document with another value at a place."""
        found = copy.deepcopy(document)
        place = found
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value
        return found

    subsets = document["subsets"]
    for k in range(len(subsets)):
        yield Forgery(f"without subset {k}", other("subsets", value=subsets[:k] + subsets[k + 1 :]), True)
        bare = {"taut": subsets[k]["taut"]}
        yield Forgery(f"subset {k} without a proof", other("subsets", k, value=bare), subsets[k] != bare)
    if len(subsets) > 1:
        yield Forgery("subsets in another order", other("subsets", value=subsets[::-1]), True)
    speaking = "c1 and of all other subsets"
    yield Forgery("a cable that speaks", other("robot", "cables", 0, "name", value=speaking), True)
    # Where lengths are ranges bounds have room for a little more.
    sharp = all(lo == hi for lo, hi in document["lengths_m"])
    carrying = sorted({i for s in document["solutions"] for i in s["taut"]})
    for i in carrying:
        lo, hi = map(float, document["lengths_m"][i])
        for a, b in ((lo - (hi - lo) - BY, hi), (lo, hi + (hi - lo) + BY), (lo + BY, hi + BY)):
            if a <= b:
                found = other("lengths_m", i, value=[repr(a), repr(b)])
                yield Forgery(f"length {i} in {a}, {b}", found, sharp)
        exit_x = float(document["robot"]["cables"][i]["frame_anchor_m"][0]) + BY
        yield Forgery(
            f"exit {i}", other("robot", "cables", i, "frame_anchor_m", 0, value=repr(exit_x)), sharp
        )
    if carrying:
        mass = repr(2 * float(document["robot"]["mass_kg"]))
        yield Forgery("mass", other("robot", "mass_kg", value=mass), True)
        up = [repr(-float(g)) for g in document["robot"]["gravity_m_s2"]]
        yield Forgery("gravity", other("robot", "gravity_m_s2", value=up), True)
        yield Forgery("force", other("external_force_N", value=["1e4", "2e4", "3e4"]), True)


def havoc(document: Document, generator: random.Random) -> Forgery:
    """Return a document of whose solutions and proofs something was copied, moved or taken at random."""
    found, done = copy.deepcopy(document), []
    for _ in range(generator.choice([1, 1, 2, 3])):
        places = list(inner_places(found, "solutions", "subsets"))
        if not places:
            break
        place, key = generator.choice(places)
        other, their = generator.choice([p for p in places if type(p[0][p[1]]) is type(place[key])])
        done.append(f"{key} from {their}")
        if isinstance(place, list) and generator.random() < 0.2:
            place.insert(key, copy.deepcopy(place[key]))
        elif isinstance(place, list) and generator.random() < 0.2:
            del place[key]
        elif place[key] is None or generator.random() < 0.1:
            place[key] = generator.choice([None, 0, 1, True, False, [], "undecided"])
        else:
            place[key] = copy.deepcopy(other[their])
    return Forgery("havoc: " + ", ".join(done), found, False)


def inner_places(document: Document, *parts: str) -> Iterator[tuple[Any, Any]]:
    """Yield (list or object, key) of all values in parts of a document."""
    waiting: list[Any] = [document[part] for part in parts]
    while waiting:
        value = waiting.pop()
        for key in range(len(value)) if isinstance(value, list) else value:
            yield value, key
            if isinstance(value[key], list | dict):
                waiting.append(value[key])
