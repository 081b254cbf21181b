"""Print table 21 and the three prototypes of the EPFL chapter on the Delta beside what comes out exactly.

The chapter, "Les robots paralleles" (R. Clavel), 1.3.4, describes a workspace by a prism under which the arms
reach down: with r = R / L_A, b = L_B / L_A, g the most that bars may lean and e the least elbow,

    z_h = -sqrt(1 + b^2 - 2 b cos e),    z_T = -sqrt((1 + b)^2 - (r + 2 b sin g / sqrt 3)^2),
    z_T' = -sqrt((1 + b cos g)^2 - (r + b sin g / sqrt 3)^2),    h = z_h - max(z_T, z_T'),
    h_max = z_h + sqrt((1 + b)^2 - r^2),    d = 2 b sin g,    s = 2 sqrt 3 sin^2 g b^2,    v = s h.

Each printed number stands beside the exact one, and beside what the author's rounding gives: z_T for every r,
0.742 b for b times 2 sin g / sqrt 3, z_h with two decimals in h_max, which is cut off, 1.286 b, 1.431 b^2. A
verdict is one of

    reproduced               the exact number has the printed digits
    rounding                 it has not, but the author's rounding has
    contradicts the text     r is below 0.63, where the text asks for z_T', and z_T was printed

Nothing is fitted to a printed number. The true workspace is larger than the prism.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

GAMMA, ELBOW = math.radians(40), math.radians(30)
TABLE = {
    (0.5, 1.75): (-1.02, 1.06, 1.68, 2.25, 4.38, 4.67),
    (0.5, 2): (-1.24, 1.01, 1.71, 2.57, 5.72, 5.79),
    (0.5, 2.25): (-1.47, 0.95, 1.74, 2.89, 7.24, 6.87),
    (0.5, 2.5): (-1.71, 0.88, 1.75, 3.22, 8.94, 7.87),
    (0.5, 2.75): (-1.95, 0.81, 1.76, 3.54, 10.82, 8.76),
    (0.5, 3): (-2.19, 0.74, 1.77, 3.86, 12.88, 9.47),
    (0.63, 1.75): (-1.02, 0.94, 1.65, 2.25, 4.38, 4.14),
    (0.63, 2): (-1.24, 0.89, 1.69, 2.57, 5.72, 5.09),
    (0.63, 2.25): (-1.47, 0.83, 1.71, 2.89, 7.24, 5.98),
    (0.63, 2.5): (-1.71, 0.76, 1.73, 3.22, 8.94, 6.76),
    (0.63, 2.75): (-1.95, 0.68, 1.74, 3.54, 10.82, 7.4),
    (0.63, 3): (-2.19, 0.61, 1.76, 3.86, 12.88, 7.84),
    (0.8, 1.75): (-1.02, 0.76, 1.61, 2.25, 4.38, 3.34),
    (0.8, 2): (-1.24, 0.71, 1.65, 2.57, 5.72, 4.04),
    (0.8, 2.25): (-1.47, 0.64, 1.68, 2.89, 7.24, 4.65),
    (0.8, 2.5): (-1.71, 0.57, 1.69, 3.22, 8.94, 5.11),
    (0.8, 2.75): (-1.95, 0.5, 1.71, 3.54, 10.82, 5.4),
    (0.8, 3): (-2.19, 0.42, 1.72, 3.86, 12.88, 5.46),
    (1, 1.75): (-1.02, 0.49, 1.54, 2.25, 4.38, 2.17),
    (1, 2): (-1.24, 0.44, 1.58, 2.57, 5.72, 2.53),
    (1, 2.25): (-1.47, 0.38, 1.62, 2.89, 7.24, 2.77),
    (1, 2.5): (-1.71, 0.32, 1.64, 3.22, 8.94, 2.82),
    (1, 2.75): (-1.95, 0.25, 1.66, 3.54, 10.82, 2.66),
    (1, 3): (-2.19, 0.17, 1.68, 3.86, 12.88, 2.23),
}
"""Printed z_h, h, h_max, d, s and v for g = 40 deg and e = 30 deg."""
ROBOTS = {
    "Micro-DELTA 240": ((67, 17, 80, 160), (206, 71.5, 136, 3.66e4, 2.62e6), (0, 1, 0, -2, -4)),
    "DELTA 580": ((150, 25, 200, 380), (489, 183, 336, 20.7e4, 3.79e7), (0, 0, 0, -3, -5)),
    "DELTA 740": ((194, 30, 260, 480), (617, 240, 435, 33e4, 7.92e7), (0, 0, 0, -4, -5)),
}
"""R_A, R_B, L_A, L_B in mm; printed D, H, H_max, S, V; decimals of these."""
NAMES = ("z_h", "h", "h_max", "d", "s", "v")
SIZES = ("D", "H", "H_max", "S", "V")
REPRODUCED, ROUNDING, CONTRADICTS = "reproduced", "rounding", "contradicts the text"
NEITHER = "not reproduced"
THRESHOLD = 0.63
"""Of r, as printed: below sqrt 3 tan(g / 2) = 0.6304 z_T' is the higher one."""


