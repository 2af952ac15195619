"""Figures of the patrol: the fuzzy supervisor, and a team in lockstep."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from maps.map_folder import MapFolder, load_map_folder
from robot_agent.patrol.rules import RULES_FILE, load_rules
from robot_agent.patrol.settings import PatrolSettings
from tools.bench.fleet import Fleet, run_bench
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench
from tools.benchmark.figure import SEED, Figure
from tools.benchmark.skfuzzy_peer import simulation_of
from tools.simulation.truth.truth import load_truth


def supervisor(_folder_path: Path) -> Iterator[Figure]:
    """Time one evaluation of the fuzzy supervisor, and the same by skfuzzy.control."""
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
    peer_seconds = _per_call(skfuzzy, 100)
    yield Figure("the same by skfuzzy.control", peer_seconds * 1e3, "ms")
    yield Figure(
        "as many times faster than skfuzzy.control", peer_seconds / seconds, "x", 300.0, True
    )


def patrol_bench(folder_path: Path) -> Iterator[Figure]:
    """Run robots in lockstep: distances from the border, contacts, speed of the benches."""
    folder = load_map_folder(folder_path)
    fleet = Fleet(folder, 3, SEED)
    started = time.process_time()
    figures = run_bench(fleet, 300.0)
    three = 300.0 / (time.process_time() - started)
    distance = figures["border_distance_m"]
    yield Figure("distance from border while patrolling, p99", distance["p99"], "m", 0.05)
    yield Figure("distance from border while patrolling, maximum", distance["max"], "m", 0.10)
    yield Figure("contacts in 300 s of three robots", figures["contacts"], "", 0)
    yield Figure("lockstep bench of three robots", three, "x real time", 20.0, at_least=True)
    ideal_s, rough_s = (_bench_time(folder, truth) for truth in ("ideal", "rough"))
    yield Figure("the truth rough: times the time of ideal", rough_s / ideal_s, "x", 1.3)
    fleet = Fleet(folder, 20, SEED)
    started = time.process_time()
    run_bench(fleet, 30.0)
    twenty = 30.0 / (time.process_time() - started)
    yield Figure("lockstep bench of 20 robots", twenty, "x real time", 3.0, at_least=True)
    ideal_fleet = IdealFleet(folder, 20, SEED)
    started = time.process_time()
    run_ideal_bench(ideal_fleet, 300.0)
    ideal = 300.0 / (time.process_time() - started)
    yield Figure("ideal bench of 20 robots", ideal, "x real time", 100.0, at_least=True)


def _bench_time(folder: MapFolder, truth: str) -> float:
    """Return the processor time of 60 s of three robots in a truth, s."""
    fleet = Fleet(folder, 3, SEED, truth=load_truth(truth))
    started = time.process_time()
    run_bench(fleet, 60.0)
    return time.process_time() - started


def _per_call(call: Callable[[int], object], count: int) -> float:
    """Return the median time of ``call(index)``, s, over index 0 to count - 1."""
    times = []
    for index in range(count):
        started = time.perf_counter()
        call(index)
        times.append(time.perf_counter() - started)
    return float(np.median(times))
