"""A day of robots that come and go, in short."""

from __future__ import annotations

import pytest

from robot_agent.messages.streams import decode
from tools.campaign import monitored_day
from tools.campaign.monitored_day import Tape, play_day, record_tape


@pytest.fixture(scope="module")
def tape() -> Tape:
    return record_tape(12)


def test_tape_holds_every_stream(tape: Tape) -> None:
    streams = {stream for second in tape for stream, _ in second}
    assert {"pose", "scan", "decision", "status", "event", "tracks", "particles"} <= streams
    for stream, payload in tape[9]:
        stamped = monitored_day._stamped(payload, 86_000)
        decode(stream, stamped)
        assert b"1800086000" in stamped or b'"sec"' not in payload


def test_robots_come_and_go(tape: Tape, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(monitored_day, "CYCLE_S", 20)
    monkeypatch.setattr(monitored_day, "_STAY_S", 30)
    first, *_, last = play_day(tape, 4)
    assert abs(last.handles - first.handles) <= 1
