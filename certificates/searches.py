"""The search trees and roots of one subset of taut cables: read, and checked leaf by leaf."""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any

from flint import arb, arb_mat, ctx, fmpq

from certificates import families
from certificates.balance import unbalanced
from certificates.balls import BITS, column, hull, norm, unit
from certificates.cells import Place, no_position, on_branch
from certificates.claims import Pose, check_pose, spoke
from certificates.forms import UNIT, Vector, between, enclosing, units
from certificates.frames import Setting, settings
from certificates.geometry import HALF_TURNS, Turned
from certificates.jets import Jet
from certificates.literals import bounds_of, entry_of, index_of, list_of
from certificates.newton import Zero
from certificates.problem import Listed, Problem
from certificates.roots import System
from certificates.subsets import Kind
from certificates.tree import Cell, Leaf, Node, decode
from certificates.turning import check_turning, never_slack
from certificates.verdicts import Malformed, NotProved

PIECES = 256
"""A leaf is bisected into at most so many parts."""
POSITION_SHARE = 0.4
"""Width of x over the platform's size that counts as much as a width of u, where a cell is bisected."""
Bounds = list[tuple[float, float]]


@dataclass(frozen=True)
class Root:
    """A box of (u, x) in one chart, and the solution whose pose it holds.

    ``end`` : the cable that alone holds the platform at the pose, another one being just tight.
    """

    chart: int
    box: Bounds
    pose: int | None
    end: int | None

    def holds(self, chart: int, entries: Iterable[tuple[Any, Any]]) -> bool:
        """Return True when bounds of (u, x) lie in the box."""
        within = (lo <= a and b <= hi for (a, b), (lo, hi) in zip(entries, self.box, strict=True))
        return self.chart == chart and all(within)


