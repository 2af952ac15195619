"""Two full agents that meet head-on turn back and stay on the border."""

import math
from pathlib import Path

import pytest
from msgspec.structs import replace

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import AgentConfig, find_map
from robot_agent.patrol.actions import Action
from robot_agent.patrol.settings import PatrolSettings
from tools.bench.fleet import Fleet, run_bench


@pytest.mark.parametrize(
    "starts",
    [
        pytest.param([Pose(15.44, 3.75, math.pi), Pose(12.04, 3.75, 0.0)], id="straight"),
        pytest.param([Pose(20.84, 9.66, -1.0), Pose(21.05, 6.33, 1.57)], id="bend"),
    ],
)
def test_head_on_meeting_turns_both_back_without_avoiding(starts):
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    config = replace(AgentConfig(), patrol=PatrolSettings(reversal_probability=0.0))
    figures = run_bench(Fleet(folder, 2, seed=105, config=config, starts=starts), 20.0)
    (meeting,) = figures["meetings"]
    assert meeting["outcome"] == "turned back"
    assert meeting["closest_m"] > 1.3
    assert figures["action_share"][Action.AVOID_TEAMMATE.value] == 0.0
    assert figures["border_distance_m"]["max"] < 0.05
    assert figures["contacts"] == 0
