"""Where the common point of some cables rests: the lowest point, along the load, that their lengths allow.

With a_i = p - A_i and multipliers t_i >= 0 the point p is static when sum t_i a_i = f. Inextensible cables:
|a_i| <= l_i, and t_i = 0 where |a_i| < l_i. These are the conditions of Karush, Kuhn and Tucker of a convex
problem whose Lagrangian is strictly convex, so there is one such p at most. Elastic cables: t_i is
k_i max(0, 1 - l_i / |a_i|): the gradient of a convex energy is zero, and an isolated zero is the only one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from flint import arb, arb_mat, ctx, fmpq, fmpq_mat

from certificates import newton
from certificates.arithmetic.balls import BITS, Vector, column, hull, minus, norm
from certificates.arithmetic.vectors import dot
from certificates.claims import Pose, check_pose, claimed
from certificates.clock import in_time
from certificates.literals import entry_of, exact, exacts, index_of, list_of
from certificates.problem import Listed, Problem
from certificates.verdicts import Malformed, NotProved

Point = tuple[arb_mat, dict[int, arb]]
"""The point (3, 1), and t_i of the cables that are not proved slack there."""
IDENTITY = arb_mat(3, 3, [1, 0, 0, 0, 1, 0, 0, 0, 1])
MOST_CUTS = 40


def check_point(problem: Problem, taut: Sequence[int], entry: Any, solutions: list[Listed]) -> set[int]:
    """Check an entry of a point mass; return the solutions it proves.

    Without ``ignore_slack`` it is about all cables together, and ``taut`` says whose pose is asked for.
    """
    (chosen,), proof = pose_indices(problem, entry, solutions, 1)
    with ctx.workprec(BITS):
        if proof == {"kind": "dependent"}:
            # A smaller subset holds the pose: that says something only where it is examined.
            examined = problem.ignore_slack and problem.taut is None
            if chosen is not None or not examined or not is_dependent(problem, taut):
                raise NotProved("the wrenches of these cables are not proved dependent")
            return set()
        cables = taut if problem.ignore_slack else range(len(problem.names))
        for part, found in lowest_points(problem, cables, proof):
            if chosen is None:
                check_absent(part, taut, found)
            else:
                check_present(part, taut, found, solutions[chosen])
    return set() if chosen is None else {chosen}


def pose_indices(
    problem: Problem, entry: Any, solutions: list[Listed], count: int
) -> tuple[list[int | None], Any]:
    """Return the solutions that an entry points to (None: proved absent), and its proof."""
    if problem.ignore_tension_sign:
        raise NotProved("a lowest point says nothing about tensions of any sign")
    chosen, proof = entry_of(entry, "point", ("poses", "proof")).values()
    poses = list_of(chosen, "poses", count)
    return [None if i is None else index_of(i, len(solutions), "poses") for i in poses], proof


def check_absent(problem: Problem, taut: Sequence[int], found: Point | None) -> None:
    """Raise NotProved unless the cables ``taut`` have no pose, their lowest point being known."""
    if found is None:
        return
    densities = found[1]
    others = any(t > 0 for i, t in densities.items() if i not in taut)
    named = problem.ignore_slack or problem.taut is not None
    if not (named and (others or any(i not in densities for i in taut))):
        raise NotProved("a pose of these cables is not excluded")


def check_present(problem: Problem, taut: Sequence[int], found: Point | None, listed: Listed) -> None:
    """Raise NotProved unless the lowest point is the listed pose."""
    if found is None:
        raise NotProved("solution claims a pose of cables that have no common point")
    carrying = [i for i, t in found[1].items() if t > 0]
    if problem.ignore_slack:
        claimed(set(carrying) == set(taut), "the pose of other cables")
    claimed(set(listed.taut) <= set(taut), "other taut cables than asked for")
    outside = not problem.ignore_slack and any(found[1][i] > 0 for i in carrying if i not in taut)
    claimed(not outside, "a pose at which another cable carries")
    slack = problem.taut is not None and any(listed.states[i] == "slack" for i in taut)
    claimed(not slack, "slack a cable that is asked to be taut")
    check_pose(problem, listed, carrying, Pose(IDENTITY, *found))


def is_dependent(problem: Problem, taut: Sequence[int]) -> bool:
    """Return True when the wrenches of inextensible cables are dependent wherever they balance the load.

    There p - A_0 is a combination of f and all A_i - A_0, and so are all p - A_i.
    """
    first, *others = [problem.exits[i] for i in taut]
    rows = [[x - y for x, y in zip(a, first, strict=True)] for a in others]
    return not problem.is_elastic and fmpq_mat([*rows, problem.load]).rank() < len(taut)


def lowest_points(
    problem: Problem, cables: Sequence[int], proof: Any, cuts: int = 0
) -> Iterator[tuple[Problem, Point | None]]:
    """Yield the lowest point for each part of the length ranges; None where there is proved to be none."""
    in_time()
    kind = proof.get("kind") if isinstance(proof, dict) else None
    if kind == "parts":
        _, cable, at, parts = entry_of(proof, "parts", ("kind", "cable", "at", "parts")).values()
        i, cut = index_of(cable, len(problem.names), "cable"), exact(at)
        lo, hi = problem.lengths[i]
        if cuts == MOST_CUTS or not lo <= cut <= hi or not isinstance(parts, list) or len(parts) != 2:
            raise Malformed("wrong cut of a length range")
        for half, part in zip(((lo, cut), (cut, hi)), parts, strict=True):
            lengths = [*problem.lengths[:i], half, *problem.lengths[i + 1 :]]
            yield from lowest_points(replace(problem, lengths=lengths), cables, part, cuts + 1)
        return
    proofs = {"newton": by_newton, "duality": by_duality, "weights": by_weights}
    if not isinstance(kind, str) or kind not in proofs:
        raise Malformed("unknown kind of proof")
    if kind != "newton" and any(problem.stiffness[i] is not None for i in cables):
        raise NotProved(f"{kind} proves nothing about elastic cables")
    yield problem, proofs[kind](problem, cables, proof)


def by_weights(problem: Problem, cables: Sequence[int], proof: Any) -> None:
    """Prove that no point lies in all balls: sum w_i (|p - A_i|^2 - l_i^2) > 0 for every p."""
    w = exacts(entry_of(proof, "weights", ("kind", "weights"))["weights"], len(cables))
    if min(w) < 0 or not any(x > 0 for x in w):
        raise Malformed("weights must be non-negative, and one positive")
    exits = [problem.exits[i] for i in cables]
    mean = [dot(w, x) / sum(w, fmpq(0)) for x in zip(*exits, strict=True)]
    powers = [square(mean, a) - problem.lengths[i][1] ** 2 for i, a in zip(cables, exits, strict=True)]
    if not dot(w, powers) > 0:
        raise NotProved("the weights do not prove that there is no common point")


def square(a: Sequence[fmpq], b: Sequence[fmpq]) -> fmpq:
    """Return |a - b|^2 exactly."""
    return sum(((x - y) ** 2 for x, y in zip(a, b, strict=True)), fmpq(0))


def by_duality(problem: Problem, cables: Sequence[int], proof: Any) -> Point:
    """Enclose the lowest point without saying which cables are taut.

    q strictly inside all balls: point and multipliers exist (Slater). For t >= 0 with sum T the Lagrangian
    is d + T/2 |p - c|^2, so T/2 |p* - c|^2 <= gap = -f . q - d. All multipliers have
    t_i (l_i^2 - |q - A_i|^2) <= 2 gap, as the products of sum t_i (p - A_i) = f with p - q show.
    A normal y bounds t_k by y . f = sum t_i y . (p - A_i).
    """
    keys = ("kind", "inner", "densities", "normals")
    _, inner, weights, normals = entry_of(proof, "duality", keys).values()
    q, t, f = exacts(inner, 3), exacts(weights, len(cables)), problem.load
    exits = [problem.exits[i] for i in cables]
    rooms = [problem.lengths[i][0] ** 2 - square(q, a) for i, a in zip(cables, exits, strict=True)]
    total = sum(t, fmpq(0))
    if min(rooms) <= 0 or min(t) < 0 or total <= 0:
        raise NotProved("the inner point or the multipliers are not feasible")
    c = [(x + dot(t, a)) / total for x, a in zip(f, zip(*exits, strict=True), strict=True)]
    powers = [square(c, a) - problem.lengths[i][1] ** 2 for i, a in zip(cables, exits, strict=True)]
    gap = dot(f, c) - dot(f, q) - dot(t, powers) / 2
    radius = arb(2 * gap / total).sqrt()
    point = [x + hull(-1, 1) * radius for x in c]
    most = {i: hull(fmpq(0), 2 * gap / room) for i, room in zip(cables, rooms, strict=True)}
    arms = {i: minus(point, problem.exits[i]) for i in cables}
    near = [i for i in cables if not norm(arms[i]) < problem.lengths[i][0]]
    densities = {i: most[i] for i in near}
    for i, normal in zip(cables, list_of(normals, "normals", len(cables)), strict=True):
        if i in near and normal is not None:
            y = exacts(normal, 3)
            others = sum((most[j] * dot(y, arms[j]) for j in near if j != i), arb(0))
            densities[i] = (dot(y, f) - others) / dot(y, arms[i])
    return column(point), densities


def by_newton(problem: Problem, cables: Sequence[int], proof: Any) -> Point:
    """Enclose the lowest point by a Krawczyk operator, from a start x = (p, t)."""
    _, start, scale = entry_of(proof, "newton", ("kind", "start", "scale")).values()
    try:
        system = System(problem, cables, exact(scale))
        x = newton.zero(system.equations, [arb(v) for v in exacts(start, 3 + len(cables))]).entries()
    except ZeroDivisionError:
        raise NotProved("the lowest point is not proved: singular") from None
    sizes = [norm(a) for a in system.arms(x)]
    may_carry = [not r < problem.lengths[i][0] for i, r in zip(cables, sizes, strict=True)]
    return column(x[:3]), {i: t for i, t, m in zip(cables, x[3:], may_carry, strict=True) if m}


class System:
    """The equations in x = (p, t): sum t_i a_i = f, and one for each cable.

    Inextensible: min(s t_i, (l_i^2 - |a_i|^2) / 2) = 0 with any s > 0.
    Elastic: k_i max(0, 1 - l_i / |a_i|) - t_i = 0.
    """

    def __init__(self, problem: Problem, cables: Sequence[int], scale: fmpq) -> None:
        if not scale > 0:
            raise Malformed("a scale must be positive")
        self.load = problem.load
        self.exits = [problem.exits[i] for i in cables]
        self.lengths = [hull(*problem.lengths[i]) for i in cables]
        self.scales = [scale * problem.lengths[i][1] ** 3 / sum(map(abs, problem.load)) for i in cables]
        self.stiffness = [problem.stiffness[i] for i in cables]

    def arms(self, x: Vector) -> list[Vector]:
        """Return a_i = p - A_i."""
        return [minus(x[:3], a) for a in self.exits]

    def equations(self, x: Vector, axes: arb_mat) -> tuple[arb_mat, arb_mat]:
        """Return values over a box, and slopes for any two of its points along ``axes``' columns."""
        arms, t, directions = self.arms(x), x[3:], axes.transpose().tolist()
        values = [dot(t, part) - f for part, f in zip(zip(*arms, strict=True), self.load, strict=True)]
        total = sum(t, arb(0))
        rows = [[total if j == k else arb(0) for k in range(3)] + [a[j] for a in arms] for j in range(3)]
        slopes = (arb_mat(rows) * axes).tolist()
        for k, (a, length, spring) in enumerate(zip(arms, self.lengths, self.stiffness, strict=True)):
            if spring is None:
                room, push = (length**2 - dot(a, a)) / 2, self.scales[k] * t[k]
                share = open_share(push - room)
                along = [(-dot(a, d[:3]), self.scales[k] * d[3 + k]) for d in directions]
                values.append(arb.min(room, push))
                slopes.append([p + share * (r - p) for r, p in along])
            else:
                rho, constant = norm(a), spring[0] / length if spring[1] else arb(spring[0])
                change = open_share(rho - length) * constant * length / rho**3
                values.append(constant * arb.max(arb(0), 1 - length / rho) - t[k])
                slopes.append([change * dot(a, d[:3]) - d[3 + k] for d in directions])
        return column(values), arb_mat(slopes)


def open_share(x: arb) -> arb:
    """Return 1 where x > 0, 0 where x < 0, else [0, 1]."""
    return arb(1) if x > 0 else arb(0) if x < 0 else hull(0, 1)
