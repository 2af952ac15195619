"""The lines of a CARMEN log: scans and odometry as loggers write them, with or without stamps.

Formats: the CARMEN toolkit's logger, and the forms of it that other programs write.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from maps.input_limits import MAX_BEAMS
from maps.pose import Pose

# Field of view and beam step, degrees, of a SICK LMS by its number of beams; the first beam is at
# the right. Others span the half turn.
_GEOMETRIES = {
    n: (180.0, step) for step, counts in ((1.0, (180, 181)), (0.5, (360, 361))) for n in counts
} | {
    720: (180.0, 0.25),
    721: (180.0, 0.25),
    101: (100.0, 1.0),
    201: (100.0, 0.5),
    401: (100.0, 0.25),
}
_HALF_TURN = 180.0
_WHOLE_TURN = math.tau + 1e-3  # rad
_LEAST_BEAMS = 2
_LARGEST = 1e10  # m, rad, s; a wall clock's seconds are below
_STAMPED = {0: None, 1: 0, 2: 0, 3: 2}
"""Index of the stamp to use among the last words of a line, by their number."""


@dataclass(frozen=True, slots=True)
class OdometryLine:
    """Raw odometry of the robot; t: s, None without a stamp."""

    t: float | None
    pose: Pose


@dataclass(frozen=True, slots=True, eq=False)
class ScanLine:
    """One scan as logged."""

    kind: str
    """Message of the line: scanners of one robot differ in it."""
    t: float | None
    readings: NDArray[np.float64]
    """(n,) as logged, counter-clockwise."""
    reach: float
    """The scanner's maximum range by the line; inf if it does not say."""
    angle_min: float
    angle_increment: float
    """rad."""
    laser: Pose | None
    robot: Pose | None
    """Poses of laser and robot; None: the line has none."""


@dataclass(slots=True)
class LaserParameters:
    """What PARAM lines say about the front laser; None: nothing."""

    resolution: float | None = None
    """rad."""
    field_of_view: float | None = None
    """rad."""
    max_range: float | None = None
    """m."""
    ahead: float = 0.0
    left: float = 0.0
    """m, of the laser from the robot's centre."""
    turned: float = 0.0
    """rad, likewise."""
    _names: dict[str, str] = field(
        default_factory=lambda: {
            "laser_front_laser_resolution": "resolution",
            "laser_front_laser_fov": "field_of_view",
            "robot_front_laser_max": "max_range",
            "laser_front_laser_max_range": "max_range",
            "robot_frontlaser_offset": "ahead",
            "robot_frontlaser_side_offset": "left",
            "robot_frontlaser_angular_offset": "turned",
        }
    )

    @property
    def mount(self) -> Pose:
        """base_from_laser."""
        return Pose(self.ahead, self.left, self.turned)

    def take(self, words: Sequence[str]) -> None:
        """Take in the words of a line, ``name value ...``; those of other parts are ignored."""
        name = self._names.get(words[0]) if len(words) > 1 else None
        if name is None:
            return
        value = _number(words[1])
        if name in ("resolution", "field_of_view"):
            value = math.radians(value)
        if value > 0.0 or name in ("ahead", "left", "turned"):
            setattr(self, name, value)


def parse_line(row: str, parameters: LaserParameters) -> OdometryLine | ScanLine | None:
    """Decode one line; None for messages that contain neither scan nor odometry.

    parameters: of the lines before; a PARAM line changes them. Raises ValueError or IndexError.
    """
    words = row.split()
    if not words:
        return None
    kind, rest = words[0], words[1:]
    if kind == "PARAM":
        parameters.take(rest)
    elif kind == "ODOM":
        return _odometry(rest)
    elif kind == "FLASER":
        return _front_laser(rest, parameters)
    elif kind in ("ROBOTLASER0", "ROBOTLASER1", "ROBOTLASER2"):
        return _robot_laser(kind, rest)
    elif kind == "RAWLASER1":
        return _raw_laser(kind, rest)
    return None


def _odometry(words: list[str]) -> OdometryLine:
    """``x y theta [tv rv accel] [ipc_timestamp ipc_hostname logger_timestamp]``."""
    _require(len(words) in (3, 4, 6, 7, 8, 9), f"ODOM with {len(words)} fields instead of 9")
    stamps = words[6:] if len(words) > 4 else words[3:]
    return OdometryLine(_stamp(stamps), _pose(words[0:3]))


