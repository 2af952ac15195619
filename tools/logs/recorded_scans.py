"""The scans of a recording, decoded from its device bytes as the agent decodes them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.scan import Scan
from drivers.lms200.session import Lms200Session
from drivers.p2os.model import load_model
from drivers.p2os.session import P2osSession
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.messages.events import BytesReceived, Event, LinkDown, LinkName, LinkUp, Tick
from robot_agent.perception.scan_points import ScanProjector
from robot_agent.pose.odometry_history import OdometryHistory
from robot_agent.recording.recording_writer import Reference
from tools.logs.log_step import LogStep
from tools.logs.recording import Recording

NEAREST_REFERENCE_S = 0.01
"""A reference belongs to the scan measured within this time of it."""


def recorded_scans(recording: Recording, config: AgentConfig) -> Iterator[LogStep]:
    """Yield every scan of a recording with odometry, points and, where known, the true pose."""
    decoder = ScanDecoder(config)
    reference: Reference | None = None
    for item in recording.items():
        if isinstance(item, Reference):
            reference = item
        elif isinstance(item, Event):
            for t, odometry, points in decoder.on_event(item):
                yield LogStep(t, odometry, points, _belonging(reference, t))


class ScanDecoder:
    """The agent's two device sessions and its odometry, and nothing after them."""

    def __init__(self, config: AgentConfig) -> None:
        self._base, self._laser = P2osSession(config.base), Lms200Session(config.laser)
        self._odometry = OdometryHistory()
        mount = config.laser.mount or load_model(config.base.model).laser_mount
        self._projector = ScanProjector(Pose(*mount))

    def on_event(self, event: Event) -> list[tuple[float, Pose, NDArray[np.float64]]]:
        """Take one event; return the scans it completes: time, odometry, points (n, 2)."""
        return [
            (scan.t, odometry, self._projector.points(scan, *self._odometry.twist_at(scan.t)))
            for scan, odometry in self.scans(event)
        ]

    @property
    def latest(self) -> tuple[float, Pose] | None:
        """Time, s, and odometry of the newest base report."""
        state = self._odometry.latest
        return None if state is None else (state.t, Pose(state.x, state.y, state.theta))

    def scans(self, event: Event) -> list[tuple[Scan, Pose]]:
        """Take one event; return the scans it completes with the odometry at each."""
        scans: list[Scan] = []
        match event:
            case BytesReceived(t, "base", data):
                for state in self._base.feed(data, t):
                    self._odometry.add(state)
            case BytesReceived(t, "laser", data):
                scans = self._laser.feed(data, t)
            case Tick(t):
                self._base.tick(t)
                self._laser.tick(t)
            case LinkUp(t, "base" | "laser" as link):
                self._session(link).link_up(t)
            case LinkDown(t, "base" | "laser" as link):
                self._session(link).link_down(t)
        # What the sessions ask of their links was done, and recorded, long ago.
        self._base.pop_requests()
        self._laser.pop_requests()
        located = [(scan, self._odometry.at(scan.t)) for scan in scans]
        return [(scan, odometry) for scan, odometry in located if odometry is not None]

    def _session(self, link: LinkName) -> P2osSession | Lms200Session:
        return self._base if link == "base" else self._laser


def _belonging(reference: Reference | None, t: float) -> Pose | None:
    if reference is None or abs(reference.t - t) > NEAREST_REFERENCE_S:
        return None
    return reference.pose
