"""The file around a certificate: a digest line and a gzip stream of JSON."""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import zlib
from pathlib import Path
from typing import Any

from certificates.verdicts import Malformed

HEAD = b"cdpr-certificate/1 sha256:"
LIMIT = 2**26
"""Most bytes of a document, and of its file, unless more is asked for: gzip packs a thousand into one."""
TOO_LARGE = "too large (over {} bytes; --size-limit allows more)"
BYTES_PER_VALUE = 32
"""A document has at most one value for so many bytes of the limit: a value takes up to 100 of memory."""


def read(path: str | Path) -> dict[str, Any]:
    """Return the document of a file."""
    return unpack(load(path))


def load(path: str | Path, limit: int | None = None) -> bytes:
    """Return the bytes of a file."""
    limit = limit or LIMIT
    try:
        with Path(path).open("rb") as file:
            content = file.read(limit + 1)
        if len(content) > limit:
            raise Malformed(f"the file is {TOO_LARGE.format(limit)}")
        return content
    except (OSError, ValueError) as error:
        raise Malformed(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None


def unpack(content: bytes, limit: int | None = None) -> dict[str, Any]:
    """Return the document in a file's bytes.

    Memory: about ten times the limit, whatever the content.
    """
    limit = limit or LIMIT
    line, _, body = content.partition(b"\n")
    if line != HEAD + hashlib.sha256(body).hexdigest().encode():
        raise Malformed("the first line is not that of a certificate with this content")
    stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
    try:
        text = stream.decompress(body, limit)
        if not stream.eof or stream.unused_data:
            raise Malformed(f"the content is {TOO_LARGE.format(limit)}, or not exactly one gzip stream")
        if sum(map(text.count, (b",", b"[", b"{"))) > limit // BYTES_PER_VALUE:
            raise Malformed(f"the content has too many values (over {limit // BYTES_PER_VALUE})")
        document = json.loads(text.decode(), object_pairs_hook=without_duplicates, parse_constant=refused)
    except (zlib.error, ValueError, RecursionError) as error:
        raise Malformed(f"the content is not gzip of JSON: {ascii(str(error))[1:80]}") from None
    if not isinstance(document, dict):
        raise Malformed("the content is not an object")
    return document


def without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object, refused where a key comes twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise Malformed("a key comes twice")
    return found


def refused(name: str) -> None:
    """Refuse NaN and Infinity."""
    raise Malformed(f"{name} is not a number")


def pack(document: dict[str, Any]) -> bytes:
    """Return the bytes of a file: the same for the same document."""
    text = json.dumps(document, sort_keys=True, separators=(",", ":"), allow_nan=False)
    body = gzip.compress(text.encode(), mtime=0)
    return HEAD + hashlib.sha256(body).hexdigest().encode() + b"\n" + body


def write(path: str | Path, document: dict[str, Any]) -> None:
    """Write a document in one step."""
    target = Path(os.path.realpath(path))
    scratch = target.with_name(f".{target.name[:100]}.{os.getpid()}.part")
    try:
        scratch.write_bytes(pack(document))
        scratch.replace(target)
    except BaseException:
        scratch.unlink(missing_ok=True)
        raise
