"""Decodes JPEG pictures that may be broken or claim to be huge."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.input_limits import MAX_PICTURE_PIXELS

START = b"\xff\xd8\xff"
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # markers that tell the size
_ALONE = frozenset((0x01, *range(0xD0, 0xD8)))  # markers without a length


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Return width and height, pixels, that a JPEG claims; None if it is none."""
    if not data.startswith(START):
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


def is_shown(data: bytes) -> bool:
    """Return whether a JPEG has a size that a viewer shows without harm."""
    width, height = jpeg_size(data) or (0, 0)
    return 0 < width * height <= MAX_PICTURE_PIXELS


def decode_jpeg(data: bytes) -> NDArray[np.uint8] | None:
    """Return a picture (height, width, 3), blue, green, red; None if it is broken or too large."""
    if not is_shown(data):
        return None
    try:
        picture = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    return None if picture is None else np.asarray(picture, dtype=np.uint8)
