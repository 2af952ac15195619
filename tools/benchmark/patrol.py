"""Figures of the patrol: the fuzzy supervisor, and a team in lockstep."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from maps.map_folder import MapFolder, load_map_folder
from robot_agent.patrol.rules import RULES_FILE, load_rules
from robot_agent.patrol.settings import PatrolSettings
from tools.batch.batch import Batch
from tools.bench.fleet import Fleet, run_bench
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench
from tools.benchmark.figure import SEED, Figure
from tools.benchmark.skfuzzy_peer import simulation_of
from tools.simulation.truth.truth import load_truth

_REACHED_S = 60.0  # s after which the robots of a batch have reached the border


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
    yield Figure("fuzzy supervisor, one evaluation", seconds * 1e3, "ms", 0.1, speed=True)
    simulation = simulation_of(system, np.linspace(0.0, 1.0, 101))

    def skfuzzy(index: int) -> None:
        for name, value in inputs[index].items():
            if name in known:
                simulation.input[name] = value
        simulation.compute()

    known = {variable.name for variable in system.inputs}
    peer_seconds = _per_call(skfuzzy, 100)
    yield Figure("the same by skfuzzy.control", peer_seconds * 1e3, "ms", speed=True)
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
    yield _speed("lockstep bench of three robots", three, 20.0)
    ideal_s, rough_s = (_bench_time(folder, truth) for truth in ("ideal", "rough"))
    yield Figure("the truth rough: times the time of ideal", rough_s / ideal_s, "x", 1.3)
    fleet = Fleet(folder, 20, SEED)
    started = time.process_time()
    run_bench(fleet, 30.0)
    twenty = 30.0 / (time.process_time() - started)
    yield _speed("lockstep bench of 20 robots", twenty, 3.0)
    ideal_fleet = IdealFleet(folder, 20, SEED)
    started = time.process_time()
    run_ideal_bench(ideal_fleet, 300.0)
    ideal = 300.0 / (time.process_time() - started)
    yield _speed("ideal bench of 20 robots", ideal, 100.0)
    yield _speed("batch of 20 robots, 200 runs", _batch_speed(folder, 20, 60.0), 2000.0)
    yield _speed("batch of three robots, 200 runs", _batch_speed(folder, 3, 120.0), 10000.0)


def _speed(name: str, value: float, limit: float) -> Figure:
    return Figure(name, value, "x real time", limit, at_least=True, speed=True)


def _batch_speed(folder: MapFolder, robots: int, duration: float) -> float:
    """Return the simulated time of 200 runs, summed, in a second of processor time.

    Measured once the robots have reached the border, for a duration, s.
    """
    runs = 200
    batch = Batch(folder, robots, range(runs))
    while batch.t < _REACHED_S:
        batch.step()
    started = time.process_time()
    while batch.t < _REACHED_S + duration:
        batch.step()
    return runs * duration / (time.process_time() - started)


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
