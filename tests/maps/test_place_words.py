"""Zones' names in the operator's texts."""

from __future__ import annotations

import pytest

from maps.place_words import PlaceWords
from maps.zone import Zone
from robot_agent.messages.streams import encode
from tests.tools.monitor.agent_recordings import FOLDER
from tests.tools.monitor.reports import pose, status
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch

HALF = Zone("north half", ((-1.0, 8.0), (30.0, 8.0), (30.0, 20.0), (-1.0, 20.0)))
WORDS = PlaceWords([HALF], FOLDER.border)


@pytest.mark.parametrize(
    ("text", "explained"),
    [
        ("near s = 3.0 m holds", "near s = 3.0 m (north half) holds"),
        ("0.2, at 3.0 m of the border", "0.2, at 3.0 m of the border (north half)"),
        ("near s = 3 m", "near s = 3 m (north half)"),
        ("near s = 35.0 m", "near s = 35.0 m"),
        ("intruder at 9.5, 14.6 m, 0.9 m", "intruder at 9.5, 14.6 m (north half), 0.9 m"),
        ("intruder 1 at (9.5, 14.6), 0.9 m", "intruder 1 at (9.5, 14.6) (north half), 0.9 m"),
        ("at -3.0, -4.0 m", "at -3.0, -4.0 m"),
        ("at 9.5, 14.6 m, s = 5.5 m", "at 9.5, 14.6 m (north half), s = 5.5 m"),
        ("battery at 11.2 V", "battery at 11.2 V"),
        ("s = 99999999999999999999 m", "s = 99999999999999999999 m"),
    ],
)
def test_zone_stands_behind_each_place(text: str, explained: str) -> None:
    assert WORDS.explained(text) == explained


def test_text_without_a_place_gets_the_robots() -> None:
    assert WORDS.placed("unplugged", (1.0, 9.0)) == "unplugged (north half)"
    assert WORDS.placed("unplugged", (1.0, 2.0)) == "unplugged"
    assert WORDS.placed("unplugged", None) == "unplugged"
    assert WORDS.placed("near s = 35.0 m", (1.0, 9.0)) == "near s = 35.0 m"


def test_alarm_tells_the_zone_of_its_robot() -> None:
    team = TeamState()
    watch = Watch(team, Site(FOLDER, (HALF,)))
    team.receive("patrol/north/anna/pose", encode(pose(1.0, 3.0, 10.0)), 1.0, 1.0)
    team.receive("patrol/north/anna/status", encode(status(1.0, stalled=True)), 1.0, 1.0)
    watch.advance(1.1, 1.1)
    (alarm,) = watch.alarms.alarms()
    assert alarm.text == "a motor is stalled (north half)"
    assert alarm.place == (3.0, 10.0)
