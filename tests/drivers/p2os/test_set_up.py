"""Limits are set, read back and reported where the robot keeps others."""

from __future__ import annotations

from dataclasses import replace

import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.command_outbox import LATER_PERIOD, P2OS_PERIOD, CommandOutbox
from drivers.p2os.commands import STAND_STILL, STOP, Command
from drivers.p2os.config_packet import LATER_FIELD_COUNT, ConfigPacket
from drivers.p2os.set_up import SetUp, kept_otherwise, limit_commands, set_up_commands
from drivers.p2os.settings import BaseSettings
from drivers.p2os.trouble import TroubleKind

N = CommandNumber
SETTINGS = BaseSettings()
AS_ASKED = ConfigPacket(
    speed_max=500,
    turn_rate_max=100,
    acceleration=300,
    deceleration=600,
    turn_acceleration=100,
    turn_deceleration=100,
    watchdog_ms=1500,
)


class Desk:
    """A set-up, its outbox and a robot that answers CONFIG with ``answer``."""

    def __init__(self, answer: ConfigPacket | None) -> None:
        self.answer = answer
        self.sent: list[Command] = []
        self.outbox = CommandOutbox([], lambda what, _t: self.sent.append(what))
        self.outbox.restart(0.0)
        self.set_up = SetUp(SETTINGS, self.outbox)

    def run(self, *, resumed: bool = False, start: float = 0.0, limit: float = 10.0) -> float:
        """Run until the robot is prepared; return that time, s."""
        self.outbox.restart(start)
        self.set_up.begin(start, resumed=resumed)
        for step in range(round(limit / 0.05)):
            t = start + 0.05 * step
            before = len(self.sent)
            if self.set_up.advance(t):
                return t
            self.outbox.flush(t)
            asked = any(what.number == N.CONFIG for what in self.sent[before:])
            if asked and self.answer is not None:
                self.set_up.on_config(self.answer)
        raise AssertionError("never prepared")


def words_of(desk: Desk) -> str:
    trouble = desk.set_up.trouble
    assert trouble is not None
    assert trouble.kind is TroubleKind.LIMITS
    return trouble.words


def test_commands_bring_limits_then_zero_motion() -> None:
    commands = set_up_commands(SETTINGS)
    assert commands[:6] == limit_commands(SETTINGS)
    assert [(c.number, c.integer) for c in commands[:6]] == [
        (N.SETV, 500),
        (N.SETRV, 100),
        (N.SETA, 300),
        (N.SETA, -600),
        (N.SETRA, 100),
        (N.SETRA, -100),
    ]
    assert commands[-3:] == [STOP, *STAND_STILL]


def test_robot_with_the_limits_is_prepared_without_trouble() -> None:
    desk = Desk(AS_ASKED)
    desk.run()
    assert [what.number for what in desk.sent].count(N.CONFIG) == 2
    assert desk.sent[-1].number == N.CONFIG
    assert desk.set_up.trouble is None
    assert desk.set_up.watchdog == 1.5
    assert desk.outbox.watchdog == 1.5
    assert desk.outbox.period == P2OS_PERIOD


def test_later_firmware_is_detected_by_config_and_gets_a_higher_rate() -> None:
    desk = Desk(replace(AS_ASKED, field_count=LATER_FIELD_COUNT))
    desk.run()
    assert desk.outbox.period == LATER_PERIOD


def test_limits_not_taken_are_sent_once_more_and_then_reported() -> None:
    desk = Desk(replace(AS_ASKED, speed_max=300))
    desk.run()
    assert [what.number for what in desk.sent].count(N.SETV) == 2
    trouble = words_of(desk)
    assert desk.set_up.refusals == 1
    assert "SETV 300 mm/s, asked for 500" in trouble
    assert "SETRV" not in trouble


def test_robot_without_config_is_prepared() -> None:
    desk = Desk(None)
    assert 1.0 <= desk.run() < 2.5
    assert [what.number for what in desk.sent].count(N.CONFIG) == 3
    assert desk.sent[-2:] == list(STAND_STILL)
    assert desk.set_up.config is None
    assert desk.set_up.watchdog == 2.0


def test_missing_config_after_the_limits_is_reported() -> None:
    desk = Desk(AS_ASKED)
    desk.run()
    desk.answer = None
    desk.run(resumed=True, start=20.0)
    assert "no longer answers CONFIG" in words_of(desk)


def test_resumed_session_gets_limits_without_a_first_config() -> None:
    desk = Desk(AS_ASKED)
    desk.run()
    desk.sent.clear()
    desk.run(resumed=True, start=20.0)
    assert desk.sent[0].number == N.SETV
    assert [what.number for what in desk.sent].count(N.CONFIG) == 1
    assert desk.set_up.trouble is None


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [
        ("turn_rate_max", 360, "SETRV 360 deg/s, asked for 100"),
        ("deceleration", 300, "SETA -300 mm/s^2, asked for -600"),
        ("turn_deceleration", 50, "SETRA -50 deg/s^2, asked for -100"),
    ],
)
def test_every_limit_is_compared(field: str, value: int, told: str) -> None:
    assert kept_otherwise(SETTINGS, AS_ASKED) == []
    assert kept_otherwise(SETTINGS, replace(AS_ASKED, **{field: value})) == [told]  # type: ignore[arg-type]
    rounded = replace(AS_ASKED, **{field: getattr(AS_ASKED, field) + 1})
    assert kept_otherwise(SETTINGS, rounded) == []


def test_incomplete_config_is_not_compared() -> None:
    assert kept_otherwise(SETTINGS, replace(AS_ASKED, speed_max=1, field_count=20)) == []
