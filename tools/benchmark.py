"""The figures every change keeps, measured: each with its unit and its limit."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil

from maps.map_folder import MapFolder, load_map_folder
from robot_agent.config import find_map
from robot_agent.effects import Effect
from robot_agent.events import BytesReceived, Event, LinkName
from robot_agent.patrol.rules import RULES_FILE, load_rules
from robot_agent.patrol.settings import PatrolSettings
from tools.bench.agent_stage import AgentStage
from tools.bench.driver_load import driver_load
from tools.bench.fleet import Fleet, run_bench
from tools.bench.fleet_recorder import FleetRecorder
from tools.color_trial import run_color_trial
from tools.demo import Demo, DemoOptions, free_endpoint
from tools.fault_list import chosen_faults
from tools.fault_table import run_faults
from tools.localize_benchmark import large_map_mb, update_costs
from tools.monitor.load_table import measure_load
from tools.monitor.operator import Operator
from tools.monitor.trouble_table import loop_timings, reconnection_time
from tools.reaction import WATCHDOG_LIMIT_S
from tools.recording import read_recording
from tools.replay import Replay
from tools.report.alignment import align
from tools.report.numbers import numbers
from tools.report.page import page
from tools.report.run_log import read_run
from tools.report.team import Team
from tools.skfuzzy_peer import simulation_of

SEED = 1
SETTLED_S = 12.0
"""An agent has connected, localized and set off by then."""
MEASURED_S = 20.0
REPORTED_S = 120.0
COLOR_PICTURES = 800


@dataclass(frozen=True)
class Figure:
    """One line of the table."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    """The value must not be above it; None: for information."""
    at_least: bool = False
    """The limit is one from below."""

    @property
    def kept(self) -> bool:
        """Whether the limit is kept."""
        if self.limit is None:
            return True
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def cells(self) -> tuple[str, str, str, str]:
        """Name, value, limit and verdict, for a table."""
        bound = "at least" if self.at_least else "at most"
        limit = "" if self.limit is None else f"{bound} {self.limit:g}"
        verdict = "" if self.limit is None else ("ok" if self.kept else "MISSED")
        return self.name, f"{self.value:.3g} {self.unit}", limit, verdict


def agent_process(folder_path: Path) -> Iterator[Figure]:
    """Measure an agent process at full sensor rate, driven by a real-time world over ptys."""
    with tempfile.TemporaryDirectory() as record:
        endpoint = free_endpoint()
        options = DemoOptions(folder_path, "border", 1, SEED, endpoint, Path(record))
        with Operator(endpoint), Demo(options) as demo:
            process = psutil.Process(demo.agent_pids()[0])
            time.sleep(SETTLED_S)
            before = process.cpu_times()
            started = time.monotonic()
            time.sleep(MEASURED_S)
            after = process.cpu_times()
            elapsed = time.monotonic() - started
            resident = process.memory_info().rss
    used = after.user + after.system - before.user - before.system
    yield Figure("agent process, share of one core", 100 * used / elapsed, "%", 15.0)
    yield Figure("agent process, memory", resident / 2**20, "MB", 150.0)


def response_on_the_line(_folder_path: Path) -> Iterator[Figure]:
    """Time, at the base's end of a pty, from the last byte of a report to the order it caused."""
    with (
        tempfile.TemporaryDirectory() as folder,
        AgentStage(Path(folder), SEED) as stage,
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
    """Time until the robot begins to stop once its agent is killed, frozen or cut off."""
    for reaction in run_faults(chosen_faults(("agent-killed", "agent-frozen", "base-cut"))):
        ordered = math.inf if reaction.ordered is None else reaction.ordered
        yield Figure(f"stops after: {reaction.what}", ordered, "s", WATCHDOG_LIMIT_S)


def supervisor(_folder_path: Path) -> Iterator[Figure]:
    """Time one evaluation of the fuzzy supervisor."""
    settings = PatrolSettings()
    system = load_rules(
        RULES_FILE,
        reading=settings.reading,
        safety_distance=settings.safety_distance,
        open_border=False,
    )
    rng = np.random.default_rng(SEED)
    inputs = [
        {
            "distance_from_border": border,
            "distance_from_neighbor": neighbor,
            "neighbor_state": gamma,
            "distance_from_left_end": np.inf,
            "distance_from_right_end": np.inf,
        }
        for border, neighbor, gamma in (
            rng.random((2000, 3)) * (3.0, 3.0, 2.0) - (0, 0, 1)
        ).tolist()
    ]
    seconds = _per_call(lambda index: system.evaluate(inputs[index]), len(inputs))
    yield Figure("fuzzy supervisor, one evaluation", seconds * 1e3, "ms", 0.1)
    simulation = simulation_of(system, np.linspace(0.0, 1.0, 101))

    def skfuzzy(index: int) -> None:
        for name, value in inputs[index].items():
            if name in known:
                simulation.input[name] = value
        simulation.compute()

    known = {variable.name for variable in system.inputs}
    theirs = _per_call(skfuzzy, 100)
    yield Figure("the same by skfuzzy.control", theirs * 1e3, "ms")
    yield Figure("as many times faster than skfuzzy.control", theirs / seconds, "x", 300.0, True)


def decision_step(folder_path: Path) -> Iterator[Figure]:
    """Time the agent's two hot events: a base report with its decision, and a scan."""
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
        "base report to command bytes, median", 1e3 * float(np.median(spent["base"])), "ms", 0.5
    )
    yield Figure("scan to pose and tracks, median", 1e3 * float(np.median(spent["laser"])), "ms")


