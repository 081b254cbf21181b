"""Every way a robot file can be wrong, with the exact line the user sees."""

from itertools import product

import pytest

from cdpr_interval import InputError, load_robot
from cdpr_interval.files.document import DEEPEST_LEVEL, MOST_ALIKE, MOST_ERRORS
from cdpr_interval.robots.formats.reader import parse_robot

GOOD = """\
format: cdpr-robot/1
name: r
platform:
  mass_kg: 80
cables:
  - name: c1
    frame_anchor_m: [0, 0, 0]
    platform_anchor_m: [0, 0, 0]
  - name: c2
    frame_anchor_m: [1, 0, 0]
    platform_anchor_m: [0, 0, 0]
"""
THREE = "must be a list of 3 numbers"
NO_TEXT = "not a text file (invalid UTF-8): save it in the encoding UTF-8"
WORD = "must be letters, digits, '_', '.' and '-', the first a letter or '_'"
ONE_OF = "must hold exactly one of 'stiffness_N_per_m' and 'axial_stiffness_N'"
ZERO_GRAVITY = "gravity_m_s2: must not be the zero vector: without a load there are no statics"


def messages(data: str | bytes) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        parse_robot(data, "r.yaml")
    assert str(caught.value) == "\n".join(caught.value.messages)
    assert all(len(line.splitlines()) == 1 for line in caught.value.messages)
    return caught.value.messages


