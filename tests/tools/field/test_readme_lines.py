"""The trial types what INSTALL.txt and deploy's README print: a line that drifts fails here."""

from __future__ import annotations

import msgspec
import pytest

from robot_agent.config import parse_config
from tools.field.installation_rows import BY_HAND, first_hour, robot_configuration
from tools.field.readme_lines import (
    FIRST_HOUR,
    SERVICE,
    command_lines,
    installation,
    robot_file,
    section,
)
from tools.field.trial_error import TrialError

TYPED = [
    "cd FOLDER",
    "sha256sum --check --quiet SHA256SUMS",
    "python3 -m venv /opt/patrol",
    "/opt/patrol/bin/pip install --no-index --find-links wheels "
    "--find-links wheels/$(uname -m) border-patrol",
    "ln -sf /opt/patrol/bin/patrol /usr/local/bin/patrol",
    "patrol ports",
    "patrol install robot1.toml",
    "patrol doctor /etc/patrol/robot1.toml",
]


def test_installation_is_what_install_txt_prints() -> None:
    assert installation() == TYPED


def test_every_line_of_the_readme_is_typed_or_left_to_a_person_for_a_reason() -> None:
    printed = [*command_lines(section(FIRST_HOUR)), *command_lines(section(SERVICE))]
    assert printed == [
        "sha256sum --check --quiet SHA256SUMS",
        "patrol ports",
        "$EDITOR robot1.toml",
        "patrol doctor robot1.toml",
        "patrol doctor --watchdog-test robot1.toml",
        "patrol record robot1.toml --teleop -o drive.mcap",
        "patrol map build drive.mcap -o my_map --from odometry",
        "patrol map border my_map",
        "patrol map check my_map",
        "sudo patrol install robot1.toml",
        "sudo patrol doctor --as-service /etc/patrol/robot1.toml",
        "sudo systemctl start patrol@robot1",
        "journalctl -fu patrol@robot1",
        "sudo patrol install robot1.toml",
        "sudo systemctl enable --now patrol@robot1",
        "journalctl -fu patrol@robot1",
    ]
    assert set(printed) - set(installation()) <= set(first_hour())
    assert set(BY_HAND) < set(first_hour())


def test_comments_and_continued_lines_are_joined_or_left_out() -> None:
    text = "words\n\n    a --b   # 1. why\n            # more\n    c \\\n        d\n\nwords\n"
    assert command_lines(text) == ["a --b", "c d"]


def test_a_section_that_is_gone_is_told() -> None:
    with pytest.raises(TrialError, match="no section 'Nowhere'"):
        section("Nowhere")


def test_the_printed_file_is_a_robots_with_the_names_of_the_adapters() -> None:
    printed = parse_config(robot_file().encode(), "README.md")
    config = parse_config(robot_configuration().encode(), "README.md")
    assert config.base.url == "/dev/patrol/base"
    assert config.laser.url == "/dev/patrol/laser"
    assert config.map.folder == "my_map"
    same = msgspec.structs.replace(config, base=printed.base, laser=printed.laser)
    assert same == printed
