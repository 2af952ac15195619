"""The survey of whole recordings."""

from __future__ import annotations

import time
from contextlib import closing
from pathlib import Path

from tests.tools.monitor.agent_recordings import START, agent_recording
from tests.tools.monitor.trouble_team import TROUBLE_AT, trouble_recording
from tools.monitor.playback import Playback
from tools.monitor.shift_log import LogFilter, ShiftLog
from tools.monitor.survey import Survey


def surveyed(paths: list[Path], log: ShiftLog) -> Survey:
    playback = Playback(paths)
    with closing(Survey(playback.files, playback.site(), log)) as survey:
        deadline = time.monotonic() + 60.0
        while not survey.done:
            assert time.monotonic() < deadline
            time.sleep(0.05)
    return survey


def test_survey_finds_every_alarm_and_the_whole_history(tmp_path: Path) -> None:
    path = trouble_recording(tmp_path / "team.mcap", 8, TROUBLE_AT + 15.0)
    with closing(ShiftLog(tmp_path / "log.sqlite")) as log:
        survey = surveyed([path], log)
    with closing(ShiftLog(tmp_path / "log.sqlite")) as log:
        entries = {entry.robot: entry for entry in log.entries(LogFilter(), 99)}
    kinds = {robot.removeprefix("north/"): entry.kind for robot, entry in entries.items()}
    assert kinds == {
        "robot2": "intruder",
        "robot3": "link laser",
        "robot4": "map",
        "robot5": "silent",
        "robot7": "silent",
    }
    assert all(abs(entry.raised - START - TROUBLE_AT) < 4.0 for entry in entries.values())
    assert set(survey.histories) == {f"north/robot{number}" for number in range(1, 9)}
    assert len(survey.histories["north/robot1"]) == 55


def test_day_between_two_recordings_is_skipped(tmp_path: Path) -> None:
    paths = [
        agent_recording("anna", tmp_path / "1.mcap", START, 5.0),
        agent_recording("anna", tmp_path / "2.mcap", START + 86_400.0, 5.0),
    ]
    with closing(ShiftLog(None)) as log:
        begun = time.monotonic()
        survey = surveyed(paths, log)
        assert time.monotonic() - begun < 30.0
    assert len(survey.histories["north/anna"]) >= 2
