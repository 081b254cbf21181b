"""YAML as people mistype it: each mistake is named, at its place, with what to write instead."""

from __future__ import annotations

import pytest
import yaml

from cdpr_interval import InputError
from cdpr_interval.files import document as document_module
from cdpr_interval.files.units import renamed
from cdpr_interval.robots.formats.reader import parse_robot

FILE = """\
format: cdpr-robot/1
name: t
platform:
  mass_kg: 10
  centre_of_mass_m: [0, 0, 0]
cables:
  - name: a
    frame_anchor_m: [0, 0, 3]
    platform_anchor_m: [-0.1, 0, 0.1]
  - name: b
    frame_anchor_m: [2, 0, 3]
    platform_anchor_m: [0.1, 0, 0.1]
"""
YAML = "not valid YAML"
THREE = "must be a list of 3 numbers, got"
MASS = "4:12: platform.mass_kg"
NAN = "is not a number"
MINUS = "its minus sign is another character, write -0.1"
UNIT = f"{NAN}: the unit is in the key, write"
FRAME, PLATFORM = "8:21: cables[0].frame_anchor_m", "9:24: cables[0].platform_anchor_m"


@pytest.fixture(params=[yaml.SafeLoader, getattr(yaml, "CSafeLoader", yaml.SafeLoader)])
def parser(request, monkeypatch):
    """Run with libyaml and with the pure Python parser, whose words differ."""
    monkeypatch.setattr(document_module, "_PARSER", request.param)


def messages(text: str | bytes) -> list[str]:
    with pytest.raises(InputError) as caught:
        parse_robot(text, "f")
    assert all(line.startswith("f:") and line.isprintable() for line in caught.value.messages)
    return [line.removeprefix("f:") for line in caught.value.messages]


SYNTAX = {
    "\tmass_kg: 10": "4:1: {}: a tab: YAML is indented by spaces only",
    "  \tmass_kg: 10": "4:3: {}: a tab: YAML is indented by spaces only",
    "  mass_kg:10": "4:10: {}: a space is missing after 'mass_kg:'",
    "  mass_kg 10": "4:10: {}: a ':' is missing after 'mass_kg'",
    "  mass_kg = 10": "4:10: {}: a '=': write 'mass_kg:'",
    "   mass_kg: 10": "5:3: {}: is indented by 2, what it belongs to by 0 (line 1)",
    "\xa0\xa0mass_kg: 10": "4:1: {}: a special space: YAML is indented by plain spaces only",
    "  x_a: a: b": "4:9: {}: a second ': ' in this line: a text that holds one needs quotes",
    "  x_a: @home": "4:8: {}: a text that begins with '@' needs quotes",
    "  x_a: 'it's'": "4:12: {}: the text in quotes ends before this: a ' inside '...' is written ''",
    '  x_a: "open': "4:8: {}: the quote that opens here is never closed",
    "  x_a: [1, 2": "5:19: {}: a ',' is missing before this, or the '[' of line 4, column 8 is not closed",
    "  x_a: {b: 1 // no": "4:14: {}: '//': a comment begins with '#'",
}


@pytest.mark.usefixtures("parser")
@pytest.mark.parametrize(("line", "message"), SYNTAX.items())
def test_a_mistake_of_one_line(line: str, message: str):
    (found,) = messages(FILE.replace("  mass_kg: 10", line))
    assert found == message.format(YAML)


def changed(old: str, new: str) -> str:
    assert old in FILE
    return FILE.replace(old, new)


WHOLE = [
    (changed("- name", "-name"), ["7:3: {}: a space is missing after the '-': write '- name:'"]),
    (changed("- name: a", "- name:a"), ["7:9: {}: a space is missing after 'name:'"]),
    (changed("platform:", "platform"), ["3:9: {}: a ':' is missing after 'platform'"]),
    (
        changed("  centre", "    centre"),
        ["5:5: {}: is indented further than line 4, which has a value already"],
    ),
    (
        changed("  - name: b", "   - name: b"),
        ["10:4: {}: is indented by 3, what it belongs to by 2 (line 7)"],
    ),
    ("```yaml\n" + FILE + "```\n", ["1:1: {}: a line of Markdown, not of YAML: remove it"]),
    (
        FILE.replace("    ", "\t").replace("  - ", "\t- "),
        ["7:1: {}: a tab: YAML is indented by spaces only (and 5 more lines)"],
    ),
]


@pytest.mark.usefixtures("parser")
@pytest.mark.parametrize(("text", "expected"), WHOLE)
def test_a_mistake_that_the_parser_sees_later(text: str, expected: list[str]):
    assert messages(text) == [line.format(YAML) for line in expected]


