"""Figures of the drivers: decoding time, and load at full rate."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.messages.effects import Effect
from robot_agent.messages.events import BytesReceived, Event, LinkName
from tools.bench.fleet import Fleet
from tools.benchmark.driver_load import FULL_RATE, driver_load
from tools.benchmark.figure import MEASURED_S, SEED, SETTLED_S, Figure


def drivers(folder_path: Path) -> Iterator[Figure]:
    """Measure the decoding of base reports and scans, and the drivers' load at full rate."""
    yield from _decoding(folder_path)
    share, scans, reports = driver_load(MEASURED_S, FULL_RATE["lms200"])
    yield Figure("driver threads at full rate, share of one core", 100 * share, "%", speed=True)
    yield Figure("scans of 361 values at 500 kbaud", scans, "1/s", 37.0, at_least=True)
    yield Figure("base reports meanwhile", reports, "1/s", 9.5, at_least=True)
    share, scans, _reports = driver_load(MEASURED_S, FULL_RATE["lms1xx"])
    yield Figure("the same with an LMS 1xx, share of one core", 100 * share, "%", speed=True)
    yield Figure("its scans of 541 values", scans, "1/s", 49.0, at_least=True)


def _decoding(folder_path: Path) -> Iterator[Figure]:
    """Time a settled agent's sessions on its recorded bytes: from bytes to SI units."""
    received: dict[LinkName, list[BytesReceived]] = {"base": [], "laser": []}

    class Listener:
        """Collects the bytes that a settled agent receives."""

        def record_event(self, event: Event) -> None:
            """Keep bytes received after ``SETTLED_S``."""
            if isinstance(event, BytesReceived) and event.t > SETTLED_S:
                received[event.link].append(event)

        def record_effect(self, t: float, effect: Effect) -> None:
            """Ignore effects."""

    fleet = Fleet(load_map_folder(folder_path), 1, SEED, observer=lambda _name, _config: Listener())
    while fleet.t < 60.0:
        fleet.step()
    agent = fleet.robots[0].agent
    for name, session, events in (
        ("base report, bytes to SI", agent.base, received["base"]),
        ("scan of 181 values, bytes to SI", agent.laser, received["laser"]),
    ):
        started = time.perf_counter()
        for event in events:
            session.feed(event.data, event.t)
        yield Figure(name, 1e6 * (time.perf_counter() - started) / len(events), "us", speed=True)
