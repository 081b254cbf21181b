"""Whatever the bytes, the reader gives a robot or an `InputError`, nothing else."""

from fractions import Fraction
from importlib import resources

from hypothesis import given, settings
from hypothesis import strategies as st

from cdpr_interval import InputError
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.text.literal import read_number, resolve

LIBRARY = resources.files("cdpr_interval.robots").joinpath("library")
SEEDS = [LIBRARY.joinpath(f"{name}.yaml").read_bytes() for name in ("uc2", "merlet_4_1_k100", "acrobot")]
TOKENS = [
    b"",
    b"\n",
    b": ",
    b"- ",
    b"[",
    b"]",
    b"{",
    b"}",
    b"'",
    b'"',
    b"#",
    b"&a ",
    b"*a",
    b"!t ",
    b"|\n",
    b">",
    b"? ",
    b"<<: ",
    b"---\n",
    b"...\n",
    b"%YAML 1.1\n",
    b"\t",
    b"\r",
    b"\x00",
    b"\x85",
    b"\xef\xbb\xbf",
    b"\xed\xa0\x80",
    b"\xff",
    b".nan",
    b"1e400",
    b"1:30",
    b"null",
    b"~",
    b"notes",
    b"x_",
    b"cables",
    b"{value: 1, tolerance: 2}",
    b"[1, 2]",
    b"<tolerance>",
]


def read(data: bytes | str) -> None:
    try:
        robot = parse_robot(data, "f")
    except InputError as error:
        assert error.messages
        assert all(line.startswith("f:") and len(line.splitlines()) == 1 for line in error.messages)
    else:
        assert isinstance(robot, Robot)


@given(st.binary(max_size=200))
def test_any_bytes(data: bytes):
    read(data)


@given(st.text(max_size=200))
def test_any_text(text: str):
    read(text)


@settings(max_examples=400)
@given(
    st.sampled_from(SEEDS),
    st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 12), st.sampled_from(TOKENS)),
        min_size=1,
        max_size=5,
    ),
)
def test_mutated_files(data: bytes, edits: list[tuple[float, int, bytes]]):
    for place, cut, token in edits:
        start = int(place * len(data))
        data = data[:start] + token + data[start + cut :]
    read(data)


TREES = st.recursive(
    st.sampled_from(["1", "-2.5", "a", "~", "true", "''", ".inf"]),
    lambda inner: (
        st.lists(inner, max_size=4).map(lambda entries: f"[{', '.join(entries)}]")
        | st.dictionaries(
            st.sampled_from(["value", "tolerance", "name", "'<tolerance>'", "mass_kg", "x_"]), inner
        ).map(lambda entries: "{" + ", ".join(f"{key}: {value}" for key, value in entries.items()) + "}")
    ),
    max_leaves=8,
)
BLOCKS = ["gravity_m_s2", "platform", "cables", "source", "name"]


@settings(max_examples=300)
@given(st.dictionaries(st.sampled_from(BLOCKS), TREES))
def test_any_shapes_under_known_keys(entries: dict[str, str]):
    read("format: cdpr-robot/1\n" + "".join(f"{key}: {tree}\n" for key, tree in entries.items()))


@given(st.text(alphabet="0123456789.eE+-_:xo nNaAiIfF", max_size=12))
def test_a_number_is_a_fraction_or_a_plain_refusal(text: str):
    try:
        value = read_number(text)
    except ValueError as error:
        assert len(str(error).splitlines()) == 1
    else:
        assert isinstance(value, Fraction)
        assert resolve(text) == value


@given(st.decimals(allow_nan=False, allow_infinity=False, min_value=-(10**30), max_value=10**30, places=20))
def test_a_decimal_is_read_exactly(value: object):
    assert read_number(str(value)) == Fraction(str(value))
