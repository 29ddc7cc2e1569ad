"""The bytes of a file as lines of text: unpacked, decoded, never more than the bounds admit."""

from __future__ import annotations

import codecs
import gzip
import io
import zlib
from types import MappingProxyType

from tracker_core.checks import InputError
from tracker_core.recordings.bounds import MOST_BYTES, MOST_UNPACKED

GZIP = b"\x1f\x8b"

KNOWN_AS = MappingProxyType(
    {
        b"PK\x03\x04": "a ZIP archive or an Excel workbook",
        b"\xd0\xcf\x11\xe0": "an old Excel workbook",
        b"PAR1": "a Parquet file",
        b"\x89HDF": "an HDF5 file",
        b"SQLite": "an SQLite database",
        b"%PDF": "a PDF document",
        b"\x89PNG": "a picture",
        b"\xff\xd8\xff": "a picture",
        b"BZh": "a bzip2 file",
        b"\xfd7zXZ": "an xz file",
        b"\x28\xb5\x2f\xfd": "a Zstandard file",
        b"MATLAB": "a MATLAB file",
        b"<?xml": "an XML (perhaps GPX or KML) document",
        b"<gpx": "a GPX document",
        b"<!DOC": "an HTML page",
        b"<html": "an HTML page",
    }
)
"""Files that are taken for tables by mistake, by their first bytes."""

_MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}

_CONTROLS = bytes([*range(9), *range(14, 27), *range(28, 32), 127])
_FEW_STRANGE = 20
_MOST_STRANGE = 0.02
"""Number and share of control characters over both of which bytes are no text."""

_PIECE = 1 << 20


class Content:
    """The text of a file.

    Attributes:
        encoding: that it is read by: "utf-8-sig", "utf-16", "utf-8" or, where the bytes fit none, "latin-1".
        packed: whether it came as gzip.

    Raises:
        InputError: naming the bound that the file passes, or what it is in place of a table.
    """

    def __init__(self, data: bytes) -> None:
        if len(data) > MOST_BYTES:
            rule = f"must have at most {MOST_BYTES:,} bytes: thin it out, or pack it with gzip"
            raise InputError("file", rule, f"{len(data):,} bytes")
        self.packed = data[:2] == GZIP
        self._data = _unpack(data) if self.packed else data
        for start, name in KNOWN_AS.items():
            if self._data.startswith(start):
                raise InputError("file", "must be a table as text (CSV): save or export it as one", name)
        self.encoding = _encoding(self._data)
        if self.encoding != "utf-16":
            # Loggers lay files out ahead with zeros.
            self._data = self._data.rstrip(b"\0")
            strange = len(self._data) - len(self._data.translate(None, _CONTROLS))
            if strange > max(_FEW_STRANGE, _MOST_STRANGE * len(self._data)):
                raise InputError("file", "must be a table as text (CSV): save or export it as one", "binary data")

    def open(self) -> io.TextIOWrapper:
        """A fresh stream of its text, with a line feed for every end of a line."""
        errors = "replace" if self.encoding == "utf-16" else "strict"
        return io.TextIOWrapper(io.BytesIO(self._data), encoding=self.encoding, errors=errors)


def _unpack(data: bytes) -> bytes:
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
            content = stream.read(MOST_UNPACKED + 1)
    except (EOFError, OSError, zlib.error) as error:
        raise InputError("file", "must be a whole gzip file: pack it again", str(error)) from None
    if len(content) > MOST_UNPACKED:
        rule = f"must unpack to at most {MOST_UNPACKED:,} bytes: thin it out"
        raise InputError("file", rule, f"more than {MOST_UNPACKED:,} bytes")
    return content


def _encoding(data: bytes) -> str:
    for mark, encoding in _MARKS.items():
        if data.startswith(mark) and (encoding == "utf-16" or _is_utf8(data)):
            return encoding
    return "utf-8" if _is_utf8(data) else "latin-1"


def _is_utf8(data: bytes) -> bool:
    """Whether the bytes decode, without holding the text."""
    decoder = codecs.getincrementaldecoder("utf-8")()
    view = memoryview(data)
    try:
        for start in range(0, len(view), _PIECE):
            decoder.decode(view[start : start + _PIECE])
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return False
    return True
