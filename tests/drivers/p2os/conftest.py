"""A P2OS session and an emulated robot joined by a serial line under a virtual clock."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from pathlib import Path

import pytest

from drivers.p2os.base_state import BaseState
from drivers.p2os.commands import Command, decode_command
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX, BaseMake
from drivers.p2os.framing import PacketFramer
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.settings import BaseSettings
from drivers.requests import SetBaud, Write
from maps.pose import Pose

STEP = 0.01


class Bench:
    """Runs both ends in steps of 10 ms; bytes exchanged at different rates are garbled."""

    def __init__(self, settings: BaseSettings, emulator: P2osEmulator) -> None:
        self.t = 0.0
        self.session = P2osSession(settings)
        self.emulator = emulator
        self.baud = settings.baud
        self.cut = False
        self.drift = 1.0
        self.pose = Pose(0.0, 0.0, 0.0)
        self.path = 0.0
        self.states: list[BaseState] = []
        self.heard: list[tuple[float, Command]] = []
        self._ear = PacketFramer()
        self._to_robot: deque[tuple[float, int, bytes]] = deque()
        self._free_at = 0.0
        self._steps = 0

    def connect(self) -> None:
        self.session.link_up(self.t)
        self.run_until(lambda: self.session.state is SessionState.READY, 30.0)

    def enable(self) -> None:
        self.session.enable_motors(self.t)
        self.run_until(lambda: self.states[-1].motors_enabled, 2.0)

    def run_until(self, done: Callable[[], bool], limit: float) -> None:
        end = self.t + limit
        while not done():
            assert self.t < end, f"not within {limit} s: state {self.session.state}"
            self.step()

    def run(self, seconds: float, act: Callable[[float], None] | None = None) -> None:
        """Step for a time; ``act`` is called 10 times a second."""
        for _ in range(round(seconds / STEP)):
            if act is not None and self._steps % 10 == 0:
                act(self.t)
            self.step()

    def step(self) -> None:
        self._carry_out_requests()
        self._steps += 1
        self.t = round(self._steps * STEP, 6)
        self._move_body()
        self._deliver_to_robot()
        for sent in self.emulator.pop_output(self.t):
            if not self.cut:
                data = sent.data if self.baud == self.emulator.baud else garble(sent.data)
                self.states += self.session.feed(data, sent.t)
        if self._steps % 5 == 0:
            self.session.tick(self.t)

    def _move_body(self) -> None:
        distance, rotation = self.emulator.advance(self.t)
        self.path += abs(distance)
        half = self.pose.compose(Pose(0.0, 0.0, 0.5 * rotation))
        self.pose = half.compose(Pose(distance, 0.0, 0.5 * rotation))
        self.emulator.turn_odometer(distance * self.drift, rotation * self.drift)

    def _carry_out_requests(self) -> None:
        for request in self.session.pop_requests():
            if isinstance(request, SetBaud):
                self.baud = request.baud
                continue
            assert isinstance(request, Write)
            self._free_at = max(self.t, self._free_at) + len(request.data) * 10.0 / self.baud
            self._to_robot.append((self._free_at, self.baud, request.data))

    def _deliver_to_robot(self) -> None:
        while self._to_robot and self._to_robot[0][0] <= self.t:
            at, baud, data = self._to_robot.popleft()
            if self.cut:
                continue
            same = baud == self.emulator.baud
            if same:
                self.heard += [(at, decode_command(p)) for p in self._ear.feed(data)]
            self.emulator.feed(data if same else garble(data), self.t)


def garble(data: bytes) -> bytes:
    """Return what a receiver at another rate decodes from bytes."""
    return bytes((byte * 37 + 11) & 0xFF for byte in data[: max(1, len(data) // 2)])


@pytest.fixture
def bench() -> Callable[..., Bench]:
    """Make a bench: ``bench(robot_baud=..., make=..., firmware=..., **settings)``."""

    def bench_of(
        robot_baud: int = 9600,
        make: BaseMake = PIONEER_2DX,
        firmware: Firmware = Firmware.P2OS,
        **settings: object,
    ) -> Bench:
        emulator = P2osEmulator(make, baud=robot_baud, firmware=firmware)
        return Bench(BaseSettings(**settings), emulator)  # type: ignore[arg-type]

    return bench_of


class Capture:
    """One recorded session: (t, bytes) of each side."""

    def __init__(self, path: Path) -> None:
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        self.lines = [line for line in lines if "hex" in line]

    def side(self, direction: str) -> list[tuple[float, bytes]]:
        chosen = (line for line in self.lines if line["dir"] == direction)
        return [(line["t"], bytes.fromhex(line["hex"])) for line in chosen]


@pytest.fixture
def read_capture(data_folder: Path) -> Callable[[str], Capture]:
    """Read a recorded session by its file's stem."""
    return lambda name: Capture(data_folder / "captures" / f"{name}.jsonl")


@pytest.fixture(params=["client-sim-tcp", "client-sim-serial"])
def capture(request: pytest.FixtureRequest, read_capture: Callable[[str], Capture]) -> Capture:
    """Each recorded session of an independent client and an independent simulator."""
    return read_capture(request.param)
