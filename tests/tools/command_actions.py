"""All options and arguments of a command, those of its subcommands too."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from tools.cli import make_parser
from tools.manual_page import subparsers_of


def command_actions(command: str) -> Iterator[argparse.Action]:
    """Yield each action of a command's parsers."""
    yield from _actions(subparsers_of(make_parser(command))[command])


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    yield from parser._actions
    for each in subparsers_of(parser).values():
        yield from _actions(each)
