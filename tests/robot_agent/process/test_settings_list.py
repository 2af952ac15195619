"""The list of the settings: complete, described, and of bounded length."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

from robot_agent.config import FIXED_KEYS, RENAMED_KEYS, AgentConfig, format_config
from robot_agent.pose.start_pose import StartPose
from robot_agent.process.settings_list import format_settings, list_settings

LIMIT = 96
"""More than that nobody can keep in mind; a new key replaces another."""


def keys_of(table: dict[str, Any], place: str = "") -> Iterator[str]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from keys_of(value, f"{place}{key}.")
        else:
            yield place + key


def test_every_key_is_listed_once() -> None:
    config = AgentConfig(start=StartPose(x=0.0, y=0.0, theta=0.0))
    listed = [setting.key for setting in list_settings()]
    assert len(listed) == len(set(listed))
    assert set(keys_of(tomllib.loads(format_config(config)))) <= set(listed)


def test_every_key_is_described() -> None:
    assert [setting.key for setting in list_settings() if not setting.meaning] == []


def test_default_and_unit_are_those_of_the_structs() -> None:
    listed = {setting.key: setting for setting in list_settings()}
    assert listed["base.max_speed"][1:3] == ("0.5", "m/s")
    assert listed["start.x"][1:3] == ("required", "m")
    assert listed["laser.mount"].default == "unset"
    assert listed["perception.color.others"].default == "[]"


def test_number_of_settings_is_bounded() -> None:
    assert len(list_settings()) <= LIMIT


def test_no_former_key_is_a_setting() -> None:
    listed = {setting.key for setting in list_settings()}
    assert not listed & {*RENAMED_KEYS, *FIXED_KEYS}
    assert set(RENAMED_KEYS.values()) <= listed


def test_the_table_ends_with_the_count() -> None:
    lines = format_settings(list_settings()).splitlines()
    assert lines[0].split() == ["key", "default", "unit", "meaning"]
    assert lines[-1] == f"{len(lines) - 2} settings"
    assert any(line.startswith("robot.name ") for line in lines)
