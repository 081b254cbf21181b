"""Exact meaning of scalar text: the YAML 1.2 core rules and decimal literals as fractions.

PyYAML resolves scalars by YAML 1.1 (``1e-3`` a string, ``no`` a boolean, ``1:30`` ninety,
``010`` eight). Nothing of that is used here: the text alone decides, by the rules below.
"""

from __future__ import annotations

import re
from fractions import Fraction

Scalar = None | bool | Fraction | str

LARGEST_EXPONENT = 100
"""Numbers are 0 or between 1e-100 and 1e100 in size: the cube of any of them is a normal double."""
LONGEST_NUMBER = 1000
"""Characters; far more digits than any measurement, few enough to convert at once."""

_NUMBER = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE]([-+]?[0-9]+))?")
_SHORT = re.compile(r"-?[0-9]{1,20}(?:\.[0-9]{1,30})?")
_INTEGER = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_NOT_FINITE_ELSEWHERE = re.compile(r"[-+]?(?:nan|inf|infinity)", re.IGNORECASE)
_CONSTANTS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}


def printable(text: str) -> str:
    """Return the text on one line, control characters escaped."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def quote(text: str) -> str:
    """Return the text in quotes, printable and shortened, for an error message."""
    return f"'{printable(text if len(text) <= 60 else text[:57] + '...')}'"


def read_number(text: str) -> Fraction:
    """Return the exact value of a number's text.

    Parameters
    ----------
    text : str
        A decimal literal such as ``-2.69``, ``.5``, ``1e-3``, or ``0o17``, ``0x1f``. Nothing
        else: no spaces, no underscores, no sexagesimal ``1:30``. ``010`` is ten.

    Returns
    -------
    Fraction
        The number written, not the nearest double.

    Raises
    ------
    ValueError
        When the text is no number, not finite, or out of range; the message quotes the text.
    """
    if _SHORT.fullmatch(text):
        # The usual case first: a batch reads millions.
        whole, _, places = text.partition(".")
        return Fraction(int(whole + places), 10 ** len(places))
    if _NOT_FINITE.fullmatch(text) or _NOT_FINITE_ELSEWHERE.fullmatch(text):
        raise ValueError(f"{quote(text)} is not a finite number")
    decimal = _NUMBER.fullmatch(text)
    if decimal is None and not _INTEGER.fullmatch(text):
        raise ValueError(f"{quote(text)} is not a number")
    if len(text) > LONGEST_NUMBER:
        raise ValueError(f"{quote(text)} has more than {LONGEST_NUMBER} characters")
    if decimal is None:
        value = Fraction(int(text, 0))
    elif not any("1" <= c <= "9" for c in re.split("[eE]", text)[0]):
        return Fraction(0)
    else:
        # The exponent is looked at before 10**exponent is built.
        exponent = int(decimal[1] or 0)
        if abs(exponent) > LARGEST_EXPONENT + LONGEST_NUMBER:
            raise ValueError(_out_of_range(text))
        value = Fraction(text)
    bound = 10**LARGEST_EXPONENT
    if value and not Fraction(1, bound) <= abs(value) <= bound:
        raise ValueError(_out_of_range(text))
    return value


def _out_of_range(text: str) -> str:
    """Return the message for a number of absurd size."""
    return f"{quote(text)} is out of range (0, or 1e-{LARGEST_EXPONENT} to 1e{LARGEST_EXPONENT} in size)"


def resolve(text: str) -> Scalar:
    """Return the value of an unquoted scalar by the YAML 1.2 core schema.

    Parameters
    ----------
    text : str
        The literal as it stands in the file.

    Returns
    -------
    None, bool, Fraction or str
        Every number is an exact `Fraction`; what is nothing else is a string (``no``, ``1:30``, ``1_000``).

    Raises
    ------
    ValueError
        For NaN, infinities (``.nan``, ``.inf``) and numbers out of range.
    """
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if _NUMBER.fullmatch(text) or _INTEGER.fullmatch(text) or _NOT_FINITE.fullmatch(text):
        return read_number(text)
    return text
