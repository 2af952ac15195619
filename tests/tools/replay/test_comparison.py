"""Recordings of earlier programs replay identically in the fields they have."""

from pathlib import Path

import msgspec

from robot_agent.messages.effects import Effect, Publish, Send
from robot_agent.recording.run_header import SCHEMA_VERSION
from tools.logs.recording import read_recording
from tools.replay.comparison import same_effects
from tools.replay.replay import Replay

RECORDINGS = Path(__file__).parents[1] / "logs" / "recordings"
OLD = SCHEMA_VERSION - 1
SENT = Send("base", b"\x01")


def payload(stream: str, **fields: object) -> Publish:
    return Publish(stream, msgspec.json.encode(fields))


def test_recording_of_layout_2_replays_identically() -> None:
    """18 s of a robot with a camera among two strangers."""
    recording = read_recording(RECORDINGS / "layout_2_strangers.mcap")
    result = Replay(recording).run()
    assert recording.layout == 2
    assert result.difference is None
    assert result.decisions == 157
    assert result.bytes_sent > 2000


def test_recording_of_layout_2_with_a_teammate_replays_up_to_its_first_detection() -> None:
    """18 s of two robots that meet; since layout 4 a teammate's place is measured otherwise."""
    recording = read_recording(RECORDINGS / "layout_2_meeting.mcap")
    result = Replay(recording).run()
    assert result.difference is not None
    assert "tracks" in result.difference or "entities" in result.difference
    assert 6.0 < result.duration < 7.0
    whole = Replay(recording).run(check=False)
    assert whole.decisions == 157
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
