from __future__ import annotations

import msgspec
import pytest

from drivers.p2os.settings import BaseSettings


@pytest.mark.parametrize(
    "line",
    ["baud = 4800", "max_speed = 0.0", "max_speed = 3.0", "max_turn_rate = -0.1", "speed = 0.3"],
)
def test_bad_settings_are_refused(line: str) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.toml.decode(line, type=BaseSettings)


def test_settings_have_defaults_and_take_overrides() -> None:
    settings = msgspec.toml.decode('model = "p3dx"\nbaud = 38400', type=BaseSettings)
    assert (settings.model, settings.baud, settings.max_speed) == ("p3dx", 38400, 0.5)
