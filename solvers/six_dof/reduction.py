"""The frames and arrays in which a subset of taut cables is searched, family or not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range, RangeVector, difference
from cdpr_interval.exact.vector import cross, is_zero, minus
from cdpr_interval.mechanics.loaded import LoadedRobot
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model, longer_and_shorter
from cdpr_interval.mechanics.six_dof.families import Classification, Kind
from cdpr_interval.mechanics.six_dof.frame import Frame, upward
from solvers.questions.problem import Options
from solvers.six_dof.cells.roots import ABOUT_ROD, ABOUT_VERTICAL, GENERAL, GEOMETRY, PLANAR, Reduction
from solvers.six_dof.cells.subset_search import SubsetSearch
from solvers.six_dof.prepared import Lengths, kind_of
from solvers.six_dof.units import METRES, Units, cells_in_metres, in_units, root_in_metres, units_of

Floats = NDArray[np.float64]

TEMPLATES = 512
"""Most searches kept without their lengths; a model of eight cables takes about 20 kB."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """One search that together with its mirror image covers a taut subset."""

    frame: Frame
    model: Model
    reduction: Reduction
    units: Units = METRES
    """Of the model."""
    own: Model | None = None
    """With the cables' own lengths, where points have ranges: in the same units and in the robot's frames."""
    middle: Frame | None = None
    """The frame for the middle of all data, where it varies with them."""

    def in_metres(self, search: SubsetSearch) -> Reduced:
        """Bring what a search of the model found to m and N; return the model in these."""
        if not self.units:
            return self
        search.roots = [root_in_metres(root, self.units) for root in search.roots]
        search.undecided_position = cells_in_metres(search.undecided_position, self.units)
        model = in_units(self.model, self.units.inverse)
        own = None if self.own is None else in_units(self.own, self.units.inverse)
        assert model is not None  # it came from there
        return replace(self, model=model, own=own, units=METRES)


@dataclass(frozen=True, eq=False)
class Template:
    """A search before the lengths are known."""

    cables: NDArray[np.int64]
    """The model's cables: the taut ones, then those whose slackness is looked at."""
    reduced: Reduced
    """Its model has lengths of 1 and is in m and N; its units are those to search in."""

    def with_lengths(self, lengths: Lengths) -> Reduced:
        """Return the search for these lengths, in units near the platform's size where that is exact."""
        bounds, squares, errors = (array[self.cables] for array in lengths)
        model = self.reduced.model._replace(lengths=bounds, lengths_sq=squares, lengths_sq_err=errors)
        own = None
        if model.gaps.any():
            space = self.reduced.own or model
            own = space._replace(lengths=bounds, lengths_sq=squares, lengths_sq_err=errors, own_points=True)
            bounds, squares, errors = longer_and_shorter(bounds, model.gaps)
            model = model._replace(lengths=bounds, lengths_sq=squares, lengths_sq_err=errors)
        units = self.reduced.units
        moved = in_units(model, units) if units else None
        moved_own = None if own is None or moved is None else in_units(own, units)
        if moved is None or (own is not None and moved_own is None):
            return replace(self.reduced, model=model, units=METRES, own=own)
        return replace(self.reduced, model=moved, own=moved_own)


def reduced_problems(
    loaded: LoadedRobot, lengths: Lengths, options: Options, taut: tuple[int, ...]
) -> list[Reduced]:
    """Return the searches whose roots are all poses of the subset (modulo its family)."""
    found = templates(loaded, taut, not options.ignore_tension_sign, not options.ignore_slack)
    return [template.with_lengths(lengths) for template in found]


@lru_cache(maxsize=TEMPLATES)
def templates(loaded: LoadedRobot, taut: tuple[int, ...], statics: bool, slack: bool) -> tuple[Template, ...]:
    """Return a subset's searches without the lengths."""
    kind = kind_of(loaded, taut)
    family = kind.vertical or kind.rod
    others = () if family else tuple(i for i in range(len(loaded.robot.cables)) if i not in taut)
    cables = np.array((*taut, *others), dtype=np.int64)
    slack = slack and not family
    with balls.precision():
        if kind.kind is Kind.PLANE:
            found = plane_problems(loaded, taut, kind, others, slack)
        else:
            found = [space_problem(loaded, taut, kind, others, statics, slack)]
    return tuple(Template(cables, replace(r, units=units_of(r.model))) for r in found)


def unit_lengths(count: int) -> list[Range]:
    """Return stand-ins for the lengths of a template's cables."""
    return [Range.exact(1)] * count


