"""Parser of a command line: what is wrong with a line is told in one line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn

_LONGEST = 400


class CommandParser(argparse.ArgumentParser):
    """An argparse parser without the usage above each error; its subparsers are such parsers too.

    The parser of a subcommand tells itself what it does not know, so that its help is named.
    """

    def error(self, message: str) -> NoReturn:
        """Print one line and end with status 2."""
        shown = "".join(c if c.isprintable() else "?" for c in message)
        if len(shown) > _LONGEST:
            shown = f"{shown[:_LONGEST]}..."
        self.exit(2, f"{self.prog}: error: {shown}; see {self.prog} --help\n")

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse a line, which may have nothing that is unknown."""
        known: tuple[Any, list[str]] = super().parse_known_args(args, namespace)
        if known[1]:
            self.error(f"unrecognized arguments: {' '.join(known[1])}")
        return known
