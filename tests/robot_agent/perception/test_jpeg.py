"""Pictures that are broken or claim to be huge: refused by their head, never an exception."""

from __future__ import annotations

import resource
import struct

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.camera_source import CameraSettings
from maps.image_size import jpeg_size
from maps.pose import Pose
from robot_agent.perception.intruder_evidence import cut_out
from robot_agent.perception.jpeg import decode_jpeg, is_shown

PIXELS = np.random.default_rng(1).integers(0, 255, (48, 64, 3), dtype=np.uint8)
JPEG = cv2.imencode(".jpg", PIXELS)[1].tobytes()
PROGRESSIVE = cv2.imencode(".jpg", PIXELS, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()
GREY = cv2.imencode(".jpg", PIXELS[..., 0])[1].tobytes()


def claiming(width: int, height: int, jpeg: bytes = JPEG) -> bytes:
    """Return a picture whose head claims another size."""
    at = jpeg.index(b"\xff\xc0") if b"\xff\xc0" in jpeg else jpeg.index(b"\xff\xc2")
    return jpeg[: at + 5] + struct.pack(">HH", height, width) + jpeg[at + 9 :]


def with_channels(count: int) -> bytes:
    """Return a picture whose head claims another number of channels."""
    at = JPEG.index(b"\xff\xc0")
    return JPEG[: at + 9] + bytes([count]) + JPEG[at + 10 :]


@pytest.mark.parametrize("jpeg", [JPEG, PROGRESSIVE, GREY])
def test_size_is_read_from_the_head(jpeg: bytes) -> None:
    assert jpeg_size(jpeg) == (64, 48)
    assert is_shown(jpeg)
    decoded = decode_jpeg(jpeg)
    assert decoded is not None
    assert decoded.shape == PIXELS.shape


@pytest.mark.parametrize(
    "jpeg",
    [
        b"",
        b"GIF89a",
        JPEG[:20],
        claiming(65500, 65500),
        claiming(65500, 65500, PROGRESSIVE),
        claiming(20_000, 20_000),
        claiming(0, 48),
    ],
)
def test_what_is_no_picture_or_too_large_is_not_decoded(jpeg: bytes) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert decode_jpeg(jpeg) is None
    assert not is_shown(jpeg)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kB


@pytest.mark.parametrize("count", [0, 2, 4, 255])
def test_wrong_numbers_of_channels_are_no_exception(count: int) -> None:
    decode_jpeg(with_channels(count))


@pytest.mark.parametrize("share", [0.3, 0.5, 0.9])
def test_picture_that_breaks_off_is_none(share: float) -> None:
    assert decode_jpeg(JPEG[: round(share * len(JPEG))]) is None


@given(st.binary(max_size=400) | st.builds(lambda rest: b"\xff\xd8\xff" + rest, st.binary()))
def test_garbage_is_none_or_a_picture(data: bytes) -> None:
    assert decode_jpeg(data) is None or is_shown(data)


@given(st.data())
def test_changed_pictures_are_none_or_a_picture(data: st.DataObject) -> None:
    jpeg = bytearray(data.draw(st.sampled_from([JPEG, PROGRESSIVE, GREY])))
    for at in data.draw(st.lists(st.integers(0, len(jpeg) - 1), min_size=1, max_size=8)):
        jpeg[at] = data.draw(st.integers(0, 255))
    decoded = decode_jpeg(bytes(jpeg[: data.draw(st.integers(0, len(jpeg)))]))
    assert decoded is None or (decoded.ndim, decoded.shape[2]) == (3, 3)


@given(st.binary(max_size=60), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_evidence_of_any_bytes_is_a_text(tail: bytes, x: float, y: float) -> None:
    camera = CameraSettings()
    for jpeg in (tail, JPEG[:700] + tail, claiming(65500, 65500) + tail):
        assert isinstance(cut_out(jpeg, camera, Pose(0.0, 0.0, 0.0), (x, y)), str)
