"""What is done to a patrolling robot, and what it must do about it."""

from __future__ import annotations

import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from tools.bench.agent_stage import AgentStage

IN_SESSION_LIMIT_S = 1.0
"""Within this a robot found still in its session must be commanded again."""
RETURN_LIMIT_S = 2.0
"""Within this of the cable's return any other device must be back."""
START_UP_S = 1.0
"""How long a base that is switched on hears nothing; comes on top."""


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
    None where the device itself takes its time.
    """

    name: str
    what: str
    begin: Callable[[AgentStage], None]
    end: Callable[[AgentStage], None]
    expected: Expected
    lasts: float = 4.0
    back_within: float | None = None

    @property
    def of_laser(self) -> bool:
        """Whether the laser is what must come back."""
        return self.name.startswith("laser")


def _do_nothing(_stage: AgentStage) -> None:
    """The fault is over as soon as it has happened."""


def _mute_base(stage: AgentStage) -> None:
    stage.base_line.mute = True


def _cut_base(stage: AgentStage) -> None:
    stage.base_line.mute = stage.base_line.deaf = True


def _mend_base(stage: AgentStage) -> None:
    stage.base_line.mute = stage.base_line.deaf = False
    stage.base_line.corrupt = 0.0


def _spoil_base(stage: AgentStage) -> None:
    stage.base_line.corrupt = 0.2


def _reset_base(stage: AgentStage) -> None:
    stage.rig.base.reset(stage.step().t, notify=False)  # P2OS does not tell


def _switch_base_off(stage: AgentStage) -> None:
    _reset_base(stage)
    _cut_base(stage)


def _switch_base_on(stage: AgentStage) -> None:
    _reset_base(stage)
    _mend_base(stage)


def _mute_laser(stage: AgentStage) -> None:
    stage.laser_line.mute = True


def _spoil_laser(stage: AgentStage) -> None:
    stage.laser_line.corrupt = 0.2


def _mend_laser(stage: AgentStage) -> None:
    stage.laser_line.mute = False
    stage.laser_line.corrupt = 0.0


def _send(number: signal.Signals) -> Callable[[AgentStage], None]:
    return lambda stage: stage.signal_agent(number)


FAULTS: tuple[Fault, ...] = (
    Fault("none", "nothing at all", _do_nothing, _do_nothing, Expected.MAY_PATROL),
    Fault(
        "base-unplugged",
        "base's cable unplugged, replugged",
        lambda stage: stage.base_cable.pull(),
        lambda stage: stage.base_cable.put_back(),
        Expected.BASE_STOPS,
        back_within=IN_SESSION_LIMIT_S,
    ),
    Fault(
        "base-cut",
        "base's line dead both ways, port stays",
        _cut_base,
        _mend_base,
        Expected.BASE_STOPS,
        back_within=IN_SESSION_LIMIT_S,
    ),
    Fault(
        "base-silent",
        "base hears, its reports are lost",
        _mute_base,
        _mend_base,
        Expected.AGENT_STOPS,
        back_within=IN_SESSION_LIMIT_S,
    ),
    Fault(
        "base-noise",
        "20 % of the base's packets corrupt",
        _spoil_base,
        _mend_base,
        Expected.MAY_PATROL,
    ),
    Fault(
        "base-reset",
        "base's RESET pressed: session lost, motors off",
        _reset_base,
        _do_nothing,
        Expected.BASE_STOPS,
        lasts=0.0,
    ),
    Fault(
        "base-power",
        "base switched off, then on",
        _switch_base_off,
        _switch_base_on,
        Expected.BASE_STOPS,
        back_within=START_UP_S + RETURN_LIMIT_S,
    ),
    Fault(
        "laser-unplugged",
        "laser's cable unplugged, replugged",
        lambda stage: stage.laser_cable.pull(),
        lambda stage: stage.laser_cable.put_back(),
        Expected.AGENT_STOPS,
        back_within=RETURN_LIMIT_S,
    ),
    Fault(
        "laser-silent",
        "laser's scans are lost",
        _mute_laser,
        _mend_laser,
        Expected.AGENT_STOPS,
        back_within=RETURN_LIMIT_S,
    ),
    Fault(
        "laser-noise",
        "20 % of the laser's telegrams corrupt",
        _spoil_laser,
        _mend_laser,
        Expected.MAY_PATROL,
    ),
    Fault(
        "laser-power",
        "laser switched off, then on: power-on telegram",
        lambda stage: stage.rig.laser.power_off(stage.step().t),
        lambda stage: stage.rig.laser.power_on(stage.step().t),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "agent-frozen",
        "agent gets SIGSTOP, then SIGCONT",
        _send(signal.SIGSTOP),
        _send(signal.SIGCONT),
        Expected.BASE_STOPS,
        back_within=IN_SESSION_LIMIT_S,
    ),
    Fault(
        "agent-killed",
        "agent gets SIGKILL, is started again",
        _send(signal.SIGKILL),
        lambda stage: stage.start_agent(),
        Expected.BASE_STOPS,
    ),
    Fault(
        "agent-ended",
        "agent gets SIGTERM, is started again",
        _send(signal.SIGTERM),
        lambda stage: stage.start_agent(),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "operator-absent",
        "operator's machine leaves the network, comes back",
        lambda stage: stage.dismiss_operator(),
        lambda stage: stage.seat_operator(),
        Expected.MAY_PATROL,
    ),
)


def chosen_faults(names: Sequence[str]) -> list[Fault]:
    """Return the faults of these names, all of them if there is none; raises FaultError."""
    known = {fault.name: fault for fault in FAULTS}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise FaultError(f"no fault {unknown[0]!r}; faults are {', '.join(known)}")
    return [known[name] for name in names] or list(FAULTS)
