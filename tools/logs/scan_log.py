"""A common interface to the scans of CARMEN logs and recordings, for map building."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.perception.scan_points import move_points
from tools.logs.carmen import CarmenScan, LogError
from tools.logs.laser_log import read_laser_log
from tools.logs.log_step import LogStep
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import recorded_mount, recorded_scans
from tools.logs.recording import read_recording
from tools.logs.ros_bag import RosTopics, is_ros_bag


@dataclass(frozen=True, slots=True, eq=False)
class RecordedScan:
    """One scan of a recording, with the interface of a log's scans."""

    t: float
    """Time of the scan."""
    end_points: NDArray[np.float64]
    """(n, 2) m, laser frame."""
    reference: Pose
    """map_from_laser; the raw odometry if the recording has no reference."""
    odometry: Pose
    """odom_from_laser."""

    def points(self) -> NDArray[np.float64]:
        """Return (n, 2) the points of the beams that returned, m, laser frame."""
        return self.end_points

    def beams(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (n,) ranges, m, and (n,) directions, rad, in the laser's frame."""
        x, y = self.end_points.T
        return np.hypot(x, y), np.arctan2(y, x)


@dataclass(frozen=True, slots=True, eq=False)
class ScanLog:
    """Scans with raw odometry, and reference poses if there are any."""

    path: Path
    scans: Sequence[CarmenScan | RecordedScan]
    odometry: list[tuple[float, Pose]]
    """Raw odometry of the laser in the order of motion; the stamps may be out of order."""
    scan_lines: list[int]
    """Index of each scan in the odometry."""
    referenced: bool
    """Whether every scan has a reference pose other than its odometry."""
    notes: list[str]
    """What was assumed or left out in reading the log, a line each, for people."""

    def from_scan(self, first: int) -> ScanLog:
        """Return the log from scan index ``first`` on; raises LogError if no scan is left."""
        if not 0 <= first < len(self.scans):
            raise LogError(
                f"{self.path}: no scan from scan {first} on: the log has {len(self.scans)}, "
                "start with an earlier one"
            )
        return replace(self, scans=self.scans[first:], scan_lines=self.scan_lines[first:])

    def with_references(self, poses: Sequence[Pose]) -> ScanLog:
        """Return the log with other reference poses, one per scan."""
        placed = [
            replace(scan, reference=pose) for scan, pose in zip(self.scans, poses, strict=True)
        ]
        return replace(self, scans=placed, referenced=True)


def read_scan_log(
    path: Path, max_range: float | None = None, topics: RosTopics | None = None
) -> ScanLog:
    """Read a CARMEN log, plain or gzip, a ROS bag, or a recording (.mcap).

    max_range, topics: as of ``read_laser_log``. Raises LogError, or RecordingError, naming file and
    remedy.
    """
    if path.suffix == ".mcap" and not is_ros_bag(path):
        return _read_recorded(path)
    log = read_laser_log(path, max_range, topics)
    return ScanLog(path, log.scans, log.lines, log.scan_lines, log.referenced, log.notes)


def _read_recorded(path: Path) -> ScanLog:
    recording = read_recording(path)
    config, _ = recorded_config(recording)
    mount = recorded_mount(recording, config)
    steps = list(recorded_scans(recording, config))
    if not steps:
        raise LogError(f"{path}: no scan with odometry in the recording: record some driving")
    scans = [_of_laser(step, mount) for step in steps]
    return ScanLog(
        path=path,
        scans=scans,
        odometry=[(scan.t, scan.odometry) for scan in scans],
        scan_lines=list(range(len(scans))),
        referenced=all(step.reference is not None for step in steps),
        notes=[recording.truncated] if recording.truncated else [],
    )


def _of_laser(step: LogStep, mount: Pose) -> RecordedScan:
    odometry = step.odometry.compose(mount)
    reference = odometry if step.reference is None else step.reference.compose(mount)
    return RecordedScan(step.t, move_points(step.points, mount.inverse()), reference, odometry)
