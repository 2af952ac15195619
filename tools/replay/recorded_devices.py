"""Playback of a recording's devices on ports, for a driver under test.

The devices' bytes are played at their recorded times, whatever the driver sends; the clock starts
with the driver's first byte, at the time of the recorded driver's first. Ports that were lost in
the recording are lost again.
"""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from drivers.emulation.port import PtyPort, TcpPort
from drivers.emulation.timed_bytes import TimedBytes
from robot_agent.messages.effects import ChangeBaud, Send
from robot_agent.messages.events import BytesReceived, LinkDown, LinkName, LinkUp
from robot_agent.recording.event_codec import LINKS
from tools.logs.recorded_config import recorded_config
from tools.logs.recording import Recording, RecordingError
from tools.simulation.emulate import open_port

PUMP_S = 0.001


class PlayClock:
    """Maps time to recorded time, from the driver's first byte on."""

    def __init__(self, first_sent: float) -> None:
        """Take the time of the recorded driver's first byte, s."""
        self._first_sent = first_sent
        self._offset: float | None = None

    def start(self, t: float) -> None:
        """Start at ``t``; no effect if already started."""
        if self._offset is None:
            self._offset = self._first_sent - t

    def recorded(self, t: float) -> float | None:
        """Return the recorded time at ``t``, s; None before the start."""
        return None if self._offset is None else t + self._offset

    def at(self, recorded: float) -> float:
        """Return the time of a recorded time, s."""
        assert self._offset is not None
        return recorded - self._offset


@dataclass
class RecordedDevice:
    """One device of a recording; an ``EmulatedDevice`` for ports and lockstep agents."""

    clock: PlayClock
    first_baud: int
    chunks: list[tuple[float, bytes]] = field(default_factory=list)
    """Bytes sent by the device with their recorded times, s, in order."""
    rates: list[tuple[float, int]] = field(default_factory=list)
    """Changes of the line's rate: recorded time, s, and baud."""
    cuts: list[tuple[float, bool]] = field(default_factory=list)
    """Recorded times, s, at which its port was lost (False) and opened (True)."""
    played: int = 0
    """Number of bytes played so far."""
    received: int = 0
    """Number of bytes received from the driver so far."""
    _next: int = 0
    _baud: int = 0

    def __post_init__(self) -> None:
        self._baud = self.first_baud

    @property
    def baud(self) -> int:
        """The line's rate at the last ``pop_output``."""
        return self._baud

    @property
    def finished(self) -> bool:
        """Whether all bytes have been played."""
        return self._next == len(self.chunks)

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes from the driver: they start the clock and have no other effect."""
        self.clock.start(t)
        self.received += len(data)

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what the device has sent by ``t`` and was not returned before."""
        now = self.clock.recorded(t)
        if now is None:
            return []
        change = bisect_right(self.rates, (now, 1 << 30))
        rate = self.rates[change - 1][1] if change else self.first_baud
        output: list[TimedBytes] = []
        while self._next < len(self.chunks) and self.chunks[self._next][0] <= now:
            at, data = self.chunks[self._next]
            self._next += 1
            self.played += len(data)
            output.append(TimedBytes(self.clock.at(at), data))
        self._baud = rate
        return output

    def is_plugged(self, t: float) -> bool:
        """Whether its port was present at ``t``."""
        now = self.clock.recorded(t)
        if now is None:
            return True
        index = bisect_right(self.cuts, (now, True))
        return self.cuts[index - 1][1] if index else True


def recorded_devices(recording: Recording) -> dict[LinkName, RecordedDevice]:
    """Return both devices of a recording, on one clock.

    Raises RecordingError if no byte was sent to a device, ConfigError.
    """
    config, _ = recorded_config(recording)
    clock = PlayClock(_first_sent(recording))
    devices: dict[LinkName, RecordedDevice] = {
        link: RecordedDevice(clock, getattr(config, link).baud)
        for link in LINKS
        if link in ("base", "laser")
    }
    was_up: set[LinkName] = set()
    t = 0.0
    for item in recording.items():
        t = getattr(item, "t", t)
        match item:
            case BytesReceived(at, link, data) if link in devices:
                devices[link].chunks.append((at, data))
            case ChangeBaud(link, baud) if link in devices:
                devices[link].rates.append((t, baud))
            case LinkUp(at, link) if link in devices:
                was_up.add(link)
                devices[link].cuts.append((at, True))
            case LinkDown(at, link) if link in was_up:
                devices[link].cuts.append((at, False))
    return devices


def _first_sent(recording: Recording) -> float:
    """Return the recorded time of the first byte to a device, s; raises RecordingError."""
    t = 0.0
    for item in recording.items():
        t = getattr(item, "t", t)
        if isinstance(item, Send):
            return t
    raise RecordingError(
        f"{recording.path}: nothing was sent to a device in it, so there is nothing to serve; "
        "give the recording of a run"
    )


def serve(
    recording: Recording,
    places: Mapping[LinkName, str],
    announce: Callable[[str, str], None],
    going_on: Callable[[float], bool],
) -> dict[LinkName, RecordedDevice]:
    """Play a recording's devices on ``pty`` or ``tcp:PORT`` to their end; return them.

    ``announce`` is called with each device's URL, ``going_on`` periodically with the recorded time;
    it returns False to end. Raises EmulateError if a port is not available.
    """
    devices = recorded_devices(recording)
    with ExitStack() as stack:
        names = Path(stack.enter_context(TemporaryDirectory(prefix="patrol-serve-")))
        ports: dict[LinkName, PtyPort | TcpPort] = {}
        for link, device in devices.items():
            # A pty that is unplugged must come back under the same name.
            port = open_port(f"--{link}", places[link], device, names / link)
            stack.callback(port.close)
            ports[link] = port
            announce(link, port.url)
        while not all(device.finished for device in devices.values()):
            now = time.monotonic()
            if not going_on(next(iter(devices.values())).clock.recorded(now) or 0.0):
                break
            for link, port in ports.items():
                _pump(port, devices[link], now)
            time.sleep(PUMP_S)
    return devices


def _pump(port: PtyPort | TcpPort, device: RecordedDevice, now: float) -> None:
    if device.is_plugged(now):
        port.plug_in()
    else:
        port.unplug()
        device.pop_output(now)  # lost while unplugged
        return
    port.pump(now)
