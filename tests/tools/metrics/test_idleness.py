"""Idleness of a border, on visits small enough to work out by hand."""

from pathlib import Path

import numpy as np
import pytest

from maps.border import Border
from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.metrics.border_visits import border_visits
from tools.metrics.idleness import idleness_figures

SPEED = 0.35
T = np.arange(0.0, 2000.0, 0.1)


@pytest.fixture(scope="module")
def border() -> Border:
    loaded = load_map_folder(find_map("paper_lab", Path.cwd())).border
    assert loaded is not None
    return loaded


def lap(border: Border, t: np.ndarray, start: float = 0.0) -> np.ndarray:
    """Positions of a robot that goes round the border at SPEED."""
    places = [border.at(float((start + SPEED * time) % border.length)) for time in t]
    return np.array([(place.x, place.y) for place in places])


def test_perfect_spacing_reaches_the_least_possible_idleness(border: Border) -> None:
    robots = 3
    ideal = border.length / (robots * SPEED)  # 48.57 s
    places = [lap(border, T, k * border.length / robots) for k in range(robots)]
    figures = idleness_figures(border_visits(border, places, T))
    idle = figures["idleness_s"]
    for name in ("average", "worst_average", "mean"):
        assert idle[name] == pytest.approx(ideal, abs=0.2)
    assert idle["worst"] == pytest.approx(ideal, abs=0.5)
    assert idle["deviation"] < 0.3  # corners are within the radius for longer
    passing = 0.5 / SPEED
    assert idle["instantaneous"] == pytest.approx((ideal - passing) ** 2 / ideal / 2, rel=0.02)
    assert figures["visits"]["cycles"] == pytest.approx(T[-1] / ideal, abs=1.0)


def test_single_robot_is_a_lap_between_its_visits(border: Border) -> None:
    idle = idleness_figures(border_visits(border, [lap(border, T)], T))["idleness_s"]
    assert idle["average"] == pytest.approx(border.length / SPEED, abs=0.2)


def test_what_begin_and_end_cut_off_is_no_interval_but_counts_as_worst(border: Border) -> None:
    t = T[: round(1.2 * 10 * border.length / SPEED)]  # 1.2 laps: a fifth is visited twice
    figures = idleness_figures(border_visits(border, [lap(border, t)], t))
    assert figures["idleness_s"]["mean"] == pytest.approx(border.length / SPEED, abs=0.5)
    assert figures["idleness_s"]["worst"] == pytest.approx(border.length / SPEED, abs=1.0)
    assert figures["visits"]["cycles"] == 1


def test_a_standing_robot_leaves_the_rest_idle(border: Border) -> None:
    t = np.arange(100) * 0.1
    figures = idleness_figures(border_visits(border, [np.tile(lap(border, t[:1]), (100, 1))], t))
    assert figures["idleness_s"]["worst"] == pytest.approx(9.9)
    assert 9.0 < figures["idleness_s"]["average"] <= 9.9
    assert figures["visits"]["cycles"] == 0


def test_no_arrival_gives_none() -> None:
    assert set(idleness_figures(None)["idleness_s"].values()) == {None}