def test_the_good_file_is_good():
    assert len(parse_robot(GOOD).cables) == 2


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        # keys
        (
            "- name: c2",
            "- name: c2\n    elasticty: {}",
            "10:5: cables[1].elasticty: unknown key (did you mean 'elasticity'?)",
        ),
        ("name: r", "name: r\nzzz: 1", "3:1: zzz: unknown key"),
        ("name: r", "name: r\n1.5: 1", "3:1: '1.5': unknown key"),
        (
            "mass_kg: 80",
            "mass_kg: 80\n  mass: 1",
            "5:3: platform.mass: unknown key (did you mean 'mass_kg'?)",
        ),
        ("name: r", "name: r\nname: s", "3:1: name: duplicate key (first on line 2)"),
        (
            "name: c2",
            "name: c2\n    name: c3",
            "10:5: cables[1].name: duplicate key (first on line 9): a new entry begins with '- '",
        ),
        ("name: r", "name: r\nx_a: {b: 1, b: 2}", "3:13: x_a.b: duplicate key (first on line 3)"),
        ("name: r", "name: r\n<<: {a: 1}", "3:1: '<<': unknown key"),
        ("name: r", "name: r\n? [a]\n: 1", "3:3: a key must be a word, not a list, a mapping or an alias"),
        ("  mass_kg: 80", "  notes: hm", "4:3: platform.mass_kg: missing"),
        ("name: r\n", "", "1:1: name: missing"),
        # numbers
        ("80", ".nan", "4:12: platform.mass_kg: '.nan' is not a finite number"),
        ("80", "NaN", "4:12: platform.mass_kg: 'NaN' is not a finite number"),
        ("80", ".inf", "4:12: platform.mass_kg: '.inf' is not a finite number"),
        ("80", "-Infinity", "4:12: platform.mass_kg: '-Infinity' is not a finite number"),
        (
            "80",
            "1e999999999",
            "4:12: platform.mass_kg: '1e999999999' is out of range (0, or 1e-100 to 1e100 in size)",
        ),
        ("80", "1e-101", "4:12: platform.mass_kg: '1e-101' is out of range (0, or 1e-100 to 1e100 in size)"),
        ("80", "0x" + "f" * 1000, f"4:12: platform.mass_kg: '0x{'f' * 55}...' has more than 1000 characters"),
        ("80", "1:30", "4:12: platform.mass_kg: '1:30' is not a number"),
        ("80", "1_000", "4:12: platform.mass_kg: '1_000' is not a number: write 1000"),
        (
            "80",
            "80 kg",
            "4:12: platform.mass_kg: '80 kg' is not a number: the unit is in the key, write 80",
        ),
        (
            "80",
            "'80'",
            "4:12: platform.mass_kg: must be a number, got the text '80': write it without quotes",
        ),
        ("80", "true", "4:12: platform.mass_kg: must be a number, got true"),
        ("80", "", "4:11: platform.mass_kg: must be a number, got nothing"),
        ("80", "٣", "4:12: platform.mass_kg: '٣' is not a number"),
        # rules
        ("80", "0", "4:12: platform.mass_kg: must be greater than 0, got 0"),
        ("80", "-3.5", "4:12: platform.mass_kg: must be greater than 0, got -3.5"),
        ("80", "[-1, 3]", "4:12: platform.mass_kg: must be greater than 0, got -1"),
        ("80", "[3, 1]", "4:12: platform.mass_kg: the lower bound 3 is above the upper bound 1"),
        ("80", "[3]", "4:12: platform.mass_kg: must be a list of 2 numbers, got a list of 1"),
        ("80", "{value: 3}", "4:12: platform.mass_kg.tolerance: missing"),
        ("80", "{value: 3, tolerance: -1}", "4:34: platform.mass_kg.tolerance: must not be negative, got -1"),
        (
            "80",
            "{value: 3, tolerance: 3.5}",
            "4:12: platform.mass_kg: must be greater than 0, got -0.5",
        ),
        (
            "[1, 0, 0]",
            "[1, [2, 1], 0]",
            "10:25: cables[1].frame_anchor_m[1]: the lower bound 2 is above the upper bound 1",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, {value: 0, tolerance: -0.1}]",
            "10:50: cables[1].frame_anchor_m[2].tolerance: must not be negative, got -0.10000000000000001",
        ),
        (
            "name: c2",
            "name: c2\n    elasticity: {stiffness_N_per_m: {value: 10, tolerance: 10}}",
            "10:37: cables[1].elasticity.stiffness_N_per_m: must be greater than 0, got 0",
        ),
        (
            "name: r",
            "name: [1, 2]",
            "2:7: name: must be a text (in quotes if it looks like a number), got a list of 2",
        ),
        (
            "name: c2",
            "name: {value: c2, tolerance: 1}",
            "9:11: cables[1].name: must be a text (in quotes if it looks like a number), got a mapping",
        ),
        (
            "80",
            "{value: 3, tolerance: 0, tolerances: 1}",
            "4:37: platform.mass_kg.tolerances: unknown key (did you mean 'tolerance'?)",
        ),
        ("name: r", "name: r\ngravity_m_s2: [0, 0, -0.0]", f"3:15: {ZERO_GRAVITY}"),
        ("name: r", "name: r\ngravity_m_s2: [0, 0, [-1, 1]]", f"3:15: {ZERO_GRAVITY}"),
        ("name: c2", "name: c1", "9:11: cables[1].name: 'c1' is the name of cables[0] already"),
        (
            "name: c2",
            "name: 2c",
            f"9:11: cables[1].name: {WORD}, got '2c'",
        ),
        (
            "name: c2",
            "name: 2",
            "9:11: cables[1].name: must be a text (in quotes if it looks like a number), got 2",
        ),
        ("name: r", 'name: "a\\nb"', "2:7: name: must be one printable line, got 'a\\nb'"),
        (
            "name: r",
            "name: ' '",
            "2:7: name: must be a text (in quotes if it looks like a number), got the text ' '",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    elasticity: {stiffness_N_per_m: -1}",
            "11:37: cables[1].elasticity.stiffness_N_per_m: must be greater than 0, got -1",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    elasticity: {axial_stiffness_N: 0}",
            "11:37: cables[1].elasticity.axial_stiffness_N: must be greater than 0, got 0",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    elasticity: {}",
            f"11:17: cables[1].elasticity: {ONE_OF}",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    elasticity: {stiffness_N_per_m: 1, axial_stiffness_N: 1}",
            f"11:17: cables[1].elasticity: {ONE_OF}",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    elasticity: 5",
            "11:17: cables[1].elasticity: must be a mapping, got 5",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    elasticity:",
            "11:16: cables[1].elasticity: must be a mapping, got nothing",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    tension_limits_N: [5, 1]",
            "11:23: cables[1].tension_limits_N: the lower bound 5 is above the upper bound 1",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0]\n    tension_limits_N: [-5, 1]",
            "11:23: cables[1].tension_limits_N: must not be negative, got -5",
        ),
        # shapes
        (
            "[1, 0, 0]",
            "[1, 0]",
            "10:21: cables[1].frame_anchor_m: must be a list of 3 numbers, got a list of 2",
        ),
        (
            "[1, 0, 0]",
            "[1, 0, 0, 0]",
            f"10:21: cables[1].frame_anchor_m: {THREE}, got a list of 4: decimals have a point, not a comma",
        ),
        ("[1, 0, 0]", "[1, 0, z]", "10:28: cables[1].frame_anchor_m[2]: 'z' is not a number"),
        (
            "[1, 0, 0]",
            "{x: 1}",
            f"10:21: cables[1].frame_anchor_m: {THREE}, got a mapping: write it in square brackets",
        ),
        ("platform:\n  mass_kg: 80", "platform: 80", "3:11: platform: must be a mapping, got 80"),
        (
            "format: cdpr-robot/1",
            "format: cdpr-robot/2",
            "1:9: format: must be 'cdpr-robot/1' or 'delta-robot/1', got the text 'cdpr-robot/2'",
        ),
        (
            "format: cdpr-robot/1",
            "format: cdpr-problem/1",
            "1:9: format: must be 'cdpr-robot/1' or 'delta-robot/1', got the text 'cdpr-problem/1'",
        ),
        # YAML beyond plain data
        ("80", "!!float 80", "4:12: platform.mass_kg: tags are not allowed ('!!float')"),
        ("80", "!<x> 80", "4:12: platform.mass_kg: tags are not allowed ('x')"),
        (
            "name: r",
            "name: !!python/object/apply:os.system [ls]",
            "2:7: name: tags are not allowed ('!!python/object/apply:os.system')",
        ),
        ("80", "&m 80", "4:12: platform.mass_kg: anchors are not allowed ('&m')"),
        ("80", "*m", "4:12: platform.mass_kg: aliases are not allowed ('*m')"),
    ],
)
def test_one_error(old: str, new: str, message: str):
    assert GOOD.count(old) == 1
    assert messages(GOOD.replace(old, new)) == (f"r.yaml:{message}",)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("", "1:1: the file is empty"),
        ("# only a comment\n", "1:1: the file is empty"),
        ("---\n", "2:1: must be a mapping, got nothing"),
        ("[1, 2]", "1:1: must be a mapping, got a list of 2"),
        (GOOD + "---\n" + GOOD, "12:1: a second document starts here; a file holds one"),
        (b"name: r\n\x00", "2:1: not a text file (control character '\\x00')"),
        (b"name: r\nx: \xff\xfe", f"2:4: {NO_TEXT}"),
        (GOOD.encode("utf-16"), f"1:1: {NO_TEXT}"),
        ("\ud800", f"1:1: {NO_TEXT}"),
        (
            "format: cdpr-robot/1\nname: r\nplatform: {mass_kg: 1}\ncables: []",
            "4:9: cables: must hold at least 1 entry",
        ),
        (
            "format: cdpr-robot/1\nname: r\nplatform: {mass_kg: 1}\ncables: {c1: 2}",
            "4:9: cables: must be a list, got a mapping",
        ),
    ],
)
def test_a_file_that_is_wrong_as_a_whole(data: str | bytes, message: str):
    assert messages(data) == (f"r.yaml:{message}",)


