"""The option ``--set KEY=VALUE`` shared by several commands."""

from __future__ import annotations

import argparse

from robot_agent.config import AgentConfig
from tools.logs.recorded_config import changed_config


def add_set_option(parser: argparse.ArgumentParser) -> None:
    """Declare the option."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a setting of every robot, e.g. patrol.reversal_probability=0 or "
        "'patrol.modifiers=[]', the paper alone",
    )


def chosen_config(options: argparse.Namespace) -> AgentConfig:
    """Return the default configuration with what ``--set`` changes. Raises ConfigError."""
    return changed_config(b"", "the defaults", options.set)
