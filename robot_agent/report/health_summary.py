"""Health of the robot as texts for people: what prevents patrolling, and what is degraded."""

from __future__ import annotations

import math

from drivers.p2os.session import SessionState
from drivers.scanner import DOWN, STREAMING
from localization.health import Health
from robot_agent.motion.gate_hold import STOPPING
from robot_agent.report.agent_state import AgentState

_LASER_BLIND = 1.0  # s without a scan after which the laser counts as blind


class HealthSummary:
    """Summarizes the state of an agent's stages for people."""

    def __init__(self, state: AgentState) -> None:
        self._state = state

    def degraded(self, t: float) -> list[str]:
        """Return one sentence for each degraded sensor at t; empty if there is none."""
        troubles = [self._state.perception.camera.trouble(t)]
        if self._laser_blind(t):
            troubles.append("laser blind: nobody is seen, the robot stands")
        return [words for words in troubles if words]

    def _laser_blind(self, t: float) -> bool:
        """Return whether no scans come; while the base is silent none can be placed, but seen.

        A laser that is still being set up is not blind yet.
        """
        state = self._state
        ready = state.base.state is SessionState.READY
        seen = state.scan_seen_at if ready else state.scan_heard_at
        if seen is not None:
            return t - seen > _LASER_BLIND
        without_port = state.laser.state == DOWN and t > _LASER_BLIND
        return without_port or state.laser.trouble is not None

    def health(self) -> str:
        """Return "ok", or the first reason that prevents the robot from patrolling."""
        return self._device_trouble() or self._patrol_trouble() or "ok"

    def _device_trouble(self) -> str | None:
        """Return the first thing wrong with the devices, or with what they are taken to be."""
        state = self._state
        if state.base.model_trouble is not None:
            return "base: no model known to be this robot's"
        if state.base.state is not SessionState.READY:
            return _device_words("base", state.base.state, state.base.trouble)
        if state.laser.state != STREAMING:
            return _device_words("laser", state.laser.state, state.laser.trouble)
        if state.pose_tracker.travel.fault is not None:
            return f"laser.mount: {state.pose_tracker.travel.fault}"
        if state.own_parts_stand_out:
            return "laser.ignore: the laser sees the robot itself"
        return None

    def _patrol_trouble(self) -> str | None:
        """Return the first thing that keeps a robot with sound devices from patrolling."""
        state = self._state
        if state.teleop is not None:
            return "driven by keys"
        if not state.pose_tracker.trusted:
            return "not localized"
        if state.pose_tracker.health is not Health.LOCALIZED:
            return f"localization {state.pose_tracker.health}"
        if state.decision is not None and math.isinf(state.decision.way_to_border):
            return "patrol: no way to the border"
        if state.gate_decision is not None and state.gate_decision.reason in STOPPING:
            return f"gate: {state.gate_decision.reason}"
        return None


def _device_words(name: str, session: str, trouble: str | None) -> str:
    return f"{name}: {trouble}" if trouble else f"{name} {session}"
