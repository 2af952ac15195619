"""The scans of a recording, decoded from its device bytes by the agent's sessions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.model import RobotModel
from drivers.p2os.session import P2osSession
from drivers.scan import Scan
from drivers.scanner import ScannerSession, scanner_session
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.messages.events import BytesReceived, Event, LinkDown, LinkName, LinkUp, Tick
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_settings import gate_limits
from robot_agent.perception.scan_points import ScanProjector
from robot_agent.pose.odometry_history import OdometryHistory
from robot_agent.recording.recording_writer import Reference
from tools.logs.log_step import LogStep
from tools.logs.recording import Recording

NEAREST_REFERENCE_S = 0.01
"""Largest time between a scan and its reference, s."""


def recorded_scans(recording: Recording, config: AgentConfig) -> Iterator[LogStep]:
    """Yield every scan of a recording with odometry, points and, if known, the reference pose."""
    decoder = ScanDecoder(config)
    reference: Reference | None = None
    for item in recording.items():
        if isinstance(item, Reference):
            reference = item
        elif isinstance(item, Event):
            for t, odometry, points in decoder.on_event(item):
                yield LogStep(t, odometry, points, _pose_of(reference, t))


def recorded_mount(recording: Recording, config: AgentConfig) -> Pose:
    """Return base_from_laser in a recording: as configured, else of the model the base reports."""
    decoder = ScanDecoder(config)
    for item in recording.items():
        if decoder.knows_model:
            break
        if isinstance(item, Event):
            decoder.scans(item)
    return decoder.mount


class ScanDecoder:
    """The agent's two device sessions and its odometry, without the later stages."""

    def __init__(self, config: AgentConfig, *, whole: bool = False) -> None:
        """Prepare for a robot. whole: keep returns from inside its own footprint."""
        self._base, self._laser = P2osSession(config.base), scanner_session(config.laser)
        self._odometry = OdometryHistory()
        self._config, self._whole = config, whole
        self._projector = self._projector_of_model()

    @property
    def mount(self) -> Pose:
        """base_from_laser: as configured, else that of the base's model."""
        return Pose(*(self._config.laser.mount or self.model.laser_mount))

    @property
    def model(self) -> RobotModel:
        """The base's model."""
        return self._base.model

    @property
    def knows_model(self) -> bool:
        """Whether the base has said what it is."""
        return self._base.identity is not None

    def _projector_of_model(self) -> ScanProjector:
        limits = gate_limits(self._config.gate, self.model)
        footprint = None if self._whole else Footprint(limits)
        there = self.model.laser
        laser = self._config.laser.mounted(
            upside_down=there.upside_down, ignore=() if self._whole else there.ignore
        )
        self._laser.remount(laser)
        return ScanProjector(self.mount, laser.ignored, footprint)

    def on_event(self, event: Event) -> list[tuple[float, Pose, NDArray[np.float64]]]:
        """Handle an event; return its scans: time, odom_from_base, points (n, 2), m, base_link."""
        return [
            (scan.t, odometry, self._projector.points(scan, *self._odometry.twist_at(scan.t)))
            for scan, odometry in self.scans(event)
        ]

    @property
    def latest(self) -> tuple[float, Pose] | None:
        """Time and odom_from_base of the newest base report; None before the first."""
        state = self._odometry.latest
        return None if state is None else (state.t, Pose(state.x, state.y, state.theta))

    def scans(self, event: Event) -> list[tuple[Scan, Pose]]:
        """Handle an event; return the scans it completes, each with odom_from_base at its time."""
        scans: list[Scan] = []
        match event:
            case BytesReceived(t, "base", data):
                model = self._base.model
                for state in self._base.feed(data, t):
                    self._odometry.add(state)
                if self._base.model is not model:
                    self._projector = self._projector_of_model()
            case BytesReceived(t, "laser", data):
                scans = self._laser.feed(data, t)
            case Tick(t):
                self._base.tick(t)
                self._laser.tick(t)
            case LinkUp(t, "base" | "laser" as link):
                self._session(link).link_up(t)
            case LinkDown(t, "base" | "laser" as link):
                self._session(link).link_down(t)
        # The sessions' requests are discarded: those of the recorded run were executed.
        self._base.pop_requests()
        self._laser.pop_requests()
        outside = map(self._projector.without_body, scans)
        located = [(scan, self._odometry.at(scan.t)) for scan in outside]
        return [(scan, odometry) for scan, odometry in located if odometry is not None]

    def _session(self, link: LinkName) -> P2osSession | ScannerSession:
        return self._base if link == "base" else self._laser


def _pose_of(reference: Reference | None, t: float) -> Pose | None:
    if reference is None or abs(reference.t - t) > NEAREST_REFERENCE_S:
        return None
    return reference.pose
