"""Valid commands in random order: no exception, every firmware moves alike, a session opens."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import TYPE_CHECKING

import pytest

from drivers.p2os.command_numbers import ARGUMENT_RANGES, MOTION, CommandNumber
from drivers.p2os.commands import STOP, Command, command
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.session import SessionState

if TYPE_CHECKING:
    from conftest import Bench

MakeBench = Callable[..., "Bench"]
COMMANDS = 150  # of one sequence
SEQUENCES = 20
LONG_SEQUENCES = 200
STRINGS = (CommandNumber.POLLING, CommandNumber.SAY, CommandNumber.TTY2, CommandNumber.TTY4)
HANDSHAKE = (Command(0), Command(1), Command(2), Command(1, 1), Command(4, 1))
RARE = (CommandNumber.CLOSE, CommandNumber.RESET, CommandNumber.HOSTBAUD)


def sequence(dice: Random) -> list[Command]:
    """A client's session: the handshake, then any commands, sometimes a handshake between them."""
    drawn = list(HANDSHAKE)
    while len(drawn) < COMMANDS:
        if dice.random() < 0.05:
            drawn += HANDSHAKE
        drawn.append(any_command(dice))
    return drawn


def any_command(dice: Random) -> Command:
    number = dice.choice([*CommandNumber, *MOTION])
    if number in RARE and dice.random() < 0.8:
        return Command(CommandNumber.PULSE)
    if number in STRINGS:
        return Command(number, dice.randbytes(dice.randrange(40)), dice.choice((b"", b"\0")))
    allowed = ARGUMENT_RANGES.get(number)
    if allowed is None:
        return command(number)
    return command(number, dice.choice((*allowed, dice.randint(*allowed))))


def assert_alike(dice: Random) -> None:
    """Feed one sequence to a robot of each firmware; they move and open sessions alike."""
    robots = [P2osEmulator(PIONEER_2DX, firmware=firmware) for firmware in Firmware]
    t = 0.0
    for one in sequence(dice):
        t += dice.choice((0.0, 0.01, 0.05, 0.3))
        for robot in robots:
            robot.feed(one.encode(), t)
            robot.turn_odometer(*robot.advance(t))
            robot.pop_output(t)
        first, *others = [
            (robot.velocity, robot.motors_enabled, robot.session_open, robot.baud)
            for robot in robots
        ]
        assert all(other == first for other in others), one


def assert_session_opens(bench: MakeBench, firmware: Firmware, dice: Random) -> None:
    """Leave a robot after one sequence, at whatever rate; a session opens and drives it."""
    wire = bench(firmware=firmware)
    for one in sequence(dice):
        wire.emulator.feed(one.encode(), wire.t)
        wire.run(dice.choice((0.0, 0.01, 0.05)))
    wire.session.link_up(wire.t)
    wire.run_until(lambda: wire.session.state is SessionState.READY, 60.0)
    wire.enable()
    wire.run(0.5, lambda t: wire.session.drive(t, 0.2, 0.0))
    assert wire.emulator.velocity[0] > 0.05
    assert next(c for _, c in wire.heard if c.number in MOTION) in (STOP, Command(11, 0))
    wire.session.shut_down(wire.t)
    wire.run(0.5)
    assert not wire.emulator.session_open


@pytest.mark.parametrize("seed", range(SEQUENCES))
def test_robots_of_every_firmware_move_alike(seed: int) -> None:
    assert_alike(Random(seed))


@pytest.mark.parametrize("firmware", list(Firmware))
@pytest.mark.parametrize("seed", range(SEQUENCES))
def test_session_opens_after_any_sequence(bench: MakeBench, seed: int, firmware: Firmware) -> None:
    assert_session_opens(bench, firmware, Random(seed))


@pytest.mark.long
def test_many_sequences(bench: MakeBench) -> None:
    for seed in range(LONG_SEQUENCES):
        assert_alike(Random(1000 + seed))
        for firmware in Firmware:
            assert_session_opens(bench, firmware, Random(2000 + seed))
