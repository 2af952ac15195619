"""Preflight of one robot: checks everything it needs to patrol, with a remedy for each failure.

Base and laser are tried with the agent's sessions over their lines. Nothing moves: the motors are
never switched on, and both sessions are closed afterwards.
"""

from __future__ import annotations

import datetime
import os
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from drivers.p2os.model import RobotModel, UnknownModelError
from drivers.p2os.model_choice import expected_model
from drivers.scanner import kind_of
from maps.clearance import needed_clearance
from maps.map_folder import DEFAULT_BORDER, MAP_FILE, MapFolder
from maps.occupancy_map import FREE, shipped_maps
from robot_agent.config import AgentConfig, ConfigError, find_map, load_config
from robot_agent.motion.gate_settings import gate_limits
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.rules import RulesError
from robot_agent.process.wall_clock import SET_IT, clock_trouble
from tools.mapping.map_check import check_map
from tools.preflight.device_trial import run_trials
from tools.preflight.doctor_base import BaseExamination
from tools.preflight.doctor_camera import CameraExamination
from tools.preflight.doctor_geometry import examine_geometry
from tools.preflight.doctor_keys import examine_keys, examine_operator
from tools.preflight.doctor_laser import LaserExamination
from tools.preflight.doctor_sight import examine_sight
from tools.preflight.finding import (
    Finding,
    failed,
    not_yet,
    ok,
    prevents_patrol,
    skipped,
    warning,
)

TRIAL_LIMIT_S = 10.0
"""Time to wait for silent devices: one pass through all their rates."""
MIN_DISK_BYTES = 500_000_000


def examine(
    path: Path,
    limit: float = TRIAL_LIMIT_S,
    progress: Callable[[float], None] = lambda _: None,
) -> list[Finding]:
    """Check the robot of a configuration file.

    limit: longest wait for base and laser, s; progress: called with the elapsed time of that, s. An
    invalid configuration is the only finding.
    """
    try:
        config = load_config(path)
    except ConfigError as error:
        return [failed("configuration", str(error), "correct the file, then run this again")]
    try:
        base = BaseExamination(config.base, kind_of(config.laser))
    except UnknownModelError as error:
        return [failed("configuration", str(error), "correct base.model")]
    devices = examine_devices(config, limit, progress, base)
    return [
        *examine_config(config, base.model),
        *examine_map(config, path.parent, base.model),
        *devices,
        examine_clock(),
        examine_recorder(config.recorder.folder),
        examine_keys(config.telemetry.keys),
        examine_operator(config.telemetry),
    ]


def is_fit(findings: list[Finding]) -> bool:
    """Return whether a robot may patrol: no check failed, nothing is missing yet."""
    return not any(map(prevents_patrol, findings))


def examine_config(config: AgentConfig, model: RobotModel) -> list[Finding]:
    """Check what no type of the configuration checks: the fields of view of a robot's sensors."""
    return [
        ok("configuration", f"{config.robot.name} of team {config.robot.team}"),
        examine_sight(config.laser, model, gate_limits(config.gate, model)),
        examine_geometry(config.base, config.laser),
    ]


class NeverDrivesError(ValueError):
    """A configuration that can never patrol; the message says why in one line, with remedies."""


def load_patrol_map(config: AgentConfig, relative_to: Path) -> MapFolder:
    """Return the map of a configuration that can patrol; paths are relative to a folder.

    Raises NeverDrivesError by the checks of map, start and rules, UnknownModelError for a model
    that nobody knows.
    """
    findings, content = _examined_map(config, relative_to, expected_model(config.base))
    reasons = [
        f"{finding.subject}: {finding.text}: {finding.remedy}"
        for finding in findings
        if prevents_patrol(finding)
    ]
    if reasons or content is None:
        raise NeverDrivesError("; ".join(reasons))
    return content


def examine_map(config: AgentConfig, relative_to: Path, model: RobotModel) -> list[Finding]:
    """Check map and border, then start pose and rules; paths are relative to a folder.

    model: of the robot that must have room along the border.
    """
    findings, _content = _examined_map(config, relative_to, model)
    return findings