class Search:
    """One frame's trees and roots."""

    def __init__(self, problem: Problem, setting: Setting, entry: Any, solutions: int) -> None:
        self.problem, self.setting = problem, setting
        found = entry_of(entry, "search", ("order", "roots", "trees"))
        n = len(setting.taut)
        self.order = tuple(
            index_of(v, len(problem.names), "order") for v in list_of(found["order"], "order", n)
        )
        if sorted(self.order) != list(setting.taut):
            raise Malformed("order: not the taut cables")
        self.families: list[tuple[Root, Pose]] = []
        """Roots whose families are listed, each with one pose: that of its frames."""
        self.roots = [self.read_root(v, solutions) for v in list_of(found["roots"], "roots")]
        with ctx.workprec(BITS):
            self.platform = setting.cables(problem, self.order)
        self.forms = self.platform.mapped(enclosing)
        self.leaves = [
            leaf
            for chart, tree in enumerate(list_of(found["trees"], "trees", 4))
            for leaf in self.read_tree(chart, tree)
        ]

    def read_root(self, entry: Any, solutions: int) -> Root:
        """Return a root as it is written."""
        found = entry_of(entry, "root", ("chart", "u", "x", "pose", "end"))
        box = [bounds_of(v, "root") for key in ("u", "x") for v in list_of(found[key], key, 3)]
        pose = None if found["pose"] is None else index_of(found["pose"], solutions, "pose")
        end = None if found["end"] is None else index_of(found["end"], len(self.problem.names), "end")
        root = Root(index_of(found["chart"], 4, "chart"), box, pose, end)
        frozen = self.setting.frozen(root.chart)
        flat = None if frozen is None else [*frozen, *([4] if self.setting.planar else [])]
        if flat is None or any(box[k] != (0.0, 0.0) for k in flat):
            raise Malformed("root: its box does not fit its chart")
        return root

    def read_tree(self, chart: int, text: Any) -> Iterator[Leaf]:
        """Yield the leaves of a chart's tree."""
        frozen = self.setting.frozen(chart)
        if frozen is None:
            if text is not None:
                raise Malformed("trees: a tree of a chart that is not needed")
            return
        try:
            content = base64.b64decode(text, validate=True)
        except (TypeError, ValueError, binascii.Error):
            raise Malformed("trees: not base64") from None
        start = Cell(chart, tuple((0.0, 0.0) if k in frozen else (-1.0, 1.0) for k in range(3)))
        yield from decode(content, start, self.reach, self.setting.planar)

    @cached_property
    def reach(self) -> float:
        """The smallest double that is not below the first cable's length."""
        longest = self.problem.lengths[self.order[0]][1]
        found = int(longest.p) / int(longest.q)
        while fmpq(*found.as_integer_ratio()) < longest:
            found = math.nextafter(found, math.inf)
        return found

    def system(self, chart: int) -> System:
        """Return the equations in a chart."""
        return System(self.setting, self.platform, chart)

    def pose(self, system: System, zero: Zero) -> Pose:
        """Return the pose of a zero."""
        rotation, way, densities = system.pose(zero)
        centre = column(self.problem.exits[self.order[0]]) + way
        return Pose(rotation, centre, dict(zip(self.order, densities, strict=True)))

    def coordinates(self, chart: int, rotation: arb_mat, centre: arb_mat) -> list[arb] | None:
        """Return (u, x) of a pose in a chart, or None where the chart may not reach it."""
        base, first = self.setting.base, self.order[0]
        r = base * rotation * self.setting.platform.transpose() * half_turn(chart)
        trace = 1 + r[0, 0] + r[1, 1] + r[2, 2]
        if not trace > 0:
            return None
        u = [(r[2, 1] - r[1, 2]) / trace, (r[0, 2] - r[2, 0]) / trace, (r[1, 0] - r[0, 1]) / trace]
        x = base * (
            centre + rotation * column(self.problem.points[first]) - column(self.problem.exits[first])
        )
        return [*u, *x.entries()]

    def check_root(self, root: Root, solutions: list[Listed]) -> int | None:
        """Check a root and what is listed of its pose; return the solution's index."""
        system = self.system(root.chart)
        if not system.has_one_zero_at_most(forms(root.box)):
            raise NotProved("a root's box is not proved to hold at most one pose")
        zero = system.zero_near([(lo + hi) / 2 for lo, hi in root.box])
        if not lies_in(
            [v.value if isinstance(v, Jet) else v for v in system.jets(zero.entries())[:6]], root.box
        ):
            raise NotProved("the pose near a root's middle is not proved to lie in its box")
        pose = self.pose(system, zero)
        if root.pose is None and root.end is None and self.is_rejected(pose):
            return None
        if self.setting.family:
            return self.check_family(root, pose, solutions)
        if root.end is not None:
            self.check_end(root, root.end)
            return None
        if root.pose is None:
            raise NotProved("a root's pose is not listed and may be a solution")
        listed = solutions[root.pose]
        if listed.family is not None:
            raise NotProved(f"solution {root.pose + 1} is listed as a family but is a single pose")
        check_pose(self.problem, listed, self.setting.taut, pose)
        self.check_alone(root, listed)
        return root.pose

    def check_roots(self, solutions: list[Listed]) -> set[int]:
        """Check all roots; return the solutions they prove."""
        self.families.clear()
        found = {self.check_root(root, solutions) for root in self.roots}
        for (first, pose), (second, other) in combinations(self.families, 2):
            entries = zip(
                [*pose.rotation.entries(), *pose.centre.entries()],
                [*other.rotation.entries(), *other.centre.entries()],
                strict=True,
            )
            where = self.coordinates(second.chart, pose.rotation, pose.centre)
            if first.pose != second.pose and all(a.overlaps(b) for a, b in entries):
                raise NotProved("a family may be listed twice")
            if first.pose == second.pose and (where is None or not lies_in(where, second.box)):
                raise NotProved("one family is listed for roots that may be two")
        return {k for k in found if k is not None}

    def is_rejected(self, pose: Pose) -> bool:
        """Return True for a pose proved not to be static: a cable would push, or another one is too long."""
        if not self.problem.ignore_tension_sign and any(t < 0 for t in pose.densities.values()):
            return True
        lengths = self.problem.lengths
        return any(
            norm(spoke(self.problem, pose, i)[1]) > lengths[i][1]
            for i in range(len(lengths))
            if self.may_be_slack(i)
        )

    def check_alone(self, root: Root, listed: Listed) -> None:
        """Refuse a listed box that does not lie in its root's box: it might hold another pose."""
        rotation = arb_mat([[hull(*b) for b in row] for row in listed.rotation])
        centre = arb_mat([[hull(*b)] for b in listed.position]) + rotation * column(self.problem.centre)
        where = self.coordinates(root.chart, rotation, centre)
        if where is None or not lies_in(where, root.box):
            raise NotProved("a solution's box is not proved to hold one pose only")
        if not self.setting.planar:
            return
        # Only where both cables carry must all lie in the plane.
        found = self.system(root.chart).tensions([enclosing(v) for v in where])
        decided = [k for k, i in enumerate(self.order) if listed.states[i] != "undecided"]
        if found is None or any(abs(units(found[0][k])) <= found[1][k] for k in decided):
            raise NotProved("a solution's box may hold poses at which a cable carries nothing")

    def check_family(self, root: Root, pose: Pose, solutions: list[Listed]) -> int | None:
        """Check a family by one of its poses."""
        if self.setting.vertical and self.setting.rod:
            raise NotProved("families about two axes cannot be checked")
        point, direction = (
            column(self.problem.exits[self.order[0]]),
            column(unit([-v for v in self.problem.load])),
        )
        if self.setting.rod:
            arm = next(self.problem.points[i] for i in self.setting.taut if any(self.problem.points[i]))
            point, direction = pose.centre, pose.rotation * column(unit(arm))
        if root.pose is None:
            never_slack(self.problem, self.setting.taut, pose, point, direction)
        else:
            check_turning(self.problem, solutions[root.pose], self.setting.taut, pose, point, direction)
            self.families.append((root, pose))
        return root.pose

    def check_end(self, root: Root, alone: int) -> None:
        """Refuse a root where the platform is not held by one cable alone, the other having no tension."""
        if sorted(self.order) != sorted({alone, *self.order}) or len(self.order) != 2:
            raise NotProved("only a pose of two cables can be the end of a family")
        ends = families.ends(self.problem, alone, next(i for i in self.order if i != alone))
        places = (self.coordinates(root.chart, end.rotation, end.centre) for end in ends)
        if not any(where is not None and lies_in(where, root.box) for where in places):
            raise NotProved("a root is not proved to be the end of a family")

    def check(self, leaf: Leaf) -> int:
        """Check a leaf, bisected where it must be; return the number of parts."""
        if leaf.node in (Node.PENDING, Node.UNDECIDED):
            return 0
        waiting, parts = [leaf.cell], 0
        while waiting:
            cell = waiting.pop()
            if self.confirmed(leaf, cell):
                parts += 1
                continue
            if leaf.node is Node.CUT or parts + len(waiting) >= PIECES:
                raise NotProved(f"{leaf.node.reason} is not confirmed in chart {cell.chart}, {cell.bounds}")
            waiting += cell.halves(self.longest(cell))
        return parts

    def longest(self, cell: Cell) -> int:
        """Return the entry in which a cell is bisected."""
        share = POSITION_SHARE * float(self.platform.per_unit)
        widths = [(hi - lo) * (1.0 if k < 3 else share) for k, (lo, hi) in enumerate(cell.bounds)]
        return widths.index(max(widths))

    def confirmed(self, leaf: Leaf, cell: Cell) -> bool:
        """Return True when what is said of a leaf is proved over a part of it."""
        entries = forms(cell.bounds)
        turned = Turned(self.forms, cell.chart, entries[:3])
        if cell.placed:
            return self.holds(leaf, cell, turned, entries[3:])
        if leaf.node is Node.NO_POSITION:
            return no_position(turned)
        return all(
            self.on_side(leaf, cell, turned, side) for side in ((cell.side,) if cell.side else (1, -1))
        )

    def on_side(self, leaf: Leaf, cell: Cell, turned: Turned, side: int) -> bool:
        """Return True when what is said of a leaf in u is proved on one side."""
        x = on_branch(turned, side)
        if x is not None and self.holds(leaf, cell, turned, x):
            return True
        return no_position(turned)

    def holds(self, leaf: Leaf, cell: Cell, turned: Turned, x: Vector) -> bool:
        """Return True when what is said of a leaf is proved for an enclosed position."""
        if leaf.node is Node.ROOT:
            place = [(Fraction(v.lowest(), UNIT), Fraction(v.highest(), UNIT)) for v in x]
            return any(root.holds(cell.chart, [*cell.bounds[:3], *place]) for root in self.roots)
        over = Place(turned, x, not cell.placed)
        if leaf.node is Node.NO_LENGTH:
            return over.no_length()
        if leaf.node is Node.CUT:
            assert leaf.kept is not None
            return all(
                over.cut_to(k, old, new)
                for k, (old, new) in enumerate(zip(cell.bounds, leaf.kept.bounds, strict=True))
            )
        if leaf.node is Node.TOO_LONG:
            return self.may_be_slack(leaf.data[0]) and over.positive(
                turned.excess(self.place_of(leaf.data[0]), x)
            )
        if self.problem.ignore_tension_sign:
            return False
        # Part of such a leaf may lie beside all poses with the right lengths, where balance says nothing.
        return (len(over.equations) > 1 and over.no_length()) or unbalanced(over, leaf.data)

    def may_be_slack(self, cable: int) -> bool:
        """Return True for a cable whose slackness is asked for."""
        others = cable < len(self.problem.names) and cable not in self.order
        return others and not self.problem.ignore_slack and not self.setting.family

    def place_of(self, cable: int) -> int:
        """Return the place of a cable that is not taut in the platform's list."""
        return [*self.order, *(i for i in range(len(self.problem.names)) if i not in self.order)].index(cable)