@pytest.mark.parametrize(
    ("text", "place"), [("a: b: c\n", "1:5"), ("a: [1\nb: 2\n", "2:2"), ("a: 1\n\tb: 2\n", "2:1")]
)
def test_syntax_error(text: str, place: str):
    (message,) = messages(text)
    assert message.startswith(f"r.yaml:{place}: not valid YAML: ")


@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_twenty_thousand_nested_brackets(opening: str):
    (message,) = messages(opening * 20_000)
    assert message.endswith(f"nested deeper than {DEEPEST_LEVEL} levels")


def test_twenty_thousand_nested_keys():
    assert messages("? " * 20_000) == ("r.yaml:1:3: a key must be a word, not a list, a mapping or an alias",)


def test_the_deepest_level_that_is_allowed():
    inside = DEEPEST_LEVEL - 1
    assert parse_robot(GOOD + f"x_deep: {'[' * inside}{']' * inside}\n").name == "r"
    assert len(messages(GOOD + f"x_deep: {'[' * (inside + 1)}{']' * (inside + 1)}\n")) == 1


def test_alias_bomb():
    bomb = "x_0: &a0 [lol]\n" + "".join(
        f"x_{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 10)}]\n" for i in range(9)
    )
    lines = messages(GOOD + bomb)
    assert "r.yaml: and 85 more like it" in lines and lines[-1] == "r.yaml: and 5 more like it"
    assert lines[0] == "r.yaml:12:6: x_0: anchors are not allowed ('&a0')"
    assert lines[1] == "r.yaml:13:6: x_1: anchors are not allowed ('&a1')"
    assert lines[2] == "r.yaml:13:11: x_1[0]: aliases are not allowed ('*a0')"


