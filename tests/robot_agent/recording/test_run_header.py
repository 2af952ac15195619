"""The versions in a recording of the libraries that affect decisions."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import version

import pytest

from robot_agent.recording.run_header import DEPENDENCIES, same_versions, versions

EARLIER = ", shapely 2.0.0, scikit-fuzzy 0.4.0"


def test_header_has_the_versions_of_all_deciding_libraries() -> None:
    named = versions().split(", ")[1:]
    assert named == [f"{name} {version(name)}" for name in DEPENDENCIES]


@pytest.mark.parametrize("recorded", ["", versions(), versions() + EARLIER])
def test_same_versions_is_true_for_the_same_libraries(recorded: str) -> None:
    assert same_versions(recorded)


@pytest.mark.parametrize(
    "recorded", ["python 3.9.2 x86_64", versions().replace("numpy", "numpy 1")]
)
def test_same_versions_is_false_for_other_libraries(recorded: str) -> None:
    assert not same_versions(recorded)


def test_decisions_do_not_depend_on_skfuzzy_and_shapely() -> None:
    """They may be called while rules and border are loaded, and never after."""
    program = """
import sys
from pathlib import Path
from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.bench.fleet import Fleet

fleet = Fleet(load_map_folder(find_map("paper_lab", Path())), 2, 1)

def forbid(frame, event, argument):
    name = frame.f_globals.get("__name__", "")
    if event == "call" and name.partition(".")[0] in ("skfuzzy", "shapely"):
        print(name, frame.f_code.co_name)

sys.setprofile(forbid)
while fleet.t < 3.0:
    fleet.step()
sys.setprofile(None)
print("done")
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "done\n", done.stderr
