"""A reader of certificates written from docs/certificate.md alone: the standard library, nothing else."""

import base64
import gzip
import hashlib
import json
import struct
from pathlib import Path
from typing import Any

HEAD = b"cdpr-certificate/1 sha256:"
PAYLOAD = {18: 1, 19: 24}
"""Bytes after the code of a leaf."""
CHILDREN = {6: 2, 7: 1, 8: 1}


def read(path: Path) -> dict[str, Any]:
    """Return the document."""
    first, _, rest = path.read_bytes().partition(b"\n")
    assert first == HEAD + hashlib.sha256(rest).hexdigest().encode()
    document: dict[str, Any] = json.loads(gzip.decompress(rest))
    assert document["format"] == "cdpr-certificate/1"
    return document


def subtree(tree: bytes, start: int) -> int:
    """Return the end of the subtree that starts at a place."""
    waiting, place = 1, start
    while waiting:
        code = tree[place]
        place += 1
        waiting -= 1
        if code < 6:
            waiting += 2
        elif code in CHILDREN:
            waiting += CHILDREN[code]
            if code == 7:
                place += 1 + 16 * tree[place].bit_count()
        else:
            assert 16 <= code <= 22
            place += PAYLOAD.get(code, 0)
    return place


def nodes(tree: bytes) -> list[int]:
    """Return where the nodes start."""
    found, place = [], 0
    while place < len(tree):
        found.append(place)
        code = tree[place]
        place += 1 + (1 + 16 * tree[place + 1].bit_count() if code == 7 else PAYLOAD.get(code, 0))
    return found


def leaves(tree: bytes) -> list[int]:
    """Return the codes of all leaves."""
    assert subtree(tree, 0) == len(tree)
    return [tree[place] for place in nodes(tree) if tree[place] >= 16]


def trees(document: dict[str, Any]) -> list[bytes]:
    """Return all trees of a document."""
    searches = [search for entry in document["subsets"] for search in entry.get("searches", [])]
    return [base64.b64decode(t) for search in searches for t in search["trees"] if t is not None]


def direction(tree: bytes, place: int) -> tuple[int, ...]:
    """Return y of a leaf that says unbalanced."""
    assert tree[place] == 19
    return struct.unpack_from("<6i", tree, place + 1)
