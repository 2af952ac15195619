"""Recordings of earlier layouts are kept here and stay readable."""

from __future__ import annotations

from pathlib import Path

import pytest

from maps.map_identity import identity
from robot_agent.config import ConfigError
from robot_agent.messages.events import BytesReceived
from robot_agent.patrol.settings import PAPER_STRATEGY
from robot_agent.recording.run_header import SCHEMA_VERSION
from tools.logs.recorded_config import changed_config, parse_old_config, recorded_config
from tools.logs.recording import read_recording
from tools.logs.recording_upgrades import UPGRADES
from tools.replay.replay import Replay

LAYOUT_1 = Path(__file__).parent / "recordings" / "layout_1.mcap"
"""4.6 s of an emulated robot in a room of 8 by 6 m."""


def test_every_earlier_layout_has_an_upgrade() -> None:
    assert list(UPGRADES) == list(range(1, SCHEMA_VERSION))


def test_a_recording_of_layout_1_is_read() -> None:
    recording = read_recording(LAYOUT_1)
    assert recording.upgrades == [
        "1 to 2: identity of map, border and software",
        "2 to 3: decisions with overrides, by today's names",
        "3 to 4: walls by their faces, teammates by several silhouettes",
    ]
    assert recording.layout == 1
    header = recording.header
    assert header.schema_version == SCHEMA_VERSION
    assert (header.map_hash, header.border_hash) == identity(header.map_files)
    assert len(header.map_hash) == len(header.border_hash) == 64
    items = list(recording.items())
    assert recording.truncated is None
    assert sum(isinstance(item, BytesReceived) for item in items) > 50


def test_a_recording_of_layout_1_can_be_replayed() -> None:
    result = Replay(read_recording(LAYOUT_1)).run(check=False)
    assert result.decisions > 10


def test_obsolete_settings_are_left_out_and_named() -> None:
    old = b"[gate]\nmax_speed = 0.3\nmagic = 1\n[oracle]\nurl = 'x'\n"
    old += b"[start]\nx=1\ny=2\ntheta=0\nq=1\n"
    config, left_out = parse_old_config(old, "old")
    assert config.gate.max_speed == 0.3
    assert config.start is not None
    assert left_out == ["gate.magic", "oracle", "start.q"]


def test_renamed_keys_are_followed_and_constants_left_out_unless_different() -> None:
    old = b"[localization.samples]\nmaximum = 900\nbin_xy = 0.1\n"
    old += b"[localization.health]\nlost_below = 0.3\nfound_above = 0.5\n"
    old += b"[telemetry]\nqueue = 256\n[perception]\nleast_extent = 0.3\nmost_extent = 0.8\n"
    config, left_out = parse_old_config(old, "old")
    assert config.localization.max_particles == 900
    assert left_out == ["localization.health.lost_below", "perception.most_extent"]
    assert changed_config(old, "old", ["localization.particles=700"]).localization.particles == 700


def test_the_papers_strategy_of_old_recordings_has_no_even_gaps() -> None:
    paper, _ = parse_old_config(b'[patrol]\nstrategy = "paper"\n', "old")
    even, _ = parse_old_config(b'[patrol]\nstrategy = "even_gaps"\n', "old")
    assert paper.patrol.modifiers == PAPER_STRATEGY
    assert even.patrol.modifiers == (*PAPER_STRATEGY, "even_gaps")


def test_kept_recordings_configuration_is_readable() -> None:
    config, _left_out = recorded_config(read_recording(LAYOUT_1))
    assert config.robot.name == "robot1"


def test_changes_are_applied_and_checked() -> None:
    content = b"[gate]\nmax_speed = 0.3\n"
    config = changed_config(content, "r", ["gate.max_speed=0.1", "robot.name=zoe"])
    assert (config.gate.max_speed, config.robot.name) == (0.1, "zoe")
    for change, complaint in (
        ("gate.max_speed", "SECTION.KEY=VALUE"),
        ("gate.sped=1", "unknown key"),
        ("gate.max_speed=-1", "gate.max_speed"),
        ("gate.max_speed.x=1", "no section"),
    ):
        with pytest.raises(ConfigError, match=complaint):
            changed_config(content, "r", [change])


def test_base_model_of_old_configurations_was_a_fallback_and_is_no_demand() -> None:
    old = b'[base]\nmodel = "p2dx"\n[gate]\nfront = 0.21\n'
    assert parse_old_config(old, "old")[0].base.model is None
    new = b'[base]\nmodel = "p2dx"\n'
    assert parse_old_config(new, "new")[0].base.model == "p2dx"
