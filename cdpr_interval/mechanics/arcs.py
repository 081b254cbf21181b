"""Turning a pose about an axis: for which angles every other cable stays slack.

The squared distance of a cable is alpha - rho cos(theta - phi), so the angles at which it is
not too long form one closed arc about phi, the whole circle or nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb, arb_mat

from cdpr_interval.exact import balls


@dataclass(frozen=True)
class ArcEnd:
    """One end of an arc: the angle (rad) and the cable that becomes tight there (None: no end)."""

    angle: arb
    cable: int | None


@dataclass(frozen=True)
class Arc:
    """Angles from ``start`` to ``end``, at most a full turn; where the width may be 0 it may be empty."""

    start: ArcEnd
    end: ArcEnd

    @property
    def width(self) -> arb:
        """Return the arc's angle."""
        return self.end.angle - self.start.angle


@dataclass(frozen=True)
class Circle:
    """The squared distance alpha - beta cos(theta) - gamma sin(theta) of one cable, against l^2."""

    cable: int
    alpha: arb
    beta: arb
    gamma: arb
    length: arb

    def arc(self) -> Arc | bool | None:
        """Return where the cable is slack: an arc, True everywhere, False nowhere, None undecided."""
        rho = (self.beta * self.beta + self.gamma * self.gamma).nonnegative_part().sqrt()
        excess = self.alpha - self.length * self.length
        if excess + rho < 0:
            return True
        if excess - rho > 0:
            return False
        if not rho > 0:
            return None
        cosine = excess / rho
        if not (cosine > -1 and cosine < 1):
            return None
        half = cosine.acos()
        # The side of atan2 without its cut: a ball across the cut would become a ball around a full turn.
        behind = self.beta.mid() < 0
        phi = arb.pi() + arb.atan2(-self.gamma, -self.beta) if behind else arb.atan2(self.gamma, self.beta)
        start, end = phi - half, phi + half
        # Bounds so wide that no angle is surely inside say nothing.
        return Arc(ArcEnd(start, self.cable), ArcEnd(end, self.cable)) if start < end else None


def circle(
    cable: int, anchor: arb_mat, point: arb_mat, axis_point: arb_mat, axis: arb_mat, length: arb
) -> Circle:
    """Return the circle of one cable when ``point`` turns about the axis (unit direction)."""
    a = anchor - axis_point
    w = point - axis_point
    along = balls.dot(a, axis) * balls.dot(w, axis)
    alpha = balls.dot(a, a) + balls.dot(w, w) - 2 * along
    beta = 2 * (balls.dot(a, w) - along)
    gamma = 2 * balls.dot(a, balls.cross(axis, w))
    return Circle(cable, alpha, beta, gamma, length)


def common_arcs(circles: list[Circle]) -> list[Arc] | None:
    """Return the arcs on which all cables are slack; one full turn (ends without cable) if none limits.

    Two arcs that touch, up to rounding, have one in common whose width is not proved positive. None: whether
    a cable ever becomes tight could not be decided.
    """
    limits: list[Arc] = []
    for c in circles:
        arc = c.arc()
        if arc is None:
            return None
        if arc is False:
            return []
        if arc is not True:
            assert isinstance(arc, Arc)
            limits.append(arc)
    if not limits:
        return [Arc(ArcEnd(-arb.pi(), None), ArcEnd(arb.pi(), None))]
    arcs = [limits[0]]
    for limit in limits[1:]:
        shorter: list[Arc] = []
        for arc in arcs:
            shorter += intersect(arc, limit)
        arcs = shorter
    return arcs


def intersect(a: Arc, b: Arc) -> list[Arc]:
    """Return the parts of ``a`` inside ``b`` (both less than a full turn) that are not proved empty."""
    turn = 2 * arb.pi()
    parts: list[Arc] = []
    # b's start is shifted to within half a turn of a's start; its neighbours may meet a as well.
    shift = round(float(((a.start.angle - b.start.angle) / turn).mid()))
    for k in (shift - 1, shift, shift + 1):
        start = ArcEnd(b.start.angle + k * turn, b.start.cable)
        end = ArcEnd(b.end.angle + k * turn, b.end.cable)
        first = start if later(start, a.start) else a.start
        last = a.end if later(end, a.end) else end
        part = Arc(
            ArcEnd(start.angle.max(a.start.angle), first.cable),
            ArcEnd(end.angle.min(a.end.angle), last.cable),
        )
        if not part.width < 0:
            parts.append(part)
    return parts


def later(x: ArcEnd, y: ArcEnd) -> bool:
    """Return whether the middle of one end lies after that of another (only names the cable)."""
    return float(x.angle.mid()) > float(y.angle.mid())
