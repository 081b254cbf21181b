"""Documents that are not those of a certificate: refused in one line, whatever is wrong with them."""

import copy
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import pytest
from flint import fmpq

import certificates
from cdpr_interval.exact.decimals import exact_text
from certificates.literals import bounds_of, exact
from certificates.problem import read_problem, read_solutions
from certificates.tree import Node
from certificates.verdicts import Malformed, Verdict
from solvers.forward import answer_question, pose_problem
from solvers.proofs.document import certificate_document
from solvers.proofs.entries import subset_entries
from solvers.proofs.listed import certificate_question, document_solutions, listed_solution, widened
from solvers.questions.problem import Options
from tests.support.made_certificates import changed, hanging, leaf, platform, three_poses, written
from tests.support.point_certificates import robot, vector

FAMILY_EXITS = [(0.0, 0.0, 3.0), (2.0, 0.0, 3.0), (1.0, 2.0, 3.0)]
ODD = [
    None,
    True,
    -1,
    0,
    10**9,
    1.5,
    "",
    "x",
    "\n",
    "\ud800",
    "1e999",
    "1/0",
    "nan",
    [],
    [[]],
    {},
    {"taut": []},
]


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield every place of a document."""
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in inner:
        yield from places(entry, (*path, key))


def at(document: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        document = document[key]
    return document


def family() -> dict[str, Any]:
    """Return a certificate of one cable of a platform."""
    made = robot(FAMILY_EXITS[:1], [(0.0, 0.0, 0.4)])
    problem = pose_problem(made, ["1"], None, None, Options())
    result = answer_question(problem, Options())
    return certificate_document(problem, Options(), result, subset_entries(problem, Options(), result))


DOCUMENTS = {
    "point mass": hanging,
    "family": family,
    "platform": lambda: platform(*[leaf(Node.UNDECIDED)] * 4),
}


@pytest.fixture(scope="module", params=DOCUMENTS)
def document(request):
    return DOCUMENTS[request.param]()


def verdict(tmp_path, document: Any) -> Verdict:
    report = certificates.check(written(tmp_path, document))
    assert len(report.lines()[0].splitlines()) == 1 and report.lines()[0].isascii()
    return report.verdict


def test_these_documents_are_proved(document, tmp_path):
    assert verdict(tmp_path, document) is Verdict.PROVED


def test_every_key_is_needed_and_no_other_allowed(document, tmp_path):
    for path in places(document):
        entry = at(document, path)
        if not isinstance(entry, dict):
            continue
        for key in entry:
            less = copy.deepcopy(document)
            del at(less, path)[key]
            assert verdict(tmp_path, less) in (Verdict.MALFORMED, Verdict.NOT_PROVED), (path, key)
        more = copy.deepcopy(document)
        at(more, path)["more"] = None
        assert verdict(tmp_path, more) is Verdict.MALFORMED, path


def test_a_wrong_kind_of_value_is_refused_at_every_place(document, tmp_path):
    for path in list(places(document))[1:]:
        old = at(document, path)
        for odd in ODD:
            if type(odd) is type(old) and type(odd) in (str, bool, int):
                continue
            if may_be(path, odd) or (type(odd) is type(old) and odd == old):
                continue
            found = verdict(tmp_path, changed(document, *path, value=copy.deepcopy(odd)))
            assert found in (Verdict.MALFORMED, Verdict.NOT_PROVED), (path, odd)


def may_be(path: tuple[Any, ...], odd: Any) -> bool:
    """Return True where the value is allowed: less is claimed, or another question is asked."""
    return (path[-2:] == ("question", "taut") and odd is None) or (
        path[-1] == "slack_respected" and odd is None
    )


def test_another_text_is_refused_or_says_nothing(document, tmp_path):
    for path in list(places(document))[1:]:
        if isinstance(at(document, path), str) and path[0] not in ("tool", "claim"):
            for odd in ("\n", "\ud800", "1e999", "1/0", "nan", "0x1p99999"):
                found = verdict(tmp_path, changed(document, *path, value=odd))
                named = path[-1] in ("name", "sha256", "pending")
                named |= path[-2:-1] == ("start",) and odd == "1e999"  # a guess: any may do
                # Far, heavy or stiff: the question changes, and may have the same answer.
                asked = odd == "1e999" and path[0] in ("robot", "lengths_m", "external_force_N")
                assert found in (Verdict.MALFORMED, Verdict.NOT_PROVED) or named or asked, (path, odd)


def test_the_question_is_restored(tmp_path):
    force = vector(1.5, -2.25, 3.125)
    made = robot([(0, 0, 1), (1.37, 0, 1), (0.3, 1, 1)], stiffness=("axial", "1000"))
    problem = pose_problem(made, ["1.03", "1..1.25", 1.1], None, force, Options())
    options = Options(ignore_slack=True)
    result = answer_question(problem, options)
    entry = {"taut": [0], "point": {"poses": list(range(len(result.solutions))), "proof": {}}}
    document = certificate_document(problem, options, result, [entry])
    question = read_problem(document)
    assert question == certificate_question(problem, options)
    solutions = document_solutions(problem, result)
    assert [listed_solution(s) for s in solutions] == read_solutions(document, question)
    assert [widened(s, True).height.tolist() for s in result.solutions] == [
        s.height.tolist() for s in solutions
    ]


@pytest.mark.parametrize("taut", [[], [1, 0], [0, 0], [2], [True]])
def test_taut_cables_are_distinct_ascending_and_there(taut):
    with pytest.raises(Malformed):
        read_problem(changed(hanging(), "question", "taut", value=taut))


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("lengths_m", 0), ["2", "1"]),
        (("lengths_m", 0), ["0", "1"]),
        (("lengths_m", 0), ["-1", "1"]),
        (("robot", "mass_kg"), "0"),
        (("robot", "mass_kg"), "-1"),
        (("robot", "gravity_m_s2"), ["0", "0", "0"]),
        (("external_force_N",), ["0", "0", "98.1"]),
        (("robot", "cables", 1, "name"), "c1"),
        (("robot", "cables"), []),
        (("question", "ignore_tension_sign"), True),
        (("format",), "cdpr-certificate/2"),
    ],
)
def test_rules_of_the_question(keys, value):
    with pytest.raises(Malformed):
        read_problem(changed(hanging(), *keys, value=value))


@pytest.mark.parametrize("key", ["stiffness_N_per_m", "axial_stiffness_N"])
def test_elastic_cables_are_those_of_point_masses(key):
    document = hanging()
    for cable in document["robot"]["cables"]:
        cable[key] = "1000"
    assert read_problem(document).stiffness == [(fmpq(1000), key == "axial_stiffness_N")] * 2
    with pytest.raises(Malformed):
        read_problem(changed(document, "robot", "cables", 0, key, value="0"))
    with pytest.raises(Malformed):
        read_problem(changed(document, "robot", "cables", 0, "platform_anchor_m", value=["1", "0", "0"]))
    del document["robot"]["cables"][0][key]
    with pytest.raises(Malformed):
        read_problem(document)


def test_both_stiffnesses_are_malformed():
    document = hanging()
    document["robot"]["cables"][0].update({"stiffness_N_per_m": "1", "axial_stiffness_N": "1"})
    with pytest.raises(Malformed):
        read_problem(document)


def test_more_than_64_cables_or_too_many_taut_ones_are_malformed():
    document = hanging()
    cable = document["robot"]["cables"][0]
    document["robot"]["cables"] = [{**cable, "name": f"c{i}"} for i in range(65)]
    document["lengths_m"] = [["1", "1"]] * 65
    with pytest.raises(Malformed, match="64"):
        read_problem(document)
    document["robot"]["cables"].pop()
    document["lengths_m"].pop()
    document["question"]["taut"] = [0, 1, 2]
    assert read_problem(document).taut == (0, 1, 2)
    document["question"]["taut"] = [0, 1, 2, 3]
    with pytest.raises(Malformed):
        read_problem(document)


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("taut",), [0, 1]),
        (("taut",), []),
        (("states",), ["taut", "taut"]),
        (("states",), ["taut", "loose"]),
        (("position_m", 0), ["0x1.0000000000000p+1", "0x1.0000000000000p+0"]),
        (("stability",), "maybe"),
        (
            ("family",),
            {"kind": "torus", "axis_point_m": None, "axis_direction": None, "angle_ranges_rad": []},
        ),
    ],
)
def test_rules_of_solutions(keys, value):
    document = changed(hanging(), "solutions", 0, *keys, value=value)
    with pytest.raises(Malformed):
        read_solutions(document, read_problem(document))


def test_too_many_solutions_are_malformed(monkeypatch):
    document = three_poses()
    monkeypatch.setattr("certificates.problem.MOST_SOLUTIONS", 2)
    with pytest.raises(Malformed):
        read_solutions(document, read_problem(document))


@pytest.mark.parametrize(
    "odd", [["0x1p+0", "0x1p+1"], ["1.0", "2.0"], ["inf", "inf"], ["nan", "nan"], [1.0, 2.0], ["0x0.0p+0"]]
)
def test_bounds_are_doubles_as_python_writes_them(odd):
    with pytest.raises(Malformed):
        bounds_of(odd, "x")
    assert bounds_of([(-1e-320).hex(), (1e300).hex()], "x") == (-1e-320, 1e300)


def test_exact_texts_are_restored():
    texts = {"0.5": "0.5", "-2.690": "-2.69", "1/3": "1/3", "0": "0", "-0.001": "-0.001", "1200": "1200"}
    for given, wanted in texts.items():
        assert exact_text(Fraction(given)) == wanted
        assert exact(wanted) == fmpq(*Fraction(given).as_integer_ratio())
    for x in (Fraction(0.1), Fraction(1, 10**100), Fraction(5e-101), Fraction(10**100)):
        assert exact(exact_text(x)) == fmpq(x.numerator, x.denominator)