def space_problem(
    loaded: LoadedRobot,
    taut: tuple[int, ...],
    kind: Classification,
    others: tuple[int, ...],
    statics: bool,
    slack: bool,
) -> Reduced:
    """Return the search of a subset that lies in no plane."""
    if kind.kind is Kind.ABOUT_VERTICAL:
        frame, reduction = vertical_frame(loaded, taut), ABOUT_VERTICAL
    elif kind.kind is Kind.ABOUT_ROD:
        frame, reduction = rod_frame(loaded, taut), ABOUT_ROD
    else:
        frame = Frame.plain()
        reduction = GEOMETRY if len(taut) == 6 else GENERAL
    arms = [frame.arm(loaded.arm_ranges[i]) for i in (*taut, *others)]
    if kind.kind is Kind.ABOUT_ROD:
        arms = [on_axis(p, 2) for p in arms]
    load = frame.force(loaded.load_direction_ranges)
    exits = [frame.exit_point(loaded.exit_ranges[i]) for i in (*taut, *others)]
    if kind.kind is Kind.ABOUT_VERTICAL:
        load, exits = on_axis(load, 2), [on_axis(a, 2) for a in exits]
    lengths = unit_lengths(len(arms))
    spread = not loaded.spread.points_are_exact
    centre = shared_sides(loaded, frame) if spread else None
    model = build_model(
        exits, arms, lengths, load, len(taut), statics=statics, slack=slack, spread=spread, centre=centre
    )
    return Reduced(frame, model, reduction)


def shared_sides(loaded: LoadedRobot, frame: Frame) -> Floats | None:
    """Return by how much the centre of mass may move all arms, (3,); None where the frame turns them."""
    if not frame.bounds.plain:
        return None
    return np.array([enclose(x.width / 2)[1] for x in loaded.centre_ranges])


def on_axis(v: RangeVector, axis: int) -> RangeVector:
    """Return a vector that is known to lie on an axis, its other entries exactly zero."""
    nought = Range.exact(0)
    return (v[0] if axis == 0 else nought, v[1] if axis == 1 else nought, v[2] if axis == 2 else nought)


def in_plane(v: RangeVector) -> RangeVector:
    """Return a vector that is known to lie in the plane y = 0."""
    return (v[0], Range.exact(0), v[2])


def is_downward(load: RangeVector) -> bool:
    """Return True for a load exactly along -z."""
    return not any(load[0]) and not any(load[1]) and load[2].hi < 0


def vertical_frame(loaded: LoadedRobot, taut: tuple[int, ...]) -> Frame:
    """Return the frame with z upward on the line of the taut exit points."""
    origin = loaded.exit_ranges[taut[0]]
    if is_downward(loaded.load_direction_ranges):
        return Frame(origin, balls.identity(), balls.identity())
    z_first = balls.right_handed(upward(loaded.load_direction_ranges)).transpose()
    return Frame(origin, cyclic() * z_first, balls.identity())


def cyclic() -> arb_mat:
    """Return the rotation that sends x to z, y to x and z to y."""
    return arb_mat([[0, 1, 0], [0, 0, 1], [1, 0, 0]])


def rod_frame(loaded: LoadedRobot, taut: tuple[int, ...]) -> Frame:
    """Return the frame whose platform z axis carries the taut platform points."""
    nought = Range.exact(0)
    platform = cyclic() * balls.right_handed(rod_axis(loaded, taut)).transpose()
    return Frame((nought, nought, nought), balls.identity(), platform)


def rod_axis(loaded: LoadedRobot, taut: tuple[int, ...]) -> arb_mat:
    """Return the unit direction of the line of the taut platform points, platform frame."""
    v = next(balls.ranges(arm) for arm in (loaded.arm_ranges[i] for i in taut) if any(map(any, arm)))
    return v * (1 / balls.norm(v))


