"""Fixtures shared by all tests."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tools.fixed_arithmetic import fix_arithmetic

fix_arithmetic()  # as the program does, before numpy is imported
# Programs that tests start inherit what is ignored, as by a shell that runs the tests with "&".
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
# The same examples every time, and no limit that depends on the speed of the machine.
settings.register_profile(
    "fixed", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fixed")

LONG_TEST_S = 1200
"""Limit of a test that takes minutes; all others have that of pyproject.toml."""
REPOSITORY = Path(__file__).resolve().parent.parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give long tests their time."""
    for item in items:
        if item.get_closest_marker("long"):
            item.add_marker(pytest.mark.timeout(LONG_TEST_S))


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Folder of real logs and captures; PATROL_DATA overrides the default beside the checkout."""
    folder = Path(os.environ.get("PATROL_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no recorded data at {folder}: set PATROL_DATA to its folder")
    return folder
