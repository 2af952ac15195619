"""Sends the telemetry of many robots without running them.

``python -m tools.benchmark.telemetry_load ENDPOINT N``:
One minute of telemetry of three benched robots is sent repeatedly under N names, each over its own
connection, with present time stamps.
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
"""Time after which the benched robots are on their border."""
SEED = 1
_STAGGER_S = 1.37  # between robots that repeat the same source
_STAMPED = frozenset({"pose", "status", "decision", "scan", "particles"})

Reports = list[tuple[float, str, Payload]]
"""Time (s), stream and payload of one robot's telemetry, in order of time."""


class _Listener:
    """Collects the telemetry of a benched robot."""

    def __init__(self, recorded: Reports) -> None:
        self._recorded = recorded

    def record_event(self, event: Event) -> None:
        """Ignore events."""

    def record_effect(self, t: float, effect: Effect) -> None:
        """Keep what is published from ``SETTLED_S`` on."""
        if isinstance(effect, Publish) and t >= SETTLED_S:
            self._recorded.append(
                (t - SETTLED_S, effect.stream, decode(effect.stream, effect.payload))
            )


def reports() -> list[Reports]:
    """Return the telemetry of each benched robot in one cycle, times from its start."""
    recorded: list[Reports] = []

    def observe(_name: str, _config: AgentConfig) -> _Listener:
        recorded.append([])
        return _Listener(recorded[-1])

    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    fleet = Fleet(folder, SOURCES, SEED, observer=observe)
    while fleet.t < SETTLED_S + CYCLE_S:
        fleet.step()
    return recorded


def schedule(recorded: list[Reports], count: int) -> list[tuple[float, int, str, Payload]]:
    """Return one cycle of ``count`` robots: time, robot, stream and payload, in order of time."""
    cycle = [
        ((t + robot * _STAGGER_S) % CYCLE_S, robot, stream, payload)
        for robot in range(count)
        for t, stream, payload in recorded[robot % len(recorded)]
    ]
    return sorted(cycle, key=lambda item: item[0])


def messages(cycle: list[tuple[float, int, str, Payload]]) -> Iterator[tuple[int, str, bytes]]:
    """Yield robot, stream and bytes when each is due, endlessly."""
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
    """Send the telemetry of ``count`` robots to an endpoint until interrupted."""
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
