"""The paper's experiment: evaluation of its claims, its figures."""

import argparse
import json
from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.patrol.actions import Action
from tools.bench.sensing import Sensing
from tools.commands import paper as command
from tools.metrics.metrics import RobotRun
from tools.studies.paper import (
    PaperRun,
    PaperTrial,
    claims,
    far_starts,
    over_seeds,
    run_seeds,
    turns,
)

FIGURES = (
    *("figure_1_structure", "figure_2_membership", "figure_3_scenario"),
    *("figure_4_distance", "figure_5_actions", "figure_6_meeting"),
)
KEEP, CW, CCW = (
    Action.KEEP_GOING.value,
    Action.PATROL_CLOCKWISE.value,
    Action.PATROL_COUNTER_CLOCKWISE.value,
)


def meeting(first_turn: int, second_turn: int, *, both: bool = True) -> PaperRun:
    """Return a run of 40 s with two robots that meet half-way and turn at these steps of 0.1 s."""
    t = np.arange(400) / 10.0
    way = np.abs(0.35 * (t - 20.0)) + 0.8
    runs = []
    for name, side, turn, action, does in (
        ("robot1", -1, first_turn, CCW, True),
        ("robot2", 1, second_turn, CW, both),
    ):
        actions = [action if turn <= i < turn + 40 and does else KEEP for i in range(400)]
        direction = np.where(np.arange(400) < turn, -side, side).astype(np.int8)
        place = np.column_stack((side * way, np.zeros_like(way)))
        runs.append(RobotRun(name, t, place, actions, direction))
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    return PaperRun(folder, runs, {})


@pytest.mark.parametrize(("second", "apart"), [(190, 0), (192, 2), (197, 7)])
def test_turns_have_the_steps_between_them(second, apart):
    (turn,) = turns(meeting(190, second))
    assert (turn.steps_apart, turn.opposite, turn.parted) == (apart, True, True)
    assert turn.closest_m == pytest.approx(1.6)


def test_robot_that_does_not_turn_breaks_the_claim():
    (turn,) = turns(meeting(190, 190, both=False))
    assert (turn.steps_apart, turn.opposite, turn.parted) == (None, False, False)


def test_robot_reversed_at_random_is_no_head_on_meeting():
    run = meeting(190, 190, both=False)
    run.runs[1].direction[:] = 1
    assert turns(run) == []


def arguments(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    command.configure(parser)
    return parser.parse_args(words)


def test_command_writes_figures_and_claims(tmp_path, capsys):
    options = ["-o", str(tmp_path), "--sensing", "ideal", "--duration", "40", "--seeds", "2"]
    status = command.run(arguments(*options))
    summary = json.loads(capsys.readouterr().out)
    assert status == (0 if all(summary["held"].values()) else 1)
    assert summary["meetings"]["head_on"] == summary["meetings"]["within_two_steps"] > 0
    assert summary["held"]["every_meeting_cw_and_ccw_then_apart"]
    assert (summary["contacts"], summary["seeds"]) == (0, [1, 2])
    assert summary["held"]["first_reach_frontier"]
    by_seed = json.loads((tmp_path / "claims.json").read_text())
    assert [each["seed"] for each in by_seed] == [1, 2]
    heads_on = [each["meetings"]["head_on"] for each in by_seed]
    assert summary["meetings"]["head_on"] == sum(heads_on)
    worst = max(each["border_distance_m"]["max"] for each in by_seed)
    assert summary["border_distance_m"]["worst_max"] == worst
    assert {path.name for path in tmp_path.iterdir()} == {
        "claims.json",
        *(f"{name}.{kind}" for name in FIGURES for kind in ("pdf", "png")),
    }


def test_two_processes_give_the_same_claims_as_one(tmp_path):
    trial = PaperTrial(find_map("intel_lab", Path.cwd()), "open", Sensing.IDEAL, 5.0)
    one, two = ([claims(run) for run in run_seeds(trial, [3, 4], jobs)] for jobs in (1, 2))
    assert one == two
    assert [each["seed"] for each in one] == [3, 4]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_robots_start_far_from_the_border(seed):
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    for start in far_starts(folder, seed, 0.3):
        assert folder.border.project(start.x, start.y).distance >= 2.0


def test_where_there_is_no_room_far_from_the_border_robots_start_near_it():
    folder = load_map_folder(find_map("intel_lab", Path.cwd()), "open")
    assert len(far_starts(folder, 1, 0.3)) == 3


def test_claim_broken_by_one_seed_is_broken_over_all(tmp_path):
    trial = PaperTrial(find_map("paper_lab", Path.cwd()), "border", Sensing.IDEAL, 1.0)
    (single,) = (claims(run) for run in run_seeds(trial, [1], 1))
    single["held"] = dict.fromkeys(single["held"], True)
    broken = single | {"held": single["held"] | {"no_contact": False}, "contacts": 3}
    summary = over_seeds([single, broken])
    assert [name for name, held in summary["held"].items() if not held] == ["no_contact"]
    assert summary["contacts"] == 3


def test_no_seeds_are_refused(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        command.run(arguments("-o", str(tmp_path), "--seeds", "0"))
    assert ended.value.code == 2
    assert "--seeds" in capsys.readouterr().err
