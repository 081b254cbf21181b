"""Small certificates for tests: of a point mass, and of a platform whose trees are made by hand."""

import base64
import copy
from pathlib import Path
from typing import Any

from certificates.container import write
from certificates.tree import Node
from solvers.answers.data import Answer
from solvers.forward import answer_question, build_result, pose_problem
from solvers.proofs.document import certificate_document
from solvers.proofs.entries import subset_entries
from solvers.questions.problem import Options
from tests.support import hanging_mass
from tests.support.point_certificates import robot

EXITS = [(0.0, 0.0, 9.0), (100.0, 0.0, 9.0), (0.0, 100.0, 9.0), (100.0, 100.0, 9.0)]
POINTS = [(0.0, 0.0, 0.1), (1.0, 0.0, 0.1), (0.0, 1.0, 0.2), (1.0, 1.0, 0.1)]


def hanging(lengths: Any = hanging_mass.LENGTHS, taut: Any = None, **options: Any) -> dict[str, Any]:
    """Return the certificate of a point mass on two cables."""
    chosen = Options(**options)
    problem = pose_problem(hanging_mass.robot(), lengths, taut, None, chosen)
    result = answer_question(problem, chosen)
    return certificate_document(problem, chosen, result, subset_entries(problem, chosen, result))


def three_poses() -> dict[str, Any]:
    """Return a certificate with three solutions: of c1, of c2, of both."""
    return hanging(["2", "3"], ignore_slack=True)


def platform(*trees: bytes, length: str = "3") -> dict[str, Any]:
    """Return the certificate of three taut cables, far too short or 120 m long, with these search trees."""
    problem = pose_problem(robot(EXITS, POINTS), [length] * 4, "c0,c1,c2", None, Options())
    search = {"order": [0, 1, 2], "roots": [], "trees": [base64.b64encode(tree).decode() for tree in trees]}
    entries = [{"taut": [0, 1, 2], "searches": [search]}]
    result = build_result(problem, Options(), Answer(()), 0.0)
    return certificate_document(problem, Options(), result, entries, [])


def leaf(node: Node, splits: int = 0) -> bytes:
    """Return a tree whose leaves are all the same, each cell being halved so many times."""
    if not splits:
        return bytes([node])
    return bytes([splits % 3]) + 2 * leaf(node, splits - 1)


def written(folder: Path, document: dict[str, Any]) -> Path:
    """Return the file of a document."""
    path = folder / "made.cert"
    write(path, document)
    return path


def changed(document: dict[str, Any], *keys: Any, value: Any) -> dict[str, Any]:
    """Return a document with another value at a place."""
    found = copy.deepcopy(document)
    place = found
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    return found
