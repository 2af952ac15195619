"""Serial traffic as JSON lines, one object per read or write, to and from recordings.

``{"t": s, "dir": "host->robot", "baud": 9600, "hex": "fafb..."}``; ``dir`` is host->robot,
robot->host, host->laser, laser->host, or ``event`` with the host's new rate as ``baud`` or
``host_baud``. Other fields are notes and are ignored. A line whose hex is abridged (``0280..372
bytes``) is left out and counted.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import msgspec

from drivers.lms200.settings import LaserSettings
from maps.input_limits import BAD_DATA, MAX_DURATION_S, MAX_PAUSE_S
from maps.whole_file import whole_file
from robot_agent.config import AgentConfig, RobotSettings, format_config
from robot_agent.messages.effects import ChangeBaud, Send
from robot_agent.messages.events import BytesReceived, LinkName, LinkUp, Tick
from robot_agent.recording.event_codec import LINKS
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_header import RunHeader, versions
from tools.logs.log_bytes import LogBytesError, read_log_bytes
from tools.logs.recorded_config import recorded_config
from tools.logs.recording import Recording

_DEVICES: dict[str, LinkName] = {"robot": "base", "laser": "laser"}
_WORDS = {link: word for word, link in _DEVICES.items()}


class CaptureError(ValueError):
    """A file is not a capture; the message names file, line and remedy."""


class CaptureLine(msgspec.Struct, omit_defaults=True):
    """One line of a capture."""

    t: Annotated[float, msgspec.Meta(ge=0.0)]
    dir: str
    baud: int | None = None
    hex: str = ""
    host_baud: int | None = None
    link: str = ""

    @property
    def device(self) -> str:
        """The device's name; empty for an event that does not name one."""
        ends = self.dir.split("->")
        return next((end for end in ends if end in _DEVICES), _WORDS_OF.get(self.link, ""))

    @property
    def abridged(self) -> bool:
        """Whether its hex is abridged."""
        return ".." in self.hex

    @property
    def from_device(self) -> bool:
        """Whether the bytes are from the device."""
        return self.dir.endswith("->host")


_WORDS_OF: dict[str, str] = {str(link): word for link, word in _WORDS.items()}


@dataclass(frozen=True, slots=True)
class CaptureSummary:
    """Counts of a conversion."""

    received: int
    """Bytes from the devices."""
    sent: int
    """Bytes from the host."""
    duration: float
    """Duration, s."""
    abridged: int
    """Lines left out because their hex is abridged."""


def read_capture(path: Path) -> list[CaptureLine]:
    """Read a capture and sort it by time; raises CaptureError."""
    lines = []
    decode = msgspec.json.Decoder(CaptureLine).decode
    try:
        data, _ = read_log_bytes(path)
    except LogBytesError as error:
        raise CaptureError(str(error)) from error
    for number, row in enumerate(data.splitlines(), start=1):
        if not row.strip():
            continue
        try:
            line = decode(row)
            bytes.fromhex("" if line.abridged else line.hex)
        except BAD_DATA as error:
            raise CaptureError(
                f"{path}: line {number}: {error}: repair or delete this line"
            ) from error
        lines.append(line)
    if not any(line.hex and line.device for line in lines):
        raise CaptureError(
            f"{path}: line 1: no traffic of a robot or laser: give a capture with `dir` and `hex`"
        )
    lines.sort(key=lambda line: line.t)
    for before, after in pairwise(lines):
        if not (after.t - before.t <= MAX_PAUSE_S and abs(after.t) <= MAX_DURATION_S):
            raise CaptureError(
                f"{path}: jumps from {before.t:.0f} s to {after.t:.0f} s: its clock was set, "
                "split it there"
            )
    return lines


def capture_to_recording(source: Path, target: Path) -> CaptureSummary:
    """Write a capture as a recording: the devices' bytes as events, the host's as effects.

    It contains no map, so it cannot be replayed; it can be served, listed and converted.
    """
    lines = read_capture(source)
    default = next(line.device for line in lines if line.device)
    header = RunHeader(
        robot=source.stem,
        team="capture",
        seed=0,
        software_version="",
        start_wall_ns=time.time_ns(),
        source=source.name,
        versions=versions(),
        configuration=format_config(_configuration(lines, default, source.stem)).encode(),
    )
    received = sent = 0
    with whole_file(target) as part, part.open("wb") as file:
        writer = RecordingWriter(file, header)
        for device in sorted({line.device for line in lines if line.device}):
            writer.write_event(LinkUp(0.0, _DEVICES[device]))
        for line in (line for line in lines if not line.abridged):
            t, data = round(line.t, 6), bytes.fromhex(line.hex)
            link = _DEVICES[line.device or default]
            rate = line.host_baud or (line.baud if line.dir == "event" else None)
            if line.from_device:
                writer.write_event(BytesReceived(t, link, data))
                received += len(data)
            elif data or rate:
                writer.write_event(Tick(t))  # an effect happens at the time of an event
                writer.write_effect(t, Send(link, data) if data else ChangeBaud(link, rate or 0))
                sent += len(data)
        writer.finish()
    abridged = sum(line.abridged for line in lines)
    return CaptureSummary(received, sent, lines[-1].t, abridged)


def _configuration(lines: list[CaptureLine], default: str, name: str) -> AgentConfig:
    """Return a configuration with the rates at the capture's start."""
    config = AgentConfig(robot=RobotSettings(name="".join(c if c.isalnum() else "-" for c in name)))
    rates: dict[str, int] = {}
    for line in lines:
        rate = line.host_baud or line.baud
        if rate:
            rates.setdefault(line.device or default, rate)
    base = msgspec.structs.replace(config.base, baud=rates.get("robot", config.base.baud))
    laser = msgspec.structs.replace(LaserSettings(), baud=rates.get("laser", config.laser.baud))
    return msgspec.structs.replace(config, base=base, laser=laser)


def recording_to_capture(recording: Recording, target: Path) -> int:
    """Write a recording's traffic as a capture; return the number of lines."""
    encode = msgspec.json.Encoder().encode
    count = 0
    with whole_file(target) as part, part.open("wb") as file:
        for line in _lines(recording):
            file.write(encode(line) + b"\n")
            count += 1
    return count


def _lines(recording: Recording) -> Iterator[CaptureLine]:
    config, _ = recorded_config(recording)
    rates: dict[str, int] = {"base": config.base.baud, "laser": config.laser.baud}
    topics = [f"{link}/{way}" for link in LINKS for way in ("rx", "tx")]
    for topic, t, data in recording.messages((*topics, "baud")):
        if topic == "baud":
            change = msgspec.json.decode(data, type=dict[str, str | int])
            link, rate = str(change["link"]), int(change["baud"])
            rates[link] = rate
            yield CaptureLine(t, "event", host_baud=rate, link=link)
            continue
        link, way = topic.split("/")
        word = _WORDS_OF.get(link)
        if word is not None:
            direction = f"{word}->host" if way == "rx" else f"host->{word}"
            yield CaptureLine(t, direction, rates[link], data.hex())
