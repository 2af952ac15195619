"""A wrong command line is one line with a remedy, for every command."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import pytest

from tools import number_range
from tools.cli import COMMANDS, main, make_parser
from tools.manual_page import subparsers_of

NUMBERS = {getattr(number_range, name) for name in ("positive", "not_negative", "share", "real")}


def parsers_of(command: str) -> Iterator[argparse.ArgumentParser]:
    """Yield the parser of a command and all below it."""
    waiting = [subparsers_of(make_parser(command))[command]]
    while waiting:
        parser = waiting.pop()
        waiting += subparsers_of(parser).values()
        yield parser


def is_number(action: argparse.Action) -> bool:
    made_by = getattr(action.type, "__qualname__", "").partition(".")[0]
    return action.type in NUMBERS or made_by == number_range.whole.__name__


def required(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return what a parser does not do without, of alternatives the first."""
    groups = [group for group in parser._mutually_exclusive_groups if group.required]
    own = [action for action in parser._actions if action.required and action.nargs != "*"]
    return own + [group._group_actions[0] for group in groups]


def refusal(capsys: pytest.CaptureFixture[str], words: list[str]) -> str:
    """Run a command line that is wrong usage; return its only line."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    captured = capsys.readouterr()
    assert (ended.value.code, captured.out) == (2, "")
    (line,) = captured.err.splitlines()
    assert len(line) < 600
    return line


@pytest.mark.parametrize("command", COMMANDS)
def test_number_out_of_range_is_one_line(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    for parser in parsers_of(command):
        for action in filter(is_number, parser._actions):
            (name, *_) = action.option_strings
            line = refusal(capsys, [*parser.prog.split()[1:], f"{name}=-1e300"])
            assert line.startswith(f"{parser.prog}: error: argument ")
            assert name in line
            assert "'-1e300' is " in line
            assert ": give a " in line
            assert line.endswith(f"; see {parser.prog} --help")


@pytest.mark.parametrize("command", COMMANDS)
def test_unknown_option_is_one_line(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    for parser in parsers_of(command):
        if subparsers_of(parser):
            continue  # the chosen one of them tells it
        words = parser.prog.split()[1:]
        for action in required(parser):
            words += [*action.option_strings[:1], "1"]
        assert refusal(capsys, [*words, "--dance"]) == (
            f"{parser.prog}: error: unrecognized arguments: --dance; see {parser.prog} --help"
        )


@pytest.mark.parametrize("command", COMMANDS)
def test_missing_argument_is_one_line(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    for parser in parsers_of(command):
        if required(parser):
            line = refusal(capsys, parser.prog.split()[1:])
            assert line.startswith(f"{parser.prog}: error: ")
            assert "required" in line
            assert line.endswith(f"; see {parser.prog} --help")


def test_range_and_remedy_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert refusal(capsys, ["bench", "--robots", "0"]) == (
        "patrol bench: error: argument --robots: '0' is out of range: give a whole number from 1 "
        "to 500; see patrol bench --help"
    )
    assert "a number above 0" in refusal(capsys, ["bench", "--duration", "0"])


def test_unknown_command_is_one_line_with_all_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    line = refusal(capsys, ["dance"])
    assert all(repr(command) in line for command in COMMANDS)
    assert "required: COMMAND" in refusal(capsys, [])


@pytest.mark.parametrize("word", ["--dance\nTraceback", "--\x1b[2J", "--" + "x" * 5000])
def test_hostile_words_stay_one_short_line(word: str, capsys: pytest.CaptureFixture[str]) -> None:
    line = refusal(capsys, ["bench", word])
    assert line.isprintable()
    assert line.endswith("; see patrol bench --help")
