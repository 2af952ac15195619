"""A teleoperated drive to calibrate by: what wheels and laser measured, and the configuration."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from drivers.p2os.model import RobotModel
from drivers.p2os.model_choice import expected_model
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.messages.events import Event
from robot_agent.perception.scan_points import ScanProjector
from tools.calibration.geometry import Geometry
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import ScanDecoder
from tools.logs.recording import read_recording
from tools.logs.scan_log import read_scan_log

_AT_LASER = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """A drive's scans, in order.

    odometry: odom_from_base at each, as counted. points: (n, 2) each, m, in the frame of an upright
    laser, by bearing, not deskewed. angles: (b,) directions of all beams, rad; ranges: (scans, b),
    m, inf without a return; both empty for a CARMEN log. config: of the recording, model: of the
    robot; the defaults for a CARMEN log.
    """

    odometry: list[Pose]
    points: list[NDArray[np.float64]]
    angles: NDArray[np.float64]
    ranges: NDArray[np.float64]
    config: AgentConfig
    model: RobotModel

    @property
    def configured(self) -> Geometry:
        """Mount and wheels as configured when it was recorded."""
        base, laser = self.config.base, self.config.laser
        model = self.model
        left, right = base.wheel_scale or (1.0, 1.0)
        return Geometry(
            mount=Pose(*(laser.mount or model.laser_mount)),
            left=left,
            right=right,
            track=base.track or 2.0 / model.conversion.turn,
            upside_down=bool(laser.mounted(upside_down=model.laser.upside_down).upside_down),
        )


def read_drive(path: Path) -> Drive:
    """Read a recording (.mcap) or a CARMEN log.

    Raises LogError, RecordingError or ConfigError.
    """
    if path.suffix == ".mcap":
        return _recorded(path)
    log = read_scan_log(path)
    odometry = [scan.odometry for scan in log.scans]
    points = [scan.points() for scan in log.scans]
    config = AgentConfig()
    model = expected_model(config.base)
    return Drive(odometry, points, np.empty(0), np.empty((0, 0)), config, model)


def _recorded(path: Path) -> Drive:
    recording = read_recording(path)
    config, _ = recorded_config(recording)
    # As the scanner sends them: nothing ignored, nothing turned over.
    bare = msgspec.structs.replace(config.laser, upside_down=False, ignore=())
    decoder = ScanDecoder(msgspec.structs.replace(config, laser=bare), whole=True)
    projector = ScanProjector(_AT_LASER)
    seen = [
        pair
        for item in recording.items()
        if isinstance(item, Event)
        for pair in decoder.scans(item)
    ]
    size = max((scan.ranges.size for scan, _ in seen), default=0)
    seen = [(scan, pose) for scan, pose in seen if scan.ranges.size == size]
    return Drive(
        odometry=[pose for _, pose in seen],
        points=[projector.points(scan) for scan, _ in seen],
        angles=seen[0][0].angles if seen else np.empty(0),
        ranges=np.array([scan.ranges for scan, _ in seen]).reshape(len(seen), size),
        config=config,
        model=decoder.model,
    )
