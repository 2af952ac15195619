"""CARMEN logs: laser scans with corrected poses, and the raw odometry recovered between them.

In logs corrected by gmapping both poses of a scan line are the corrected pose, and the ODOM lines
after a scan are raw odometry re-based onto it. The raw increment between two scans is therefore
``inverse(first ODOM after scan k-1) o (last ODOM before scan k)``; composing those gives the raw
odometry. In a log that was not corrected the scan line's own odometry pose is raw and is used; its
first pose is then the laser's, a constant offset from the second, or the same.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maps.input_limits import MAX_DURATION_S
from maps.pose import Pose, wrap_angle
from tools.logs.carmen_lines import LaserParameters, OdometryLine, ScanLine, parse_line
from tools.logs.karto_log import is_karto_log, karto_elements, parse_karto_element
from tools.logs.log_bytes import LogBytesError, read_log_bytes
from tools.logs.log_clock import continuous_times
from tools.logs.no_return import no_return
from tools.logs.player_lines import is_player_log, parse_player_line

_MIN_STEP = 0.03  # s; least time between two scans: two mirror turns of an LMS
_SAME_POSE = 1e-6  # m and rad; an ODOM line this close to a scan's pose repeats it
_RIGID = 0.005  # m and rad; change of a mounted laser's offset: loggers round to millimetres
_LARGEST_OFFSET = 1.0  # m; no laser is mounted farther from the robot's centre
_MILLIMETRES = 500.0  # median of a log's readings that are no metres
_NO_METRES = 100.0  # likewise, in whatever unit


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
    """map_from_laser, corrected; the odometry in a log that was not corrected."""
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
    referenced: bool = True
    """Whether the scans' reference poses are other than their odometry."""
    notes: list[str] = field(default_factory=list)
    """What was assumed or left out in reading the log, a line each, for people."""


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """The lines of a log, in file order, with their times."""

    lines: list[OdometryLine | ScanLine]
    times: list[float]
    mount: Pose
    """base_from_laser, as PARAM lines say."""
    max_range: float | None
    notes: list[str]


@dataclass(frozen=True, slots=True, eq=False)
class _RawOdometry:
    at_scans: list[Pose]
    knots: list[tuple[float, Pose]]
    lines: list[tuple[float, Pose]]
    scan_lines: list[int]


def read_carmen(path: Path, max_range: float | None = None) -> CarmenLog:
    """Read a CARMEN log, or one of Player's writelog or kartowriter, plain or compressed.

    Of a truncated file the complete lines are used; single bad lines are left out, and ``notes``
    says how many. max_range: readings from which on mean no return, m; None: by the log. Raises
    LogError naming file, line and remedy.
    """
    read = _read_lines(path)
    scan_lines = [line for line in read.lines if isinstance(line, ScanLine)]
    scan_times = _scan_times(read)
    rebased = _is_rebased(read.lines)
    poses = _scan_poses(read.lines)
    robots, lasers = [robot for _, robot in poses], [laser for laser, _ in poses]
    mount = None if rebased else _rigid_mount(robots, lasers)
    raw = _raw_odometry(read, robots, scan_times, rebased=rebased)
    if not rebased:
        raw = _mounted(raw, mount or read.mount)
    ranges, notes = _ranges(path, scan_lines, max_range or read.max_range)
    if mount is not None:
        notes.append(f"{path}: {_mount_note(mount)}")
    scans = [
        CarmenScan(
            t=t,
            ranges=measured,
            angle_min=line.angle_min,
            angle_increment=line.angle_increment,
            reference=odometry if mount is not None else laser,
            odometry=odometry,
        )
        for line, t, measured, laser, odometry in zip(
            scan_lines, scan_times, ranges, lasers, raw.at_scans, strict=True
        )
    ]
    return CarmenLog(
        path=path,
        scans=scans,
        odometry=raw.knots,
        lines=raw.lines,
        scan_lines=raw.scan_lines,
        referenced=mount is None,
        notes=[*read.notes, *notes],
    )


# --- the file -------------------------------------------------------------------------------------


def _read_lines(path: Path) -> _Lines:
    """Decode a file's lines; raises LogError if there is no scan in it."""
    lines, parameters, notes = _decode(path)
    if not any(isinstance(line, ScanLine) for line in lines):
        raise LogError(
            f"{path}: line 1: no FLASER or ROBOTLASER line in the file: "
            "give a CARMEN log with laser scans"
        )
    lines, left = _of_one_scanner(lines)
    if left:
        notes.append(f"{path}: {left} scans of other scanners left out")
    times, jumps, missing = continuous_times([line.t for line in lines])
    if jumps:
        notes.append(f"{path}: its clock was set {jumps} times: time is taken to go on")
    if missing:
        notes.append(f"{path}: {missing} lines without a time stamp: taken 0.1 s apart")
    if max(times) - times[0] > MAX_DURATION_S:
        raise LogError(f"{path}: line 1: lasts {max(times) - times[0]:.0f} s: split it")
    return _Lines(lines, times, parameters.mount, parameters.max_range, notes)


