"""The records in a chunk of a recording, decompressed to no more than the chunk claims."""

from __future__ import annotations

import zlib
from collections.abc import Callable

import zstandard
from mcap.records import Chunk

from maps.input_limits import MAX_RECORD_BYTES

_WINDOW_LOG = 23
"""Largest zstd window, bits: 8 MB, what every decoder supports."""


def chunk_data(chunk: Chunk) -> bytes:
    """Return a chunk's records, decompressed and checked.

    Raises ValueError if its size is not the one it claims or too large, or a checksum fails;
    ZstdError or RuntimeError (lz4) for damaged data.
    """
    size = chunk.uncompressed_size
    if size > MAX_RECORD_BYTES:
        raise ValueError("a chunk there claims an impossible size")
    data: bytes = _DECOMPRESS[chunk.compression](chunk.data, size)
    if len(data) != size:
        raise ValueError("a chunk there holds more or less than it claims")
    if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise ValueError("a chunk there fails its checksum")
    return data


def _of_zstd(data: bytes, size: int) -> bytes:
    decompressor = zstandard.ZstdDecompressor(max_window_size=1 << _WINDOW_LOG)
    with decompressor.stream_reader(data) as reader:
        return bytes(reader.read(size + 1))


def _of_lz4(data: bytes, size: int) -> bytes:
    import lz4.frame  # type: ignore[import-untyped]

    decompressor = lz4.frame.LZ4FrameDecompressor()
    return bytes(decompressor.decompress(data, size + 1))


_DECOMPRESS: dict[str, Callable[[bytes, int], bytes]] = {
    "": lambda data, _size: data,
    "zstd": _of_zstd,
    "lz4": _of_lz4,
}
