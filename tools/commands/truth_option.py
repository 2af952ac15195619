"""The option ``--truth NAME|FILE`` shared by the commands that simulate robots."""

from __future__ import annotations

import argparse

from tools.simulation.truth.truth import Truth, load_truth, truth_names

DEFAULT_TRUTH = "rough"
_HELP = "help"


class _ListTruths(argparse.Action):
    """Stores the option's value; lists the shipped truths and ends when it is ``help``."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        """Take the value."""
        del option_string
        if values == _HELP:
            for name in truth_names():
                print(f"{name:20}{load_truth(name).about}")
            parser.exit()
        setattr(namespace, self.dest, values)


def add_truth_option(parser: argparse.ArgumentParser) -> None:
    """Declare the option."""
    parser.add_argument(
        "--truth",
        action=_ListTruths,
        metavar="NAME|FILE",
        help="what the robots and the world really are: a shipped truth or a TOML file, by "
        f"default {DEFAULT_TRUTH}; help lists them",
    )


def chosen_truth(options: argparse.Namespace) -> Truth:
    """Return the truth of ``--truth``. Raises TruthError."""
    return load_truth(options.truth or DEFAULT_TRUTH)