def _front_laser(words: list[str], parameters: LaserParameters) -> ScanLine:
    """``n r1..rn x y theta odom_x odom_y odom_theta [ipc_timestamp host logger_timestamp]``."""
    count = int(words[0])
    _require(_LEAST_BEAMS <= count <= MAX_BEAMS, f"FLASER with {count} beams")
    stamps = len(words) - 1 - count - 6
    _require(stamps in _STAMPED, f"FLASER with {len(words)} fields instead of {count + 10}")
    tail = words[1 + count :]
    angle_min, increment = _geometry(count, parameters)
    return ScanLine(
        kind="FLASER",
        t=_stamp(tail[6:]),
        readings=np.array(words[1 : 1 + count], dtype=np.float64),
        reach=math.inf,
        angle_min=angle_min,
        angle_increment=increment,
        laser=_pose(tail[0:3]),
        robot=_pose(tail[3:6]),
    )


def _geometry(count: int, parameters: LaserParameters) -> tuple[float, float]:
    """Return direction of the first beam and step, rad, of a FLASER line's beams."""
    degrees, step = _GEOMETRIES.get(count, (_HALF_TURN, _HALF_TURN / (count - 1)))
    whole, increment = math.radians(degrees), math.radians(step)
    if parameters.resolution is not None and parameters.resolution * (count - 1) <= _WHOLE_TURN:
        increment = parameters.resolution
        whole = increment * (count - 1)
        if abs(count * increment - math.pi) < 0.5 * increment:
            whole = math.pi  # the beam at the left is left out
    if parameters.field_of_view is not None:
        whole = parameters.field_of_view
        increment = whole / (count if abs(whole / count - increment) < 1e-6 else count - 1)
    return -0.5 * whole, increment


def _robot_laser(kind: str, words: list[str]) -> ScanLine:
    """Decode a ROBOTLASER line.

    That of a RAWLASER line, with ``laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv
    forward_safety side_safety turn_axis`` before the stamps.
    """
    scan, tail = _configured_scan(kind, words, 11)
    return replace(scan, laser=_pose(tail[0:3]), robot=_pose(tail[3:6]))


def _raw_laser(kind: str, words: list[str]) -> ScanLine:
    """Decode a RAWLASER line.

    ``type start_angle field_of_view resolution maximum_range accuracy remission_mode n r1..rn
    m e1..em [ipc_timestamp host logger_timestamp]``.
    """
    return _configured_scan(kind, words, 0)[0]


def _configured_scan(kind: str, words: list[str], more: int) -> tuple[ScanLine, list[str]]:
    """Return a scan that says its geometry, without poses, and its words after the remissions."""
    count = int(words[7])
    _require(_LEAST_BEAMS <= count <= MAX_BEAMS, f"{kind} with {count} beams, no laser's")
    remissions = int(words[8 + count])
    tail = words[9 + count + remissions :]
    _require(
        remissions >= 0 and len(tail) - more in _STAMPED,
        f"{kind} with {len(words)} fields instead of {9 + count + max(remissions, 0) + more + 3}",
    )
    start, field_of_view, increment = (_number(word) for word in words[1:4])
    if max(abs(start), abs(field_of_view)) > _WHOLE_TURN:  # degrees
        start, field_of_view = math.radians(start), math.radians(field_of_view)
        increment = math.radians(increment)
    if not 0.0 < increment * (count - 1) <= _WHOLE_TURN:
        increment = field_of_view / (count - 1)
    _require(
        0.0 < increment * (count - 1) <= _WHOLE_TURN,
        f"{kind} with {count} beams {increment:g} rad apart, no laser's",
    )
    reach = _number(words[4])
    scan = ScanLine(
        kind=kind,
        t=_stamp(tail[more:]),
        readings=np.array(words[8 : 8 + count], dtype=np.float64),
        reach=reach if reach > 0.0 else math.inf,
        angle_min=start,
        angle_increment=increment,
        laser=None,
        robot=None,
    )
    return scan, tail


def _stamp(words: Sequence[str]) -> float | None:
    index = _STAMPED.get(len(words))
    return None if index is None else _number(words[index])


def _require(condition: bool, complaint: str) -> None:
    if not condition:
        raise ValueError(complaint)


def _number(word: str) -> float:
    value = float(word)
    _require(abs(value) <= _LARGEST, f"{word!r:.40} is not a finite number of a log")
    return value


def _pose(words: Sequence[str]) -> Pose:
    return Pose(_number(words[0]), _number(words[1]), _number(words[2]))
