"""The manual page of a command with subcommands, made from its parsers."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator

_PLACEHOLDER = re.compile(r"%\((\w+)\)s")


def manual_page(parser: argparse.ArgumentParser, version: str) -> str:
    """Return the page of section 1 as roff for the macros of ``man``, ASCII."""
    lines = [
        f'.TH {_roff(parser.prog).upper()} 1 "" "{_roff(f"{parser.prog} {version}")}"',
        ".ad l",
        ".SH NAME",
        rf"{_roff(parser.prog)} \- {_roff(_first_line(parser))}",
        ".SH SYNOPSIS",
        rf"\fB{_roff(parser.prog)}\fR {_roff('[--help] [--version] [--man] COMMAND ...')}",
        ".SH DESCRIPTION",
        *_paragraphs((parser.description or "").partition("\n\n")[2]),
        ".SH COMMANDS",
    ]
    for subparser in subparsers_of(parser).values():
        lines += _command_lines(subparser)
    return "\n".join(lines) + "\n"


def subparsers_of(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the parsers of a parser's subcommands by name; empty without any."""
    for action in parser._actions:  # argparse has no public way
        if isinstance(action, argparse._SubParsersAction):
            return dict(action.choices)
    return {}


def _command_lines(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Yield heading, summary, options and examples of a command, then of those below it."""
    yield f'.SS "{_roff(parser.prog)}"'
    yield from _paragraphs(parser.description or "")
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction | argparse._HelpAction):
            continue
        if action.help == argparse.SUPPRESS:
            continue
        yield ".TP"
        yield _invocation(action)
        yield _roff(_help(action)) or r"\&"
    if parser.epilog:
        yield from (".PP", ".nf", *map(_text_line, parser.epilog.splitlines()), ".fi")
    below = subparsers_of(parser)
    summaries = _summaries(parser)
    for name, subparser in below.items():
        subparser.description = subparser.description or summaries.get(name)
        yield from _command_lines(subparser)


def _summaries(parser: argparse.ArgumentParser) -> dict[str, str]:
    """Return the help of each subcommand, by name."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return {each.dest: each.help or "" for each in action._choices_actions}
    return {}


def _invocation(action: argparse.Action) -> str:
    """Return how an option or argument is written: names bold, values in italics."""
    if action.choices is not None and action.metavar is None:
        value = "|".join(map(str, action.choices))
    else:
        value = str(action.metavar or action.dest.upper())
    many = " ..." if action.nargs in ("*", "+") else ""
    shown = "" if action.nargs == 0 else rf"\fI{_roff(value)}\fR{many}"
    names = ", ".join(rf"\fB{_roff(name)}\fR" for name in action.option_strings)
    return " ".join(filter(None, (names, shown)))


def _help(action: argparse.Action) -> str:
    """Return an option's help with its default, if it has one that is not told there."""
    words = action.help or ""
    told = _PLACEHOLDER.sub(lambda found: str(getattr(action, found[1])), words)
    told = told.replace("%%", "%")
    if action.nargs == 0 or action.default in (None, "", []) or "default" in told:
        return told
    default = f"default: {action.default}"
    return f"{told} ({default})" if told else default


def _first_line(parser: argparse.ArgumentParser) -> str:
    return (parser.description or "").partition("\n")[0].rstrip(".")


def _paragraphs(text: str) -> Iterator[str]:
    """Yield paragraphs, which empty lines separate."""
    for number, paragraph in enumerate(filter(None, text.strip().split("\n\n"))):
        if number:
            yield ".PP"
        yield _text_line(" ".join(paragraph.split()))


def _text_line(text: str) -> str:
    """Return a line of text that roff takes for no request."""
    line = _roff(text)
    return rf"\&{line}" if line.startswith((".", "'")) else line


def _roff(text: str) -> str:
    """Return a text with what roff reads otherwise escaped; beyond ASCII by code."""
    escaped = text.replace("\\", r"\(rs").replace("-", r"\-").replace('"', r"\(dq")
    escaped = escaped.replace("`", r"\(ga").replace("^", r"\(ha").replace("~", r"\(ti")
    return "".join(c if c.isascii() else rf"\[u{ord(c):04X}]" for c in escaped.replace("\n", " "))
