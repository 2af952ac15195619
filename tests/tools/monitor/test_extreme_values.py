"""No value of any field of any stream costs the operator more than that payload."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest
from rich.console import Console

from robot_agent.messages.streams import STREAMS, IntruderPayload, PayloadError, decode, encode
from tests.robot_agent.messages.extreme_payloads import extreme_payloads, full_payload
from tests.tools.monitor.reports import decision, pose, status
from tools.monitor.page_message import PageFeed
from tools.monitor.robot_choice import RobotChoice
from tools.monitor.sighting import sighting_of
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.text_view import Size, plain_view, team_view
from tools.monitor.watch import Watch

BAD, GOOD = "patrol/north/bad", "patrol/north/good"


def shown(watch: Watch) -> dict[str, Any]:
    """Return every part of a fresh page's first message, by robot, and draw the text views."""
    message: dict[str, Any] = json.loads(PageFeed(watch).message({}))
    plain_view(watch, RobotChoice("bad")).encode()
    Console(file=io.StringIO(), width=80, height=24).print(
        team_view(watch, RobotChoice(), Size(80, 24))
    )
    return {robot["name"]: robot for robot in message["robots"]}


@pytest.mark.parametrize("stream", STREAMS)
def test_every_field_of_a_stream_may_be_anything(stream: str) -> None:
    watch = Watch(TeamState(), Site(None))
    for payload in (status(0.5), decision(0.5), pose(0.5)):
        kind = type(payload).__name__.removesuffix("Payload").removesuffix("InFrame").lower()
        watch.team.receive(f"{GOOD}/{kind}", encode(payload), 0.5)
        watch.team.receive(f"{BAD}/{kind}", encode(payload), 0.5)
    watch.advance(0.5, 0.5)
    refused = 0
    for number, data in enumerate(extreme_payloads(stream)):
        t = 1.0 + 0.001 * number
        watch.team.receive(f"{BAD}/{stream}", data, t, t)
        try:
            payload = decode(stream, data)
        except PayloadError:
            refused += 1
            continue
        if isinstance(payload, IntruderPayload) and payload.picture:
            refused += not sighting_of(payload, t).picture
        watch.advance(t, t)
        robots = shown(watch)
        assert {"status", "decision", "pose"} <= set(robots["good"])
    bad, good = watch.team.snapshot()
    assert refused > 100
    assert bad.malformed == refused, "what is within its bounds, and pictures, can be shown"
    assert good.malformed == 0


@pytest.mark.parametrize("stream", STREAMS)
def test_payload_with_every_field_is_shown(stream: str) -> None:
    watch = Watch(TeamState(), Site(None))
    watch.team.receive(f"{BAD}/{stream}", json.dumps(full_payload(stream)).encode(), 1.0)
    watch.advance(1.0, 1.0)
    assert shown(watch)["bad"]["malformed"] == 0


def test_part_that_cannot_be_made_costs_that_part_only(monkeypatch: pytest.MonkeyPatch) -> None:
    from tools.monitor import page_message

    def overflow(_robot: object) -> float:
        return float(10**309)

    monkeypatch.setitem(page_message._PARTS, "scan", overflow)
    watch = Watch(TeamState(), Site(None))
    for stream in ("scan", "pose"):
        watch.team.receive(f"{BAD}/{stream}", json.dumps(full_payload(stream)).encode(), 1.0)
    watch.advance(1.0, 1.0)
    robot = shown(watch)["bad"]
    assert "pose" in robot
    assert "scan" not in robot
    assert watch.team.snapshot()[0].malformed == 1
