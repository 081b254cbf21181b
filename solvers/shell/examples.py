"""Examples at the end of a command's help: lines that run as they stand, one after the other."""

from __future__ import annotations

HEAD = "Examples:"


def examples(*lines: str) -> str:
    """Return an epilog with a line for each example, without the name of the program."""
    # Behind the mark click leaves lines as they are.
    return "\b\n" + "\n".join([HEAD, *(f"  cdpr-solve {line}" for line in lines)])
