"""Comparison of decisions under other settings, on a kept recording."""

from __future__ import annotations

from pathlib import Path

import pytest

from robot_agent.messages.effects import Publish
from tools.cli import main
from tools.logs.recorded_config import changed_config
from tools.logs.recording import Recording, read_recording
from tools.replay.replay import Replay
from tools.replay.what_if import WhatIf

KEPT = Path(__file__).parents[1] / "logs" / "recordings" / "layout_1.mcap"


@pytest.fixture
def recording() -> Recording:
    return read_recording(KEPT)


def replayed(recording: Recording, changes: list[str], since: float = 0.0) -> WhatIf:
    """Compare decisions with the changes to decisions without."""
    config = changed_config(recording.header.configuration, str(KEPT), changes)
    what_if = WhatIf()
    Replay(recording, config=config).run(check=False, since=since, what_if=what_if)
    return what_if


def test_a_slower_gate_gives_other_commands(recording: Recording) -> None:
    what_if = replayed(recording, ["gate.max_speed=0.05"])
    assert what_if.decisions > 10
    assert what_if.other_command > 3
    assert what_if.other_gate > 3
    assert what_if.largest_v > 0.05
    assert any("pose uncertain" in line for line in what_if.lines())


def test_the_same_decisions_do_not_differ(recording: Recording) -> None:
    effects = [item for item in recording.items() if isinstance(item, Publish)]
    what_if = WhatIf()
    for index, effect in enumerate(effects):
        what_if.compare(0.1 * index, [effect], [effect])
    assert what_if.decisions == sum(effect.stream == "decision" for effect in effects)
    assert what_if.episodes == []
    assert what_if.other_command == what_if.other_action == what_if.one_sided == 0


def test_one_sided_decisions_are_counted(recording: Recording) -> None:
    decision = next(
        item
        for item in recording.items()
        if isinstance(item, Publish) and item.stream == "decision"
    )
    what_if = WhatIf()
    what_if.compare(1.0, [decision], [])
    what_if.compare(1.1, [decision], [])
    what_if.compare(5.0, [], [decision])
    assert what_if.one_sided == 3
    assert [(e.start, e.end) for e in what_if.episodes] == [(1.0, 1.1), (5.0, 5.0)]
    assert what_if.episodes[0].now == "no decision"


def test_decisions_before_since_are_not_counted(recording: Recording) -> None:
    whole = replayed(recording, ["gate.max_speed=0.05"])
    late = replayed(recording, ["gate.max_speed=0.05"], since=3.5)
    assert 0 < late.decisions < whole.decisions
    assert min(episode.start for episode in late.episodes) >= 3.5


def test_command_line_prints_the_comparison(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(KEPT), "--set", "gate.max_speed=0.05", "--from", "3"]) == 0
    assert "decisions compared on the recorded inputs" in capsys.readouterr().out
    # The recording is of an earlier program, which decided otherwise: the comparison is with now.
    assert main(["replay", str(KEPT), "--set", "gate.max_speed=0.4"]) == 0
    assert "0 another action, 0 another word of the gate, 0 another" in capsys.readouterr().out
    assert main(["replay", str(KEPT), "--check", "--set", "gate.max_speed=0.05"]) == 2
    assert main(["replay", str(KEPT), "--set", "gate.speed=0.05"]) == 1
    assert "gate.speed: unknown key" in capsys.readouterr().err
