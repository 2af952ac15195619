"""CARMEN logs: laser scans with corrected poses, and the raw odometry recovered between them.

In logs corrected by gmapping both poses of a scan line are the corrected pose, and the ODOM lines
after a scan are raw odometry re-based onto it. The raw increment between two scans is therefore
``inverse(first ODOM after scan k-1) o (last ODOM before scan k)``; composing those gives the raw
odometry. In a log that was not corrected the scan line's own odometry pose is raw and is used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maps.input_limits import MAX_BEAMS, MAX_DURATION_S, MAX_PAUSE_S
from maps.pose import Pose
from tools.logs.log_bytes import LogBytesError, read_log_bytes
from tools.logs.no_return import no_return

# Beams of a SICK LMS over its half turn, first beam at the right (-90 degrees).
_INCREMENT_DEGREES = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5}
_LARGEST = 1e10  # m, rad, s; a wall clock's seconds are below
_LEAST_BEAMS = 2
_WHOLE_TURN = math.tau + 1e-3  # rad
_MIN_STEP = 0.03  # s; least time between two scans: two mirror turns of an LMS
_SAME_POSE = 1e-6  # m and rad; an ODOM line this close to a scan's pose repeats it


class LogError(ValueError):
    """A file is not a readable CARMEN log; the message names file, line and remedy."""


@dataclass(frozen=True, slots=True, eq=False)
class CarmenScan:
    """One scan of a log."""

    t: float
    """Log time, s; increasing (a scan stamped too early is put two mirror turns after the last)."""
    ranges: NDArray[np.float64]
    """(n,) m, counter-clockwise; inf for no return."""
    angle_min: float
    """Direction of the first beam in the laser's frame, rad."""
    angle_increment: float
    """Angle from one beam to the next, rad."""
    reference: Pose
    """map_from_laser, corrected."""
    odometry: Pose
    """odom_from_laser, raw odometry with its drift."""

    def points(self) -> NDArray[np.float64]:
        """Return (m, 2) the points of the beams that returned, m, laser frame."""
        ranges, angles = self.beams()
        return np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))

    def beams(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (m,) ranges, m, and (m,) directions, rad, laser frame, of beams with a return."""
        angles = self.angle_min + self.angle_increment * np.arange(self.ranges.size)
        valid = np.isfinite(self.ranges)
        return self.ranges[valid], np.asarray(angles[valid], dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class CarmenLog:
    """Scans and raw odometry of a CARMEN log, in file order."""

    path: Path
    scans: list[CarmenScan]
    odometry: list[tuple[float, Pose]]
    """Raw odometry at strictly increasing times; the knot at a scan's time is the scan's own."""
    lines: list[tuple[float, Pose]] = field(default_factory=list)
    """All raw odometry in file order, which is the order of motion, with the logged stamps."""
    scan_lines: list[int] = field(default_factory=list)
    """Index of each scan in ``lines``."""
    notes: list[str] = field(default_factory=list)
    """What was assumed or left out in reading the log, a line each, for people."""


@dataclass(frozen=True, slots=True)
class _OdometryLine:
    t: float
    pose: Pose


@dataclass(frozen=True, slots=True, eq=False)
class _RawOdometry:
    at_scans: list[Pose]
    knots: list[tuple[float, Pose]]
    lines: list[tuple[float, Pose]]
    scan_lines: list[int]


@dataclass(frozen=True, slots=True, eq=False)
class _ScanLine:
    t: float
    readings: NDArray[np.float64]
    reach: float
    angle_min: float
    angle_increment: float
    laser: Pose
    robot: Pose


def read_carmen(path: Path, max_range: float | None = None) -> CarmenLog:
    """Read a CARMEN log, plain or gzip; of a truncated file the complete lines are used.

    max_range: readings from which on mean no return, m; None: by the log. Raises LogError naming
    file, line and remedy.
    """
    text, truncated = _read_text(path)
    lines, cut_line = _parse(path, text, may_be_cut=truncated is not None)
    truncated = truncated or cut_line
    if not any(isinstance(line, _ScanLine) for line in lines):
        raise LogError(
            f"{path}: line 1: no FLASER or ROBOTLASER1 line in the file: "
            "give a CARMEN log with laser scans"
        )
    intervals = _odometry_between_scans(lines)
    scan_lines = [line for line in lines if isinstance(line, _ScanLine)]
    times = _scan_times(scan_lines)
    raw = _raw_odometry(scan_lines, times, intervals)
    far = no_return([line.readings for line in scan_lines], max_range)
    scans = [
        CarmenScan(
            t=t,
            ranges=_usable(line.readings, min(far.limit, line.reach)),
            angle_min=line.angle_min,
            angle_increment=line.angle_increment,
            reference=line.laser,
            odometry=odometry,
        )
        for line, t, odometry in zip(scan_lines, times, raw.at_scans, strict=True)
    ]
    return CarmenLog(
        path=path,
        scans=scans,
        odometry=raw.knots,
        lines=raw.lines,
        scan_lines=raw.scan_lines,
        notes=[
            *([truncated] if truncated else []),
            f"{path}: readings from {far.limit:.2f} m on mean no return: {far.reason}",
        ],
    )


def _read_text(path: Path) -> tuple[str, str | None]:
    """Return the file's text and, if a gzip stream ends early, a notice of it."""
    try:
        data, truncated = read_log_bytes(path)
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({error.strerror}): check the path") from error
    except LogBytesError as error:
        raise LogError(str(error)) from error
    try:
        return data.decode("ascii", errors="strict"), truncated
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise LogError(f"{path}: line {line}: not text: give a CARMEN log, plain or .gz") from error


def _parse(
    path: Path, text: str, *, may_be_cut: bool
) -> tuple[list[_OdometryLine | _ScanLine], str | None]:
    """Decode all lines of known messages; a last line without its end may be truncated."""
    rows = text.split("\n")
    unfinished = rows.pop()
    parsed: list[_OdometryLine | _ScanLine] = []
    for number, row in enumerate(rows, start=1):
        try:
            line = _parse_line(row)
            if line is not None and parsed:
                _check_clock(parsed[0].t, parsed[-1].t, line.t)
        except (ValueError, IndexError) as error:
            reason = f"{error!s:.200}"
            raise LogError(
                f"{path}: line {number}: {reason}: repair or delete this line"
            ) from error
        if line is not None:
            parsed.append(line)
    if not unfinished or may_be_cut:
        return parsed, None
    try:
        line = _parse_line(unfinished)
    except (ValueError, IndexError):
        return parsed, f"{path}: ends within line {len(rows) + 1}: the lines before it are used"
    if line is not None:
        parsed.append(line)
    return parsed, None


def _parse_line(row: str) -> _OdometryLine | _ScanLine | None:
    """Decode one line; None for messages that contain neither scan nor odometry."""
    kind, _, rest = row.partition(" ")
    if kind == "ODOM":
        return _parse_odometry(rest.split())
    if kind == "FLASER":
        return _parse_front_laser(rest.split())
    if kind == "ROBOTLASER1":
        return _parse_robot_laser(rest.split())
    return None


def _parse_odometry(words: list[str]) -> _OdometryLine:
    """``x y theta tv rv accel ipc_timestamp host logger_timestamp``."""
    _require(len(words) == 9, f"ODOM with {len(words)} fields instead of 9")
    return _OdometryLine(t=_time(words[8]), pose=_pose(words[0:3]))


def _parse_front_laser(words: list[str]) -> _ScanLine:
    """``n r1..rn x y theta odom_x odom_y odom_theta ipc_timestamp host logger_timestamp``."""
    count = int(words[0])
    _require(
        count in _INCREMENT_DEGREES,
        f"FLASER with {count} beams (180, 181, 360 or 361 are known)",
    )
    _require(len(words) == count + 10, f"FLASER with {len(words)} fields instead of {count + 10}")
    tail = words[1 + count :]
    return _ScanLine(
        t=_time(tail[8]),
        readings=np.array(words[1 : 1 + count], dtype=np.float64),
        reach=math.inf,
        angle_min=-math.pi / 2,
        angle_increment=math.radians(_INCREMENT_DEGREES[count]),
        laser=_pose(tail[0:3]),
        robot=_pose(tail[3:6]),
    )


def _parse_robot_laser(words: list[str]) -> _ScanLine:
    """Decode a ROBOTLASER1 line.

    ``type start_angle field_of_view resolution maximum_range accuracy remission_mode n r1..rn
    m e1..em laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward_safety
    side_safety turn_axis ipc_timestamp host logger_timestamp``.
    """
    count = int(words[7])
    remissions = int(words[8 + count])
    expected = 9 + count + remissions + 14
    _require(
        count > 0 and remissions >= 0 and len(words) == expected,
        f"ROBOTLASER1 with {len(words)} fields instead of {expected}",
    )
    increment = _number(words[3])
    _require(
        _LEAST_BEAMS <= count <= MAX_BEAMS and 0.0 < increment * (count - 1) <= _WHOLE_TURN,
        f"ROBOTLASER1 with {count} beams {increment:g} rad apart, no laser's",
    )
    tail = words[9 + count + remissions :]
    return _ScanLine(
        t=_time(tail[13]),
        readings=np.array(words[8 : 8 + count], dtype=np.float64),
        reach=_number(words[4]),
        angle_min=_number(words[1]),
        angle_increment=increment,
        laser=_pose(tail[0:3]),
        robot=_pose(tail[3:6]),
    )


def _require(condition: bool, complaint: str) -> None:
    if not condition:
        raise ValueError(complaint)


def _check_clock(first: float, before: float, t: float) -> None:
    _require(
        t - before <= MAX_PAUSE_S,
        f"is {t - before:.0f} s after the line before, its clock was set",
    )
    _require(
        t - first <= MAX_DURATION_S, f"is {t - first:.0f} s after the first, its clock was set"
    )


def _number(word: str) -> float:
    value = float(word)
    _require(abs(value) <= _LARGEST, f"{word!r:.40} is not a finite number of a log")
    return value


def _time(word: str) -> float:
    return _number(word)


def _pose(words: Sequence[str]) -> Pose:
    return Pose(_number(words[0]), _number(words[1]), _number(words[2]))


def _odometry_between_scans(
    lines: Sequence[_OdometryLine | _ScanLine],
) -> list[list[_OdometryLine]]:
    """Group ODOM lines: before the first scan, between each two, after the last."""
    intervals: list[list[_OdometryLine]] = [[]]
    for line in lines:
        if isinstance(line, _ScanLine):
            intervals.append([])
        else:
            intervals[-1].append(line)
    return intervals


def _raw_odometry(
    scans: Sequence[_ScanLine],
    times: Sequence[float],
    intervals: Sequence[Sequence[_OdometryLine]],
) -> _RawOdometry:
    """Recover the raw odometry at each scan and between them."""
    rebased = _is_rebased(scans, intervals)
    raw = _RawOdometry([], [], [], [])
    start, start_t = Pose(0.0, 0.0, 0.0), -math.inf
    for index, interval in enumerate(intervals):
        poses = [line.pose for line in interval]
        if rebased and index > 0 and poses:
            base = start.compose(poses[0].inverse())
            poses = [base.compose(pose) for pose in poses]
        end_t = times[index] if index < len(scans) else math.inf
        inner = list(zip((line.t for line in interval), poses, strict=True))
        raw.knots.extend(_increasing(inner, start_t, end_t))
        # The first line only repeats a corrected scan's pose, with a meaningless stamp.
        raw.lines.extend(inner[1:] if rebased and index > 0 else inner)
        if index < len(scans):
            start = (poses[-1] if poses else start) if rebased else scans[index].robot
            start_t = end_t
            raw.at_scans.append(start)
            raw.knots.append((start_t, start))
            raw.scan_lines.append(len(raw.lines))
            raw.lines.append((start_t, start))
    return raw


def _increasing(
    knots: Iterable[tuple[float, Pose]], after: float, before: float
) -> list[tuple[float, Pose]]:
    """Return the knots between two scans whose stamps are increasing; the others are dropped."""
    kept: list[tuple[float, Pose]] = []
    for t, pose in knots:
        if (kept[-1][0] if kept else after) < t < before:
            kept.append((t, pose))
    return kept


def _scan_times(scans: Sequence[_ScanLine]) -> list[float]:
    """Return the scans' log times; a scan stamped too early is moved to the least interval."""
    times: list[float] = []
    for scan in scans:
        times.append(max(scan.t, times[-1] + _MIN_STEP) if times else scan.t)
    return times


def _is_rebased(scans: Sequence[_ScanLine], intervals: Sequence[Sequence[_OdometryLine]]) -> bool:
    """Whether the log is corrected: the first ODOM after (nearly) every scan repeats its pose."""
    followed = [
        (scan.robot, interval[0].pose)
        for scan, interval in zip(scans, intervals[1:], strict=True)
        if interval
    ]
    repeats = sum(math.dist(scan, odometry) < _SAME_POSE for scan, odometry in followed)
    return repeats > len(followed) / 2


def _usable(readings: NDArray[np.float64], limit: float) -> NDArray[np.float64]:
    """Return readings with everything that is no measured distance replaced by inf."""
    return np.where((readings > 0.0) & (readings < limit), readings, np.inf)