def _examined_map(
    config: AgentConfig, relative_to: Path, model: RobotModel
) -> tuple[list[Finding], MapFolder | None]:
    """Return the findings of ``examine_map``, and the map unless it is unusable."""
    folder = find_map(config.map.folder, relative_to)
    report = check_map(folder, config.map.border, needed_clearance(model.body.corner_reach))
    wrong = [
        str(finding).removeprefix("FAIL").strip() for finding in report.findings if not finding.ok
    ]
    if not (folder / MAP_FILE).is_file():
        return [_missing_map(folder)], None
    drawn = (folder / f"{DEFAULT_BORDER}.toml").is_file()
    if config.map.border == DEFAULT_BORDER and not drawn:
        text = f"{folder}: {DEFAULT_BORDER}.toml is missing: no border has been drawn"
        remedy = f"draw it with `patrol map border {folder}`, then `patrol map check {folder}`"
        return [not_yet("map and border", text, remedy)], None
    if wrong:
        remedy = f"correct it; `patrol map show {folder} -o map.png` draws it"
        return [failed("map and border", "; ".join(wrong), remedy)], None
    content = report.content
    assert content is not None, "check_map has read it"
    assert content.border is not None, "check_map requires it"
    summary = f"{folder}, {config.map.border}: {content.border.length:.1f} m"
    findings = [
        ok("map and border", summary),
        examine_start(config, content),
        _examine_rules(config, content),
    ]
    return findings, content


def _missing_map(folder: Path) -> Finding:
    """Return the finding that there is no map yet, with the steps to one."""
    text = f"{folder}: no map is there; shipped maps are {', '.join(shipped_maps())}"
    remedy = (
        "first `patrol record ROBOT.toml --teleop -o drive.mcap`, then `patrol map build "
        f"drive.mcap -o {folder} --from odometry`, then `patrol map border {folder}`"
    )
    return not_yet("map and border", text, remedy)


def examine_start(config: AgentConfig, content: MapFolder) -> Finding:
    """Check that the start pose, if any, is in a free cell of the map."""
    start = config.start
    if start is None:
        remedy = "set start, if you know where the robot stands"
        return warning("start", "unknown: the robot begins with global localization", remedy)
    rows, cols = content.map.cells_at(np.array([[start.x, start.y]]))
    inside = bool(content.map.inside(rows, cols)[0])
    text = f"{start.x:g}, {start.y:g} m"
    if not inside or content.map.cells[rows[0], cols[0]] != FREE:
        where = "not on free ground" if inside else "outside the map"
        return failed("start", f"{text}: {where}", "correct start, m in the map frame")
    return ok("start", text)


def _examine_rules(config: AgentConfig, content: MapFolder) -> Finding:
    assert content.border is not None
    try:
        Patrol(config.patrol, content.border, np.random.default_rng(0))
    except RulesError as error:
        return failed("rules", str(error), "correct the rule file")
    return ok("rules", config.patrol.rules_file or "the shipped ones")


def examine_devices(
    config: AgentConfig,
    limit: float,
    progress: Callable[[float], None] = lambda _: None,
    base: BaseExamination | None = None,
) -> list[Finding]:
    """Check base, laser and camera concurrently, base and laser for at most ``limit`` s."""
    base, laser = (
        base or BaseExamination(config.base, kind_of(config.laser)),
        LaserExamination(config.laser),
    )
    trials = [trial for trial in (base.trial, laser.trial) if trial is not None]
    camera = CameraExamination(config.camera)
    run_trials(trials, limit, progress)
    return [*base.findings(), *laser.findings(), *camera.findings()]


def examine_clock(
    wall: Callable[[], float] = time.time, monotonic: Callable[[], float] = time.monotonic
) -> Finding:
    """Check that the wall clock is set, to label recordings, and that the monotonic one runs."""
    now = datetime.datetime.fromtimestamp(wall(), datetime.UTC)
    before = monotonic()
    time.sleep(0.01)
    if not 0.005 < monotonic() - before < 5.0:
        remedy = "choose another clocksource: see /sys/devices/system/clocksource"
        return failed("clock", "the monotonic clock does not run evenly", remedy)
    text = f"{now:%Y-%m-%d %H:%M} UTC"
    if clock_trouble(now.timestamp()):
        return failed("clock", f"{text}: not set", SET_IT)
    return ok("clock", text)


def examine_recorder(folder: str, min_free: int = MIN_DISK_BYTES) -> Finding:
    """Check that recordings can be written to a folder and have ``min_free`` bytes of space."""
    if not folder:
        return skipped("disk", "recorder.folder is not set: nothing is recorded")
    path = Path(folder)
    try:
        place = _nearest_existing(path)
        with tempfile.TemporaryFile(dir=place):
            free = shutil.disk_usage(place).free
    except OSError as error:
        remedy = f"make {path} a folder that user {_user()} may write, or set recorder.folder"
        return failed("disk", f"{path}: cannot be written ({error.strerror})", remedy)
    text = f"{path}: {free / 1e9:.1f} GB free"
    if free < min_free:
        remedy = "delete or move old recordings"
        return failed("disk", f"{text}, {min_free / 1e9:.1f} GB needed", remedy)
    return ok("disk", text)


def _nearest_existing(path: Path) -> Path:
    """Return the path itself, or its nearest existing parent."""
    return next(place for place in (path.absolute(), *path.absolute().parents) if place.exists())


def _user() -> str:
    return os.environ.get("USER") or str(os.getuid())
