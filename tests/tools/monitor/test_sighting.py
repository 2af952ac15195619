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
from tools.monitor.alarm import Condition, Severity
from tools.monitor.intruder_groups import IntruderGroups
from tools.monitor.sighting import Sighting, sighting_of
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


def told(robot: str, x: float) -> Condition:
    seen = Sighting(x, 0.0, START)
    words = f"intruder at {x:.1f}"
    return Condition(f"north/{robot}", "intruder", Severity.CRITICAL, words, sighting=seen)


def merged(groups: IntruderGroups, now: float, *found: Condition) -> list[tuple[str, str]]:
    return [(each.robot, each.text) for each in groups.merged(found, now)]


def test_one_intruder_that_several_robots_report_is_one_alarm_of_the_first() -> None:
    groups = IntruderGroups()
    assert merged(groups, 0.0, told("bob", 5.0)) == [("north/bob", "intruder at 5.0")]
    both = merged(groups, 1.0, told("anna", 5.6), told("bob", 5.2))
    assert both == [("north/bob", "intruder at 5.2; seen by anna")]
    alone = merged(groups, 2.0, told("anna", 6.0))
    assert alone == [("north/bob", "intruder at 6.0; seen by anna")]
    walked = merged(groups, 3.0, told("anna", 9.0))
    assert walked == [("north/bob", "intruder at 9.0; seen by anna")]


def test_two_intruders_are_two_alarms_and_a_later_one_is_new() -> None:
    groups = IntruderGroups()
    pair = merged(groups, 0.0, told("anna", 0.0), told("bob", 2.0))
    assert [robot for robot, _ in pair] == ["north/anna", "north/bob"]
    later = merged(groups, 60.0, told("carl", 0.0))
    assert later == [("north/carl", "intruder at 0.0")]


@pytest.mark.parametrize("text", ["no base64!", base64.b64encode(b"<svg/>").decode(), "ü"])
def test_what_is_no_jpeg_is_no_picture(text: str) -> None:
    payload = msgspec.structs.replace(intruder(TROUBLE_AT), picture=text)
    assert sighting_of(payload, START).picture == b""


HUGE = b"\xff\xd8\xff\xc0\x00\x0b\x08\xff\xdc\xff\xdc" + bytes(8)
"""The head of a picture of 65500 x 65500 pixels, which would fill a browser's memory."""


@pytest.mark.parametrize("data", [HUGE, b"\xff\xd8\xff", b"\xff" * 60_000, b"<svg/>"])
def test_picture_that_cannot_be_shown_is_counted_and_costs_nothing_else(data: bytes) -> None:
    team = TeamState()
    for number, shown in ((1, picture()), (2, data)):
        text = base64.b64encode(shown).decode()
        report = msgspec.structs.replace(intruder(TROUBLE_AT), x=float(number), picture=text)
        team.receive(KEY, encode(report), float(number), START)
    (robot,) = team.snapshot()
    assert robot.malformed == 1
    assert robot.intruders[1].place == (2.0, INTRUDER[1])
    assert robot.intruders[1].picture == picture(), "the last that can be shown"
