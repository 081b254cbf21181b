"""The generic tree behind every file format."""

from fractions import Fraction

import pytest
import yaml

from cdpr_interval import InputError
from cdpr_interval.files import document as document_module
from cdpr_interval.files.document import DEEPEST_LEVEL, TOO_DEEP, child, parse_document, read_document
from cdpr_interval.text.literal import resolve

TEXT = 'a: 1e-3\nb:\n  - no\n  - "1"\n  - {c: ~}\n'


@pytest.fixture(params=[yaml.SafeLoader, getattr(yaml, "CSafeLoader", yaml.SafeLoader)])
def parser(request, monkeypatch):
    """Run with libyaml and with the pure Python parser, which a platform may be left with."""
    monkeypatch.setattr(document_module, "_PARSER", request.param)


@pytest.mark.usefixtures("parser")
def test_values_places_and_literals():
    document = parse_document(TEXT)
    document.require_valid()
    a, b = document.root.mapping["a"], document.root.mapping["b"]
    assert (a.value, a.literal, a.plain, a.line, a.column) == (Fraction(1, 1000), "1e-3", True, 1, 4)
    assert a.key is not None and (a.key.literal, a.key.line, a.key.column) == ("a", 1, 1)
    assert [node.value for node in b.items[:2]] == ["no", "1"]
    assert [node.plain for node in b.items[:2]] == [True, False]
    assert (b.items[1].line, b.items[1].column) == (4, 5)
    assert b.items[2].mapping["c"].value is None
    assert a.mapping == {} and a.items == []


@pytest.mark.usefixtures("parser")
def test_errors_of_the_tree_and_of_the_reader_come_together():
    document = parse_document("b: 1\na: *x\na: 2\n", "f.yaml")
    root = document.root
    document.report(root.mapping["a"], "a", "dropped: this value is broken already")
    document.report_unknown_key(root.mapping["b"], child("", "b"), ["bb"])
    with pytest.raises(InputError) as caught:
        document.require_valid()
    assert caught.value.messages == (
        "f.yaml:1:1: b: unknown key (did you mean 'bb'?)",
        "f.yaml:2:4: a: aliases are not allowed ('*x')",
        "f.yaml:3:1: a: duplicate key (first on line 2)",
    )


def only_message(text: str) -> str:
    """Return the message of a text that is no document."""
    with pytest.raises(InputError) as caught:
        parse_document(text)
    (message,) = caught.value.messages
    assert len(message) < 150 and message.isprintable()
    return message


@pytest.mark.usefixtures("parser")
@pytest.mark.parametrize(
    "text",
    [
        "a: b: c", "a: 'x", "%YAML 2.0\n---\na", f"%YAML 1.{'1' * 5000}\n---\na", f"!{'q' * 1000}!x 1",
        f"%TAG !a! {'u' * 2000}\n%TAG !a! x\n---\n", "[" * 32 + "]" * 33, "- ']' : [",
    ],
)  # fmt: skip
def test_hopeless_texts_are_one_line(text: str):
    assert ": not valid YAML: " in only_message(text)


@pytest.mark.usefixtures("parser")
@pytest.mark.parametrize("count", [DEEPEST_LEVEL + 1, 900, 1_100, 20_000])
@pytest.mark.parametrize(
    ("opening", "column"),
    [("[", 33), ("{a: ", 129), ("- ", 65), ("[[", 33), ("[{a: ", 81), ("[  ", 97), ("[\n", 1)],
)
def test_nesting_has_one_answer_whatever_limit_the_parser_has(opening: str, column: int, count: int):
    assert only_message(opening * count).endswith(f":{column}: {TOO_DEEP}")


class StubbornParser(yaml.SafeLoader):
    """A parser that gives up at the third level, in words of its own."""

    error: Exception = yaml.YAMLError("no")
    level = 0

    def get_event(self):
        event = super().get_event()
        self.level += isinstance(event, yaml.CollectionStartEvent)
        if self.level > 2:
            raise self.error
        return event


@pytest.mark.parametrize(
    ("error", "place"),
    [
        (yaml.YAMLError("a\nb" * 500), "1:1"),
        (yaml.MarkedYAMLError("context", None, "too\tdeep", yaml.Mark("f", 5, 0, 5, None, 0)), "1:6"),
        (yaml.MarkedYAMLError("context" * 50, yaml.Mark("f", 7, 1, 2, None, 0)), "2:3"),
        (yaml.reader.ReaderError("f", 1, 0xFFFE, "unicode", "odd"), "1:1"),
        (ValueError("digits" * 100), "1:1"),
    ],
)
def test_the_parser_may_say_what_it_likes(error: Exception, place: str, monkeypatch):
    monkeypatch.setattr(document_module, "_PARSER", StubbornParser)
    monkeypatch.setattr(StubbornParser, "error", error)
    assert only_message("[" * 100).endswith(f":1:{DEEPEST_LEVEL + 1}: {TOO_DEEP}")
    assert only_message("[[[a]]]").startswith(f"<text>:{place}: not valid YAML: ")


def test_read_document_names_the_file_as_given(tmp_path):
    path = tmp_path / "d.yaml"
    path.write_text("a: .nan")
    assert read_document(path).messages == (f"{path}:1:4: a: '.nan' is not a finite number",)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", None), ("~", None), ("Null", None), ("nULL", "nULL"),
        ("true", True), ("FALSE", False), ("yes", "yes"), ("off", "off"), ("y", "y"),
        ("1", Fraction(1)), ("-0", Fraction(0)), ("0o17", Fraction(15)), ("0xF", Fraction(15)),
        ("017", Fraction(17)), ("0b11", "0b11"), ("+0x1", "+0x1"), ("1_0", "1_0"), ("1:30", "1:30"),
        ("1e3", Fraction(1000)), ("1.e-2", Fraction(1, 100)), (".", "."), ("e3", "e3"), (".e3", ".e3"),
        ("2001-12-14", "2001-12-14"), ("nan", "nan"), ("1 2", "1 2"), ("=", "="), ("<<", "<<"),
    ],
)  # fmt: skip
def test_core_schema(text: str, value: object):
    result = resolve(text)
    assert result == value and type(result) is type(value)
