"""The solutions of a result as rows of plain numbers, for spreadsheets and data frames."""

from __future__ import annotations

import math
from typing import Any

from cdpr_interval.errors import CdprError
from solvers.answers.data import ResultData, Solution


def rows(result: ResultData) -> list[dict[str, Any]]:
    """Return a row for every solution, numbered from 1 as in the table, with columns as in ``solutions.csv``.

    Numbers are middles of their certified bounds (nan where nothing bounds them), angles in degrees;
    ``width_m`` is the largest width of the position.
    """
    return [_row(number, solution, result.cables) for number, solution in enumerate(result.solutions, 1)]


def data_frame(result: ResultData) -> Any:
    """Return the rows as a pandas ``DataFrame``, also without any solution with all its columns.

    Raises
    ------
    CdprError
        pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise CdprError(
            "to_dataframe: pandas is not installed: pip install pandas, or install this package with its"
            " extra 'pandas'; to_rows() needs nothing"
        ) from None
    return pandas.DataFrame(rows(result), columns=columns(result.cables))


def columns(cables: tuple[str, ...]) -> list[str]:
    """Return the names of the columns."""
    numbers = ["x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg", "height_m", "width_m"]
    tensions = [f"tension_{name}_N" for name in cables]
    return ["solution", "taut", "stability", "proof", "proved", *numbers, *tensions]


def _row(number: int, solution: Solution, cables: tuple[str, ...]) -> dict[str, Any]:
    nominal = solution.nominal
    values = [
        number,
        " ".join(cables[i] for i in solution.taut),
        solution.stability.value,
        solution.proof.value,
        solution.is_proved,
        *nominal.position,
        *(math.degrees(angle) for angle in nominal.rpy),
        _middle(*solution.height.tolist()),
        max(hi - lo for lo, hi in solution.position.tolist()),
        *(_middle(lo, hi) for lo, hi in solution.tensions.tolist()),
    ]
    return dict(zip(columns(cables), values, strict=True))


def _middle(lo: float, hi: float) -> float:
    return 0.5 * lo + 0.5 * hi if math.isfinite(lo) and math.isfinite(hi) else math.nan
