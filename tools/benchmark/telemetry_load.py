"""Many robots at full telemetry, without the robots.

``python -m tools.benchmark.telemetry_load ENDPOINT N``:
What three benched robots report in a minute is sent again and again under N names, each over a
connection of its own, with the time stamps of the present.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec

from maps.map_folder import load_map_folder
from robot_agent.config import AgentConfig, TelemetrySettings, find_map
from robot_agent.messages.effects import Effect, Publish
from robot_agent.messages.events import Event
from robot_agent.messages.foxglove import timestamp_at
from robot_agent.messages.streams import Payload, decode, encode
from robot_agent.process.telemetry import Telemetry
from tools.bench.fleet import Fleet

SOURCES = 3
CYCLE_S = 60.0
SETTLED_S = 20.0
"""The robots of the bench are on their border by then."""
SEED = 1
_STAGGER_S = 1.37  # between robots that repeat the same source
_STAMPED = frozenset({"pose", "status", "decision", "scan", "particles"})

Said = list[tuple[float, str, Payload]]


class _Listener:
    """Keeps what a benched robot reports."""

    def __init__(self, said: Said) -> None:
        self._said = said

    def record_event(self, event: Event) -> None:
        """Events do not matter here."""

    def record_effect(self, t: float, effect: Effect) -> None:
        """Keep what is published once the robot has settled."""
        if isinstance(effect, Publish) and t >= SETTLED_S:
            self._said.append((t - SETTLED_S, effect.stream, decode(effect.stream, effect.payload)))


def reports() -> list[Said]:
    """Return what each of the benched robots reports in a cycle, by time (s)."""
    said: list[Said] = []

    def observe(_name: str, _config: AgentConfig) -> _Listener:
        said.append([])
        return _Listener(said[-1])

    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    fleet = Fleet(folder, SOURCES, SEED, observer=observe)
    while fleet.t < SETTLED_S + CYCLE_S:
        fleet.step()
    return said


def schedule(said: list[Said], count: int) -> list[tuple[float, int, str, Payload]]:
    """Return one cycle of N robots: time (s), robot, stream and payload, in order of time."""
    cycle = [
        ((t + robot * _STAGGER_S) % CYCLE_S, robot, stream, payload)
        for robot in range(count)
        for t, stream, payload in said[robot % len(said)]
    ]
    return sorted(cycle, key=lambda item: item[0])


def messages(cycle: list[tuple[float, int, str, Payload]]) -> Iterator[tuple[int, str, bytes]]:
    """Yield robot, stream and bytes when each is due, for ever."""
    started = time.monotonic()
    while True:
        for t, robot, stream, payload in cycle:
            wait = started + t - time.monotonic()
            if wait > 0.002:
                time.sleep(wait)
            stamped = payload
            if stream in _STAMPED:
                stamped = msgspec.structs.replace(payload, timestamp=timestamp_at(time.time()))
            yield robot, stream, encode(stamped)
        started += CYCLE_S


def run(endpoint: str, count: int) -> None:
    """Report as ``count`` robots until interrupted."""
    cycle = schedule(reports(), count)
    settings = TelemetrySettings(operator=endpoint)
    robots = [
        Telemetry(settings, robot=f"robot{number + 1}", team="load") for number in range(count)
    ]
    print(len(cycle) / CYCLE_S, flush=True)  # payloads per second: ready
    for robot, stream, payload in messages(cycle):
        robots[robot].publish(stream, payload)


if __name__ == "__main__":
    run(sys.argv[1], int(sys.argv[2]))