def patrol_bench(folder_path: Path) -> Iterator[Figure]:
    """Run three robots in lockstep with noise and take the distances from the border."""
    fleet = Fleet(load_map_folder(folder_path), 3, SEED)
    figures = run_bench(fleet, 300.0)
    distance = figures["border_distance_m"]
    yield Figure("distance from border while patrolling, p99", distance["p99"], "m", 0.05)
    yield Figure("distance from border while patrolling, maximum", distance["max"], "m", 0.10)
    yield Figure("contacts in 300 s of three robots", figures["contacts"], "", 0)
    yield Figure(
        "lockstep bench of three robots",
        300.0 / figures["wall_s"],
        "x real time",
        20.0,
        at_least=True,
    )


def replay_speed(folder_path: Path) -> Iterator[Figure]:
    """Record a robot in lockstep for three minutes and replay the recording."""
    folder = load_map_folder(folder_path)
    with tempfile.TemporaryDirectory() as parent:
        path = record_lockstep(folder, 180.0, Path(parent))
        result = Replay(read_recording(path)).run()
        size = path.stat().st_size
    yield Figure(
        "replay of a recording", result.duration / result.wall, "x real time", 50.0, at_least=True
    )
    yield Figure("recording of one hour", size * 3600 / result.duration / 2**20, "MB", 250.0)


def report_speed(folder_path: Path) -> Iterator[Figure]:
    """Record three robots in lockstep for two minutes; time reading and reporting."""
    folder = load_map_folder(folder_path)
    with tempfile.TemporaryDirectory() as parent:
        with FleetRecorder(folder, Path(parent)) as recorder:
            fleet = Fleet(folder, 3, SEED, observer=recorder.observe)
            while fleet.t < REPORTED_S:
                fleet.step()
            fleet.shut_down()
        started = time.process_time()
        runs = [read_run(path) for path in recorder.paths]
        read = time.process_time()
        team = Team(runs, align(runs))
        page(team, numbers(team), lambda _done: None)
        drawn = time.process_time()
    yield Figure(
        "reading a recording for a report", 3 * REPORTED_S / (read - started), "x real time"
    )
    yield Figure("report of three runs, figures and page", drawn - read, "s of CPU")


def record_lockstep(folder: MapFolder, duration: float, target: Path) -> Path:
    """Record one robot of a lockstep run of a duration, s (virtual), in a folder."""
    with FleetRecorder(folder, target) as recorder:
        fleet = Fleet(folder, 1, SEED, observer=recorder.observe)
        while fleet.t < duration:
            fleet.step()
        fleet.shut_down()
    return recorder.paths[0]


def drivers(folder_path: Path) -> Iterator[Figure]:
    """Time the decoding of base reports and of scans, and load the drivers at full rate."""
    yield from _decoding(folder_path)
    share, scans, reports = driver_load(MEASURED_S)
    yield Figure("driver threads at full rate, share of one core", 100 * share, "%")
    yield Figure("scans of 361 values at 500 kbaud", scans, "1/s", 37.0, at_least=True)
    yield Figure("base reports meanwhile", reports, "1/s", 9.5, at_least=True)


