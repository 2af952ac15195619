"""What is done to a patrolling robot, and what it must do about it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from tools.campaign.agent_stage import AgentStage

IN_SESSION_LIMIT_S = 1.0
"""Within this a robot found still in its session must be commanded again."""
RETURN_LIMIT_S = 2.0
"""Within this of the cable's return any other device must be back."""
START_UP_S = 1.0
"""How long a base that is switched on hears nothing; comes on top."""
NEW_AGENT_LIMIT_S = 15.0
"""Within this a robot must patrol whose agent is started again; of it 5 s are the start."""


class FaultError(ValueError):
    """A fault could not be run; the message says why."""


class Expected(StrEnum):
    """What a robot must do about a fault."""

    AGENT_STOPS = "agent stops"
    """The agent can see the fault and still command."""
    BASE_STOPS = "base stops"
    """Only the base itself can: its controller or its watchdog."""
    MAY_PATROL = "may patrol"
    """The fault can be lived with; stopping for it is no failure."""


@dataclass(frozen=True, slots=True)
class Fault:
    """Something done to a robot for a while.

    lasts: s. back_within: limit, s, from the fault's end until the device is back in service;
    None where the device itself takes its time. order_within: limit, s, of the agent's order to
    stand, where it is not the usual one; recover_within: likewise, until the robot patrols again.
    traitor: what the agent is sabotaged in. to_border: only
    back on its border does the robot patrol again.
    """

    name: str
    what: str
    begin: Callable[[AgentStage], None]
    end: Callable[[AgentStage], None]
    expected: Expected
    lasts: float = 4.0
    back_within: float | None = None
    order_within: float | None = None
    recover_within: float | None = None
    traitor: str = ""
    to_border: bool = False

    @property
    def with_camera(self) -> bool:
        """Whether the robot needs a camera for it."""
        return self.traitor == "camera"

    @property
    def of_laser(self) -> bool:
        """Whether the laser is what must come back."""
        return self.name.startswith("laser-") and self.back_within is not None


def do_nothing(_stage: AgentStage) -> None:
    """The fault is over as soon as it has happened."""


def sending(number: signal.Signals) -> Callable[[AgentStage], None]:
    """Send the agent's process a signal."""
    return lambda stage: stage.signal_agent(number)


def setting(part: str, name: str, value: object) -> Callable[[AgentStage], None]:
    """Set an attribute of a part of the stage: rig, base_line, laser_line."""
    return lambda stage: setattr(getattr(stage, part), name, value)
