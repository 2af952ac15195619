"""How the robot fares, in words: what keeps it from patrolling, and what it has to do without."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.lms200.session import SessionState as LaserState
from drivers.p2os.session import SessionState
from localization.health import Health
from robot_agent.motion.gate_hold import STOPPING

if TYPE_CHECKING:
    from robot_agent.agent import Agent

_LASER_BLIND = 1.0  # s without a scan after which nobody is seen any more


class Condition:
    """Sums up the agent's stages for people."""

    def __init__(self, agent: Agent) -> None:
        """Tell of this agent."""
        self._agent = agent

    def degraded(self, t: float) -> list[str]:
        """Return what the robot has to do without at t, s; nothing when all is well."""
        troubles = [self._agent.sight.camera.trouble(t)]
        seen = self._agent.surroundings.seen_at
        if seen is None or t - seen > _LASER_BLIND:
            troubles.append("laser blind: nobody is seen, the robot stands")
        return [words for words in troubles if words]

    def health(self) -> str:
        """Return "ok", or the first thing that keeps the robot from patrolling."""
        agent = self._agent
        if agent.base.state is not SessionState.READY:
            return f"base {agent.base.state}"
        if agent.laser.state is not LaserState.STREAMING:
            return f"laser {agent.laser.state}"
        if agent.teleop is not None:
            return "driven by keys"
        if not agent.whereabouts.trusted:
            return "not localized"
        if agent.whereabouts.health is not Health.LOCALIZED:
            return f"localization {agent.whereabouts.health}"
        if agent.gate_decision is not None and agent.gate_decision.reason in STOPPING:
            return f"gate: {agent.gate_decision.reason}"
        return "ok"
