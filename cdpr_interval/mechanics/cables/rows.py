"""Rows of the arrays of routes (ROUTE, 2) and of ways (WAY, 2), whose last axis is (lo, hi)."""

from __future__ import annotations

FIXED, ONE_JOINT, BALANCED, BISECTED = 0, 1, 2, 3
"""Kinds of routes: a fixed exit point, a pulley on one joint, on two in exact balance, on two with the
bisector."""
KIND, EXIT, AXIS, RADIUS, ARM, LEAD_IN, BEFORE, THETA, SNUG = 0, 1, 4, 7, 8, 9, 10, 11, 12
"""Rows of a route: kind; A (3 rows); unit vector k (3); radius, arm and lead-in; the straight piece that
arrives (all of what lies before a fixed exit) and the angle of K, both for one joint; 1 where the arm is
the radius."""
ROUTE = 13
LENGTH, ALONG, ACROSS, OUTWARD, FREE, WRAP, SWING, NORMAL, PLANE, TILT = 0, 1, 4, 5, 6, 7, 8, 10, 12, 15
"""Rows of a way: L; a (3 rows); x, the distance from the axis; a_u; sigma; the wrap (rad); the gradient of
psi in the plane (2); n in the plane (2); u (3); dL/dX - a in the plane (2), which only the bisector has."""
WAY = 17