def test_all_errors_are_reported_in_file_order():
    text = GOOD.replace("80", "-80").replace("name: c2", "name: c1").replace("[1, 0, 0]", "[1, 0, .nan]")
    assert messages("x_t: !t 1\n" + text.replace("name: r", "nam: r")) == (
        "r.yaml:1:1: name: missing",
        "r.yaml:1:6: x_t: tags are not allowed ('!t')",
        "r.yaml:3:1: nam: unknown key (did you mean 'name'?)",
        "r.yaml:5:12: platform.mass_kg: must be greater than 0, got -80",
        "r.yaml:10:11: cables[1].name: 'c1' is the name of cables[0] already",
        "r.yaml:11:28: cables[1].frame_anchor_m[2]: '.nan' is not a finite number",
    )


def test_very_many_errors_are_cut_short():
    words = ["".join(letters) for letters in product("qvz", repeat=7)]
    lines = messages(GOOD + "".join(f"{word}: 1\n" for word in words))
    assert len(lines) == MOST_ERRORS + 1
    assert lines[-1] == f"r.yaml: and {len(words) - MOST_ERRORS} more errors"


def test_errors_that_are_alike_are_counted():
    lines = messages(GOOD + "".join(f"k{i}: 1\n" for i in range(5000)) + "other: 1\n")
    assert lines == (
        *(f"r.yaml:{12 + i}:1: k{i}: unknown key" for i in range(MOST_ALIKE)),
        f"r.yaml: and {5000 - MOST_ALIKE} more like it",
        "r.yaml:5012:1: other: unknown key",
    )


def test_five_that_are_alike_are_only_shown():
    lines = messages(GOOD + "".join(f"k{i}: 1\n" for i in range(MOST_ALIKE)))
    assert len(lines) == MOST_ALIKE and "like it" not in str(lines)


def test_missing_file(tmp_path):
    path = tmp_path / "nowhere.yaml"
    with pytest.raises(InputError, match=r"nowhere\.yaml: no such file or shipped robot"):
        load_robot(path)


def test_directory(tmp_path):
    with pytest.raises(InputError) as caught:
        load_robot(tmp_path)
    assert str(caught.value) == f"{tmp_path}: cannot be read: Is a directory"


def test_binary_file(tmp_path):
    path = tmp_path / "r.yaml"
    path.write_bytes(bytes(range(256)) * 10)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    assert str(caught.value) == f"{path}:1:1: not a text file (control character '\\x00')"


def test_file_of_50_megabytes(tmp_path):
    path = tmp_path / "r.yaml"
    with path.open("wb") as file:
        file.write(GOOD.encode() + b"# ")
        file.truncate(50_000_000)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    assert str(caught.value) == f"{path}: is larger than 1000000 bytes, the limit for a file"


@pytest.mark.parametrize("name", ["", ".", "a\0b", "x" * 5000, "two\nlines"])
def test_names_that_are_no_files(name: str):
    with pytest.raises(InputError) as caught:
        load_robot(name)
    assert len(caught.value.messages) == 1
    assert "\n" not in str(caught.value)
