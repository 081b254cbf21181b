"""The question of a certificate and the solutions it lists."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any

from flint import fmpq

from certificates.literals import bounds_of, choice_of, entry_of, exact, exacts, index_of, list_of, text_of
from certificates.verdicts import Malformed

Bounds = tuple[float, float]
Exact = list[fmpq]
FORMAT = "cdpr-certificate/1"
DOCUMENT = ("format", "tool", "claim", "robot", "lengths_m", "external_force_N", "question")
LISTS = ("solutions", "subsets", "not_certified")
ROBOT = ("name", "sha256", "gravity_m_s2", "mass_kg", "centre_of_mass_m", "cables")
ELASTIC = ("stiffness_N_per_m", "axial_stiffness_N")
MOST_CABLES = 64
MOST_SOLUTIONS = 10_000
MOST_RANGES = 64
"""Of the angles of one family."""
CABLE_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]{0,99}")
"""As in `cdpr-robot/1`: a name stands in the verdict and must not speak."""
SHOWN = 100
"""Most characters of a text from the file in what is printed."""


@dataclass(frozen=True)
class Pulley:
    """A pulley on one joint, whose arm is its radius."""

    radius: fmpq
    axis: Exact
    """The rope's direction as it arrives, of any length but zero."""
    before: fmpq
    """Of the rope, from where it starts to the exit point, which lies on the axis."""


@dataclass(frozen=True)
class Problem:
    """A robot, its lengths and the question: all numbers exact."""

    names: tuple[str, ...]
    exits: list[Exact]
    points: list[Exact]
    centre: Exact
    lengths: list[tuple[fmpq, fmpq]]
    stiffness: list[tuple[fmpq, bool] | None]
    mass: fmpq
    gravity: Exact
    load: Exact
    taut: tuple[int, ...] | None
    ignore_slack: bool
    ignore_tension_sign: bool
    pulleys: tuple[Pulley | None, ...] = ()
    """One for each cable; none where there is no pulley at all."""

    @property
    def is_routed(self) -> bool:
        """True for a platform with a cable over a pulley."""
        return bool(self.pulleys)

    @property
    def is_point_mass(self) -> bool:
        """True when every platform anchor is the centre of mass."""
        return not any(x != 0 for point in self.points for x in point)

    @property
    def is_elastic(self) -> bool:
        """True when some cable stretches."""
        return any(entry is not None for entry in self.stiffness)


@dataclass(frozen=True)
class Turning:
    """The family of a solution."""

    kind: str
    axis_point: list[Bounds] | None
    axis_direction: list[Bounds] | None
    angle_ranges: list[tuple[Bounds, Bounds]]


@dataclass(frozen=True)
class Listed:
    """A solution as the certificate lists it."""

    taut: tuple[int, ...]
    states: tuple[str, ...]
    position: list[Bounds]
    rotation: list[list[Bounds]]
    height: Bounds
    tensions: list[Bounds]
    distances: list[Bounds]
    slack_respected: bool | None
    stability: str
    family: Turning | None


def needed(holds: bool, what: str) -> None:
    """Raise Malformed unless a rule of the format holds."""
    if not holds:
        raise Malformed(what)


