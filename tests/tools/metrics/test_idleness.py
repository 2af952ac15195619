"""Idleness of a border, on visits small enough to work out by hand."""

from pathlib import Path

import numpy as np
import pytest

from maps.border import Border
from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.metrics.idleness import border_visits, idleness_figures, return_entropy

SPEED = 0.35


@pytest.fixture(scope="module")
def border() -> Border:
    loaded = load_map_folder(find_map("paper_lab", Path.cwd())).border
    assert loaded is not None
    return loaded


def lap_positions(border: Border, t: np.ndarray, start: float = 0.0) -> np.ndarray:
    places = [border.at(float((start + SPEED * time) % border.length)) for time in t]
    return np.array([(place.x, place.y) for place in places])


def test_evenly_spaced_robots_reach_the_ideal_idleness(border: Border) -> None:
    robots = 3
    ideal = border.length / (robots * SPEED)
    t = np.arange(0.0, 10 * ideal, 0.1)
    positions = [lap_positions(border, t, k * border.length / robots) for k in range(robots)]
    figures = idleness_figures(border_visits(border, positions, t))
    visit = 0.5 / SPEED  # a robot is within the visit radius that long
    assert figures["idleness_s"]["worst"] == pytest.approx(ideal - visit, abs=0.8)
    assert figures["idleness_s"]["instantaneous"] == pytest.approx(
        (ideal - visit) ** 2 / ideal / 2, rel=0.05
    )
    assert figures["visits"]["cycles"] in (10, 11)
    assert figures["visits"]["most"] <= 12
    assert figures["return_entropy_bit"] < 0.2


def test_one_lap_visits_every_point_once(border: Border) -> None:
    t = np.arange(0.0, border.length / SPEED, 0.1)
    figures = idleness_figures(border_visits(border, [lap_positions(border, t)], t))
    assert figures["idleness_s"]["worst"] == pytest.approx(t[-1], rel=0.05)
    assert figures["visits"]["cycles"] == 1


def test_a_standing_robot_leaves_the_rest_idle(border: Border) -> None:
    t = np.arange(100) * 0.1
    standing = np.tile(lap_positions(border, t[:1]), (100, 1))
    figures = idleness_figures(border_visits(border, [standing], t))
    assert figures["idleness_s"]["worst"] == pytest.approx(9.9)
    assert 9.0 < figures["idleness_s"]["average"] <= 9.9
    assert figures["visits"]["cycles"] == 0
    assert figures["return_entropy_bit"] is None


def test_no_arrival_gives_none() -> None:
    figures = idleness_figures(None)
    assert set(figures["idleness_s"].values()) == {None}


def test_entropy_of_return_times_matches_known_cases() -> None:
    assert return_entropy(np.array([])) is None
    assert return_entropy(np.full(8, 55.0)) == 0.0
    assert return_entropy(np.array([5.0, 15.0, 25.0, 35.0])) == pytest.approx(2.0)
