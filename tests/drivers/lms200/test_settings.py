"""Scan period by the laser's settings."""

import math
import re

import pytest

from drivers.lms200.measurement import TURN
from drivers.lms200.settings import LaserSettings


@pytest.mark.parametrize(
    ("baud", "resolution", "partial", "turns"),
    [
        (9600, 1.0, False, 30),
        (38400, 1.0, False, 8),
        (38400, 0.5, False, 16),
        (38400, 0.5, True, 9),  # 8 are on the wire; the next must be of the other phase
        (500000, 1.0, False, 1),
        (500000, 0.5, False, 2),
    ],
)
def test_scan_period_is_in_mirror_turns(baud, resolution, partial, turns):
    """A telegram of 372 bytes takes 29.1 turns at 9600 baud: 29 scans are lost for each sent."""
    settings = LaserSettings(baud=baud, resolution_deg=resolution, partial_scans=partial)
    assert settings.scan_period == pytest.approx(turns * TURN)


@pytest.mark.parametrize(
    ("mount", "words"),
    [
        ((0.017, 0.008, 180.0), "degrees?"),
        ((0.0, 0.0, -3.15), "degrees?"),
        ((17.0, 8.0, 0.0), "millimetres?"),
        ((0.0, -1.01, 0.0), "millimetres?"),
    ],
)
def test_mount_in_other_units_is_refused_with_the_right_question(mount, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        LaserSettings(mount=mount)


def test_mount_backwards_is_accepted():
    assert LaserSettings(mount=(1.0, -1.0, -math.pi)).mount == (1.0, -1.0, -math.pi)
