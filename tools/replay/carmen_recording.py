"""Converts a CARMEN log to a recording of real device bytes with an agent on board."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from drivers.lms200.settings import LaserSettings
from maps.map_folder import MapFolder
from maps.whole_file import whole_file
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, MapSettings, RobotSettings
from robot_agent.messages.effects import Effect
from robot_agent.messages.events import Event
from robot_agent.pose.start_pose import StartPose
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_header import header_of_run
from tools.logs.carmen import CarmenLog, CarmenScan, LogError
from tools.replay.carmen_devices import BASE_BAUD, LASER_BAUD, LogRig, Moment, padded_ranges, play
from tools.simulation.lockstep import LockstepAgent

FLUSH_S = 5.0
_LMS_BEAMS = (181, 361)
SPARSE_SCANS_S = 3600.0
"""Laser timeout, s: logs are thinned to a scan every few seconds."""


@dataclass(frozen=True)
class Conversion:
    """Counts of a conversion."""

    scans: int
    base_reports: int
    duration: float
    """Duration, s."""


class RecordingObserver:
    """Writes a lockstep agent's events and effects as the live recorder does."""

    def __init__(self, writer: RecordingWriter) -> None:
        """Write to ``writer``."""
        self._writer = writer
        self._next_flush = FLUSH_S

    def record_event(self, event: Event) -> None:
        """Write an event; finish a chunk periodically, so that a truncated file loses little."""
        if event.t >= self._next_flush:
            self._next_flush = event.t + FLUSH_S
            self._writer.flush()
        self._writer.write_event(event)

    def record_effect(self, t: float, effect: Effect) -> None:
        """Write an effect of the event at t."""
        self._writer.write_effect(t, effect)


def convert(
    log: CarmenLog,
    folder: MapFolder,
    path: Path,
    progress: Callable[[float], None] = lambda _: None,
) -> Conversion:
    """Write the recording of an agent on the log's robot; the map is ``folder``'s.

    The agent starts at the log's first reference pose, or finds itself in a log without; the
    reference poses are recorded too. Raises LogError for scans that an LMS 200 does not send.
    """
    _require_lms_scans(log)
    config = configuration_for(log, folder)
    start_wall_ns = time.time_ns()
    header = header_of_run(config, folder, source=log.path.name, start_wall_ns=start_wall_ns)
    rig = LogRig(config.robot.name)
    with whole_file(path) as part, part.open("wb") as file:
        writer = RecordingWriter(file, header)
        lockstep = LockstepAgent(
            Agent(config, folder, start_wall_ns),
            {"base": rig.base, "laser": rig.laser},
            RecordingObserver(writer),
        )

        def write_reference(moment: Moment) -> None:
            assert moment.scan is not None
            if not log.referenced:
                return
            writer.write_reference(round(moment.t, 6), moment.scan.reference)

        duration = play(log, rig, lockstep, write_reference, progress)
        writer.finish()
    return Conversion(
        scans=len(log.scans),
        base_reports=lockstep.agent.base.counters.sips,
        duration=duration,
    )


def as_lms_scans(log: CarmenLog) -> CarmenLog:
    """Return a log whose scans an LMS 200 sends: half a turn ahead, by 0.5 or 1 degree.

    Each beam is the nearest one of the log's scanner; where that has none, there is no return. A
    log that is so already is returned unchanged.
    """
    first = log.scans[0]
    step = math.radians(1.0 if first.angle_increment > math.radians(0.75) else 0.5)
    angles = np.linspace(-math.pi / 2, math.pi / 2, round(math.pi / step) + 1)
    if all(_is_lms(scan, angles) for scan in log.scans):
        return log
    scans = [
        replace(scan, ranges=_at(scan, angles), angle_min=-math.pi / 2, angle_increment=step)
        for scan in log.scans
    ]
    apart = math.degrees(first.angle_increment)
    note = (
        f"{log.path}: scans of {first.ranges.size} beams by {apart:.2f} degrees become those of an "
        f"LMS 200, {angles.size} by {math.degrees(step):g}"
    )
    return replace(log, scans=scans, notes=[*log.notes, note])


def _is_lms(scan: CarmenScan, angles: NDArray[np.float64]) -> bool:
    first, step = float(angles[0]), float(angles[1] - angles[0])
    same = math.isclose(scan.angle_min, first, abs_tol=0.1 * step)
    return same and padded_ranges(scan).size == angles.size


def _at(scan: CarmenScan, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n,) the ranges of the beams nearest to angles (n,), rad; inf outside the scan."""
    beam = np.rint((angles - scan.angle_min) / scan.angle_increment).astype(np.intp)
    inside = (beam >= 0) & (beam < scan.ranges.size)
    return np.where(inside, scan.ranges.take(beam, mode="clip"), np.inf)


def _require_lms_scans(log: CarmenLog) -> None:
    sent = padded_ranges(log.scans[0]).size
    for number, scan in enumerate(log.scans, start=1):
        beams = padded_ranges(scan).size
        if beams not in _LMS_BEAMS or beams != sent:
            raise LogError(
                f"{log.path}: scan {number}: has {scan.ranges.size} beams, an LMS 200 sends always "
                "181 or always 361: read the log itself, by `patrol localize` or `map build`"
            )


def configuration_for(log: CarmenLog, folder: MapFolder) -> AgentConfig:
    """Return the configuration of an agent on the log's robot: laser, start pose, map."""
    defaults = AgentConfig()
    first = log.scans[0]
    at = first.reference
    return AgentConfig(
        robot=RobotSettings(name=log.path.name.split(".")[0], team="log"),
        map=MapSettings(folder=folder.name),
        start=StartPose(x=at.x, y=at.y, theta=at.theta) if log.referenced else None,
        base=msgspec.structs.replace(defaults.base, baud=BASE_BAUD),
        laser=msgspec.structs.replace(
            LaserSettings(),
            baud=LASER_BAUD,
            resolution_deg=1.0 if first.ranges.size <= 181 else 0.5,
            mount=(0.0, 0.0, 0.0),  # a log's poses are of the laser
            silence=SPARSE_SCANS_S,
        ),
    )
