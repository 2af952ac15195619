"""Recordings of earlier programs replay identically in the fields they have."""

from pathlib import Path

import msgspec
import pytest

from robot_agent.messages.effects import Effect, Publish, Send
from robot_agent.recording.run_header import SCHEMA_VERSION, same_arithmetic
from tools.logs.recording import read_recording
from tools.replay.comparison import same_effects
from tools.replay.replay import Replay
from tools.replay.what_if import WhatIf

RECORDINGS = Path(__file__).parents[1] / "logs" / "recordings"
OLD = SCHEMA_VERSION - 1
SENT = Send("base", b"\x01")


def payload(stream: str, **fields: object) -> Publish:
    return Publish(stream, msgspec.json.encode(fields))


@pytest.mark.parametrize("name", ["layout_2_strangers", "layout_2_meeting"])
def test_recording_of_layout_2_is_decided_equally_until_it_drives_fast(name: str) -> None:
    """18 s of a robot; since layout 4 it goes slowly until scans have confirmed its mount."""
    recording = read_recording(RECORDINGS / f"{name}.mcap")
    assert recording.layout == 2
    assert not same_arithmetic(recording.header)
    until_then = WhatIf()
    Replay(recording).run(until=2.95, what_if=until_then)
    assert until_then.equal
    what_if = WhatIf()
    whole = Replay(recording).run(what_if=what_if)
    assert whole.difference is not None
    assert 2.95 < what_if.episodes[0].start < 3.1
    assert whole.decisions == what_if.decisions == 157
    assert whole.bytes_sent > 1900
    assert "3 to 4" in "".join(recording.upgrades)


def test_a_changed_byte_or_value_is_found_in_any_layout() -> None:
    for layout in (OLD, SCHEMA_VERSION):
        assert same_effects([SENT], [SENT], layout, complete=True)
        assert not same_effects([SENT], [Send("base", b"\x02")], layout, complete=True)
        for stream in ("decision", "pose", "status"):
            recorded = payload(stream, x=1.0, y=2.0)
            assert not same_effects(
                [recorded], [payload(stream, x=1.0, y=2.1)], layout, complete=True
            )


def test_earlier_layout_may_lack_fields_and_differ_in_texts() -> None:
    recorded: list[Effect] = [payload("event", message="a"), payload("decision", wish=1, x=2)]
    now: list[Effect] = [payload("decision", requested=1, x=2, turn="chance")]
    assert same_effects(recorded, now, OLD, complete=True)
    assert not same_effects(recorded, now, SCHEMA_VERSION, complete=True)


def test_a_part_of_a_payload_may_lack_fields_in_an_earlier_layout_too() -> None:
    recorded: list[Effect] = [payload("status", health="base down", base={"state": "ready"})]
    now: list[Effect] = [payload("status", health="ok", base={"state": "ready", "trouble": ""})]
    assert same_effects(recorded, now, OLD, complete=True)
    assert not same_effects(recorded, now, SCHEMA_VERSION, complete=True)
    other: list[Effect] = [payload("status", health="ok", base={"state": "down", "trouble": ""})]
    assert not same_effects(recorded, other, OLD, complete=True)


def test_fields_changed_in_meaning_by_an_override_are_not_compared() -> None:
    recorded = payload("decision", action="keep_going", degrees={"keep_going": 0.9})
    overridden = payload(
        "decision", action="keep_going", degrees={"keep_going": 0.1}, override="closing_in"
    )
    plain = payload("decision", action="keep_going", degrees={"keep_going": 0.1})
    assert same_effects([recorded], [overridden], OLD, complete=True)
    assert not same_effects([recorded], [plain], OLD, complete=True)


def test_truncated_effects_may_be_fewer_but_not_more() -> None:
    assert same_effects([SENT], [SENT, SENT], SCHEMA_VERSION, complete=False)
    assert not same_effects([SENT], [SENT, SENT], SCHEMA_VERSION, complete=True)
    assert not same_effects([SENT, SENT], [SENT], SCHEMA_VERSION, complete=False)
