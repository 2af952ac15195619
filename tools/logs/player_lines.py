"""The lines of a log of Player's ``writelog`` driver: position2d and laser data.

``time host robot interface index type subtype`` and the data of the interface: of position2d
``x y angle vx vy va stall``, of laser ``scan_id min_angle max_angle resolution max_range count``
and ``range intensity`` of each beam; m, rad, s.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from maps.input_limits import MAX_BEAMS
from maps.pose import Pose
from tools.logs.carmen_lines import LaserParameters, OdometryLine, ScanLine

_LOOKED_AT = 200  # lines in which a data line must be found
_HEAD = 7
_DATA, _STATE, _SCAN = 1, 1, 1
_TURN = 6.4  # rad; a whole turn and a little


def is_player_log(rows: Sequence[str]) -> bool:
    """Whether lines are those of a Player log."""
    for row in rows[:_LOOKED_AT]:
        words = row.split()
        if len(words) > _HEAD and words[3] in ("laser", "position2d", "sync"):
            return words[0].replace(".", "", 1).isdecimal()
    return False


def parse_player_line(row: str, _parameters: LaserParameters) -> OdometryLine | ScanLine | None:
    """Decode one line; None for what is neither scan nor odometry of the first device.

    Raises ValueError or IndexError.
    """
    words = row.split()
    if row.lstrip().startswith(("#", "%")) or len(words) <= _HEAD:
        return None
    device, data = words[3], words[_HEAD:]
    if device not in ("laser", "position2d") or int(words[5]) != _DATA or int(words[4]) != 0:
        return None
    if device == "position2d":
        return _odometry(words, data) if int(words[6]) == _STATE else None
    return _scan(words, data) if int(words[6]) == _SCAN else None


def _odometry(words: Sequence[str], data: Sequence[str]) -> OdometryLine:
    x, y, theta = (float(word) for word in data[:3])
    if not abs(x) + abs(y) + abs(theta) < 1e6:
        raise ValueError(f"position2d at {x:g}, {y:g}, {theta:g}")
    return OdometryLine(float(words[0]), Pose(x, y, theta))


def _scan(words: Sequence[str], data: Sequence[str]) -> ScanLine:
    first, last, step, reach = (float(word) for word in data[1:5])
    count = int(data[5])
    readings = np.array(data[6 : 6 + 2 * count : 2], dtype=np.float64)
    if not (2 <= count <= MAX_BEAMS and len(readings) == count):
        raise ValueError(f"laser with {len(readings)} of {count} beams")
    if not 0.0 < step * (count - 1) <= _TURN:
        step = (last - first) / (count - 1)
    if not 0.0 < step * (count - 1) <= _TURN:
        raise ValueError(f"laser with {count} beams {step:g} rad apart")
    return ScanLine(
        kind="laser",
        t=float(words[0]),
        readings=readings,
        reach=reach if reach > 0.0 else float("inf"),
        angle_min=first,
        angle_increment=step,
        laser=None,
        robot=None,
    )
