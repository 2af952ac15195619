"""The bytes of a log, plain or gzip, no more of them than a log has."""

from __future__ import annotations

import zlib
from pathlib import Path

from maps.input_limits import MAX_LOG_BYTES

_GZIP = b"\x1f\x8b"


class LogBytesError(ValueError):
    """A log that is damaged or too large; the message names file, line and remedy."""


def read_log_bytes(path: Path) -> tuple[bytes, str | None]:
    """Return a log's bytes and, if a gzip stream ends early, a notice of it.

    Raises LogBytesError for damaged gzip data and too large logs, OSError as ``read_bytes`` does.
    """
    with path.open("rb") as file:
        data = file.read(MAX_LOG_BYTES + 1)
    if data[:2] == _GZIP:
        return _decompressed(path, data)
    _check_size(path, data)
    return data, None


def _decompressed(path: Path, data: bytes) -> tuple[bytes, str | None]:
    """Decompress gzip members as far as they are complete."""
    text = bytearray()
    while data:
        stream = zlib.decompressobj(wbits=zlib.MAX_WBITS | 16)
        try:
            text += stream.decompress(data, MAX_LOG_BYTES + 1 - len(text))
        except zlib.error as error:
            raise LogBytesError(
                f"{path}: line {text.count(10) + 1}: damaged gzip data ({error}): "
                "fetch the file again"
            ) from error
        _check_size(path, text)
        if not stream.eof:
            return bytes(text), (
                f"{path}: gzip data end early, in line {text.count(10) + 1}: "
                "the whole lines before it are used"
            )
        data = stream.unused_data
    return bytes(text), None


def _check_size(path: Path, text: bytes | bytearray) -> None:
    if len(text) > MAX_LOG_BYTES:
        raise LogBytesError(
            f"{path}: line {text.count(10) + 1}: has more than {MAX_LOG_BYTES >> 20} MB of text: "
            "split it"
        )
