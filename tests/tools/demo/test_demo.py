"""The demo as shipped: a world process, agent processes on ptys, an operator; in real time."""

import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from maps.border import Border
from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.demo.demo import Demo, DemoOptions
from tools.demo.demo_summary import print_summary, read_runs
from tools.logs.recording import read_recording
from tools.monitor.endpoint import free_endpoint
from tools.monitor.operator import Operator
from tools.replay.replay import Replay

DEADLINE_S = 40.0


def wait_for(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"never: {what}"
        time.sleep(0.1)


@pytest.fixture(scope="module")
def border() -> Border:
    folder = load_map_folder(find_map("paper_lab", Path()))
    assert folder.border is not None
    return folder.border


def test_robots_patrol_apart_and_replay_identically(
    tmp_path: Path, border: Border, capsys: pytest.CaptureFixture[str]
) -> None:
    endpoint = free_endpoint()
    options = DemoOptions(find_map("paper_lab", tmp_path), "border", 2, 3, endpoint, tmp_path)
    with closing(Operator(endpoint)) as operator, Demo(options).running() as demo:

        def patrolling() -> bool:
            team = operator.team.snapshot()
            speeds = [r.decision.command.v if r.decision else 0.0 for r in team]
            return len(team) == 2 and min(speeds) > 0.1

        wait_for(patrolling, "both robots under way")
        assert demo.alive()
        for pid in demo.agent_pids():
            connections = psutil.Process(pid).net_connections(kind="inet")
            assert [c.status for c in connections] == [psutil.CONN_ESTABLISHED]
            assert f"tcp/{connections[0].raddr.ip}:{connections[0].raddr.port}" == endpoint
    assert demo.exit_statuses == {"robot1": 0, "robot2": 0, "world": 0}

    recordings = {robot.name: demo.recording_path(robot.name) for robot in demo.robots}
    for path in recordings.values():
        result = Replay(read_recording(path)).run()
        assert result.difference is None
        assert result.decisions > 10
    runs, contacts = read_runs(demo.truth_path, recordings)
    assert contacts == 0
    assert all(set(run.action) - {""} for run in runs), "decisions join with true positions"
    print_summary(border, runs, contacts)
    printed = capsys.readouterr().out
    assert "robot1" in printed
    assert "contacts: 0" in printed


def test_missing_map_raises_and_leaves_no_process(tmp_path: Path) -> None:
    options = DemoOptions(tmp_path / "no_map", "border", 1, 1, free_endpoint(), tmp_path)
    with pytest.raises(ValueError, match="world process did not start"), Demo(options).running():
        pass
    children = psutil.Process().children(recursive=True)
    assert not [child for child in children if "world_server" in " ".join(child.cmdline())]
