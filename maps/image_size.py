"""Width and height of an image by its head alone, so that none is decoded that is too large."""

from __future__ import annotations

import re
import struct

_PGM = re.compile(rb"P[2356](?:\s+|#[^\n]*\n){1,99}(\d{1,9})(?:\s+|#[^\n]*\n){1,99}(\d{1,9})\s")
HEAD_BYTES = 4096
"""Bytes in which an image says its size."""
_PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"
_JPEG = b"\xff\xd8\xff"
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # markers that tell a JPEG's size
_ALONE = frozenset((0x01, *range(0xD0, 0xD8)))  # markers without a length


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


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Return width and height, pixels, that a JPEG claims; None if it is none."""
    if not data.startswith(_JPEG):
        return None
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker in _FRAMES:
            height = int.from_bytes(data[at + 5 : at + 7], "big")
            width = int.from_bytes(data[at + 7 : at + 9], "big")
            return width, height
        if marker == 0xFF:  # a fill byte
            at += 1
        elif marker in _ALONE:
            at += 2
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return None
