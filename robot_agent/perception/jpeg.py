"""Decodes pictures that may be broken or claim to be huge."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.image_size import jpeg_size
from maps.input_limits import MAX_PICTURE_PIXELS


def is_shown(data: bytes) -> bool:
    """Return whether a JPEG has a size that a viewer shows without harm."""
    return _is_harmless(jpeg_size(data))


def decode_jpeg(data: bytes) -> NDArray[np.uint8] | None:
    """Return a picture (height, width, 3), blue, green, red; None if it is broken or too large."""
    return decode_picture(data, jpeg_size(data))


def decode_picture(data: bytes, size: tuple[int, int] | None) -> NDArray[np.uint8] | None:
    """Return as ``decode_jpeg`` a picture of any kind by the size, pixels, that its head claims."""
    if not _is_harmless(size):
        return None
    try:
        picture = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    return None if picture is None else np.asarray(picture, dtype=np.uint8)


def _is_harmless(size: tuple[int, int] | None) -> bool:
    width, height = size or (0, 0)
    return 0 < width * height <= MAX_PICTURE_PIXELS
