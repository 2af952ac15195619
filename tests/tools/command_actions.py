"""All options and arguments of a command, those of its subcommands too."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from tools.cli import make_parser


def command_actions(command: str) -> Iterator[argparse.Action]:
    """Yield each action of a command's parsers."""
    (subparsers,) = _choices(make_parser(command))
    parsers = [subparsers.choices[command]]
    while parsers:
        parser = parsers.pop()
        yield from parser._actions
        for choices in _choices(parser):
            parsers += choices.choices.values()


def _choices(parser: argparse.ArgumentParser) -> list[argparse._SubParsersAction]:
    return [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
