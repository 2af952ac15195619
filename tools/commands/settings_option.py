"""The options ``--config`` and ``--set`` shared by several commands: what robots believe."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import tomli_w

from maps.toml_text import read_toml
from robot_agent.config import AgentConfig, parse_config, place_paths
from tools.logs.recorded_config import changed_config


def add_set_option(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--config", type=Path, metavar="ROBOT.toml", help="configuration of every robot"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a setting of every robot, e.g. patrol.reversal_probability=0",
    )
    parser.add_argument(
        "--pure",
        action="append_const",
        dest="set",
        const="patrol.modifiers=[]",
        help="the paper and nothing else: no modifiers",
    )


def chosen_config(
    options: argparse.Namespace, defaults: Mapping[str, object] = MappingProxyType({})
) -> AgentConfig:
    """Return the configuration of ``--config``, or the default one, with what ``--set`` changes.

    defaults: by dotted key, of a command whose defaults differ; they hold without ``--config``.

    Raises ConfigError, and OSError for a file that cannot be read.
    """
    if options.config is None:
        own = [f"{key}={value}" for key, value in defaults.items()]
        return changed_config(b"", "the defaults", [*own, *options.set])
    return changed_config(robots_file(options), str(options.config), options.set)


def robots_file(options: argparse.Namespace) -> bytes:
    """Return ``--config``, checked, its paths absolute, as TOML; empty without the option.

    Raises ConfigError, and OSError for a file that cannot be read.
    """
    if options.config is None:
        return b""
    content: bytes = options.config.read_bytes()
    parse_config(content, str(options.config))
    table = read_toml(content)
    place_paths(table, options.config.parent)
    return tomli_w.dumps(table).encode()