def plane_problems(
    loaded: LoadedRobot, taut: tuple[int, ...], kind: Classification, others: tuple[int, ...], slack: bool
) -> list[Reduced]:
    """Return the planar searches: base z upward, exit points and taut platform points in y = 0.

    The platform's plane can face either way: two mirrored searches, one where a family turns one
    into the other.
    """
    origin = loaded.exit_ranges[taut[0]]
    base = plane_base(loaded, taut)
    platform = plane_platform(loaded, taut, kind)
    mirrored = arb_mat([[1, 0, 0], [0, -1, 0], [0, 0, -1]]) * platform
    found = []
    for turned in [platform] if kind.vertical or kind.rod else [platform, mirrored]:
        frame = Frame(origin, base, turned)
        everyone = (*taut, *others)
        arms = [frame.arm(loaded.arm_ranges[i]) for i in everyone]
        exits = [frame.exit_point(loaded.exit_ranges[i]) for i in everyone]
        flat = len(taut)
        arms[:flat] = [on_axis(p, 0) if kind.rod else in_plane(p) for p in arms[:flat]]
        exits[:flat] = [on_axis(a, 2) if kind.vertical else in_plane(a) for a in exits[:flat]]
        if not (loaded.spread.points_are_exact or kind.vertical or kind.rod):
            exits[:2] = plane_exits(loaded, taut)
            arms[:2] = plane_arms(loaded, taut, mirrored=turned is not platform)
        model = build_model(
            exits,
            arms,
            unit_lengths(len(everyone)),
            on_axis(frame.force(loaded.load_direction_ranges), 2),
            flat,
            planar=True,
            slack=slack,
            spread=not loaded.spread.points_are_exact,
        )
        found.append(Reduced(frame, model, PLANAR))
    if loaded.spread.points_are_exact or kind.vertical or kind.rod:
        return found
    space = space_problem(loaded, taut, kind, others, True, slack)
    seen = plane_problems(loaded.middle, taut, kind, others, slack)
    return [replace(r, own=space.model, middle=m.frame) for r, m in zip(found, seen, strict=True)]


def plane_base(loaded: LoadedRobot, taut: tuple[int, ...]) -> arb_mat:
    """Return the rotation whose rows are x (horizontal, in the plane), y (its normal), z (up)."""
    up = upward(loaded.load_direction_ranges)
    x = horizontal_step(loaded, taut)
    if x is None:
        rows = balls.right_handed(up)
        return cyclic() * rows.transpose()
    x = x * (1 / balls.norm(x))
    return balls.columns(x, balls.cross(up, x), up).transpose()


def horizontal_step(loaded: LoadedRobot, taut: tuple[int, ...]) -> arb_mat | None:
    """Return the horizontal part of A_2 - A_1, scaled by |f|^2; None where it vanishes."""
    f, d = loaded.load_direction_ranges, difference(loaded.exit_ranges[taut[1]], loaded.exit_ranges[taut[0]])
    exact = loaded.middle
    # f x (d x f) = |f|^2 d - (f . d) f
    if is_zero(cross(exact.load, cross(minus(exact.exits[taut[1]], exact.exits[taut[0]]), exact.load))):
        return None
    ball = balls.ranges(f)
    return balls.cross(ball, balls.cross(balls.ranges(d), ball))


def plane_exits(loaded: LoadedRobot, taut: tuple[int, ...]) -> list[RangeVector]:
    """Return two exit points with ranges in the frame of the plane that each choice of them has."""
    up = upward(loaded.load_direction_ranges)
    d = balls.ranges(difference(loaded.exit_ranges[taut[1]], loaded.exit_ranges[taut[0]]))
    rise = balls.dot(up, d)
    return [in_plane_at(arb(0), arb(0)), in_plane_at(balls.norm(balls.cross(up, d)), rise)]


def plane_arms(loaded: LoadedRobot, taut: tuple[int, ...], mirrored: bool) -> list[RangeVector]:
    """Return two arms with ranges in the frame of the plane that each choice of them has."""
    b1, b2 = (balls.ranges(loaded.arm_ranges[i]) for i in taut)
    size = balls.norm(b1)
    across = balls.norm(balls.cross(b1, b2)) / size
    return [in_plane_at(size, arb(0)), in_plane_at(balls.dot(b1, b2) / size, across if mirrored else -across)]


def in_plane_at(x: arb, z: arb) -> RangeVector:
    """Return a vector in the plane y = 0."""
    return (balls.to_range(x), Range.exact(0), balls.to_range(z))


def plane_platform(loaded: LoadedRobot, taut: tuple[int, ...], kind: Classification) -> arb_mat:
    """Return the rotation that lays the taut platform points and the centre of mass into y = 0."""
    if kind.rod:
        return balls.right_handed(rod_axis(loaded, taut)).transpose()
    b1, b2 = (balls.ranges(loaded.arm_ranges[i]) for i in taut[:2])
    first = rod_axis(loaded, taut)
    normal = balls.cross(b1, b2)
    normal = normal * (1 / balls.norm(normal))
    return balls.columns(first, normal, balls.cross(first, normal)).transpose()
