"""What a bench says of a robot that stands for a reason."""

from __future__ import annotations

from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.bench.fleet import Fleet, run_bench
from tools.simulation.truth.truth import load_truth


def test_figures_of_a_robot_on_its_charger_say_when_it_stood_and_warned_and_why() -> None:
    folder = load_map_folder(find_map("paper_lab", Path()))
    fleet = Fleet(folder, 1, seed=1, truth=load_truth("charging"))
    (robot,) = run_bench(fleet, 10.0)["each"]
    assert robot["stood_s"] < 1.0
    assert robot["said"].startswith("gate: charging")
    assert 0.0 < robot["warned_s"]["gate"] < 10.0
    assert robot["collisions_with"] == {}
