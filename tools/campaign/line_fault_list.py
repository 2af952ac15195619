"""Faults of a robot's two lines and of the devices behind them."""

from __future__ import annotations

from collections.abc import Callable

from robot_agent.messages.events import LinkName
from tools.campaign.agent_stage import AgentStage
from tools.campaign.fault import (
    IN_SESSION_LIMIT_S,
    RETURN_LIMIT_S,
    START_UP_S,
    Expected,
    Fault,
    do_nothing,
    setting,
)
from tools.simulation.cable import Cable

_SENT: dict[LinkName, str] = {"base": "report", "laser": "scan"}
_NOISE = 0.2
_DELAY_S = 0.4


def _cable(stage: AgentStage, link: LinkName) -> Cable:
    return stage.base_cable if link == "base" else stage.laser_cable


def _pulled(link: LinkName) -> Callable[[AgentStage], None]:
    return lambda stage: _cable(stage, link).pull()


def _put_back(link: LinkName) -> Callable[[AgentStage], None]:
    return lambda stage: _cable(stage, link).put_back()


def _left_out(link: LinkName) -> Callable[[AgentStage], None]:
    """Return the action that starts the agent without one of its devices."""

    def begin(stage: AgentStage) -> None:
        stage.end_agent()
        _cable(stage, link).pull()
        stage.start_agent()

    return begin


def _switch(link: LinkName, name: str, value: object) -> Callable[[AgentStage], None]:
    return setting(f"{link}_line", name, value)


def _faults_of(link: LinkName, unplugged: Expected, back: float) -> tuple[Fault, ...]:
    """Return the faults of one line; ``back``: limit, s, after the line is restored."""
    sent = _SENT[link]
    return (
        Fault(
            f"{link}-unplugged",
            f"{link}'s cable unplugged, replugged",
            _pulled(link),
            _put_back(link),
            unplugged,
            back_within=back,
        ),
        Fault(
            f"{link}-absent",
            f"agent started with no {link}; plugged in",
            _left_out(link),
            _put_back(link),
            Expected.AGENT_STOPS,
            back_within=RETURN_LIMIT_S if link == "base" else None,
        ),
        Fault(
            f"{link}-silent",
            f"{link}'s {sent}s are lost",
            _switch(link, "mute", True),
            _switch(link, "mute", False),
            Expected.AGENT_STOPS,
            back_within=back,
        ),
        Fault(
            f"{link}-noise",
            f"{100 * _NOISE:g} % of the {link}'s {sent}s corrupt",
            _switch(link, "spoilt", _NOISE),
            _switch(link, "spoilt", 0.0),
            Expected.MAY_PATROL,
        ),
        Fault(
            f"{link}-slow",
            f"{link}'s {sent}s come {_DELAY_S:g} s late",
            _switch(link, "late", _DELAY_S),
            _switch(link, "late", 0.0),
            Expected.MAY_PATROL,
        ),
        Fault(
            f"{link}-stuck",
            f"{link}'s last {sent} comes again and again",
            _switch(link, "frozen", True),
            _switch(link, "frozen", False),
            Expected.AGENT_STOPS,
        ),
    )


def _cut_base(stage: AgentStage) -> None:
    stage.base_line.mute = stage.base_line.deaf = True


def _mend_base(stage: AgentStage) -> None:
    stage.base_line.mute = stage.base_line.deaf = False


def _reset_base(stage: AgentStage) -> None:
    stage.rig.base.reset(stage.step().t, notify=False)  # P2OS sends no notification


def _switch_base_off(stage: AgentStage) -> None:
    _reset_base(stage)
    _cut_base(stage)


def _switch_base_on(stage: AgentStage) -> None:
    _reset_base(stage)
    _mend_base(stage)


LINE_FAULTS: tuple[Fault, ...] = (
    *_faults_of("base", Expected.BASE_STOPS, IN_SESSION_LIMIT_S),
    Fault(
        "base-cut",
        "base's line dead both ways, port stays",
        _cut_base,
        _mend_base,
        Expected.BASE_STOPS,
        back_within=IN_SESSION_LIMIT_S,
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
    *_faults_of("laser", Expected.AGENT_STOPS, RETURN_LIMIT_S),
    Fault(
        "laser-power",
        "laser switched off, then on: power-on telegram",
        lambda stage: stage.rig.laser.power_off(stage.step().t),
        lambda stage: stage.rig.laser.power_on(stage.step().t),
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
