"""Print the degrees and numbers of Merlet 2012, "The kinematics of the redundant N-1 wire driven robot".

Each line holds the paper's value and ours; what in the paper is wrong or must be read differently is said
where it matters. ``python scripts/reproduce_merlet_2012.py`` computes everything in half a minute; with
``--tables`` the Monte-Carlo study of section IV.B instead.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

import merlet_2012_tables
from flint import fmpq, fmpz_poly

from cdpr_interval import load_robot
from cdpr_interval.symbolic.eliminant import Eliminant, eliminant, part_over_rationals
from cdpr_interval.symbolic.elimination import conditions_modulo, resultant, survey
from cdpr_interval.symbolic.residues import primes
from cdpr_interval.symbolic.statics import Statics
from solvers import forward_kinematics, pose_from_tensions

SEED = 20261123
(PRIME,) = primes(1)
SIDE = [[fmpq(0)] * 3, [fmpq(4), fmpq(0), fmpq(0)], [fmpq(0), fmpq(4), fmpq(0)], [fmpq(4), fmpq(4), fmpq(0)]]
LOAD = [fmpq(0), fmpq(0), fmpq(-7848, 10)]


def rows() -> Iterator[tuple[str, str, str]]:
    """Yield what it is, what the paper says, what comes out here."""
    yield from inextensible()
    yield from elimination_of_lengths()
    yield from elimination_of_tensions()
    yield from nominal()


def inextensible() -> Iterator[tuple[str, str, str]]:
    """Section III: four lengths, three taut cables."""
    lengths = ["2.692582403567252", "3.905124837953327", "3.354101966249685", "4.385"]
    (pose,) = forward_kinematics(load_robot("merlet_4_1"), lengths).solutions
    names = [str(i + 1) for i in pose.taut]
    yield "III: taut cables", "1, 3, 4", ", ".join(names)
    yield "III: C in cm", "100.272188, 150, -199.863675", shown(100 * pose.position.mean(axis=1))
    away = f"{100 * pose.distances[1].mean():.9f}"
    yield "III: |A_2 C| in cm (the paper's is taken at its rounded pose)", "390.2335837301", away


def elimination_of_lengths() -> Iterator[tuple[str, str, str]]:
    """Section IV.A: elastic cables, generic lengths and stiffness on the square."""
    stiffness, lengths = [1000, 1100, 950, 1020], [(29, 10), (31, 10), (4, 1), (41, 10)]
    statics = Statics.elastic(SIDE, LOAD, [fmpq(k) for k in stiffness], [fmpq(*x) for x in lengths])
    printed = ["(6,6,2)", "(3,3,3)", "(9,9,3)"]
    for name, paper, ours in zip(("a_1", "a_2", "a_3"), printed, condition_degrees(statics), strict=True):
        yield f"IV.A: degrees of {name} in rho_1, rho_2, rho_3", paper, str(ours).replace(" ", "")
    first, second = survey(statics, PRIME)[:2]
    yield "IV.A: degree of P_1", "15", str(first.degrees[0])
    yield "IV.A: degree of P_2", "18", str(second.degrees[0])
    found = eliminant(statics)
    yield "IV.A: true factor", "76", irreducible(found.factors[0].polynomial)
    yield "IV.A: extraneous factor (squared)", "96", irreducible(part_over_rationals(statics, 2))
    symmetric = [fmpq(299558, 100000)] * 2 + [fmpq(4121083, 1000000)] * 2
    paper_data = eliminant(Statics.elastic(SIDE, LOAD, [fmpq(100000)] * 4, symmetric))
    yield (
        "IV.A: the same for the lengths of IV.B (symmetric: roots coincide)",
        "-",
        str(paper_data.true_degree),
    )
    yield "IV.A: real roots; all rho > 0; static", "-, -, at most 1", counts(paper_data)


def elimination_of_tensions() -> Iterator[tuple[str, str, str]]:
    """Section IV.C: given tensions, generic numbers; P_2 and Q = Res(a_2, a_3)."""
    statics = Statics.given_tensions(SIDE, LOAD, [fmpq(t) for t in (441, 442, 202, 203)])
    curves = survey(statics, PRIME)
    whole = resultant(statics, [curves[1], curves[3]], PRIME)
    simple = next(f for f, m in whole.factor_squarefree()[1] if m == 1)
    true = simple.gcd(resultant(statics, curves[:2], PRIME))
    yield "IV.C: true factor in rho_1^2", "30", str(true.degree() // 2)
    yield "IV.C: extraneous factor in rho_1^2", "144", str((simple.degree() - true.degree()) // 2)


def nominal() -> Iterator[tuple[str, str, str]]:
    """Sections IV.B and IV.C: nominal poses; labels 2 and 3 of the exit points are exchanged there."""
    robot = load_robot("merlet_4_1_k1000")
    (pose,) = forward_kinematics(robot, ["2.99558", "2.99558", "4.121083", "4.121083"]).solutions
    yield (
        "IV.B: nominal C in cm (its lengths fit (200, 100, -200) with eq. (2))",
        "100, 200, -200",
        shown(100 * pose.position.mean(axis=1)),
    )
    yield "IV.B: nominal tensions in N", "441.45, 441.45, 202.2383", shown(pose.tensions.mean(axis=1))
    (given,) = pose_from_tensions(robot, "441.45,441.45,202.238331,202.238331").solutions
    yield (
        "IV.C: C in cm for these tensions (y = 100 is a misprint for 200)",
        "100, 100, -200",
        shown(100 * given.position.mean(axis=1)),
    )


def shown(values: Sequence[float]) -> str:
    """Return numbers for a column."""
    return ", ".join(f"{v:.4f}" for v in values)


def irreducible(f: fmpz_poly) -> str:
    """Return a polynomial's degree, and whether it has factors over Q."""
    degrees = [int(g.degree()) for g, _ in f.factor()[1]]
    return f"{degrees[0]}, irreducible over Q" if len(degrees) == 1 else f"{degrees} over Q"


def counts(found: Eliminant) -> str:
    """Return numbers of real solutions, of those with positive distances, and of static ones."""
    zeros = [zero for _, over in found.real_solutions for zero in over]
    positive = sum(all(v.real > 0 for v in zero.distances) for zero in zeros)
    return f"{len(zeros)}, {positive}, {sum(zero.is_static for zero in zeros)}"


def condition_degrees(statics: Statics) -> list[tuple[int, int, int]]:
    """Return the degrees of a_1, a_2, a_3 in rho_1, rho_2, rho_3, modulo a prime."""
    found, _ = conditions_modulo(statics, PRIME)
    return [(max(c.degrees()[0] for c in cs), max(c.degrees()[1] for c in cs), len(cs) - 1) for cs in found]


def main() -> None:
    """Print the table, or with ``--tables`` the sensitivity study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", action="store_true", help="the Monte-Carlo study of IV.B instead")
    parser.add_argument("--samples", type=int, help="of each study instead of 1000 or 3000")
    arguments = parser.parse_args()
    if arguments.tables:
        merlet_2012_tables.print_studies(SEED, arguments.samples)
        return
    print(f"seed {SEED}; degrees modulo {PRIME}, factors over Q")
    print(f"{'':70}{'paper':28}here")
    for what, paper, ours in rows():
        print(f"{what:70}{paper:28}{ours}", flush=True)


if __name__ == "__main__":
    main()