def forms(bounds: Sequence[tuple[float, float]]) -> Vector:
    """Return numbers within bounds, one symbol each."""
    return [between(lo, hi, k) for k, (lo, hi) in enumerate(bounds)]


def lies_in(values: list[arb], box: Bounds) -> bool:
    """Return True when numbers lie within bounds; where these are one number, when they may be it.

    A pose of a plane or family has such entries exactly in one of the mirrored frames, and is far off in
    the other.
    """
    return all(
        v.contains(arb(lo)) if lo == hi else lo <= v and v <= hi
        for v, (lo, hi) in zip(values, box, strict=True)
    )


def half_turn(chart: int) -> arb_mat:
    """Return D_c."""
    return arb_mat([[HALF_TURNS[chart][i] if i == j else 0 for j in range(3)] for i in range(3)])


class Searches:
    """All searches of one subset."""

    def __init__(
        self, problem: Problem, taut: tuple[int, ...], kind: Kind, entry: Any, solutions: list[Listed]
    ) -> None:
        frames = settings(problem, taut, kind)
        given = list_of(entry, "searches", len(frames))
        self.solutions = solutions
        self.searches = [Search(problem, s, e, len(solutions)) for s, e in zip(frames, given, strict=True)]
        self.leaves = [(search, leaf) for search in self.searches for leaf in search.leaves]
        nodes = [leaf.node for _, leaf in self.leaves]
        self.open = nodes.count(Node.PENDING), nodes.count(Node.UNDECIDED)

    def check_roots(self) -> set[int]:
        """Check all roots; return the solutions they prove."""
        return {k for search in self.searches for k in search.check_roots(self.solutions)}

    def check(self, leaf: tuple[Search, Leaf]) -> int:
        """Check a leaf; return the number of parts it took."""
        return leaf[0].check(leaf[1])
