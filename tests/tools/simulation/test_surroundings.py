"""Things that no map shows, drawn into the simulated building."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

from maps.map_folder import MapFolder, load_map_folder
from maps.occupancy_map import OCCUPIED
from robot_agent.config import find_map
from tools.simulation.surroundings import Surroundings, surroundings_of
from tools.simulation.truth.surroundings_truth import ThingsTruth
from tools.simulation.truth.truth import load_truth

ROUGH = load_truth("rough").things


@cache
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


def drawn(things: ThingsTruth, seed: int = 1) -> Surroundings:
    return surroundings_of(folder().map, folder().border, things, np.random.default_rng(seed))


def only(**counts: int) -> ThingsTruth:
    none = load_truth("plain").things
    return msgspec.structs.replace(none, **counts)


def test_without_things_the_building_is_its_map() -> None:
    around = drawn(only())
    assert around.touched is around.seen is around.heard is folder().map


def test_a_seed_draws_the_same_things_again_and_another_seed_others() -> None:
    first, again, other = (drawn(ROUGH, seed).touched.cells for seed in (1, 1, 2))
    assert (first == again).all()
    assert (first != other).any()


@pytest.mark.parametrize("seed", range(5))
def test_no_thing_stands_so_near_to_the_border_that_a_robot_could_not_pass(seed: int) -> None:
    cells, occupancy, border = drawn(ROUGH, seed).touched.cells, folder().map, folder().border
    assert border is not None
    row, col = np.nonzero(cells != occupancy.cells)
    middles = np.column_stack((col, row)) * 0.05 + 0.025 + occupancy.origin[:2]
    _, distances = border.project_many(middles)
    assert len(distances) > 50
    assert distances.min() >= ROUGH.narrowest


def test_low_boxes_are_touched_and_heard_but_not_seen() -> None:
    around = drawn(only(low_boxes=3))
    assert (around.seen.cells == folder().map.cells).all()
    assert (around.touched.cells != around.seen.cells).any()
    assert around.heard is around.touched


def test_lasers_see_through_glass_that_stops_bodies_and_sound() -> None:
    around = drawn(only(glass=2))
    assert (around.touched.cells == folder().map.cells).all()
    gone = (around.heard.cells == OCCUPIED) & (around.seen.cells != OCCUPIED)
    assert gone.sum() > 80


def test_doors_open_and_shut_against_the_map() -> None:
    opened = drawn(only(doors_open=2)).touched.cells != folder().map.cells
    shut = drawn(only(doors_shut=2)).touched.cells != folder().map.cells
    assert (folder().map.cells[opened] == OCCUPIED).any()
    assert (folder().map.cells[shut] != OCCUPIED).all()
    assert opened.any()
    assert shut.any()


def test_a_laser_sees_four_thin_legs_of_a_table() -> None:
    cells = drawn(only(tables=1)).seen.cells != folder().map.cells
    assert 4 <= cells.sum() <= 16
