"""Rows: cables pulled and the agent's process ended while the robot drives."""

from __future__ import annotations

from functools import partial

from tools.field.field_row import FieldRow, Outcome
from tools.field.field_stage import UNIT, FieldStage, drives, stands
from tools.field.journal import starts

REST_LIMIT_S = 2.0
"""Limit until the wheels are at rest, s: the campaign's, where the base's watchdog must do it."""
OUT_S = 5.0
"""Time for which a cable is out, s."""
BACK_LIMIT_S = 20.0
"""Limit from a cable's return until the robot drives, s."""
NEW_AGENT_LIMIT_S = 45.0
"""Limit for a robot to drive after its agent was killed, s: start, devices, first pose."""


def _pull(name: str, stage: FieldStage, outcome: Outcome) -> None:
    stage.patrolling()
    adapter = getattr(stage.robot, name)
    before, begun = starts(stage.journal()), stage.robot.now
    stage.machine.pull(adapter)
    outcome.within("at rest after", stage.robot.wait(stands, REST_LIMIT_S, begun), REST_LIMIT_S)
    stage.clock.sleep(OUT_S)
    stage.machine.plug(adapter)
    _drives_again(stage, outcome, BACK_LIMIT_S)
    outcome.require(starts(stage.journal()) == before, "the service was started again")


def _signal(signal: str, stage: FieldStage, outcome: Outcome) -> None:
    stage.patrolling()
    before, begun = starts(stage.journal()), stage.robot.now
    stage.guest.run(f"systemctl kill --kill-whom=main --signal={signal} {UNIT}")
    outcome.within("at rest after", stage.robot.wait(stands, REST_LIMIT_S, begun), REST_LIMIT_S)
    _drives_again(stage, outcome, NEW_AGENT_LIMIT_S)
    again = starts(stage.journal()) - before
    outcome.require(again == 1, f"{again} new starts, not one")


def _drives_again(stage: FieldStage, outcome: Outcome, limit: float) -> None:
    outcome.within("drives again after", stage.robot.wait(drives, limit), limit)
    outcome.require(stage.robot.contacts == 0, f"{stage.robot.contacts} contacts")
    if outcome.complaints:
        outcome.note(stage.last_words())
        stage.spoil()


FAULT_ROWS = (
    FieldRow(
        "base-pulled",
        f"base's adapter pulled while it drives, plugged in {OUT_S:.0f} s later",
        f"at rest in {REST_LIMIT_S:g} s (the base's watchdog), drives {BACK_LIMIT_S:.0f} s after",
        partial(_pull, "base"),
    ),
    FieldRow(
        "laser-pulled",
        "the same with the laser's",
        f"at rest in {REST_LIMIT_S:g} s, drives {BACK_LIMIT_S:.0f} s after",
        partial(_pull, "laser"),
    ),
    FieldRow(
        "killed",
        "the agent gets kill -9 while the robot drives",
        f"at rest in {REST_LIMIT_S:g} s, one new start, drives in {NEW_AGENT_LIMIT_S:.0f} s",
        partial(_signal, "KILL"),
    ),
    FieldRow(
        "frozen",
        "the agent hangs (SIGSTOP) while the robot drives",
        "the same: systemd's watchdog ends it",
        partial(_signal, "STOP"),
    ),
)