def _decoding(folder_path: Path) -> Iterator[Figure]:
    """Time what a settled agent's sessions make of what it heard: from bytes to SI units."""
    heard: dict[LinkName, list[BytesReceived]] = {"base": [], "laser": []}

    class Listener:
        """Keeps what a settled agent receives."""

        def record_event(self, event: Event) -> None:
            """Keep bytes received after the handshakes."""
            if isinstance(event, BytesReceived) and event.t > SETTLED_S:
                heard[event.link].append(event)

        def record_effect(self, t: float, effect: Effect) -> None:
            """Effects do not matter here."""

    fleet = Fleet(load_map_folder(folder_path), 1, SEED, observer=lambda _name, _config: Listener())
    while fleet.t < 60.0:
        fleet.step()
    agent = fleet.robots[0].agent
    for name, session, events in (
        ("base report, bytes to SI", agent.base, heard["base"]),
        ("scan of 181 values, bytes to SI", agent.laser, heard["laser"]),
    ):
        started = time.perf_counter()
        for event in events:
            session.feed(event.data, event.t)
        yield Figure(name, 1e6 * (time.perf_counter() - started) / len(events), "us")


def localization(_folder_path: Path) -> Iterator[Figure]:
    """Time the localizer by particles and beams on the map of a real building."""
    limits = {(2000, 60): 0.9, (5000, 180): 4.0}
    for cost in update_costs(find_map("intel_lab", Path.cwd())):
        size = f"localization, {cost.particles} particles x {cost.beams} beams"
        yield Figure(
            f"{size}, filter", cost.filter_ms, "ms", limits.get((cost.particles, cost.beams))
        )
        yield Figure(f"{size}, with refinement and check", cost.whole_ms, "ms")
        yield Figure(f"{size}, products", 1e-6 * cost.products_per_s, "million/s")
    yield Figure("localization, map of 100 x 100 m at 0.05 m", large_map_mb(), "MB", 60.0)


def telemetry(_folder_path: Path) -> Iterator[Figure]:
    """Time the control loop with the network in every state of repair."""
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
    """Load the monitor and its page with many robots at full telemetry."""
    load = measure_load(50, MEASURED_S)
    yield Figure("50 robots: payloads", load.messages_per_s, "1/s")
    yield Figure("50 robots: server, share of one core", 100 * load.server_cpu, "%", 50.0)
    yield Figure("50 robots: server, memory", load.server_mb, "MB")
    if load.page is not None:
        yield Figure("50 robots: shown on the page", load.page.robots, "", 50, at_least=True)
        frames = load.page.frames_per_s
        yield Figure("50 robots: redraws of the page", frames, "1/s", 20.0, at_least=True)
        yield Figure("50 robots: processor time of a redraw", 1e3 * load.page.cpu_per_frame, "ms")
        yield Figure("50 robots: robot to pixel, median", 1e3 * load.page.latency_median, "ms")
        yield Figure("50 robots: robot to pixel, p99", 1e3 * load.page.latency_p99, "ms")


def color(_folder_path: Path) -> Iterator[Figure]:
    """Look for bands in composed pictures, 10 to 2000 lux, half of them without any."""
    trial = run_color_trial(COLOR_PICTURES, SEED)
    yield Figure("bands at 2.5 m found", 100 * trial.recall, "%", 95.0, at_least=True)
    yield Figure("bands at 0.6 to 2.5 m found", 100 * trial.recall_near, "%", 95.0, at_least=True)
    yield Figure("false bands in 200 pictures", 200 * trial.false_share, "", 1.0)
    yield Figure("bearing of a band at 2.5 m, sigma", math.degrees(trial.bearing_sigma), "deg")
    yield Figure("range of a band at 2.5 m, bias", trial.range_bias, "m")
    yield Figure("range of a band at 2.5 m, sigma", trial.range_sigma, "m")
    yield Figure("colour detection, 320 x 240, processor time", trial.cpu_ms, "ms", 5.0)


GROUPS: dict[str, Callable[[Path], Iterator[Figure]]] = {
    "agent": agent_process,
    "response": response_on_the_line,
    "stop": stop_without_agent,
    "supervisor": supervisor,
    "decision": decision_step,
    "patrol": patrol_bench,
    "replay": replay_speed,
    "report": report_speed,
    "localization": localization,
    "drivers": drivers,
    "telemetry": telemetry,
    "page": operator_page,
    "color": color,
}


def _per_call(call: Callable[[int], object], count: int) -> float:
    """Return the median time of a call, s, over ``count`` of them."""
    times = []
    for index in range(count):
        started = time.perf_counter()
        call(index)
        times.append(time.perf_counter() - started)
    return float(np.median(times))