def _decode(path: Path) -> tuple[list[OdometryLine | ScanLine], LaserParameters, list[str]]:
    """Return a file's lines, what PARAM lines say, and what was left out; LogError if too much."""
    text, truncated = _read_text(path)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    rows = text.split("\n")
    parameters = LaserParameters()
    messages = list(enumerate(rows, start=1))
    parse: Callable[[str, LaserParameters], OdometryLine | ScanLine | None] = parse_line
    if is_karto_log(text):
        messages, parse = karto_elements(text), parse_karto_element
    elif is_player_log(rows):
        parse = parse_player_line
    lines: list[OdometryLine | ScanLine] = []
    bad: list[str] = []
    for number, message in messages:
        try:
            line = parse(message, parameters)
        except (ValueError, IndexError) as error:
            bad.append(f"{path}: line {number}: {error!s:.200}")
            continue
        if line is not None:
            lines.append(line)
    last = f"{path}: line {len(rows)}: "
    if bad and bad[-1].startswith(last) and len(lines) > 0:
        truncated = truncated or f"{path}: ends within line {len(rows)}: those before it are used"
        bad.pop()
    scans = sum(isinstance(line, ScanLine) for line in lines)
    if len(bad) > scans:
        raise LogError(f"{bad[0]}: repair or delete this line")
    notes = [truncated] if truncated else []
    if bad:
        notes.append(f"{bad[0]}: left out, {len(bad)} such lines in all")
    return lines, parameters, notes


def _read_text(path: Path) -> tuple[str, str | None]:
    """Return the file's text and, if a compressed stream ends early, a notice of it."""
    try:
        data, truncated = read_log_bytes(path)
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({error.strerror}): check the path") from error
    except LogBytesError as error:
        raise LogError(str(error)) from error
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise LogError(f"{path}: line {line}: not text: give a CARMEN log, plain or compressed")
    # Comments may be in any language; numbers and names are ASCII.
    return data.removeprefix(b"\xef\xbb\xbf").decode("latin-1"), truncated


def _of_one_scanner(
    lines: list[OdometryLine | ScanLine],
) -> tuple[list[OdometryLine | ScanLine], int]:
    """Return the lines without scans of other scanners than the one with most, and their number."""
    kinds = Counter(line.kind for line in lines if isinstance(line, ScanLine))
    (chosen, count), *_ = kinds.most_common(1)
    kept = [line for line in lines if not isinstance(line, ScanLine) or line.kind == chosen]
    return kept, sum(kinds.values()) - count


# --- readings -------------------------------------------------------------------------------------


def _ranges(
    path: Path, scans: Sequence[ScanLine], max_range: float | None
) -> tuple[list[NDArray[np.float64]], list[str]]:
    """Return the ranges of each scan, (n,) m, inf for no return, and what to say about them.

    Raises LogError if the readings are no metres or hardly one is a distance.
    """
    notes, scale = [], 1.0
    known = np.concatenate([scan.readings for scan in scans])
    known = known[np.isfinite(known) & (known > 0.0)]
    median = float(np.median(known)) if known.size else 0.0
    if median > _MILLIMETRES:
        notes.append(f"{path}: readings of {median:.0f} in the median: taken as millimetres")
        scale = 1e-3
    elif median > _NO_METRES:
        raise LogError(
            f"{path}: line 1: readings of {median:.0f} in the median are no metres: convert them"
        )
    readings = [scale * scan.readings for scan in scans]
    far = no_return(readings, max_range)
    notes.append(f"{path}: readings from {far.limit:.2f} m on mean no return: {far.reason}")
    ranges = [
        np.where((each > 0.0) & (each < min(far.limit, scale * scan.reach)), each, np.inf)
        for each, scan in zip(readings, scans, strict=True)
    ]
    if not any(np.isfinite(each).any() for each in ranges):
        raise LogError(f"{path}: line 1: no reading is below {far.limit:.2f} m: see --no-return")
    return ranges, notes


# --- poses ----------------------------------------------------------------------------------------


def _scan_poses(lines: Sequence[OdometryLine | ScanLine]) -> list[tuple[Pose, Pose]]:
    """Return the poses of laser and robot at each scan; without its own, the latest ODOM's."""
    poses, latest = [], Pose(0.0, 0.0, 0.0)
    for line in lines:
        if isinstance(line, OdometryLine):
            latest = line.pose
            continue
        robot = latest if line.robot is None else line.robot
        poses.append((robot if line.laser is None else line.laser, robot))
    return poses


