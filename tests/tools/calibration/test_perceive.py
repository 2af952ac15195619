"""On a log without robots of the team no track is a teammate, and walls are not moving."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tools.calibration.perceive import perceive
from tools.localize.localize import log_steps, map_of_log
from tools.logs.carmen import read_carmen


def test_no_teammate_is_found_in_a_building_without_robots(data_folder: Path) -> None:
    log = read_carmen(data_folder / "logs" / "intel-corrected.log.gz")
    log = replace(log, scans=log.scans[:240])
    steps = log_steps(log)[1::2]
    result = perceive("intel", steps, map_of_log(log, 0.05, "even"))
    assert result.scans > 100
    assert result.teammates == 0
    assert result.moving_per_100 < 1.0
