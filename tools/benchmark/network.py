"""Figures of the network: control loop times under network faults, and the operator's page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tools.benchmark.figure import MEASURED_S, Figure
from tools.benchmark.load_table import measure_load
from tools.benchmark.trouble_table import loop_timings, reconnection_time


def telemetry(_folder_path: Path) -> Iterator[Figure]:
    """Time the control loop under every network fault, and the reconnection to an operator."""
    without: float | None = None
    for timing in loop_timings(MEASURED_S / 2):
        name = f"report to order, {timing.trouble}"
        yield Figure(f"{name}: median", 1e3 * timing.median, "ms")
        yield Figure(f"{name}: p99", 1e3 * timing.p99, "ms")
        without = timing.p99 if without is None else without
        yield Figure(f"{name}: p99, more than without", 1e3 * (timing.p99 - without), "ms", 5.0)
        yield Figure(f"{name}: longest", 1e3 * timing.longest, "ms")
        yield Figure(f"{name}: memory", timing.memory_mb, "MB", 150.0)
        yield Figure(f"{name}: payloads dropped", timing.dropped, "")
    for absence in (1.0, 5.0, 20.0):
        name = f"robot heard again, operator absent for {absence:g} s"
        yield Figure(name, reconnection_time(absence), "s", 2.0)


def operator_page(_folder_path: Path) -> Iterator[Figure]:
    """Measure the monitor and its page with 50 robots at full telemetry."""
    load = measure_load(50, MEASURED_S)
    yield Figure("50 robots: payloads", load.messages_per_s, "1/s")
    yield Figure(
        "50 robots: server, share of one core", 100 * load.server_cpu, "%", 50.0, speed=True
    )
    yield Figure("50 robots: server, memory", load.server_mb, "MB")
    if load.page is not None:
        yield Figure("50 robots: shown on the page", load.page.robots, "", 50, at_least=True)
        frames = load.page.frames_per_s
        yield Figure("50 robots: redraws of the page", frames, "1/s", 20.0, at_least=True)
        redraw_ms = 1e3 * load.page.cpu_per_frame
        yield Figure("50 robots: processor time of a redraw", redraw_ms, "ms", speed=True)
        yield Figure("50 robots: robot to pixel, median", 1e3 * load.page.latency_median, "ms")
        yield Figure("50 robots: robot to pixel, p99", 1e3 * load.page.latency_p99, "ms")
