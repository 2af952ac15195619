"""Read-only view of the agent's stages, from which reports are built."""

from __future__ import annotations

from typing import Protocol

from drivers.p2os.session import P2osSession
from drivers.scanner import ScannerSession
from maps.pose import Pose
from robot_agent.motion.gate import GateDecision
from robot_agent.motion.teleop import Teleop
from robot_agent.patrol.patrol import PatrolDecision
from robot_agent.perception.perception import Perception
from robot_agent.pose.pose_tracker import PoseTracker


class AgentState(Protocol):
    """The stages of an agent that telemetry and the health summary read."""

    @property
    def base(self) -> P2osSession:
        """Session with the robot base."""

    @property
    def laser_mount(self) -> Pose:
        """base_from_laser, as configured or by the robot's model."""

    @property
    def laser(self) -> ScannerSession:
        """Session with the laser."""

    @property
    def pose_tracker(self) -> PoseTracker:
        """Odometry and localization."""

    @property
    def own_parts_stand_out(self) -> bool:
        """Whether the laser sees parts of the robot outside the footprint."""

    @property
    def perception(self) -> Perception:
        """Tracks, camera and intruders."""

    @property
    def teleop(self) -> Teleop | None:
        """Teleoperation by keys; None on a robot that patrols."""

    @property
    def decision(self) -> PatrolDecision | None:
        """The patrol's latest decision; None before the first."""

    @property
    def gate_decision(self) -> GateDecision | None:
        """The gate's latest decision; None before the first."""

    @property
    def scan_seen_at(self) -> float | None:
        """Measurement time of the latest accepted scan; None before the first."""

    @property
    def scan_heard_at(self) -> float | None:
        """Arrival of the latest scan, accepted or not; None before the first."""
