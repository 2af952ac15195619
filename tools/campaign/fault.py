"""A fault of a patrolling robot and the reaction required."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from tools.campaign.agent_stage import AgentStage

IN_SESSION_LIMIT_S = 1.0
"""Limit for commanding a robot that is still in its session again, s."""
RETURN_LIMIT_S = 2.0
"""Limit for any other device to be back after the cable's return, s."""
START_UP_S = 1.0
"""Time after its power-on in which a base receives nothing, s; added to the limit."""
NEW_AGENT_LIMIT_S = 15.0
"""Limit for a robot to patrol after a new start of its agent, s; 5 s of it are the start."""


class FaultError(ValueError):
    """A fault could not be run; the message contains the reason."""


class Expected(StrEnum):
    """The reaction required."""

    AGENT_STOPS = "agent stops"
    """The agent must stop the robot: it detects the fault and can still command."""
    BASE_STOPS = "base stops"
    """The base's controller or watchdog must stop the robot."""
    MAY_PATROL = "may patrol"
    """The robot may go on patrolling; a stop is no failure."""
    PATROLS_ON = "patrols on"
    """The robot must go on patrolling, its service's watchdog fed, and say what is wrong."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault with its begin, end and limits.

    lasts: duration, s. back_within: limit, s, from the fault's end until the device is back in
    service; None where the device itself determines it. order_within: limit, s, of the agent's
    order to stand, None for the usual one; recover_within: likewise, until the robot patrols again.
    prepare: makes what the fault needs, before the agent starts.
    sabotage: fault of the agent process at SIGUSR1 (``sabotaged_agent``), empty for none.
    to_border: the robot counts as patrolling only when it is back on its border.
    """

    name: str
    what: str
    begin: Callable[[AgentStage], None]
    end: Callable[[AgentStage], None]
    expected: Expected
    prepare: Callable[[AgentStage], None] = lambda _stage: None
    lasts: float = 4.0
    back_within: float | None = None
    order_within: float | None = None
    recover_within: float | None = None
    sabotage: str = ""
    to_border: bool = False

    @property
    def with_camera(self) -> bool:
        """Whether the fault needs a robot with a camera."""
        return self.sabotage == "camera"

    @property
    def of_laser(self) -> bool:
        """Whether ``back_within`` refers to the laser."""
        return self.name.startswith("laser-") and self.back_within is not None


def do_nothing(_stage: AgentStage) -> None:
    """End action of a fault that needs none."""


def sending(number: signal.Signals) -> Callable[[AgentStage], None]:
    """Return the action that sends a signal to the agent's process."""
    return lambda stage: stage.signal_agent(number)


def setting(part: str, name: str, value: object) -> Callable[[AgentStage], None]:
    """Return the action that sets an attribute of ``stage.rig``, ``.base_line`` or the like."""
    return lambda stage: setattr(getattr(stage, part), name, value)
