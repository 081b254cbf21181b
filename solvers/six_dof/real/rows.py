"""The rows of forms that cells of real cables need beside those of all platforms."""

from __future__ import annotations

from cdpr_interval.engine.rows import Table
from cdpr_interval.mechanics.six_dof import rows as platform

FORMS = Table(platform.FORMS.ranges)
"""Rows of F."""
SCALED = FORMS.take("SCALED", 3)
"""s v, v = p - p_c."""
SQUARED = FORMS.take("SQUARED")
"""s |v|^2."""
INNER = FORMS.take("INNER", 3)
"""v . s R e_j."""
OUTER = FORMS.take("OUTER", 9)
"""(s R e_j x v)_k at 3 k + j."""
TURNED = FORMS.take("TURNED", 3)
"""s R b of one cable."""
MORE_WRENCH = FORMS.take("MORE_WRENCH", platform.DIMENSIONS)
"""s w_i of one cable behind the sixth."""
ONE_OVER_SCALE = FORMS.take("ONE_OVER_SCALE")
"""1 / s."""
FROM_FOOT = FORMS.take("FROM_FOOT")
"""|X - T0|^2 / 2 of one cable."""
DENSITY = FORMS.take("DENSITY")
"""t of one cable, by its stretch."""

WORK = Table(platform.WORK.ranges)
"""Rows of W."""
