"""The intruder who sees all robots and must strike now."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import AgentConfig, find_map
from tools.batch.all_knowing import detections
from tools.batch.batch import Batch
from tools.batch.batch_bench import run_batch
from tools.bench.bench_fault import parse_fault
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench
from tools.metrics.intruder_exposure import least_detection

FOLDER = load_map_folder(find_map("paper_lab", Path.cwd()))
LAP_S = FOLDER.border.length / 0.35


def config(**patrol: object) -> AgentConfig:
    one = AgentConfig()
    return msgspec.structs.replace(one, patrol=msgspec.structs.replace(one.patrol, **patrol))


def spaced(count: int) -> list[Pose]:
    """Return robots on the border that all look clockwise, evenly spaced."""
    points = [FOLDER.border.at(FOLDER.border.length * number / count) for number in range(count)]
    return [Pose(x, y, float(np.arctan2(ty, tx))) for x, y, tx, ty, _ in points]


def test_the_least_of_certain_futures_is_0_or_1():
    first = np.array([[5.0, 30.0, np.inf]] * 8)
    assert least_detection(first, 20.0) == 0.0
    assert least_detection(first[:, :2], 20.0) == 0.0
    assert least_detection(first[:, :2], 40.0) == 1.0


def test_the_place_is_not_chosen_by_the_futures_that_judge_it():
    first = np.where(np.random.default_rng(1).random((64, 200)) < 0.5, 10.0, np.inf)
    assert (first <= 20.0).mean(axis=0).min() < 0.36  # what chance alone makes the least
    assert least_detection(first, 20.0) == pytest.approx(0.5, abs=0.15)


def test_one_place_that_every_other_future_visits_is_seen_half_the_time():
    first = np.array([[10.0, 1.0], [np.inf, 1.0]] * 8)
    assert least_detection(first, 20.0) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("robots", [1, 3])
def test_perfect_spacing_is_all_or_nothing(robots):
    clockwork = config(modifiers=(), reversal_probability=0.0)
    batch = Batch(FOLDER, robots, [1], clockwork, starts=[spaced(robots)])
    while batch.t < 30.0:
        batch.step()
    (seen,) = detections(batch, rollouts=4)
    gap = LAP_S / robots
    assert seen == {f"{dwell:g}": float(dwell > gap) for dwell in (20.0, 40.0, 60.0, 90.0)}


def test_futures_without_chance_are_the_run_itself():
    batch = Batch(FOLDER, 3, [1, 2], config(modifiers=(), reversal_probability=0.0))
    while batch.t < 60.0:
        batch.step()
    future = batch.branched(2, seed=1)
    for _ in range(300):
        batch.step()
        future.step()
    for run in range(4):
        one, same = 3 * (run // 2), 3 * run
        assert [future.bodies.pose(same + own) for own in range(3)] == [
            batch.bodies.pose(one + own) for own in range(3)
        ]


def test_looking_into_the_future_changes_nothing():
    looked, other = (Batch(FOLDER, 3, [5]) for _ in range(2))
    for batch in (looked, other):
        while batch.t < 40.0:
            batch.step()
    detections(looked, rollouts=2)
    for batch in (looked, other):
        while batch.t < 80.0:
            batch.step()
    assert looked.bodies.pose(1) == other.bodies.pose(1)


def test_figures_are_those_of_the_ideal_bench_and_the_intruder_beside_them():
    faults = [parse_fault("robot2:dead@30")]
    fleet = IdealFleet(FOLDER, 3, 4, faults=faults)
    batch = Batch(FOLDER, 3, [4], faults=[faults])
    (figures,) = run_batch(batch, 60.0, moments=2, rollouts=4)
    expected = run_ideal_bench(fleet, 60.0)
    for one in (figures, figures["settled"]):
        assert set(one["intruder_seen"].pop("all_knowing")) == {"20", "40", "60", "90"}
    assert set(figures) == set(expected)
    assert figures["idleness_s"] == pytest.approx(expected["idleness_s"])
    assert figures["action_share"] == pytest.approx(expected["action_share"])
    assert figures["intruder_seen"]["random"] == expected["intruder_seen"]["random"]
