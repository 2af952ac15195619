"""The ``patrol`` command: one entry point, one module per subcommand.

Exit status: 0 ok, 1 failed, 2 wrong usage, 78 an agent that could never patrol, 130 interrupted,
143 or 129 ended by SIGTERM or SIGHUP.
Data goes to standard output, messages to standard error.
"""

from __future__ import annotations

import argparse
import errno
import importlib
import os
import signal
import sys
from collections.abc import Sequence
from importlib.metadata import version
from types import FrameType, ModuleType
from typing import Any

from tools.command_parser import CommandParser
from tools.computer_check import unfit_computer
from tools.fixed_arithmetic import fix_arithmetic
from tools.manual_page import manual_page, subparsers_of

ROOMS = ("drivers", "maps", "localization", "robot_agent", "tools")

# Each is a module of tools.commands with configure(parser) and run(options) -> exit status. It is
# imported when used: the agent must start without the operator's or the bench's libraries.
COMMANDS = {
    "agent": "run one robot: the onboard process",
    "demo": "emulated robots on pseudo-terminals, one agent process each",
    "bench": "emulated robots in lockstep, faster than real time",
    "paper": "the paper's experiment: its figures, its claims checked",
    "study": "many benches over seeds and settings, compared",
    "soak": "a team under random faults for hours",
    "doctor": "check one robot before it patrols",
    "install": "make this machine a robot: service, port names, configuration",
    "bundle": "everything for an installation with no network",
    "ports": "list serial adapters and a udev line for each",
    "emulate": "one emulated robot for any client",
    "faults": "measure a patrolling robot's reaction to every fault",
    "mutation": "mutation test of the safety gate",
    "record": "record a robot driven by keys, for a map",
    "campaign": "the same as faults: every fault, one table",
    "trial": "the bundle on a virtual computer: boots, cables, power cuts, one table",
    "monitor": "watch the team: the operator's side",
    "keys": "make certificates for robots and operator",
    "map": "build, draw, show and check maps",
    "rules": "draw and check the supervisor's fuzzy sets and rules",
    "convert": "logs and captures to recordings of real device bytes, and back",
    "localize": "run localization alone on a log or recording",
    "perceive": "run the tracker on a log, by laser alone",
    "calibrate": "fit the team's colour and the camera's direction from pictures",
    "report": "what happened in a run: figures, tables and numbers",
    "replay": "feed a recording to the agent again",
    "regression": "compare decisions of short runs with the reference",
    "test": "check the code and run all tests that need no hardware",
    "benchmark": "measure the figures every change keeps",
}


DESCRIPTION = """Pioneer robots patrol a border without communication between them.

Exit status: 0 ok, 1 failed, 2 wrong usage, 78 an agent that could never patrol, 130 interrupted,
143 or 129 ended by SIGTERM or SIGHUP. Data goes to standard output, messages to standard error."""

EXTRAS = {
    **dict.fromkeys(("aiohttp", "argcomplete", "cryptography"), "operator"),
    **dict.fromkeys(("jinja2", "matplotlib", "rich"), "operator"),
    **dict.fromkeys(("dask", "distributed"), "cluster"),
    "rosbags": "ros",
    "foxglove": "foxglove",
    **dict.fromkeys(("hypothesis", "psutil", "pytest", "selenium"), "development"),
}
"""Packages that the product does without, with the extra that brings each."""


DISK_ERRORS = {
    errno.ENOSPC: "make room on the disk, or write to another",
    errno.EDQUOT: "make room within your quota, or write elsewhere",
    errno.EFBIG: "write to a disk, and under a limit, that takes larger files",
    errno.EROFS: "write to another disk, or mount this one for writing",
    errno.EIO: "the disk fails: write to another",
}
"""What to do about errors of a disk, which come without a file's name from a write."""


class EndedBySignal(KeyboardInterrupt):
    """SIGTERM or SIGHUP, which end a command as Ctrl-C does: files finished, children ended."""

    def __init__(self, number: int) -> None:
        """Take the signal's number."""
        super().__init__(number)
        self.number = number


