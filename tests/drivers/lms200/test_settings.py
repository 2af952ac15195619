"""Scan period by the laser's settings."""

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
