"""The bytes of a log, plain or compressed, no more of them than a log has."""

from __future__ import annotations

import bz2
import lzma
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from maps.input_limits import MAX_LOG_BYTES

# By the first bytes of a stream: its name, and what decompresses it.
_KINDS: dict[bytes, tuple[str, Callable[[], Any]]] = {
    b"\x1f\x8b": ("gzip", lambda: zlib.decompressobj(wbits=zlib.MAX_WBITS | 16)),
    b"BZh": ("bzip2", bz2.BZ2Decompressor),
    b"\xfd7zXZ\0": ("xz", lzma.LZMADecompressor),
}
_DAMAGED = (zlib.error, lzma.LZMAError, OSError, EOFError, ValueError)


class LogBytesError(ValueError):
    """A log that is damaged or too large; the message names file, line and remedy."""


def read_log_bytes(path: Path) -> tuple[bytes, str | None]:
    """Return a log's bytes and, if a compressed stream ends early, a notice of it.

    Raises LogBytesError for damaged data and too large logs, OSError as ``read_bytes`` does.
    """
    with path.open("rb") as file:
        data = file.read(MAX_LOG_BYTES + 1)
    for start, (name, stream) in _KINDS.items():
        if data.startswith(start):
            return _decompressed(path, data, start, name, stream)
    _check_size(path, data)
    return data, None


def _decompressed(
    path: Path, data: bytes, start: bytes, name: str, new_stream: Callable[[], Any]
) -> tuple[bytes, str | None]:
    """Decompress streams one after another as far as they are complete; padding is left out."""
    text = bytearray()
    while data.startswith(start):
        stream = new_stream()
        try:
            text += stream.decompress(data, MAX_LOG_BYTES + 1 - len(text))
        except _DAMAGED as error:
            raise LogBytesError(
                f"{path}: line {text.count(10) + 1}: damaged {name} data ({error}): "
                "fetch the file again"
            ) from error
        _check_size(path, text)
        if not stream.eof:
            return bytes(text), (
                f"{path}: {name} data end early, in line {text.count(10) + 1}: "
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
