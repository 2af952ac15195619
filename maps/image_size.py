"""Width and height of an image by its head alone, so that none is decoded that is too large."""

from __future__ import annotations

import re
import struct

_PGM = re.compile(rb"P[2356](?:\s+|#[^\n]*\n){1,99}(\d{1,9})(?:\s+|#[^\n]*\n){1,99}(\d{1,9})\s")
HEAD_BYTES = 4096
"""Bytes in which an image says its size."""
_PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"


def image_size(data: bytes) -> tuple[int, int] | None:
    """Return width and height, pixels, of a PGM (or PPM), PNG or BMP; None for anything else."""
    head = data[:HEAD_BYTES]
    if head.startswith(_PNG) and len(head) >= 24:
        width, height = struct.unpack_from(">II", head, 16)
        return width, height
    if head.startswith(b"BM") and len(head) >= 26:
        width, height = struct.unpack_from("<ii", head, 18)
        return abs(width), abs(height)
    if match := _PGM.match(head):
        return int(match[1]), int(match[2])
    return None
