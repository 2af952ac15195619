"""A service whose device filter keeps out a device that is there ends, so that it is made anew."""

from __future__ import annotations

import errno
import io
import os
from pathlib import Path
from typing import Any

import pytest

from drivers.lms200.settings import LaserSettings
from drivers.p2os.settings import BaseSettings
from maps.map_folder import load_map_folder
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, TelemetrySettings, find_map
from robot_agent.process import runtime
from robot_agent.process.journal import Journal
from robot_agent.process.runtime import Clock, DeviceFilterError, Runtime
from robot_agent.process.telemetry import Telemetry


def test_device_that_is_kept_out_by_the_filter_ends_the_agent_with_the_remedy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    opened = os.open

    def kept_out(path: Any, *arguments: Any, **options: Any) -> int:
        if path == "/dev/null":
            raise PermissionError(errno.EPERM, "Operation not permitted", path)
        return opened(path, *arguments, **options)

    monkeypatch.setattr(os, "open", kept_out)
    monkeypatch.setattr(runtime, "FILTERED_S", 0.1)
    config = AgentConfig(
        base=BaseSettings(url="/dev/null"), laser=LaserSettings(url="/dev/none-such")
    )
    agent = Agent(config, load_map_folder(find_map("paper_lab", Path()), "border"))
    journal = io.StringIO()
    telemetry = Telemetry(TelemetrySettings(), robot="robot1", team="lab")
    running = Runtime(agent, Clock(), None, telemetry, Journal(journal, {}))
    with pytest.raises(DeviceFilterError, match="start the service again"):
        running.run()
    telemetry.close()
    assert "error: base: the service's device filter keeps /dev/null out" in journal.getvalue()
