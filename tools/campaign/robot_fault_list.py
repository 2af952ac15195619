"""Faults of the robot itself and of its environment."""

from __future__ import annotations

import dataclasses

from maps.pose import Pose
from tools.campaign.agent_stage import AgentStage
from tools.campaign.fault import NEW_AGENT_LIMIT_S, Expected, Fault, do_nothing, setting
from tools.simulation.world import plain_noise


def _free_wheels(stage: AgentStage) -> None:
    stage.rig.stuck = False
    stage.press_motors_twice()


def _bump_twice(stage: AgentStage) -> None:
    press, leave = setting("rig", "bumped", 4), setting("rig", "bumped", 0)
    press(stage)
    stage.later(
        (0.5, lambda: leave(stage)), (1.0, lambda: press(stage)), (1.5, lambda: leave(stage))
    )


def _carry(stage: AgentStage) -> None:
    stage.rig.body.pose = Pose(5.5, 4.3, -2.0)


def _slip(stage: AgentStage) -> None:
    noise = stage.world.noise
    stage.world.noise = dataclasses.replace(noise, slip_distance=0.2, slip_heading=0.1)


def _grip(stage: AgentStage) -> None:
    stage.world.noise = plain_noise()


def _drain(stage: AgentStage) -> None:
    stage.rig.base.battery.volts = 10.5


def _charge(stage: AgentStage) -> None:
    stage.rig.base.battery.volts = 12.8


def _release_stop_button(stage: AgentStage) -> None:
    stage.rig.base.release_stop_button()
    stage.rig.base.press_motors_button()


ROBOT_FAULTS: tuple[Fault, ...] = (
    Fault(
        "wrong-map",
        "agent started with the map of another place; with its own",
        lambda stage: stage.start_agent(elsewhere=True),
        lambda stage: stage.start_agent(),
        Expected.AGENT_STOPS,
        lasts=10.0,
        recover_within=NEW_AGENT_LIMIT_S,
    ),
    Fault(
        "carried-away",
        "robot put down 3 m away, turned round",
        _carry,
        do_nothing,
        Expected.MAY_PATROL,
        lasts=0.0,
        to_border=True,
    ),
    Fault(
        "wheels-slip",
        "wheels slip, 20 % after a metre",
        _slip,
        _grip,
        Expected.MAY_PATROL,
        lasts=10.0,
        to_border=True,
    ),
    Fault(
        "wheels-stuck",
        "wheels held; then a person frees them and presses MOTORS twice",
        setting("rig", "stuck", True),
        _free_wheels,
        Expected.AGENT_STOPS,
    ),
    Fault(
        "bumper",
        "a bumper pressed for 4 s",
        setting("rig", "bumped", 4),
        setting("rig", "bumped", 0),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "bumper-twice",
        "a bumper pressed twice; then a person presses MOTORS twice",
        _bump_twice,
        lambda stage: stage.press_motors_twice(),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "battery-low",
        "battery at 10.5 V; then charged",
        _drain,
        _charge,
        Expected.AGENT_STOPS,
        order_within=2.5,
    ),
    Fault(
        "stop-button",
        "stop button pressed; then freed and MOTORS pressed",
        lambda stage: stage.rig.base.press_stop_button(),
        _release_stop_button,
        Expected.BASE_STOPS,
    ),
)