def _rigid_mount(robots: Sequence[Pose], lasers: Sequence[Pose]) -> Pose | None:
    """Return base_from_laser if it is the same at (nearly) every scan: nobody corrected the log.

    None where the laser's poses are other than the odometry's, so corrected. One scan alone shows
    no offset that stays.
    """
    if len(robots) == 1 and robots[0] != lasers[0]:
        return None
    offsets = np.array([robot.between(laser) for robot, laser in zip(robots, lasers, strict=True)])
    offsets[:, 2] = [wrap_angle(angle - offsets[0, 2]) for angle in offsets[:, 2]]
    middle = np.median(offsets, axis=0)
    rigid = np.abs(offsets - middle).max(axis=1) < _RIGID
    if rigid.mean() < 0.95:
        return None
    theta = wrap_angle(float(middle[2] + robots[0].between(lasers[0]).theta))
    mount = Pose(float(middle[0]), float(middle[1]), theta)
    return mount if math.hypot(mount.x, mount.y) < _LARGEST_OFFSET else Pose(0.0, 0.0, 0.0)


def _mount_note(mount: Pose) -> str:
    raw = "its poses are raw odometry, no reference"
    if max(abs(value) for value in mount) < _RIGID:
        return raw
    degrees = math.degrees(mount.theta)
    return f"{raw}; the laser is {mount.x:.3f} m ahead, {mount.y:.3f} m left, {degrees:.1f} degrees"


def _mounted(raw: _RawOdometry, mount: Pose) -> _RawOdometry:
    """Return the laser's odometry of the robot's; mount: base_from_laser."""
    return replace(
        raw,
        at_scans=[pose.compose(mount) for pose in raw.at_scans],
        knots=[(t, pose.compose(mount)) for t, pose in raw.knots],
        lines=[(t, pose.compose(mount)) for t, pose in raw.lines],
    )


def _raw_odometry(
    read: _Lines, robots: Sequence[Pose], scan_times: Sequence[float], *, rebased: bool
) -> _RawOdometry:
    """Recover the raw odometry at each scan and between them."""
    raw = _RawOdometry([], [], [], [])
    start, start_t = Pose(0.0, 0.0, 0.0), -math.inf
    intervals = _odometry_between_scans(read)
    for index, interval in enumerate(intervals):
        poses = [pose for _, pose in interval]
        if rebased and index > 0 and poses:
            base = start.compose(poses[0].inverse())
            poses = [base.compose(pose) for pose in poses]
        end_t = scan_times[index] if index < len(robots) else math.inf
        inner = list(zip((t for t, _ in interval), poses, strict=True))
        raw.knots.extend(_increasing(inner, start_t, end_t))
        # The first line only repeats a corrected scan's pose, with a meaningless stamp.
        raw.lines.extend(inner[1:] if rebased and index > 0 else inner)
        if index < len(robots):
            start = (poses[-1] if poses else start) if rebased else robots[index]
            start_t = end_t
            raw.at_scans.append(start)
            raw.knots.append((start_t, start))
            raw.scan_lines.append(len(raw.lines))
            raw.lines.append((start_t, start))
    return raw


def _odometry_between_scans(read: _Lines) -> list[list[tuple[float, Pose]]]:
    """Group ODOM lines: before the first scan, between each two, after the last."""
    intervals: list[list[tuple[float, Pose]]] = [[]]
    for line, t in zip(read.lines, read.times, strict=True):
        if isinstance(line, ScanLine):
            intervals.append([])
        else:
            intervals[-1].append((t, line.pose))
    return intervals


def _increasing(
    knots: Iterable[tuple[float, Pose]], after: float, before: float
) -> list[tuple[float, Pose]]:
    """Return the knots between two scans whose stamps are increasing; the others are dropped."""
    kept: list[tuple[float, Pose]] = []
    for t, pose in knots:
        if (kept[-1][0] if kept else after) < t < before:
            kept.append((t, pose))
    return kept


def _scan_times(read: _Lines) -> list[float]:
    """Return the scans' times; a scan stamped too early is moved to the least interval."""
    times: list[float] = []
    for line, t in zip(read.lines, read.times, strict=True):
        if isinstance(line, ScanLine):
            times.append(max(t, times[-1] + _MIN_STEP) if times else t)
    return times


def _is_rebased(lines: Sequence[OdometryLine | ScanLine]) -> bool:
    """Whether the log is corrected: the first ODOM after (nearly) every scan repeats its pose.

    While a robot stands it does so in any log: scans that repeat the ODOM before say nothing.
    """
    repeats = others = 0
    for before, scan, after in zip([None, *lines], lines, [*lines[1:], None], strict=False):
        if not isinstance(scan, ScanLine) or not isinstance(after, OdometryLine):
            continue
        if scan.robot is None:
            continue
        same = math.dist(scan.robot, after.pose) < _SAME_POSE
        if isinstance(before, OdometryLine) and math.dist(scan.robot, before.pose) < _SAME_POSE:
            others += not same
            continue
        repeats, others = repeats + same, others + (not same)
    return repeats > others