def read_problem(document: Any) -> Problem:
    """Return the question of a document, whose solutions and subsets are not looked at."""
    found = entry_of(document, "certificate", (*DOCUMENT, *LISTS))
    text_of(found["format"], "format", [FORMAT])
    text_of(found["claim"], "claim")
    for key, value in entry_of(found["tool"], "tool", ("name", "version")).items():
        text_of(value, key)
    robot = entry_of(found["robot"], "robot", ROBOT)
    for key in ("name", "sha256"):
        text_of(robot[key], key)
    cables = list_of(robot["cables"], "cables")
    needed(1 <= len(cables) <= MOST_CABLES, f"1 to {MOST_CABLES} cables are needed")
    mass, centre = exact(robot["mass_kg"]), exacts(robot["centre_of_mass_m"], 3)
    gravity, force = exacts(robot["gravity_m_s2"], 3), exacts(found["external_force_N"], 3)
    found_cables = (read_cable(cable, centre) for cable in cables)
    names, exits, points, stiffness, pulleys = zip(*found_cables, strict=True)
    question = entry_of(found["question"], "question", ("taut", "ignore_slack", "ignore_tension_sign"))
    lengths = [exacts(v, 2) for v in list_of(found["lengths_m"], "lengths_m", len(cables))]
    problem = Problem(
        names=names,
        exits=list(exits),
        points=list(points),
        centre=centre,
        lengths=[(lo, hi) for lo, hi in lengths],
        stiffness=list(stiffness),
        mass=mass,
        gravity=gravity,
        load=[mass * g + extra for g, extra in zip(gravity, force, strict=True)],
        taut=None if question["taut"] is None else read_taut(question["taut"], len(cables)),
        ignore_slack=choice_of(question["ignore_slack"], "ignore_slack"),
        ignore_tension_sign=choice_of(question["ignore_tension_sign"], "ignore_tension_sign"),
        pulleys=pulleys if any(pulleys) else (),
    )
    needed(len(set(names)) == len(names), "two cables have one name")
    needed(all(0 < lo <= hi for lo, hi in problem.lengths), "a length is not positive, or its range is empty")
    needed(mass > 0 and any(x != 0 for x in problem.load), "the mass must be positive, the load not zero")
    elastic = [entry is not None for entry in stiffness]
    needed(all(elastic) or not any(elastic), "elastic and inextensible cables in one robot")
    needed(problem.is_point_mass or not problem.is_elastic, "elastic cables of a platform")
    needed(not (problem.is_point_mass and problem.pulleys), "pulleys of a point mass")
    if problem.is_routed:
        require_routed(problem)
    most = 6 if not problem.is_point_mass else len(names) if problem.is_elastic else 3
    needed(problem.taut is None or len(problem.taut) <= most, "too many taut cables are asked for")
    legs = not problem.is_point_mass and problem.taut is not None and len(problem.taut) == 6
    needed(legs or not problem.ignore_tension_sign, "tensions of any sign need six taut cables of a platform")
    return problem


def require_routed(problem: Problem) -> None:
    """Refuse what this format does not say of cables over pulleys."""
    needed(all(lo == hi for lo, hi in problem.lengths), "ranges of lengths over pulleys")
    needed(not problem.ignore_tension_sign, "cables over pulleys that push")
    long = (p is None or hi > p.before for (_, hi), p in zip(problem.lengths, problem.pulleys, strict=False))
    needed(all(long), "a cable ends before its pulley")


def described(document: dict[str, Any], problem: Problem) -> tuple[str, ...]:
    """Return what a document is about, as it says itself, to be printed beside the verdict."""
    robot, asked = document["robot"], "all subsets"
    if problem.taut is not None:
        asked = "subset " + ",".join(problem.names[i] for i in problem.taut)
    asked += ", slackness ignored" * problem.ignore_slack + ", signs ignored" * problem.ignore_tension_sign
    pairs = zip(problem.names, document["lengths_m"], strict=True)
    lengths = (f"{name} {lo if lo == hi else f'{lo}..{hi}'}" for name, (lo, hi) in pairs)
    return (
        f"robot {quoted(robot['name'])}, sha256 {quoted(robot['sha256'])}",
        f"lengths_m {', '.join(lengths)}",
        f"external_force_N {', '.join(document['external_force_N'])}; {asked}",
    )


def quoted(text: str) -> str:
    """Return a text of the file in ASCII between quotes, which it cannot leave."""
    return json.dumps(text[:SHOWN]) + ("..." if len(text) > SHOWN else "")


def read_cable(
    value: Any, centre: Exact
) -> tuple[str, Exact, Exact, tuple[fmpq, bool] | None, Pulley | None]:
    """Return name, exit point, platform point from the centre of mass, stiffness (axial or not), pulley."""
    given = [key for key in ELASTIC if isinstance(value, dict) and key in value][:1]
    more = ["pulley"] if isinstance(value, dict) and "pulley" in value else []
    found = entry_of(value, "cable", ("name", "frame_anchor_m", "platform_anchor_m", *given, *more))
    spring = (exact(found[given[0]]), given[0] == ELASTIC[1]) if given else None
    needed(spring is None or spring[0] > 0, "a stiffness is not positive")
    point = [b - c for b, c in zip(exacts(found["platform_anchor_m"], 3), centre, strict=True)]
    name = text_of(found["name"], "name")
    needed(CABLE_NAME.fullmatch(name) is not None, f"{quoted(name)} is no name of a cable")
    pulley = read_pulley(found["pulley"]) if more else None
    return name, exacts(found["frame_anchor_m"], 3), point, spring, pulley


