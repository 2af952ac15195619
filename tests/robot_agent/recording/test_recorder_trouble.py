"""A robot whose disk is full continues and reports it."""

from __future__ import annotations

import signal
import subprocess
from pathlib import Path

import msgspec

from robot_agent.config import AgentConfig, format_config
from tools.deploy.child_program import environment, program


def test_full_disk_is_reported_and_the_agent_continues(tmp_path: Path) -> None:
    config = tmp_path / "robot1.toml"
    defaults = AgentConfig()
    nowhere = str(tmp_path / "no_port")
    settings = msgspec.structs.replace(
        defaults,
        base=msgspec.structs.replace(defaults.base, url=nowhere),
        laser=msgspec.structs.replace(defaults.laser, url=nowhere),
    )
    config.write_text(format_config(settings))
    told: list[str] = []
    with subprocess.Popen(
        program("tools.cli", "agent", str(config), "--record", "/dev/full"),
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
    ) as agent:
        assert agent.stderr is not None
        for line in agent.stderr:
            told.append(line)
            if "recorder" in line:
                break
        assert agent.poll() is None
        agent.send_signal(signal.SIGTERM)
        told += agent.stderr.readlines()
    assert any("error: recorder: /dev/full: recording stopped: No space" in line for line in told)
    assert agent.returncode == 0
