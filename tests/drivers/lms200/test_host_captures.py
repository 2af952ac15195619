"""The host's side of five other clients' recorded sessions, played to the emulated laser.

Player, sicktoolbox, CARMEN and MRPT; bytes sent at a wrong rate are recorded as a laser heard them.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import HOST_ADDRESSES, REPLY_BIT, Telegram, TelegramFramer
from drivers.lms200.telegrams import BAD_COMMAND, RESET_CONFIRMED, Command

POLL = 0.01  # s
LONGEST_REPLY = 1.0  # s


@dataclass(frozen=True)
class Asked:
    """What one write of a capture completes, and what came until the next or a second later."""

    commands: list[bytes]
    replies: list[bytes]


def ramp(t: float, n: int, increment: float) -> NDArray[np.float64]:
    return np.linspace(1.0, 5.0, n)


def conversation(capture: Path) -> list[Asked]:
    lines = [json.loads(line) for line in capture.read_text().splitlines()]
    sent = [line for line in lines if line["dir"] == "host->laser"]
    emulator = Lms200Emulator(baud=sent[0]["baud"], scan_source=ramp)
    hears, answers = TelegramFramer(HOST_ADDRESSES), TelegramFramer()
    found: list[Asked] = []
    now = sent[0]["t"]
    for line, following in zip(sent, [*sent[1:], None], strict=True):
        assert emulator.baud == line["baud"]
        data = bytes.fromhex(line["hex"])
        emulator.feed(data, line["t"])
        commands = [i.payload for i in hears.feed(data) if isinstance(i, Telegram)]
        if commands:
            found.append(Asked(commands, []))
        end = now + LONGEST_REPLY if following is None else following["t"]
        while now < end:
            now = min(now + POLL, end)
            for sent_bytes in emulator.pop_output(now):
                items = answers.feed(sent_bytes.data) + answers.break_off()
                if found:
                    found[-1].replies.extend(i.payload for i in items if isinstance(i, Telegram))
    return found


CAPTURES = {
    "host-player-base-and-laser.jsonl": 8,
    "host-player-laser-resolutions.jsonl": 34,
    "host-sicktoolbox-every-call.jsonl": 141,
    "host-carmen-laser-and-base.jsonl": 49,
    "host-mrpt-laser.jsonl": 51,
}
"""By file: its commands that arrive whole."""


@pytest.mark.parametrize("name", CAPTURES)
def test_every_command_is_answered_by_its_own_reply(data_folder: Path, name: str) -> None:
    asked = conversation(data_folder / "captures" / name)
    assert sum(len(write.commands) for write in asked) == CAPTURES[name]
    for write in asked:
        codes = {reply[0] for reply in write.replies}
        assert BAD_COMMAND not in codes, write.commands
        for command in write.commands:
            reset = command[0] == Command.RESET
            assert (RESET_CONFIRMED if reset else command[0] | REPLY_BIT) in codes, command.hex(" ")


@pytest.mark.parametrize(
    ("name", "command", "reply"),
    [
        ("host-player-laser-resolutions.jsonl", "20 27 01 00 B5 00", "B7 01 00 B5 00 B5 40"),
        ("host-sicktoolbox-every-call.jsonl", "20 27 01 00 0A 00", "B7 01 00 0A 00 0A 40"),
        ("host-sicktoolbox-every-call.jsonl", "20 26 05", "B6 05 69 41"),
        ("host-sicktoolbox-every-call.jsonl", "20 28 05 01 00 0A 00", "BF 05 01 00 0A 00 0A 40"),
        ("host-carmen-laser-and-base.jsonl", "20 2A", "B0 B5 60"),
        ("host-carmen-laser-and-base.jsonl", "20 2B 01 00 01 00 B5 00", "F5 01 00 01 00 B5 00 B5"),
    ],
)
def test_streams_that_were_refused_before_now_run(
    data_folder: Path, name: str, command: str, reply: str
) -> None:
    asked = conversation(data_folder / "captures" / name)
    streams = [write for write in asked if bytes.fromhex(command) in write.commands]
    assert streams
    for stream in streams:
        assert stream.replies[0] == b"\xa0\x00\x10"
        values = stream.replies[1:]
        assert len(values) >= 3
        assert any(payload.startswith(bytes.fromhex(reply)) for payload in values)
