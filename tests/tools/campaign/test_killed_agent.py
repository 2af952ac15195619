"""An agent killed at any time leaves a recording complete but for its last second."""

from __future__ import annotations

import random
import signal
from contextlib import closing
from pathlib import Path

import pytest

from tools.campaign.agent_stage import AgentStage
from tools.logs.recording import read_recording
from tools.replay.replay import Replay

LOST_S = 1.0
SOME_S = 1.5
"""After its first word to the base there is something that must not be lost."""


@pytest.mark.parametrize(
    "number",
    [pytest.param(n, marks=() if n == 0 else pytest.mark.long) for n in range(20)],
)
def test_killed_agent_loses_at_most_one_second_of_recording(tmp_path: Path, number: int) -> None:
    lives = random.Random(number).uniform(SOME_S, 7.5)
    with closing(AgentStage(tmp_path, seed=number)) as stage:
        stage.start_agent()
        while not stage.tap.last_at:
            stage.step()
        first_order = stage.tap.last_at
        while stage.step().t < first_order + lives:
            pass
        stage.signal_agent(signal.SIGKILL)
        last_order = stage.tap.last_at
    recording = read_recording(tmp_path / "robot1.mcap")
    result = Replay(recording).run()
    assert recording.truncated is not None, "nobody finished this file"
    assert result.difference is None
    assert result.events > 0
    # What the agent did last by the base's own account: on a busy machine it may not have got
    # to run for a while before it died.
    died = last_order - recording.header.start_monotonic_ns / 1e9
    assert died - recording.end() <= LOST_S