def end_by_signals() -> None:
    """Raise ``EndedBySignal`` in the main thread on SIGTERM and SIGHUP, ``KeyboardInterrupt`` on
    SIGINT, which ``tools.start`` has held until now.
    """

    def end(number: int, _frame: FrameType | None) -> None:
        raise EndedBySignal(number)

    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:  # nohup and others have their reasons
            signal.signal(number, end)
    if callable(signal.getsignal(signal.SIGINT)):
        signal.signal(signal.SIGINT, signal.default_int_handler)


def make_parser(command: str | None) -> argparse.ArgumentParser:
    """Return the parser; only the module of the given subcommand is imported and configured."""
    parser = CommandParser(
        prog="patrol", description=DESCRIPTION, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--version", action="version", version=version("border-patrol"))
    parser.add_argument("--man", action=ManualPage, help="print the manual page and exit")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, summary in COMMANDS.items():
        subparser = subparsers.add_parser(
            name,
            help=summary,
            description=summary,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name == command:
            load_command(name).configure(subparser)
    return parser


class ManualPage(argparse.Action):
    """Prints the manual page of all commands: ``patrol --man | man -l -``."""

    def __init__(self, option_strings: Sequence[str], dest: str, **options: Any) -> None:
        """Take no value."""
        super().__init__(option_strings, dest, nargs=0, **options)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print the page and end the command; imports the module of every command."""
        for name, subparser in subparsers_of(parser).items():
            load_command(name).configure(subparser)
        print(manual_page(parser, version("border-patrol")), end="")
        parser.exit()


def load_command(name: str) -> ModuleType:
    """Import a subcommand's module."""
    return importlib.import_module(f"tools.commands.{name}")


def _parsed(words: list[str]) -> argparse.Namespace:
    """Return the options; completes the line and exits where a shell asks for that."""
    if "_ARGCOMPLETE" in os.environ:
        complete_line()
    command = next((word for word in words if not word.startswith("-")), None)
    return make_parser(command).parse_args(words)


def complete_line() -> None:
    """Answer a shell that completes a line, and exit; return where argcomplete is missing."""
    try:
        import argcomplete
    except ImportError:
        return
    words = os.environ.get("COMP_LINE", "").split()[1:]
    command = next((word for word in words if word in COMMANDS), None)
    argcomplete.autocomplete(make_parser(command))


def main(arguments: list[str] | None = None) -> int:
    """Run one subcommand and return its exit status.

    arguments: the words after ``patrol``; None: those of the process. Errors that are not about
    input are raised.
    """
    unfit = unfit_computer()
    if unfit:
        print(f"patrol: {unfit}", file=sys.stderr)
        return 1
    fix_arithmetic()
    words = sys.argv[1:] if arguments is None else arguments
    try:
        if arguments is None:
            end_by_signals()
        return _run(words)
    except EndedBySignal as end:
        return 128 + end.number
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        sys.stderr.close()  # the output's reader has closed the pipe: no message can be shown
        return 1
    except ModuleNotFoundError as error:
        extra = EXTRAS.get((error.name or "").split(".")[0])
        if extra is None:
            raise
        print(f"patrol: needs {error.name}: pip install 'border-patrol[{extra}]'", file=sys.stderr)
        return 1


def _run(words: list[str]) -> int:
    """Run one subcommand; of its input's errors one line each."""
    name = "patrol"
    try:
        options = _parsed(words)
        name = f"patrol {options.command}"
        status: int = load_command(options.command).run(options)
        sys.stdout.flush()  # at the interpreter's end an error of it would be a traceback
    except OSError as error:
        words_of_error = _system_words(error)
        if words_of_error is None:
            raise
        print(f"{name}: {words_of_error}", file=sys.stderr)
        return 1
    except ValueError as error:
        if type(error).__module__.split(".")[0] not in ROOMS:
            raise  # only errors of these packages are about input; any other is a bug
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    return status


def _system_words(error: OSError) -> str | None:
    """Return what the system refused, and the remedy; None for what is no matter of files."""
    if isinstance(error, BrokenPipeError):
        return None
    place = "" if error.filename is None else f"{error.filename}: "
    if error.errno in DISK_ERRORS:
        return f"{place}{error.strerror}; {DISK_ERRORS[error.errno]}"
    return f"{place}{error.strerror}; check path and rights" if place else None


if __name__ == "__main__":
    sys.exit(main())
