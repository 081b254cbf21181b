"""Print the study of Paty et al. 2021 on pulleys and elasticity beside what comes out with our cables.

The paper, "Cable-Driven Parallel Robot Modelling Considering Pulley Kinematics and Cable Elasticity", asks
how far a robot is from where it should be when its cable lengths come from a simple model: fixed exit
points, no stretch. Three cables carry the load; of the sets of three without a negative tension the one with
the least error counts.

What the paper does not print is chosen here: A_i are the corners at 5 m, the winches' exits C_i lie straight
below on the floor (``--lead-in``), all of a cable from C_i on stretches, with its full section of 4 mm, and
g = 9.81 m/s2. Nothing is fitted to a printed number. Means are over an even grid, faces included, of the box
|x|, |y| <= 2.314 m, 0 <= z <= 3.75 m. Workspaces and their volumes (RW, V_L and R_V, figures 13 and 14) are
not computed: the box is taken from the printed 80.31 m3.

It takes half a minute, with ``--full`` some minutes.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

# Run from anywhere: the parts of the study lie in this folder.
sys.path.insert(0, str(Path(__file__).resolve().parent))

from paty_2021_accuracy import paths, planes
from paty_2021_design import experiments, optima
from paty_2021_elasticity import elasticity
from paty_2021_model import LEAD_IN
from paty_2021_rows import HEAD, NOT, REPRODUCED, RULES, SHAPE, Row, line
from paty_2021_targets import Settings

PARTS: dict[str, tuple[str, Callable[[Settings], Iterator[Row]]]] = {
    "paths": ("Section 3.3.1: a straight path", paths),
    "planes": ("Section 3.3.2: the plane z = 2.5 m", planes),
    "experiments": ("Section 4.2: design of experiments", experiments),
    "optima": ("Section 4.3: the best arm for each radius", optima),
    "elasticity": ("Table 3, section 5: E = 102.2 +-35 GPa", elasticity),
}
FINER = 4
"""Times as many targets each way on the plane with ``--full``."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parts", nargs="*", help=f"some of {', '.join(PARTS)}; all where none is named")
    parser.add_argument(
        "--points",
        type=int,
        default=Settings.points,
        metavar="N",
        help="means over N x N x 2N targets (50: 250000, as in the paper)",
    )
    parser.add_argument("--full", action="store_true", help="also where optima are searched; a finer plane")
    parser.add_argument("--lead-in", type=Fraction, default=LEAD_IN, metavar="M", help="from C to A, m (5)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write this file")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="also draw (extra 'plot')")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.parts if name not in PARTS]
    if unknown:
        parser.error(f"unknown part {unknown[0]}; known: {', '.join(PARTS)}")
    if options.points < 2:
        parser.error(f"--points: must be at least 2, got {options.points}")
    if options.lead_in <= 0:
        parser.error(f"--lead-in: must be above 0, got {options.lead_in}")
    settings = settings_of(options)
    found = {name: table(name, settings) for name in options.parts or PARTS}
    verdicts = Counter(row.verdict for rows in found.values() for row in rows)
    print("\n" + ", ".join(f"{verdicts[verdict]} {verdict}" for verdict in (REPRODUCED, SHAPE, NOT)))
    print(RULES)
    if options.json:
        document = {name: [row.to_dict() for row in rows] for name, rows in found.items()}
        options.json.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    if options.pictures:
        pictures(options.pictures, settings)
    return 0


def settings_of(options: argparse.Namespace) -> Settings:
    """Return how finely to ask."""
    return Settings(
        points=options.points,
        line_points=options.points if options.full else min(options.points, Settings.line_points),
        plane_intervals=Settings.plane_intervals * (FINER if options.full else 1),
        lead_in=options.lead_in,
    )


def table(name: str, settings: Settings) -> list[Row]:
    """Print the table of a part, row by row; return the rows."""
    title, part = PARTS[name]
    print(f"\n{title}\n{HEAD}")
    rows = []
    for row in part(settings):
        print(line(row), flush=True)
        rows.append(row)
    return rows


def pictures(folder: Path, settings: Settings) -> None:
    """Draw, and print the files."""
    from paty_2021_pictures import draw

    from solvers.report.figures import require_matplotlib

    for file in draw(folder, require_matplotlib("--pictures"), settings):
        print(file)


if __name__ == "__main__":
    sys.exit(main())
