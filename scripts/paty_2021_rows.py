"""A line of the comparison with Paty et al. 2021, and the rule by which it gets its verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

REPRODUCED, SHAPE, NOT, UNPRINTED = "reproduced", "shape only", "not", "-"
CLOSE = 0.02
"""Relative difference up to which a number is reproduced, also where it rounds to other digits than printed:
means depend on the grid in the third digit, and the paper does not say how its points are distributed."""
ALIKE = 0.125
"""Relative difference up to which it still is of the printed size."""
RULES = f"""\
reproduced  rounds to the printed digits, or is within {100 * CLOSE:.0f} % of them, and what the paper says of
            it (its place, order or sign) holds here
shape only  within {100 * ALIKE:.1f} %, and what the paper says of it holds here
not         neither
What is stated in words is reproduced or not; what the paper draws without a number has no verdict."""


@dataclass(frozen=True)
class Row:
    """What the paper says of a quantity, and what comes out here."""

    quantity: str
    ours: str
    printed: str | None = None
    """The number as printed; None where the paper has none."""
    value: float | None = None
    """Ours, in the unit of the printed number."""
    holds: bool | None = None
    """Whether what the paper says holds here; of a number: what it says besides."""
    remark: str = ""

    @property
    def published(self) -> str:
        """Return what stands in the paper's column."""
        return self.printed or ("stated" if self.holds is not None else "-")

    @property
    def difference(self) -> float | None:
        """Return by which part of the printed number ours differs from it."""
        if self.printed is None or self.value is None:
            return None
        return self.value / float(self.printed) - 1.0

    @property
    def verdict(self) -> str:
        """Return the verdict by the rules."""
        if self.printed is None or self.value is None:
            return UNPRINTED if self.holds is None else REPRODUCED if self.holds else NOT
        if self.holds is False:
            return NOT
        away = abs(self.value / float(self.printed) - 1.0)
        if abs(self.value - float(self.printed)) <= half_a_digit(self.printed) or away <= CLOSE:
            return REPRODUCED
        return SHAPE if away <= ALIKE else NOT

    def to_dict(self) -> dict[str, Any]:
        """Return the row for a JSON file."""
        return {
            "quantity": self.quantity,
            "printed": self.printed,
            "value": self.value if self.value is not None and math.isfinite(self.value) else None,
            "ours": self.ours,
            "holds": self.holds,
            "verdict": self.verdict,
            "remark": self.remark,
        }


def half_a_digit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number."""
    return float(Decimal(5).scaleb(int(Decimal(printed).as_tuple().exponent) - 1))


def number(quantity: str, printed: str, value: float, holds: Any = None, remark: str = "") -> Row:
    """Return the row of a printed number; ours is shown with two digits more."""
    places = max(0, -int(Decimal(printed).as_tuple().exponent)) + 2
    said = None if holds is None else bool(holds)
    return Row(quantity, f"{value:.{places}f}", printed, float(value), said, remark)


def claim(statement: str, ours: str, holds: Any, remark: str = "") -> Row:
    """Return the row of what the paper says in words."""
    return Row(statement, ours, holds=bool(holds), remark=remark)


def unprinted(quantity: str, ours: str, remark: str = "") -> Row:
    """Return the row of what the paper draws without a number."""
    return Row(quantity, ours, remark=remark)


def line(row: Row) -> str:
    """Return a row as a line of the table, a remark below it."""
    away = "" if row.difference is None else f"{100 * row.difference:+.1f} %"
    text = f"{row.quantity:<66}{row.published:>9}  {row.ours:<34}{away:>9}  {row.verdict}"
    return text + (f"\n    ({row.remark})" if row.remark else "")


HEAD = f"{'':<66}{'paper':>9}  {'here':<34}{'':>9}  verdict"
