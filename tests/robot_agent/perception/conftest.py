"""The room shared by the perception tests."""

from __future__ import annotations

import pytest

from tests.robot_agent.perception.simulated_room import Room


@pytest.fixture(scope="session")
def room() -> Room:
    return Room()