@dataclass(frozen=True)
class Prism:
    """The workspace of the chapter, in multiples of the arm."""

    r: float
    b: float

    @property
    def top(self) -> float:
        """z_h."""
        return -math.sqrt(1 + self.b**2 - 2 * self.b * math.cos(ELBOW))

    @property
    def corners(self) -> tuple[float, float]:
        """z_T and z_T'."""
        r, b, sine = self.r, self.b, math.sin(GAMMA) / math.sqrt(3)
        far = -math.sqrt((1 + b) ** 2 - (r + 2 * b * sine) ** 2)
        return far, -math.sqrt((1 + b * math.cos(GAMMA)) ** 2 - (r + b * sine) ** 2)

    @property
    def lowest(self) -> float:
        """The lowest point of all."""
        return -math.sqrt((1 + self.b) ** 2 - self.r**2)

    def exact(self) -> tuple[float, ...]:
        """Return z_h, h, h_max, d, s and v."""
        height, area = self.top - max(self.corners), 2 * math.sqrt(3) * math.sin(GAMMA) ** 2 * self.b**2
        width = 2 * self.b * math.sin(GAMMA)
        return self.top, height, self.top - self.lowest, width, area, area * height

    def by_the_author(self) -> tuple[float, ...]:
        """Return the same as the table was computed."""
        r, b, top = self.r, self.b, rounded(self.top)
        height = math.sqrt((1 + b) ** 2 - (r + 0.742 * b) ** 2) + self.top
        highest = math.floor(100 * (top - self.lowest)) / 100
        area = 1.431 * b**2
        others = map(rounded, (1.286 * b, area, area * height))
        return top, rounded(height), highest, *others


def rounded(x: float) -> float:
    """Return two decimals, halves upwards; 1.286 * 2.5 is such a half but for a double's error."""
    return math.floor(100 * x + 0.5 + 1e-9) / 100


def verdict(printed: float, exact: float, authors: float, decimals: int, r: float, name: str) -> str:
    """Return what a printed number is."""
    if abs(printed - exact) <= 0.5000001 * 10.0**-decimals:
        return REPRODUCED
    if abs(printed - authors) > 0.5000001 * 10.0**-decimals:
        return NEITHER
    return CONTRADICTS if r < THRESHOLD and name in ("h", "v", "H", "V") else ROUNDING


def table() -> Iterator[tuple[str, str]]:
    """Yield a line and a verdict for each cell of table 21."""
    for (r, b), printed in TABLE.items():
        prism = Prism(r, b)
        for name, value, exact, authors in zip(
            NAMES, printed, prism.exact(), prism.by_the_author(), strict=True
        ):
            found = verdict(value, exact, authors, 2, r, name)
            yield f"{r:5g} {b:5g}  {name:6} {value:9g} {authors:9g} {exact:13.8f}  {found}", found


def robots() -> Iterator[tuple[str, str]]:
    """Yield a line and a verdict for each number of the prototypes."""
    for robot, ((base, platform, arm, bar), printed, decimals) in ROBOTS.items():
        prism = Prism((base - platform) / arm, bar / arm)
        _, height, highest, width, area, volume = prism.exact()
        lower = prism.top - prism.corners[0]
        powers = (arm, arm, arm, arm**2, arm**3)
        exact = [x * p for x, p in zip((width, height, highest, area, volume), powers, strict=True)]
        cut = math.floor(highest * arm)
        authors = [exact[0], lower * arm, cut, exact[3], area * lower * arm**3]
        for name, value, mine, others, digits in zip(SIZES, printed, exact, authors, decimals, strict=True):
            found = verdict(value, mine, others, digits, prism.r, name)
            yield f"{robot:16} {name:6} {value:11g} {others:13.6g} {mine:13.8g}  {found}", found


def main() -> int:
    """Print both tables, and how many verdicts there are of each kind."""
    for title, head, rows in (
        ("Table 21, in multiples of the arm", "    r     b  name    printed  author's", table),
        ("Prototypes, mm", f"{'robot':16} name       printed      author's", robots),
    ):
        print(f"\n{title}\n{head}         exact  verdict")
        counts: Counter[str] = Counter()
        for line, found in rows():
            print(line)
            counts[found] += 1
        print(", ".join(f"{count} {word}" for word, count in counts.most_common()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
