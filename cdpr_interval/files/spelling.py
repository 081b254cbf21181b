"""What people mistype in keys and values, and what they are told to write instead.

A hint is the end of a message that says already what is wrong; it is empty where nothing is recognised.
"""

from __future__ import annotations

import re
from collections.abc import Collection

from cdpr_interval.exact.decimals import decimal_text
from cdpr_interval.files.units import UNITS, renamed, unit_of
from cdpr_interval.text.literal import quote, read_number

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_WITH_UNIT = re.compile(rf"({_NUMBER})\s*([A-Za-zµ°%\"'][A-Za-zµ°%/^*²0-9]*)")
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")
_FRACTION = re.compile(r"[-+]?\d+/\d+")
_GROUPED = re.compile(r"[-+]?\d[\d_ ']*\d(?:\.\d+)?")
_LISTED = re.compile(rf"[\[(]?\s*({_NUMBER}(?:\s*[,;\s]\s*{_NUMBER})+)\s*[\])]?")
_KEY_AND_VALUE = re.compile(r"([A-Za-z_][A-Za-z0-9_.-]*):(\S.*)", re.DOTALL)
_GROUPING = str.maketrans("", "", "_ '")
_DASHES = str.maketrans(dict.fromkeys("\u2010\u2011\u2012\u2013\u2014\u2212", "-"))


def key_hint(key: str, known: Collection[str]) -> str:
    """Return what to write instead of an unknown key: a space that is missing, or a key of another unit."""
    if key.startswith("-") and key[1:2].isidentifier():
        return f": a space is missing after the '-', write '- {key[1:]}'"
    if (pair := _KEY_AND_VALUE.fullmatch(key)) and pair[1] in known:
        return f": a space is missing after '{pair[1]}:'"
    told = renamed(key, known)
    return f": {told}" if told else ""


def number_hint(text: str, key: str) -> str:
    """Return what to write instead of a text that is no number, below a key whose unit is known."""
    text = text.strip()
    if text.translate(_DASHES) != text:
        return f": its minus sign is another character, write {text.translate(_DASHES)}"
    if "#" in text:
        return ": a space is missing before the '#' of a comment"
    if "//" in text:
        return ": a comment begins with ' #'"
    if _DECIMAL_COMMA.fullmatch(text):
        return f": decimals have a point, write {text.replace(',', '.')}"
    if _FRACTION.fullmatch(text):
        return ": write it as a decimal"
    if with_unit := _WITH_UNIT.fullmatch(text):
        return _without_unit(with_unit[1], with_unit[2], key)
    if _GROUPED.fullmatch(text):
        return f": write {text.translate(_GROUPING)}"
    return ""


def _without_unit(number: str, unit: str, key: str) -> str:
    """Return how a number with a unit is written in the unit of its key."""
    ours = unit_of(key)
    if ours is None:
        return ": write the number alone"
    factor = UNITS[ours].get(unit)
    try:
        value = read_number(number)
    except ValueError:
        factor = None
    if factor is None:
        same = unit.replace("/", "_per_") == ours or unit == ours.replace("_", "/")
        return f": the unit is in the key, write {number if same else f'the number alone, in {ours}'}"
    written = decimal_text(value * factor)
    return f": the unit is in the key, write {written} ({number} {unit} in {ours})"


def unquoted_hint(text: str) -> str:
    """Return that a number in quotes is a text."""
    try:
        read_number(text)
    except ValueError:
        return ""
    return ": write it without quotes"


def list_hint(text: str) -> str:
    """Return how a list that was typed as a text is written."""
    if listed := _LISTED.fullmatch(text.strip()):
        numbers = ", ".join(re.split(r"[,;\s]+", listed[1]))
        return f": write [{numbers}]"
    return ""


def mapping_hint(text: str) -> str:
    """Return what is missing in a text that was to be a mapping: the space after a colon, or the colon."""
    if pair := _KEY_AND_VALUE.fullmatch(text):
        return f": a space is missing after {quote(pair[1] + ':')}"
    word, _, rest = text.partition(" ")
    if rest and word.isidentifier():
        return f": a ':' is missing after {quote(word)}"
    return ""
