"""The emulated laser against ``listing.toml``, command by command."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import Ack, Nak, Telegram, TelegramFramer, encode_telegram
from drivers.lms200.telegrams import Command, Mode, Variant

LISTING = Path(__file__).with_name("listing.toml")
TELEGRAMS: list[dict[str, Any]] = tomllib.loads(LISTING.read_text())["telegram"]
INSTALL = b"\x20\x00SICK_LMS"
NEEDS_INSTALLATION = [entry for entry in TELEGRAMS if "needs" in entry]


def flat(t: float, n: int, increment: float) -> NDArray[np.float64]:
    return np.full(n, 2.5)


def one_degree_laser() -> Lms200Emulator:
    return Lms200Emulator(baud=500000, scan_source=flat, variant=Variant(180, 100))


def ask(emulator: Lms200Emulator, payload: bytes, t: float) -> list[Telegram | Ack | Nak]:
    """Return what is sent in the 2.6 s after a command at ``t``, cut to the first telegrams."""
    emulator.feed(encode_telegram(payload), t)
    output = b"".join(item.data for item in emulator.pop_output(t + 2.6))
    output += b"".join(item.data for item in emulator.pop_output(t + 2.6))  # at another rate
    return TelegramFramer().feed(output)[:4]


def named(entry: dict[str, Any]) -> str:
    return f"{entry['command']}: {entry['name']}"


@pytest.mark.parametrize("entry", TELEGRAMS, ids=named)
def test_command_is_answered_as_listed(entry: dict[str, Any]) -> None:
    emulator = one_degree_laser()
    if "needs" in entry:
        ask(emulator, INSTALL, 0.0)
    ack, *telegrams = ask(emulator, bytes.fromhex(entry["command"]), 10.0)
    assert ack == Ack()
    payloads = [item.payload for item in telegrams if isinstance(item, Telegram)]
    starts = [bytes.fromhex(entry["reply"])]
    if "then" in entry:
        starts += [bytes.fromhex(entry["then"])]
    assert len(payloads) >= len(starts)
    for payload, start in zip(payloads, starts, strict=False):
        assert payload.startswith(start), payload[:12].hex(" ")
    assert len(payloads[len(starts) - 1]) == entry["bytes"]
    if "then" not in entry:
        assert len(payloads) == 1, "nothing follows"


@pytest.mark.parametrize("entry", NEEDS_INSTALLATION, ids=named)
def test_command_that_needs_the_password_is_refused_without(entry: dict[str, Any]) -> None:
    _ack, reply = ask(one_degree_laser(), bytes.fromhex(entry["command"]), 0.0)
    assert isinstance(reply, Telegram)
    assert reply.payload == b"\x92\x10"


def test_every_command_and_mode_is_listed() -> None:
    commands = [bytes.fromhex(entry["command"]) for entry in TELEGRAMS]
    assert {command[0] for command in commands} - {0x99} == set(Command)
    modes = {command[1] for command in commands if command[0] == Command.MODE}
    assert set(Mode) | {0x40, 0x41, 0x42, 0x48} == modes


@pytest.mark.parametrize("entry", TELEGRAMS, ids=named)
def test_a_shorter_or_longer_command_raises_nothing(entry: dict[str, Any]) -> None:
    emulator = one_degree_laser()
    command = bytes.fromhex(entry["command"])
    for number, payload in enumerate((command[:-1], command + b"\0", command + bytes(300))):
        if payload:
            answer = ask(emulator, payload, 10.0 * number)
            assert answer[0] == Ack()
