"""What the operator keeps of an intruder: last place, its time and the picture."""

from __future__ import annotations

import base64

import msgspec
import pytest

from robot_agent.messages.streams import encode
from tests.tools.monitor.agent_recordings import START
from tests.tools.monitor.trouble_team import (
    INTRUDER,
    TROUBLE_AT,
    WITNESS,
    intruder,
    picture,
    team_payloads,
)
from tools.monitor.sighting import sighting_of
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch

KEY = "patrol/north/robot2/intruder"


def test_last_place_and_picture_stay_with_the_alarm_when_it_is_over() -> None:
    team = TeamState()
    watch = Watch(team, Site(None))
    first = intruder(TROUBLE_AT)
    later = msgspec.structs.replace(first, x=3.0, picture="")
    for t, payload in ((0.0, first), (2.0, later)):
        team.receive(KEY, encode(payload), t, START + t)
        watch.advance(t, START + t)
    for step in range(30):
        watch.advance(3.0 + step, START + 3.0 + step)
    alarm = next(each for each in watch.alarms.alarms() if each.kind == "intruder")
    assert not alarm.active
    assert alarm.sighting is not None
    assert alarm.sighting.place == (3.0, INTRUDER[1])
    assert alarm.sighting.wall == START + 2.0
    assert alarm.sighting.picture == picture()
    assert alarm.text.endswith("0.9 m from the border at s = 5.5 m")


def test_one_intruder_told_by_tracks_log_and_report_is_one_alarm() -> None:
    team = TeamState()
    watch = Watch(team, Site(None))
    for t, key, payload in team_payloads(2, TROUBLE_AT + 4.0):
        if t >= TROUBLE_AT - 2.0:
            team.receive(key, encode(payload), t, START + t)
            watch.advance(t, START + t)
    found = [(alarm.robot, alarm.kind) for alarm in watch.alarms.alarms()]
    assert found == [(f"north/robot{WITNESS}", "intruder")]


@pytest.mark.parametrize("text", ["no base64!", base64.b64encode(b"<svg/>").decode(), "ü"])
def test_what_is_no_jpeg_is_no_picture(text: str) -> None:
    payload = msgspec.structs.replace(intruder(TROUBLE_AT), picture=text)
    assert sighting_of(payload, START).picture == b""
