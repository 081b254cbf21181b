"""The file around a certificate: nothing but what was written is read."""

import gzip
import hashlib
import json
import subprocess
import sys

import pytest

import certificates
from certificates import container
from certificates.verdicts import Malformed, Verdict
from tests.support.made_certificates import hanging, written


def packed(body: bytes) -> bytes:
    """Return a file with a correct digest."""
    return container.HEAD + hashlib.sha256(body).hexdigest().encode() + b"\n" + body


def text(document: str) -> bytes:
    """Return a file of any text."""
    return packed(gzip.compress(document.encode()))


@pytest.fixture(scope="module")
def content() -> bytes:
    return container.pack(hanging())


def test_what_is_written_is_read(tmp_path):
    document = hanging()
    path = written(tmp_path, document)
    assert container.read(path) == document
    assert certificates.check(path).verdict is Verdict.PROVED
    before = path.read_bytes()
    container.write(path, dict(reversed(document.items())))
    assert path.read_bytes() == before and [p.name for p in tmp_path.iterdir()] == ["made.cert"]


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = written(tmp_path, hanging())
    before = path.read_bytes()
    with pytest.raises(ValueError):
        container.write(path, {"x": float("nan")})
    assert path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def test_every_flipped_byte_is_noticed(content):
    for place in range(len(content)):
        for bit in (1, 32, 128):
            flipped = bytearray(content)
            flipped[place] ^= bit
            with pytest.raises(Malformed):
                container.unpack(bytes(flipped))


def test_a_flipped_byte_is_malformed(content, tmp_path):
    path = tmp_path / "flipped"
    for place in (0, 17, 60, 90, 91, 100, len(content) - 1):
        flipped = bytearray(content)
        flipped[place] ^= 4
        path.write_bytes(flipped)
        assert certificates.check(path).verdict is Verdict.MALFORMED


def test_every_truncation_and_addition_is_noticed(content):
    for size in range(len(content)):
        with pytest.raises(Malformed):
            container.unpack(content[:size])
    for more in (b"\0", b"\n", content):
        with pytest.raises(Malformed):
            container.unpack(content + more)


@pytest.mark.parametrize("change", ["short", "second stream", "byte"])
def test_a_gzip_stream_that_is_not_exactly_one_is_refused(content, change):
    body = content[content.index(b"\n") + 1 :]
    body = {"short": body[:-9], "second stream": body + body, "byte": body + b"\0"}[change]
    with pytest.raises(Malformed):
        container.unpack(packed(body))


def test_a_bomb_is_refused(monkeypatch):
    monkeypatch.setattr(container, "LIMIT", 1000)
    assert container.unpack(text('{"a":"' + "x" * 900 + '"}'))
    with pytest.raises(Malformed, match="too large"):
        container.unpack(text('{"a":"' + "x" * 1000 + '"}'))


@pytest.mark.parametrize(
    "document",
    [
        '{"a":1,"a":1}',
        '{"b":{"a":1,"c":[],"a":2}}',
        '{"a":NaN}',
        '{"a":-Infinity}',
        '{"a":' + "[" * 200_000 + "]" * 200_000 + "}",
        '{"a":' + "9" * 5000 + "}",
        "[1]",
        "null",
        "",
        '{"a":1} x',
    ],
    ids=lambda text: text[:20],
)
def test_other_text_is_refused(document):
    with pytest.raises(Malformed) as refusal:
        container.unpack(text(document))
    assert len(str(refusal.value).splitlines()) == 1


@pytest.mark.parametrize("encoding", ["utf-16", "latin-1", "utf-8-sig"])
def test_other_encodings_are_refused(encoding):
    body = gzip.compress(json.dumps({"a": "\u00e9"}, ensure_ascii=False).encode(encoding))
    with pytest.raises(Malformed):
        container.unpack(packed(body))


def test_files_that_cannot_be_read_are_malformed(tmp_path):
    (tmp_path / "empty").touch()
    for path in (tmp_path, tmp_path / "nothing", tmp_path / "empty", "a\0b"):
        report = certificates.check(path)
        assert report.verdict is Verdict.MALFORMED and len(report.lines()[0].splitlines()) == 1


def test_the_check_is_imported_on_use():
    early, late = ("assert 'flint' not in sys.modules", "assert 'flint' in sys.modules")
    code = f"import sys, certificates; {early}; certificates.check; {late}"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
    with pytest.raises(AttributeError):
        _ = certificates.nothing
