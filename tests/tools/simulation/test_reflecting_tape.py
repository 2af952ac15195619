"""Beams on reflecting tape."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.framing import Telegram, TelegramFramer, encode_telegram
from drivers.lms200.measurement import MEASURING_MODES, MODE_32_M, UNIT_MM, decode_measurement
from drivers.lms200.telegrams import Command, Mode
from maps.map_folder import load_map_folder
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from robot_agent.config import find_map
from tools.simulation.fan import laser_fan
from tools.simulation.rig import make_rigs, sense
from tools.simulation.stranger import PERSON
from tools.simulation.truth.robot_truth import TapeTruth
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

BEARINGS = np.radians(np.linspace(-30.0, 30.0, 121))
NO_NOISE = load_truth("ideal").noise


def seen(
    tape: TapeTruth | None, heading: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Ranges to a robot 2 m ahead and which beams a reflector returns; the observer wears tape."""
    free = OccupancyMap(np.zeros((80, 80), dtype=np.uint8), 0.05, Pose(0.0, 0.0, 0.0))
    world = World(free, np.random.default_rng(1), NO_NOISE)
    observer = world.add_body(Pose(0.5, 2.0, 0.0))
    observer.tape = TapeTruth(worn=True, facing=0.5, missed=0.0)
    other = world.add_body(Pose(2.5, 2.0, heading))
    other.tape = tape
    ranges, reflectors = world.scans(
        [laser_fan(observer, observer.pose, BEARINGS, (0.0, 0.0, 0.0))]
    )[0]
    assert reflectors is not None
    return ranges, reflectors


def test_beams_on_a_robot_with_tape_return_a_reflectors_light() -> None:
    ranges, reflectors = seen(TapeTruth(worn=True, facing=0.5, missed=0.0))
    assert reflectors.sum() > 5
    assert (reflectors == np.isfinite(ranges)).all()


def test_beams_on_a_robot_without_tape_do_not() -> None:
    _, reflectors = seen(None)
    assert not reflectors.any()


def test_tape_seen_too_steeply_is_missed() -> None:
    ranges, reflectors = seen(TapeTruth(worn=True, facing=0.5, missed=0.0), math.radians(45.0))
    assert np.isfinite(ranges).sum() > 5
    assert not reflectors.any()


def test_a_share_of_the_beams_misses_the_tape() -> None:
    ranges, reflectors = seen(TapeTruth(worn=True, facing=0.5, missed=0.5))
    share = reflectors.sum() / np.isfinite(ranges).sum()
    assert 0.2 < share < 0.8


def test_a_person_wears_no_tape() -> None:
    free = OccupancyMap(np.zeros((80, 80), dtype=np.uint8), 0.05, Pose(0.0, 0.0, 0.0))
    world = World(free, np.random.default_rng(1), NO_NOISE)
    [rig] = make_rigs(world, [Pose(0.5, 2.0, 0.0)], 0.0, load_truth("housing_tape"))
    world.add_body(Pose(2.5, 2.0, 0.0), PERSON)
    returns = world.scans([laser_fan(rig.body, rig.body.pose, BEARINGS, (0.0, 0.0, 0.0))])[0]
    assert np.isfinite(returns.ranges).any()
    assert returns.reflectors is not None
    assert not returns.reflectors.any()


def test_the_laser_sends_the_bit_in_the_mode_that_has_it() -> None:
    """Byte path: two robots nose to nose, one of them scans in mode 5."""
    folder = load_map_folder(find_map("paper_lab", Path()))
    truth = load_truth("housing_tape")
    world = World(folder.map, np.random.default_rng(1), truth.noise)
    place = Pose(5.0, 13.4, 0.0)
    rigs = make_rigs(world, [place, Pose(place.x + 1.5, place.y, math.pi)], 0.0, truth)
    laser = rigs[0].laser
    laser.state.configuration = laser.state.configuration.changed(MODE_32_M, UNIT_MM)
    laser.feed(encode_telegram(bytes((Command.MODE, Mode.CONTINUOUS)), 0), 0.0)
    framer, received = TelegramFramer(), []
    for step in range(1, 100):
        t = 0.01 * step
        for rig in rigs:
            rig.move(t)
        sense(rigs, t)
        for chunk in laser.pop_output(t):
            received += [each for each in framer.feed(chunk.data) if isinstance(each, Telegram)]
    scans = [decode_measurement(each, MEASURING_MODES[MODE_32_M]) for each in received]
    found = [scan.reflectors for scan in scans if scan is not None and scan.reflectors is not None]
    assert found
    assert all(reflectors.any() for reflectors in found)
