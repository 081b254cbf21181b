"""The short table of a result: only digits that are proved, angles in degrees."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TextIO

from cdpr_interval.mechanics.stability import Stability
from solvers.answers.angles import rpy_enclosures
from solvers.answers.data import CableState, Certainty, Solution
from solvers.answers.digits import proved_decimal, proved_significant
from solvers.answers.result import Result

DECIMALS = 6
"""Of positions: a micrometre; the JSON holds every digit."""
ANGLE_DECIMALS = 4
TENSION_DIGITS = 6
_COLOURS = {Stability.STABLE: "green", Stability.UNDECIDED: "yellow", Stability.UNSTABLE: "red"}


def print_result(result: Result, stream: TextIO) -> None:
    """Print the result as a table, with colour only on a terminal."""
    title = f"{result.robot.name} ({result.model}, {len(result.cables)} cables): {result.message}"
    head, rows = table(result)
    if stream.isatty():
        _print_rich(title, head, rows, result, stream)
    else:
        stream.write(title + "\n")
        if rows:
            stream.writelines(line + "\n" for line in _aligned([head, *rows]))
    stream.writelines(line + "\n" for line in _undecided(result))
    stream.flush()


def table(result: Result) -> tuple[list[str], list[list[str]]]:
    """Return the head and the rows of the table as text."""
    platform = result.model != "point-mass"
    head = ["#", "taut", "stability", "x m", "y m", "z m"]
    head += ["roll deg", "pitch deg", "yaw deg"] if platform else []
    head += ["tensions N"]
    rows = [_row(number, solution, result, platform) for number, solution in enumerate(result.solutions, 1)]
    if any(row[-1] for row in rows):
        return [*head, "remarks"], rows
    return head, [row[:-1] for row in rows]


def _row(number: int, solution: Solution, result: Result, platform: bool) -> list[str]:
    cells = [str(number), ",".join(result.cables[i] for i in solution.taut) or "-", solution.stability.value]
    cells += [proved_decimal(lo, hi, DECIMALS) for lo, hi in solution.position.tolist()]
    if platform:
        angles = rpy_enclosures(solution.rotation)
        cells += ["?" if angle is None else proved_decimal(*angle, ANGLE_DECIMALS) for angle in angles]
    tense = [i for i, state in enumerate(solution.cable_states) if state is not CableState.SLACK]
    cells.append(" ".join(_tension(solution, i) for i in tense))
    return [*cells, _remarks(solution, result)]


def _tension(solution: Solution, cable: int) -> str:
    lo, hi = solution.tensions[cable].tolist()
    return proved_significant(lo, hi, TENSION_DIGITS)


def _remarks(solution: Solution, result: Result) -> str:
    remarks = []
    if not solution.is_proved:
        kinds = {"existence": solution.existence, "uniqueness": solution.uniqueness}
        unproved = " and ".join(kind for kind, value in kinds.items() if value is Certainty.UNDECIDED)
        remarks.append(f"{unproved} not proved")
    if names := _in_state(solution, result, CableState.UNDECIDED):
        remarks.append(f"taut or slack undecided: {names}")
    if names := _in_state(solution, result, CableState.SWITCHING):
        remarks.append(f"switching, one pose either way: {names}")
    if solution.slack_respected is False:
        remarks.append("other cables are not slack")
    if solution.family is not None:
        remarks.append(f"family: {solution.family.kind}")
    if solution.note:
        remarks.append(solution.note)
    return "; ".join(remarks)


def _in_state(solution: Solution, result: Result, state: CableState) -> str:
    states = zip(result.cables, solution.cable_states, strict=True)
    return ",".join(name for name, own in states if own is state)


def _undecided(result: Result) -> list[str]:
    lines = []
    for cluster in result.undecided:
        taut = ",".join(result.cables[i] for i in cluster.taut)
        place = ", ".join(proved_decimal(lo, hi, DECIMALS) for lo, hi in cluster.position.tolist())
        lines.append(f"undecided: taut {taut}, {cluster.cells} cells at ({place}) m: {cluster.reason}")
    return lines


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    last = len(widths) - 1
    return [
        "  ".join(
            cell if i == last else cell.rjust(width) if i == 0 or i > 2 else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def _print_rich(
    title: str, head: Sequence[str], rows: Sequence[Sequence[str]], result: Result, stream: TextIO
) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(file=stream, no_color=bool(os.environ.get("NO_COLOR")), highlight=False)
    console.print(Text(title, style="bold"))
    if not rows:
        return
    layout = Table(box=None, pad_edge=False)
    for i, name in enumerate(head):
        layout.add_column(name, justify="right" if i == 0 or 2 < i < len(head) - 1 else "left")
    for row, solution in zip(rows, result.solutions, strict=True):
        colour = _COLOURS[solution.stability]
        layout.add_row(*(Text(cell, style=colour if i == 2 else "") for i, cell in enumerate(row)))
    # A number cut short by a narrow terminal would be a wrong number: let long lines wrap instead.
    console.width = max(console.width, *(len(line) for line in _aligned([head, *rows])))
    console.print(layout)
