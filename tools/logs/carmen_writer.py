"""Export of recordings as CARMEN logs, for tools that read these."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from drivers.scan import Scan
from maps.pose import Pose
from maps.whole_file import whole_file
from robot_agent.config import AgentConfig
from robot_agent.messages.effects import Publish
from robot_agent.messages.events import Event
from robot_agent.messages.streams import DecisionPayload, decode
from robot_agent.recording.recording_writer import Reference
from tools.logs.carmen import LogError
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import NEAREST_REFERENCE_S, ScanDecoder, recorded_mount
from tools.logs.recording import Recording

NO_RETURN_M = 81.91
"""Reading for no return, m: above an LMS's range."""
HOST = "patrol"
_ROUNDING = 1e-6  # rad

_HEAD = """\
# message formats defined: PARAM ODOM FLASER
# PARAM param_name param_value
# ODOM x y theta tv rv accel ipc_timestamp ipc_hostname logger_timestamp
# FLASER num_readings [range_readings] x y theta odom_x odom_y odom_theta ipc_timestamp \
ipc_hostname logger_timestamp
"""


def recording_to_carmen(recording: Recording, target: Path) -> int:
    """Write odometry and scans as a CARMEN log; return the number of scans.

    A scan's first pose is the laser's: by the recording's reference if there is one, else by the
    agent's estimate, else by odometry. Its second pose is raw odometry. Raises LogError for a
    recording without a scan.
    """
    config, _ = recorded_config(recording)
    mount = recorded_mount(recording, config)
    scans = 0
    with whole_file(target) as part, part.open("w") as file:
        file.write(_HEAD)
        file.write(f"PARAM robot_frontlaser_offset {mount.x:.6f} nohost 0\n")
        file.write(f"PARAM robot_frontlaser_side_offset {mount.y:.6f} nohost 0\n")
        file.write(f"PARAM robot_frontlaser_angular_offset {mount.theta:.6f} nohost 0\n")
        for line in _lines(recording, config, mount):
            file.write(line + "\n")
            scans += line.startswith("FLASER")
    if not scans:
        raise LogError(f"{recording.path}: no scan with odometry in it: record some driving")
    return scans


def _lines(recording: Recording, config: AgentConfig, mount: Pose) -> Iterator[str]:
    """Yield the log's lines in the recorded order."""
    decoder = ScanDecoder(config)
    wall = recording.header.start_wall_ns / 1e9
    reference: Reference | None = None
    own: Pose | None = None
    last_odometry: Pose | None = None
    for item in recording.items():
        if isinstance(item, Reference):
            reference = item
        elif isinstance(item, Publish) and item.stream == "decision":
            decision = decode(item.stream, item.payload)
            assert isinstance(decision, DecisionPayload)
            own = Pose(decision.pose.x, decision.pose.y, decision.pose.theta)
        elif isinstance(item, Event):
            found = decoder.scans(item)
            latest = decoder.latest
            if latest is not None and latest[1] != last_odometry:
                last_odometry = latest[1]
                yield f"ODOM {_fields(latest[1])} 0 0 0 {_stamp(latest[0], wall)}"
            for scan, odometry in found:
                known = reference is not None and abs(reference.t - scan.t) < NEAREST_REFERENCE_S
                at = reference.pose if known and reference is not None else own or odometry
                yield _scan_line(scan, at.compose(mount), odometry, wall)


def _scan_line(scan: Scan, laser: Pose, odometry: Pose, wall: float) -> str:
    """Return a FLASER line, whose readers take the readings for those of 180 degrees at most."""
    seen = scan.ranges[np.abs(scan.angles) <= 0.5 * math.pi + _ROUNDING]
    ranges = np.where(np.isfinite(seen), seen, NO_RETURN_M)
    readings = " ".join(f"{reading:.3f}" for reading in ranges.tolist())
    poses = f"{_fields(laser)} {_fields(odometry)}"
    return f"FLASER {ranges.size} {readings} {poses} {_stamp(scan.t, wall)}"


def _fields(pose: Pose) -> str:
    return f"{pose.x:.6f} {pose.y:.6f} {math.remainder(pose.theta, math.tau):.6f}"


def _stamp(t: float, wall: float) -> str:
    return f"{wall + t:.6f} {HOST} {t:.6f}"
