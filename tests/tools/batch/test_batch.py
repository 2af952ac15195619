"""The batch: the decisions of ``IdealFleet``, step by step, of many runs at once."""

from pathlib import Path

import msgspec
import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import AgentConfig, find_map
from robot_agent.patrol.settings import PAPER_STRATEGY
from tools.batch.batch import Batch
from tools.batch.situations import ACTIONS, CAUSES, NONE, REASONS
from tools.bench.bench_fault import BenchFaultError, draw_faults
from tools.bench.ideal_fleet import IdealFleet

ROUNDING = 1e-9  # m, m/s and rad/s: of the functions of numpy and of the C library


def folder(name: str, border: str = "border"):
    return load_map_folder(find_map(name, Path.cwd()), border)


def config(**patrol: object) -> AgentConfig:
    one = AgentConfig()
    return msgspec.structs.replace(one, patrol=msgspec.structs.replace(one.patrol, **patrol))


def name_of(names: tuple[str, ...], code: int) -> str | None:
    return None if code == NONE else names[code]


@pytest.mark.parametrize(
    ("place", "robots", "seeds", "duration", "faults", "patrol"),
    [
        (("paper_lab",), 3, (1, 2), 150.0, [], {"modifiers": PAPER_STRATEGY}),
        (("paper_lab",), 3, (3,), 60.0, [], {"modifiers": ()}),
        (("paper_lab",), 3, (1, 2), 250.0, [], {}),
        (
            *(("paper_lab",), 3, (1, 2), 400.0, ["any1:dead@60"]),
            {"team_size": 3},
        ),
        (("paper_lab",), 20, (1,), 40.0, [], {}),
        (("paper_lab", "open"), 5, (3,), 120.0, ["any1:dead@30..60"], {}),
        (
            *(("intel_lab",), 8, (4, 5), 60.0, ["any2:dead@20..40", "any1:stuck@30+20"]),
            {"modifiers": PAPER_STRATEGY},
        ),
        pytest.param(
            *(("paper_lab",), 3, (2, 3), 1400.0, ["any1:dead@1300"]),
            {"common_secret": "x", "team_size": 3},
            marks=pytest.mark.long,
        ),
        (("intel_lab", "open"), 8, (2,), 60.0, [], {"reversal_distribution": "exponential"}),
        (("paper_lab",), 8, (2,), 200.0, [], {"common_secret": "x", "team_size": 8}),
        (("paper_lab",), 1, (1,), 520.0, [], {}),
    ],
    ids=[
        "paper's strategy",
        "paper alone",
        "default",
        "one dies",
        "20 robots",
        "open, one dies",
        "two die",
        "common turns",
        "chance",
        "too many for common turns",
        "one alone",
    ],
)
def test_every_step_is_that_of_the_agents_own_decision_layer(
    place, robots, seeds, duration, faults, patrol
):
    where, own = folder(*place), config(**patrol)
    team = [f"robot{number + 1}" for number in range(robots)]
    drawn = [draw_faults(faults, team, seed) for seed in seeds]
    fleets = [
        IdealFleet(where, robots, seed, own, faults=each)
        for seed, each in zip(seeds, drawn, strict=True)
    ]
    batch = Batch(where, robots, seeds, own, faults=drawn)
    while batch.t < duration:
        batch.step()
        for run, fleet in enumerate(fleets):
            fleet.step()
            for number, robot in enumerate(fleet.robots, run * robots):
                same_robot(batch, number, robot)
    for run, fleet in enumerate(fleets):
        assert batch.gate_stops(run) == sum(robot.gate_stops for robot in fleet.robots)
        assert batch.bodies.contacts(run) == fleet.world.contacts
        assert [(wreck.robot, wreck.since) for wreck in batch.wrecks(run)] == [
            (wreck.robot, wreck.since) for wreck in fleet.wrecks()
        ]


def same_robot(batch: Batch, number: int, robot) -> None:
    """Compare a robot of the batch with one of the ideal fleet after the same step."""
    assert same(batch.bodies.pose(number), robot.body.pose)
    assert batch.dead[number] == robot.dead
    if robot.dead:
        return
    made, decision, gate = batch.decisions, robot.decision, robot.gate_decision
    assert ACTIONS[made.action[number]] == decision.action
    assert made.direction[number] == decision.direction
    assert name_of(REASONS, made.reason[number]) == decision.override
    assert name_of(CAUSES, made.turn[number]) == decision.turn
    assert same((made.vx[number], made.vy[number]), decision.velocity)
    assert same((batch.order[0][number], batch.order[1][number]), (gate.v, gate.w))


def same(found: tuple[float, ...], wanted: tuple[float, ...]) -> bool:
    """Return whether values are equal but for rounding; ``approx`` takes a fifth of these tests."""
    return all(abs(a - b) <= ROUNDING for a, b in zip(found, wanted, strict=True))


def test_runs_do_not_depend_on_those_beside_them():
    where = folder("paper_lab")
    many, one = Batch(where, 3, (7, 8, 9)), Batch(where, 3, (8,))
    for _ in range(600):
        many.step()
        one.step()
    assert [many.bodies.pose(3 + number) for number in range(3)] == [
        one.bodies.pose(number) for number in range(3)
    ]


def test_faults_that_a_batch_has_not_are_refused():
    faults = draw_faults(["robot1:dead@10-20"], ["robot1"], 1)
    with pytest.raises(BenchFaultError, match="use patrol bench"):
        Batch(folder("paper_lab"), 1, (1,), faults=[faults])


def test_a_supervisor_without_arrays_is_refused():
    with pytest.raises(ValueError, match="has no arrays"):
        Batch(folder("paper_lab"), 1, (1,), config(supervisor="automaton"))