VALUES = [
    (changed(": 10", ": 1,5"), f"{MASS}: '1,5' {NAN}: decimals have a point, write 1.5"),
    (changed(": 10", ": 10kg"), f"{MASS}: '10kg' {UNIT} 10"),
    (changed(": 10", ": 1.5 t"), f"{MASS}: '1.5 t' {UNIT} 1500 (1.5 t in kg)"),
    (changed(": 10", ": 9 stone"), f"{MASS}: '9 stone' {UNIT} the number alone, in kg"),
    (changed(": 10", ": 10# kg"), f"{MASS}: '10# kg' {NAN}: a space is missing before the '#' of a comment"),
    (changed(": 10", ": 10 // kg"), f"{MASS}: '10 // kg' {NAN}: a comment begins with ' #'"),
    (changed(": 10", ": 1_000"), f"{MASS}: '1_000' {NAN}: write 1000"),
    (changed(": 10", ": 1/2"), f"{MASS}: '1/2' {NAN}: write it as a decimal"),
    (changed(": 10", ": '10'"), f"{MASS}: must be a number, got the text '10': write it without quotes"),
    (changed(": 10", ": ten"), f"{MASS}: 'ten' {NAN}"),
    (
        changed("0, 0, 3]", "0, 0, 3000mm]"),
        f"8:28: cables[0].frame_anchor_m[2]: '3000mm' {UNIT} 3 (3000 mm in m)",
    ),
    (
        changed("[-0.1", "[\u22120.1"),
        f"9:25: cables[0].platform_anchor_m[0]: '\u22120.1' {NAN}: {MINUS}",
    ),
    (
        changed("[-0.1, 0, 0.1]", "[-0,1, 0, 0,1]"),
        f"{PLATFORM}: {THREE} a list of 5: decimals have a point, not a comma",
    ),
    (changed("[0, 0, 3]", "0, 0, 3"), f"{FRAME}: {THREE} the text '0, 0, 3': write [0, 0, 3]"),
    (changed("[0, 0, 3]", "(0, 0, 3)"), f"{FRAME}: {THREE} the text '(0, 0, 3)': write [0, 0, 3]"),
    (changed("[0, 0, 3]", "[0 0 3]"), f"{FRAME}: {THREE} a list of 1: write [0, 0, 3]"),
    (changed("[0, 0, 3]", "{x: 0, y: 0, z: 3}"), f"{FRAME}: {THREE} a mapping: write it in square brackets"),
    (changed("[0, 0, 3]", "[0, 3]"), f"{FRAME}: {THREE} a list of 2"),
    (changed("format: cdpr-robot/1\n", ""), "1:1: format: missing: write 'format: cdpr-robot/1'"),
    (FILE.encode("utf-16"), "1:1: not a text file (invalid UTF-8): save it in the encoding UTF-8"),
]


@pytest.mark.parametrize(("text", "message"), VALUES)
def test_a_value_that_is_spelled_differently(text: str | bytes, message: str):
    assert messages(text) == [message]


MILLI = "and divide by 1000"
KEYS = [
    (
        "mass_kg: 10\n  centre_of_mass_m: [0, 0, 0]",
        "mass_kg:10",
        ["must be a mapping, got the text 'mass_kg:10': a space is missing after 'mass_kg:'"],
    ),
    (
        "frame_anchor_m: [0",
        "frame_anchor_mm: [0",
        ["missing", f"frame_anchor_mm: unknown key: write 'frame_anchor_m', {MILLI}"],
    ),
    (
        "frame_anchor_m: [0",
        "frame_anchor_MM: [0",
        ["missing", f"frame_anchor_MM: unknown key: write 'frame_anchor_m', {MILLI}"],
    ),
    (
        "frame_anchor_m: [0",
        "frame_anker_mm: [0",
        ["missing", f"frame_anker_mm: unknown key: write 'frame_anchor_m', {MILLI}"],
    ),
    ("mass_kg", "mass_g", ["unknown key: write 'mass_kg', and divide by 1000", "missing"]),
    ("mass_kg", "mass", ["unknown key (did you mean 'mass_kg'?)", "missing"]),
    (
        "  - name: b",
        "    name: b",
        [f"duplicate key (first on line {n}): a new entry begins with '- '" for n in (7, 8, 9)],
    ),
]


@pytest.mark.parametrize(("old", "new", "ends"), KEYS)
def test_a_key_that_is_spelled_differently(old: str, new: str, ends: list[str]):
    found = messages(changed(old, new))
    assert len(found) == len(ends)
    assert all(line.endswith(end) for line, end in zip(found, ends, strict=True))


def test_a_list_of_entries_without_their_spaces_is_one_error():
    text = FILE.replace("- name", "-name").replace("    ", "  ")
    said = "cables: must be a list, got a mapping: a space is missing after the '-', write '- name'"
    assert messages(text) == [f"7:3: {said}"]


KNOWN = (
    "frame_anchor_m", "platform_anchor_m", "mass_kg", "stiffness_N_per_m", "axial_stiffness_N", "yaw_deg",
    "gravity_m_s2", "cycle_s",
)  # fmt: skip


@pytest.mark.parametrize(
    ("key", "told"),
    [
        ("frame_anchor_cm", "write 'frame_anchor_m', and divide by 100"),
        ("platform_anchor_km", "write 'platform_anchor_m', and multiply by 1000"),
        ("frame_anchor_in", "write 'frame_anchor_m', and multiply by 0.0254"),
        ("stiffness_N_per_mm", "write 'stiffness_N_per_m', and multiply by 1000"),
        ("stiffness_N_m", "write 'stiffness_N_per_m'"),
        ("axial_stiffness_kN", "write 'axial_stiffness_N', and multiply by 1000"),
        ("gravity_mm_s2", "write 'gravity_m_s2', and divide by 1000"),
        ("cycle_ms", "write 'cycle_s', and divide by 1000"),
        ("yaw_rad", "write 'yaw_deg', and multiply by 180/pi"),
        ("frame_anchor_m", None),
        ("anything", None),
    ],
)
def test_a_key_of_another_unit_names_the_factor(key: str, told: str | None):
    assert renamed(key, KNOWN) == told


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("begin", ["", "\ufeff"])
def test_windows_files_are_read(begin: str, end: str):
    assert parse_robot((begin + FILE.replace("\n", end)).encode()).name == "t"


@pytest.mark.parametrize("word", ["no", "on", "Yes", "1e", "0b1", "12:30:45", "1_0"])
def test_words_that_yaml_1_1_takes_for_something_else_are_texts(word: str):
    assert parse_robot(changed("name: t", f"name: {word}")).name == word
