"""Perception settings are checked as they are read."""

from __future__ import annotations

import msgspec
import pytest

from robot_agent.perception.settings import PerceptionSettings


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("detection_range = 2.0", "detection_range"),
        ("memmory = 3.0", "memmory"),
    ],
)
def test_invalid_settings_raise_with_their_name(toml: str, message: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=message):
        msgspec.toml.decode(toml, type=PerceptionSettings)


def test_defaults_are_valid() -> None:
    assert msgspec.toml.decode("", type=PerceptionSettings) == PerceptionSettings()
