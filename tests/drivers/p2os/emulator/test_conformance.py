"""An emulated robot of each firmware against the table of commands, one by one."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Literal

import msgspec
import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.config_packet import ConfigPacket, decode_config
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.framing import PacketFramer
from drivers.p2os.sip import SipTail, decode_sip, is_sip

LASTS = 0.6  # s, the time after which the effects are compared


class Row(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    """One row of the table; its head says what the columns mean."""

    number: int
    name: str
    since: Literal["p2os", "later", "never"]
    send: list[list[int | str]]
    ours: bool = False
    unlike_p2os: bool = False
    wire: str = ""
    packets: dict[str, int] = {}
    config: dict[str, int] = {}
    sip: dict[str, int] = {}
    sonar: list[int] | None = None
    state: dict[str, int | bool] = {}
    speed: list[float] | None = None

    @property
    def commands(self) -> list[Command]:
        return [Command(int(number), *map(argument_of, rest)) for number, *rest in self.send]

    def is_known_to(self, firmware: Firmware) -> bool:
        later = firmware is not Firmware.P2OS
        return self.ours or self.since == "p2os" or (self.since == "later" and later)


def argument_of(value: int | str) -> int | bytes:
    return bytes.fromhex(value) if isinstance(value, str) else value


class Table(msgspec.Struct, forbid_unknown_fields=True):
    command: list[Row]


TABLE = msgspec.toml.decode(
    (Path(__file__).parent / "commands.toml").read_bytes(), type=Table
).command


class Robot:
    """A robot in an open session with the motors on."""

    def __init__(self, firmware: Firmware) -> None:
        self.emulator = P2osEmulator(PIONEER_2DX, baud=115200, firmware=firmware)
        for port in self.emulator.board.aux.values():
            port.loop_back = True
        self.packets: list[bytes] = []
        self._framer = PacketFramer()
        self._t = 0.0
        self.send(Command(0), Command(1), Command(2), Command(1, 1), Command(4, 1))
        self.run(0.25)
        self.packets.clear()

    def send(self, *commands: Command) -> None:
        for command in commands:
            self.emulator.feed(command.encode(), self._t)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.01)):
            self._t += 0.01
            self.emulator.turn_odometer(*self.emulator.advance(self._t))
            for sent in self.emulator.pop_output(self._t):
                self.packets += self._framer.feed(sent.data)

    def config(self) -> ConfigPacket:
        self.packets.clear()
        self.send(Command(18, 1))
        self.run(0.05)
        found = [config for p in self.packets if (config := decode_config(p)) is not None]
        assert len(found) == 1
        return found[0]

    def sip_fields(self) -> dict[str, Any]:
        sip = [sip for p in self.packets if (sip := decode_sip(p)) is not None][-1]
        tail = sip.tail._asdict()
        named = {f.name: getattr(sip, f.name) for f in fields(sip)}
        return {**{n: v for n, v in tail.items() if v is not None}, **named}

    def fired(self) -> list[int]:
        sips = [sip for p in self.packets if (sip := decode_sip(p)) is not None]
        return [number for sip in sips[1:] for number, _ in sip.sonar]


CASES = [
    pytest.param(row, firmware, id=f"{row.number} {row.name} {row.send} {firmware}")
    for row in TABLE
    for firmware in Firmware
    if not (row.unlike_p2os and firmware is Firmware.P2OS)
]


@pytest.mark.parametrize(("row", "firmware"), CASES)
def test_robot_conforms_to_the_table(row: Row, firmware: Firmware) -> None:
    robot = Robot(firmware)
    before = robot.config()
    robot.packets.clear()
    robot.send(*row.commands)
    robot.run(LASTS)
    if row.is_known_to(firmware):
        assert robot.emulator.counters.unknown_commands == 0
        assert_effects(row, robot, before)
    else:
        assert robot.emulator.counters.unknown_commands == len(row.send)
        assert not others(robot)
        assert robot.emulator.velocity == (0.0, 0.0)
        assert robot.config() == before


def assert_effects(row: Row, robot: Robot, before: ConfigPacket) -> None:
    expected = {int(kind, 16): amount for kind, amount in row.packets.items()}
    assert amounts(robot) == expected
    shown = robot.sip_fields() if row.sip else {}
    for name, value in row.sip.items():
        assert shown[name] == value, name
    if row.sonar is not None:
        rounds = list(dict.fromkeys(robot.fired()))
        first = rounds.index(row.sonar[0]) if row.sonar else 0
        assert rounds[first:] + rounds[:first] == row.sonar
    for name, value in row.state.items():
        assert getattr(robot.emulator, name) == value, name
    if row.speed is not None:
        v, w = robot.emulator.velocity
        assert v == pytest.approx(row.speed[0], abs=0.006)
        assert math.degrees(w) == pytest.approx(row.speed[1], abs=1.0)
    on_wire = [field.name for field in fields(ConfigPacket)][: before.field_count]
    changed = {name: value for name, value in row.config.items() if name in on_wire}
    if changed:
        assert robot.config() == replace(before, **changed)


def others(robot: Robot) -> list[int]:
    return [packet[0] for packet in robot.packets if not is_sip(packet)]


def amounts(robot: Robot) -> dict[int, int]:
    """1 for each type of packet that came once, 2 for one that came with every SIP."""
    sips = sum(is_sip(packet) for packet in robot.packets)
    kinds = others(robot)
    assert all(kinds.count(kind) in (1, sips - 1, sips) for kind in kinds)
    return {kind: 1 if kinds.count(kind) == 1 else 2 for kind in kinds}


def test_table_has_every_command_and_its_name() -> None:
    listed = {row.number: row.name for row in TABLE if row.name}
    assert set(listed) == {int(number) for number in CommandNumber}
    assert all(CommandNumber[name] == number for number, name in listed.items())


def test_fields_in_the_table_exist() -> None:
    known = {f.name for f in fields(ConfigPacket)}
    assert all(name in known for row in TABLE for name in row.config)
    assert set(SipTail._fields) >= {"digital_out", "analog_port", "battery_decivolts"}


@pytest.mark.parametrize("row", [row for row in TABLE if row.wire], ids=lambda row: row.wire)
def test_commands_are_on_the_wire_as_in_the_manuals(row: Row) -> None:
    assert row.commands[0].encode() == bytes.fromhex(row.wire)
