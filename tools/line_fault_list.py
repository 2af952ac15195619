"""Faults of a robot's two lines and of the devices behind them."""

from __future__ import annotations

from collections.abc import Callable

from tools.bench.agent_stage import AgentStage
from tools.fault import (
    IN_SESSION_LIMIT_S,
    RETURN_LIMIT_S,
    START_UP_S,
    Expected,
    Fault,
    do_nothing,
    setting,
)


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


def _leave_out(link: str) -> Callable[[AgentStage], None]:
    """Start the agent without one of its devices."""

    def begin(stage: AgentStage) -> None:
        stage.end_agent()
        (stage.base_cable if link == "base" else stage.laser_cable).pull()
        stage.start_agent()

    return begin


LINE_FAULTS: tuple[Fault, ...] = (
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
        do_nothing,
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
        "base-absent",
        "agent started with no base; plugged in",
        _leave_out("base"),
        lambda stage: stage.base_cable.put_back(),
        Expected.AGENT_STOPS,
        back_within=RETURN_LIMIT_S,
    ),
    Fault(
        "base-slow",
        "base's reports come 0.4 s late",
        setting("base_line", "delay", 0.4),
        setting("base_line", "delay", 0.0),
        Expected.MAY_PATROL,
    ),
    Fault(
        "base-stuck",
        "base's last report comes again and again",
        setting("base_line", "frozen", True),
        setting("base_line", "frozen", False),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "laser-absent",
        "agent started with no laser; plugged in",
        _leave_out("laser"),
        lambda stage: stage.laser_cable.put_back(),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "laser-slow",
        "laser's scans come 0.4 s late",
        setting("laser_line", "delay", 0.4),
        setting("laser_line", "delay", 0.0),
        Expected.MAY_PATROL,
    ),
    Fault(
        "laser-stuck",
        "laser's last scan comes again and again",
        setting("laser_line", "frozen", True),
        setting("laser_line", "frozen", False),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "laser-blind",
        "no beam of the laser returns",
        setting("rig", "blind", True),
        setting("rig", "blind", False),
        Expected.AGENT_STOPS,
    ),
)
