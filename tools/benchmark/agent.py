"""Figures of the agent process: load, response time, stop without agent, time of a decision."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import psutil

from maps.map_folder import load_map_folder
from robot_agent.messages.effects import Effect
from robot_agent.messages.events import BytesReceived, Event
from tools.bench.fleet import Fleet
from tools.benchmark.figure import MEASURED_S, SEED, SETTLED_S, Figure
from tools.campaign.agent_stage import AgentStage
from tools.campaign.fault_list import chosen_faults
from tools.campaign.fault_table import run_faults
from tools.campaign.reaction import WATCHDOG_LIMIT_S
from tools.demo.demo import Demo, DemoOptions
from tools.monitor.endpoint import free_endpoint
from tools.monitor.operator import Operator


def agent_process(folder_path: Path) -> Iterator[Figure]:
    """Measure load and memory of an agent process at full sensor rate, emulated over ptys."""
    with tempfile.TemporaryDirectory() as record:
        endpoint = free_endpoint()
        options = DemoOptions(folder_path, "border", 1, SEED, endpoint, Path(record))
        with closing(Operator(endpoint)), Demo(options).running() as demo:
            process = psutil.Process(demo.agent_pids()[0])
            time.sleep(SETTLED_S)
            before = process.cpu_times()
            started = time.monotonic()
            time.sleep(MEASURED_S)
            after = process.cpu_times()
            elapsed = time.monotonic() - started
            resident = process.memory_info().rss
    used = after.user + after.system - before.user - before.system
    yield Figure("agent process, share of one core", 100 * used / elapsed, "%", 15.0, speed=True)
    yield Figure("agent process, memory", resident / 2**20, "MB", 150.0)


def response_on_the_line(_folder_path: Path) -> Iterator[Figure]:
    """Measure the time from a report's last byte to its command's first, at the pty's base end."""
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(AgentStage(Path(folder), SEED)) as stage,
    ):
        stage.start_agent()
        settled = time.monotonic() + SETTLED_S
        while stage.step().t < settled:
            stage.tap.response_times.clear()
        while stage.step().t < settled + MEASURED_S:
            pass
        times = 1e3 * np.array(stage.tap.response_times)
    yield Figure("last report byte to first command byte, median", float(np.median(times)), "ms")
    p99 = float(np.percentile(times, 99))
    yield Figure("last report byte to first command byte, p99", p99, "ms", 10.0)


def stop_without_agent(_folder_path: Path) -> Iterator[Figure]:
    """Measure the time from killing, freezing or disconnecting the agent to the stop."""
    for reaction in run_faults(chosen_faults(("agent-killed", "agent-frozen", "base-cut"))):
        ordered = math.inf if reaction.ordered is None else reaction.ordered
        yield Figure(f"stops after: {reaction.what}", ordered, "s", WATCHDOG_LIMIT_S)


def decision_step(folder_path: Path) -> Iterator[Figure]:
    """Time the agent's two most frequent events: a base report with its decision, and a scan."""
    folder = load_map_folder(folder_path)
    fleet = Fleet(folder, 1, SEED)
    spent: dict[str, list[float]] = {"base": [], "laser": []}
    agent = fleet.robots[0].agent
    handle = agent.handle

    def timed(event: Event) -> list[Effect]:
        started = time.perf_counter()
        effects = handle(event)
        if isinstance(event, BytesReceived) and agent.decision is not None:
            spent[event.link].append(time.perf_counter() - started)
        return effects

    agent.handle = timed  # type: ignore[method-assign]
    while fleet.t < 60.0:
        fleet.step()
    yield Figure(
        "base report to command bytes, median",
        1e3 * float(np.median(spent["base"])),
        "ms",
        0.5,
        speed=True,
    )
    scan_ms = 1e3 * float(np.median(spent["laser"]))
    yield Figure("scan to pose and tracks, median", scan_ms, "ms", speed=True)
