"""What is allowed in a robot, and yet hardly meant: millimetres typed as metres, springs in N/mm.

A doubt is one sentence. It never stops anything: somebody may really have such a robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations

from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Cable, Robot
from cdpr_interval.robots.numbers import Point, Scalar

FARTHEST_ANCHOR = 1.5
"""Frame widths from the platform's origin to an anchor: Dietmaier's platform comes to 1.2."""
LARGEST_FRAME = 1000.0
"""m between exit points: the widest cable robot built, the telescope FAST, has 600."""
SMALLEST_PLATFORM = 1000.0
"""Times that a frame is wider than its platform: a camera on a stadium's cables comes to some 700."""
FARTHEST_CENTRE = 50.0
"""Sizes of the platform between its anchors and its centre of mass: a hook on a long sling comes to ten."""
LIGHTEST = 0.05
"""kg/m2 of a platform over its size squared: paper has 0.08."""
STRONGEST_GRAVITY = 100.0
"""m/s2; the Earth's in mm/s2 is 9810."""
NEARLY_EQUAL = 1e-6
"""Of the frame: anchors so near to the centre of mass are meant to be there."""
IN_MILLIMETRES = 10.0
"""Frame widths: nearer anchors may be of the base frame; in millimetres those of a small platform are ten."""
MILLIMETRES = "in millimetres? Keys that end in _m are in metres: divide by 1000"


def doubts(robot: Robot) -> list[str]:
    """Return what is hardly meant in the data of a robot, a sentence each."""
    return [*_frame(robot), *_platform(robot), *_cables(robot)]


def _frame(robot: Robot) -> Iterator[str]:
    """Yield doubts about exit points and gravity."""
    size = _extent([cable.frame_anchor for cable in robot.cables])
    if size >= LARGEST_FRAME:
        yield f"frame_anchor_m: exit points are {_m(size)} apart: {MILLIMETRES}"
    gravity = _norm(robot.gravity)
    if gravity > STRONGEST_GRAVITY:
        yield f"gravity_m_s2: is {gravity:.4g} m/s2 strong: in mm/s2? Divide by 1000"


def _platform(robot: Robot) -> Iterator[str]:
    """Yield doubts about platform anchors, centre of mass and mass."""
    frame = _extent([cable.frame_anchor for cable in robot.cables])
    anchors = [cable.platform_anchor for cable in robot.cables]
    size, centre = _extent(anchors), robot.platform.centre_of_mass
    far = [
        cable for cable in robot.cables if frame and _norm(cable.platform_anchor) > FARTHEST_ANCHOR * frame
    ]
    if far:
        yield _far_anchors(far, frame)
    off = _distance(centre, _middle(anchors))
    if frame and not robot.is_point_mass and max(size, off) < NEARLY_EQUAL * frame:
        near = f"all are within {_m(max(size, off))} of centre_of_mass_m, and not equal to it"
        yield f"platform_anchor_m: {near}: equal decimals make a point mass, this is a platform that turns"
        return
    if size and frame > SMALLEST_PLATFORM * size and frame < LARGEST_FRAME:
        wide = f"exit points are {_m(frame)} apart, platform anchors {_m(size)}"
        yield f"frame_anchor_m: {wide}: are some in millimetres?"
    if size and off > FARTHEST_CENTRE * size:
        apart = f"is {_m(off)} from the platform anchors, which are {_m(size)} apart"
        yield f"centre_of_mass_m: {apart}: {MILLIMETRES}"
    mass = _middle_of(robot.platform.mass)
    if not far and mass < LIGHTEST * size**2:
        yield f"platform anchors are {_m(size)} apart on a platform of {mass:.4g} kg: {MILLIMETRES}"


def _far_anchors(far: Sequence[Cable], frame: float) -> str:
    """Return the doubt about anchors farther from the platform's origin than the frame is wide."""
    worst = max(far, key=lambda cable: _norm(cable.platform_anchor))
    others = f" (also {', '.join(cable.name for cable in far if cable is not worst)})" if len(far) > 1 else ""
    place = f"{_m(_norm(worst.platform_anchor))} from the platform's origin, the frame {_m(frame)} wide"
    ratio = _norm(worst.platform_anchor) / frame
    meant = MILLIMETRES if ratio > IN_MILLIMETRES else "in the base frame instead of the platform's?"
    return f"platform_anchor_m: that of {worst.name} is {place}{others}: {meant}"


def _cables(robot: Robot) -> Iterator[str]:
    """Yield doubts about cables: twice the same, or as soft as no cable is."""
    for a, b in combinations(robot.cables, 2):
        if (a.frame_anchor, a.platform_anchor) == (b.frame_anchor, b.platform_anchor):
            yield f"{a.name} and {b.name} run between the same two points"
    weight = _middle_of(robot.platform.mass) * _norm(robot.gravity)
    springs = [cable.elasticity for cable in robot.cables if cable.elasticity is not None]
    frame = _extent([cable.frame_anchor for cable in robot.cables])
    constants = [_middle_of(spring.stiffness) for spring in springs if spring.stiffness is not None]
    if frame and constants and weight > frame * sum(constants):
        stretch = f"all cables together stretch by {_m(weight / sum(constants))} under the weight"
        yield f"stiffness_N_per_m: {stretch}: in N/mm? Multiply by 1000"
    axial = [_middle_of(spring.axial_stiffness) for spring in springs if spring.axial_stiffness is not None]
    if axial and weight > sum(axial):
        yield "axial_stiffness_N: under the weight the cables stretch by more than their length: in kN?"


def _exactly(value: Scalar) -> Fraction:
    return value.mid if isinstance(value, Range) else value


def _middle_of(value: Scalar) -> float:
    return float(_exactly(value))


def _norm(point: Point) -> float:
    return math.hypot(*map(_middle_of, point))


def _distance(a: Sequence[Scalar], b: Sequence[Scalar]) -> float:
    return math.dist([_middle_of(x) for x in a], [_middle_of(x) for x in b])


def _middle(points: Sequence[Point]) -> Point:
    x, y, z = (sum(map(_exactly, axis), Fraction(0)) / len(points) for axis in zip(*points, strict=True))
    return x, y, z


def _extent(points: Sequence[Point]) -> float:
    """Return the largest distance between two of some points, m."""
    return max((_distance(a, b) for a, b in combinations(points, 2)), default=0.0)


def _m(length: float) -> str:
    """Return a length for a sentence."""
    return f"{length:.4g} m"
