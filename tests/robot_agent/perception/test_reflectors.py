"""Reflecting tape, from the bytes of an LMS 200 to the kind of a track."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.framing import TelegramFramer, encode_telegram
from drivers.lms200.measurement import (
    MEASURING_MODES,
    UNIT_MM,
    decode_measurement,
)
from drivers.lms200.scan import scan_of
from drivers.scan import Scan
from maps.pose import Pose
from robot_agent.perception.identity import Kind
from robot_agent.perception.scan_points import ScanProjector, hits
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.tracker import TeammateTracker
from tests.drivers.lms200.measured_telegram import encode_measurement
from tests.robot_agent.perception.simulated_room import SILHOUETTES, Box, Room

HERE = Pose(4.0, 4.0, 0.0)
PERIOD = 0.2
LASER = 0x80  # a telegram's address from the laser to its host
FIELD_A = 0x2000  # bit 13: what a mode without reflectors says of a field
# The bits above the distance that mark a reflector in each mode, as sick_lms200.md lists them.
REFLECTOR = {0x01: 0xE000, 0x03: 0xC000, 0x05: 0x8000}


def as_sent(ranges: NDArray[np.float64], flagged: NDArray[np.bool_], mode: int, bits: int) -> bytes:
    """Return a B0 telegram's bytes, with bits set in the values of some beams."""
    payload = bytearray(encode_measurement(ranges, MEASURING_MODES[mode], UNIT_MM))
    for beam in np.flatnonzero(flagged).tolist():
        payload[4 + 2 * beam] |= bits >> 8  # after B0 and the count: little-endian values
    return encode_telegram(bytes(payload), LASER)


def as_decoded(sent: bytes, mode: int, t: float) -> Scan:
    [telegram] = TelegramFramer().feed(sent)
    measurement = decode_measurement(telegram, MEASURING_MODES[mode])
    assert measurement is not None
    return scan_of(measurement, t, 0.0)


def kinds_seen(
    room: Room, mode: int, bits: int, settings: PerceptionSettings, half_width_deg: float = 10.0
) -> set[Kind]:
    """Return the kinds of the track of a standing robot, of whose beams some have bits set.

    half_width_deg: from the robot's middle up to which they have; the robot is 20 degrees wide.
    """
    rng = np.random.default_rng(5)
    tracker = TeammateTracker(settings, room.map, SILHOUETTES)
    projector = ScanProjector(Pose(0.0, 0.0, 0.0))
    robot = Box(6.0, 4.4, 0.4)
    bearing = math.atan2(0.4, 2.0)
    for step in range(15):
        points = room.scan(HERE, [robot], rng)
        bearings = np.linspace(-math.pi / 2, math.pi / 2, len(points))
        on_tape = np.abs(bearings - bearing) < math.radians(half_width_deg)
        sent = as_sent(np.hypot(points[:, 0], points[:, 1]), on_tape, mode, bits)
        scan = as_decoded(sent, mode, step * PERIOD)
        reflectors = None if scan.reflectors is None else scan.reflectors[hits(scan)]
        tracker.update(step * PERIOD, HERE, projector.points(scan), reflectors)
    assert len(tracker.tracks) == 1
    return {track.kind for track in tracker.tracks}


@pytest.mark.parametrize("mode", sorted(REFLECTOR))
def test_reflecting_tape_makes_a_teammate_in_every_mode_with_reflectors(
    room: Room, mode: int
) -> None:
    wearing = PerceptionSettings(reflecting_bands=True)
    bits = REFLECTOR[mode]
    assert kinds_seen(room, mode, bits, wearing) == {Kind.TEAMMATE}
    assert kinds_seen(room, mode, 0, wearing) == {Kind.UNKNOWN}
    assert kinds_seen(room, mode, bits, PerceptionSettings()) == {Kind.UNKNOWN}


@pytest.mark.parametrize("mode", [0x00, 0x02])
def test_a_field_flag_is_no_reflector(room: Room, mode: int) -> None:
    wearing = PerceptionSettings(reflecting_bands=True)
    assert kinds_seen(room, mode, FIELD_A, wearing) == {Kind.UNKNOWN}


def test_a_glint_on_a_few_beams_is_no_tape(room: Room) -> None:
    wearing = PerceptionSettings(reflecting_bands=True)
    mode, bits = 0x05, REFLECTOR[0x05]
    assert kinds_seen(room, mode, bits, wearing, 1.5) == {Kind.UNKNOWN}


def test_reflectors_on_a_wall_beside_a_robot_are_not_its_tape(room: Room) -> None:
    rng = np.random.default_rng(6)
    here = Pose(9.0, 6.8, 0.0)
    tracker = TeammateTracker(PerceptionSettings(reflecting_bands=True), room.map, SILHOUETTES)
    for step in range(15):
        points = room.scan(here, [Box(10.6, 7.55, 0.0)], rng)
        tracker.update(step * PERIOD, here, points, points[:, 1] > 1.15)
    assert [track.kind for track in tracker.tracks] == [Kind.UNKNOWN]
