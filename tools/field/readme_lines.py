"""The command lines that READMEs and the bundle tell a user to type on the robot, in order.

The trial types what is printed there; a line that is added, changed or left out fails a test.
"""

from __future__ import annotations

import re
from pathlib import Path

from tools.deploy.bundle import INSTRUCTIONS
from tools.field.trial_error import TrialError

README = Path(__file__).resolve().parents[1] / "deploy" / "README.md"
FIRST_HOUR = "The first hour on the robot"
SERVICE = "As a service"
FILE = "The robot's file"


def section(heading: str) -> str:
    """Return the text of a section of deploy's README; raises TrialError if it has none."""
    _, found, rest = README.read_text().partition(f"\n## {heading}\n")
    if not found:
        raise TrialError(f"{README}: has no section {heading!r}")
    return rest.partition("\n## ")[0]


def command_lines(text: str) -> list[str]:
    """Return the commands of a text's indented blocks, without their comments."""
    joined = text.replace("\\\n", " ")
    lines = [line.split(" #")[0] for line in re.findall(r"^    (.+)$", joined, re.MULTILINE)]
    return [" ".join(line.split()) for line in lines if line.strip()]


def installation() -> list[str]:
    """Return the commands of the bundle's INSTALL.txt."""
    return command_lines(INSTRUCTIONS)


def robot_file() -> str:
    """Return the robot's file that the README prints."""
    found = re.search(r"^```toml\n(.*?)^```", section(FILE), re.MULTILINE | re.DOTALL)
    if found is None:
        raise TrialError(f"{README}: {FILE!r} prints no file")
    return found[1]
