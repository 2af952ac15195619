"""Since when a robot drives or stands, from canned traces; the emulated robot itself."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from robot_agent.config import find_map
from tools.field.acceleration import Acceleration
from tools.field.emulated_robot import EmulatedRobot, Moment, state_since
from tools.field.needed_programs import missing_packages


def trace(*speeds: float) -> list[Moment]:
    return [Moment(0.5 * i, v, 0.0, 0) for i, v in enumerate(speeds)]


def test_a_state_counts_once_it_has_lasted() -> None:
    moments = trace(0.3, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0)
    assert state_since(moments, 0.0, lambda moment: moment.stands) == 1.5


def test_a_state_counts_from_the_time_asked_for() -> None:
    moments = trace(0.0, 0.0, 0.0, 0.0, 0.0)
    assert state_since(moments, 0.6, lambda moment: moment.stands) == 1.0


def test_a_state_that_has_just_begun_does_not_count() -> None:
    moments = trace(0.3, 0.3, 0.0, 0.0)
    assert state_since(moments, 0.0, lambda moment: moment.stands) is None


def test_turning_is_neither_driving_nor_standing() -> None:
    turning = Moment(0.0, 0.0, 0.5, 0)
    assert not turning.drives
    assert not turning.stands


@pytest.mark.skipif("util-linux" in missing_packages(), reason="setpriv is not there")
def test_the_emulated_robot_stands_at_its_ports_until_it_is_driven() -> None:
    place = find_map("paper_lab", Path("/"))
    with closing(EmulatedRobot(Acceleration("none", (), 1.0), place, "5.0,13.4,0")) as robot:
        assert robot.base.port != robot.laser.port
        assert Path(robot.base.port).is_char_device()
        assert robot.wait(lambda moment: moment.stands, 10.0) is not None
        assert robot.contacts == 0
