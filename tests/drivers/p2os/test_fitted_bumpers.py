from __future__ import annotations

import pytest

from drivers.p2os.config_packet import P2OS_FIELD_COUNT, ConfigPacket
from drivers.p2os.fitted_bumpers import OPEN_INPUTS, FittedBumpers
from drivers.p2os.sip import Sip, decode_sip

HEAD = "33 00 00 00 00 00 00 00 00 00 00 7F {rear:02X} {front:02X} 00 00 03 00 00 00"


def report(front: int, rear: int = 0) -> Sip:
    """A SIP with ring masks above a clear stall bit."""
    sip = decode_sip(bytes.fromhex(HEAD.format(front=front << 1, rear=rear << 1)))
    assert sip is not None
    return sip


def config(front: int, rear: int, field_count: int = P2OS_FIELD_COUNT + 2) -> ConfigPacket:
    return ConfigPacket(
        front_bumper_segments=front, rear_bumper_segments=rear, field_count=field_count
    )


def test_ring_whose_every_bit_reads_1_from_the_first_report_on_is_not_fitted() -> None:
    bumpers = FittedBumpers((5, 5))
    assert bumpers.pressed(report(OPEN_INPUTS, OPEN_INPUTS)) == (0, 0)
    assert bumpers.missing == "no bumpers fitted (every bit reads 1)"


def test_each_ring_is_judged_by_itself() -> None:
    bumpers = FittedBumpers((5, 5))
    assert bumpers.pressed(report(0b100, OPEN_INPUTS)) == (0b100, 0)
    assert bumpers.missing == "no rear bumpers fitted (every bit reads 1)"


def test_ring_that_reads_otherwise_once_counts_from_then_on() -> None:
    bumpers = FittedBumpers((5, 5))
    bumpers.pressed(report(OPEN_INPUTS))
    assert bumpers.pressed(report(0)) == (0, 0)
    assert bumpers.pressed(report(OPEN_INPUTS)) == (OPEN_INPUTS, 0)
    assert bumpers.missing is None


def test_robot_switched_on_pressed_all_along_a_ring_of_five_is_pressed() -> None:
    assert FittedBumpers((5, 5)).pressed(report(0b11111)) == (0b11111, 0)


def test_ring_stated_to_have_every_segment_is_pressed_when_every_bit_reads_1() -> None:
    bumpers = FittedBumpers((5, 5))
    bumpers.on_config(config(7, 5))
    assert bumpers.pressed(report(OPEN_INPUTS, OPEN_INPUTS)) == (OPEN_INPUTS, 0)


@pytest.mark.parametrize("stated", [5, 7])
def test_ring_whose_model_has_every_segment_is_pressed_when_every_bit_reads_1(stated: int) -> None:
    bumpers = FittedBumpers((7, 5))
    bumpers.on_config(config(stated, 5))
    assert bumpers.pressed(report(OPEN_INPUTS)) == (OPEN_INPUTS, 0)


def test_ring_that_the_model_lacks_is_not_fitted() -> None:
    assert FittedBumpers((0, 0)).pressed(report(0b1, 0b1)) == (0, 0)


def test_ring_stated_to_have_no_segments_is_not_fitted() -> None:
    bumpers = FittedBumpers((5, 5))
    bumpers.on_config(config(0, 5))
    assert bumpers.pressed(report(0b1, 0b1)) == (0, 0b1)
    assert bumpers.missing == "no front bumpers fitted (it has no segments, by CONFIG or model)"


@pytest.mark.parametrize("field_count", [P2OS_FIELD_COUNT, P2OS_FIELD_COUNT + 1])
def test_config_that_does_not_reach_the_segments_states_none(field_count: int) -> None:
    bumpers = FittedBumpers((5, 5))
    bumpers.on_config(config(0, 0, field_count))
    assert bumpers.pressed(report(0b1, 0b10)) == (0b1, 0b10)
