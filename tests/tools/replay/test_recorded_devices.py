"""A recording's devices with the unmodified agent, and on ports."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

from drivers.link import Link
from maps.map_folder import map_folder_from_files
from robot_agent.agent import Agent
from robot_agent.messages.effects import Effect, Publish
from robot_agent.messages.events import Event
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_header import RunHeader
from tools.cli import main
from tools.logs.recorded_config import recorded_config
from tools.logs.recording import Recording, RecordingError, read_recording
from tools.replay.recorded_devices import recorded_devices, serve
from tools.simulation.lockstep import LockstepAgent

KEPT = Path(__file__).parents[1] / "logs" / "recordings" / "layout_1.mcap"


@pytest.fixture
def recording() -> Recording:
    return read_recording(KEPT)


class Decisions:
    """Keeps the times of an agent's decisions."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def record_event(self, event: Event) -> None:
        pass

    def record_effect(self, t: float, effect: Effect) -> None:
        if isinstance(effect, Publish) and effect.stream == "decision":
            self.times.append(t)


def test_agent_on_recorded_devices_decides_as_recorded(tmp_path: Path) -> None:
    bench = ["bench", "--robots", "1", "--duration", "4.6", "--record", str(tmp_path)]
    assert main([*bench, "--json", str(tmp_path / "bench.json")]) == 0
    (path,) = tmp_path.glob("*.mcap")
    recording = read_recording(path)
    config, _ = recorded_config(recording)
    folder = map_folder_from_files("lab", recording.header.map_files)
    devices = recorded_devices(recording)
    seen = Decisions()
    lockstep = LockstepAgent(Agent(config, folder), dict(devices), seen)
    lockstep.start(0.0)
    for step in range(460):
        lockstep.deliver(step / 100)
    recorded = [t for _topic, t, _data in recording.messages(("decision",))]
    assert len(recorded) > 10
    assert len(seen.times) == pytest.approx(len(recorded), abs=2)
    assert seen.times[0] == pytest.approx(recorded[0], abs=0.2)


def test_devices_send_nothing_before_the_drivers_first_byte(recording: Recording) -> None:
    base = recorded_devices(recording)["base"]
    assert base.pop_output(100.0) == []
    base.feed(b"\xfa\xfb", 200.0)
    first_at, first = base.chunks[0]
    early, late = 200.0 + first_at - 0.001, 200.0 + first_at + 0.001
    assert base.pop_output(early - base.clock.recorded(200.0)) == []  # type: ignore[operator]
    assert [out.data for out in base.pop_output(late)][:1] == [first]


class Listener:
    """Collects a link's bytes."""

    def __init__(self) -> None:
        self.heard = bytearray()

    def received(self, t: float, data: bytes) -> None:
        self.heard += data

    def link_up(self, t: float) -> None:
        pass

    def link_down(self, t: float, reason: str) -> None:
        pass


@pytest.mark.parametrize("place", ["pty", "tcp:0"])
def test_driver_connects_to_the_devices_on_ports(recording: Recording, place: str) -> None:
    urls: dict[str, str] = {}
    done = threading.Event()
    worker = threading.Thread(
        target=serve,
        args=(
            recording,
            {"base": place, "laser": place},
            urls.__setitem__,
            lambda _t: not done.is_set(),
        ),
    )
    worker.start()
    while len(urls) < 2:
        time.sleep(0.01)
    listener = Listener()
    link = Link(urls["base"], 9600, listener, time.monotonic)
    link.start()
    give_up = time.monotonic() + 10.0
    while b"\xfa\xfb" not in listener.heard and time.monotonic() < give_up:
        link.write(b"\xfa\xfb\x03\x00\x00\x00")
        time.sleep(0.05)
    link.close()
    done.set()
    worker.join()
    assert b"\xfa\xfb" in listener.heard


def test_a_recording_without_a_driver_cannot_be_served(tmp_path: Path) -> None:
    path = tmp_path / "empty.mcap"
    header = RunHeader(robot="r", team="t", seed=1, software_version="", start_wall_ns=0)
    with path.open("wb") as file:
        RecordingWriter(file, header).finish()
    with pytest.raises(RecordingError, match="nothing to serve"):
        recorded_devices(read_recording(path))