def read_pulley(value: Any) -> Pulley:
    """Return a pulley."""
    radius, axis, before = entry_of(value, "pulley", ("radius_m", "axis", "lead_in_m")).values()
    pulley = Pulley(exact(radius), exacts(axis, 3), exact(before))
    needed(
        pulley.radius > 0 and pulley.before >= 0, "a pulley's radius is not positive, or its lead-in negative"
    )
    needed(any(x != 0 for x in pulley.axis), "a pulley's axis has no direction")
    return pulley


def read_taut(value: Any, count: int, least: int = 1) -> tuple[int, ...]:
    """Return cables in ascending order."""
    taut = tuple(index_of(v, count, "taut") for v in list_of(value, "taut"))
    needed(len(taut) >= least and list(taut) == sorted(set(taut)), "taut: cables are not in ascending order")
    return taut


def read_solutions(document: Any, problem: Problem) -> list[Listed]:
    """Return the listed solutions of a document."""
    given = list_of(document["solutions"], "solutions")
    needed(len(given) <= MOST_SOLUTIONS, f"more than {MOST_SOLUTIONS} solutions")
    return [read_solution(value, len(problem.names)) for value in given]


def read_solution(value: Any, count: int) -> Listed:
    """Return a solution of a robot with so many cables."""
    keys = ("taut", "states", "position_m", "rotation", "height_m", "tensions_N", "distances_m")
    found = entry_of(value, "solution", (*keys, "slack_respected", "stability", "family"))
    words = ("taut", "slack", "undecided")
    states = tuple(text_of(v, "state", words) for v in list_of(found["states"], "states", count))
    listed = Listed(
        taut=read_taut(found["taut"], count, least=0),
        states=states,
        position=bounds_list(found["position_m"], "position_m", 3),
        rotation=[bounds_list(row, "rotation", 3) for row in list_of(found["rotation"], "rotation", 3)],
        height=bounds_of(found["height_m"], "height_m"),
        tensions=bounds_list(found["tensions_N"], "tensions_N", count),
        distances=bounds_list(found["distances_m"], "distances_m", count),
        slack_respected=choice_of(found["slack_respected"], "slack_respected", (True, False, None)),
        stability=text_of(found["stability"], "stability", ("stable", "unstable", "undecided")),
        family=None if found["family"] is None else read_family(found["family"]),
    )
    needed(all((s == "taut") == (i in listed.taut) for i, s in enumerate(states)), "taut and states differ")
    return listed


def read_left_out(document: Any, problem: Problem) -> list[str]:
    """Return the reasons of the found poses that are not certified, one for each."""
    found = []
    for value in list_of(document["not_certified"], "not_certified"):
        taut, reason = entry_of(value, "not_certified", ("taut", "reason")).values()
        read_taut(taut, len(problem.names), least=0)
        found.append(text_of(reason, "reason"))
    return found


def read_family(value: Any) -> Turning:
    """Return a family."""
    keys = ("kind", "axis_point_m", "axis_direction", "angle_ranges_rad")
    kind, point, direction, ranges = entry_of(value, "family", keys).values()
    turns = text_of(kind, "kind", ("rotation", "all-rotations")) == "rotation"
    needed(turns or (point is None and direction is None and ranges == []), "all rotations have no axis")
    needed(len(list_of(ranges, "angles")) <= MOST_RANGES, f"more than {MOST_RANGES} ranges of angles")
    return Turning(
        kind=kind,
        axis_point=bounds_list(point, "axis_point_m", 3) if turns else None,
        axis_direction=bounds_list(direction, "axis_direction", 3) if turns else None,
        angle_ranges=[(a, b) for a, b in (bounds_list(v, "angles", 2) for v in list_of(ranges, "angles"))],
    )


def bounds_list(value: Any, what: str, count: int) -> list[Bounds]:
    """Return a list of so many bounds."""
    return [bounds_of(v, what) for v in list_of(value, what, count)]
