"""The manual page: every command with its options, and text that roff reads as written."""

from __future__ import annotations

import argparse
import shutil
import subprocess

import pytest

from tools.cli import COMMANDS, main, make_parser
from tools.manual_page import manual_page, subparsers_of


def printed(capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as ended:
        main(["--man"])
    assert ended.value.code == 0
    return capsys.readouterr().out


def formatted(page: str) -> tuple[str, str]:
    """Return the page as a reader sees it, and what the formatter complains of."""
    if not shutil.which("groff"):
        pytest.skip("needs groff")
    command = ["groff", "-man", "-ww", "-Tutf8", "-P-c", "-rLL=200n"]
    done = subprocess.run(command, input=page, capture_output=True, text=True, check=True)
    plain = done.stdout
    while "\b" in plain:  # bold and italics are overstruck
        at = plain.index("\b")
        plain = plain[: at - 1] + plain[at + 1 :]
    return " ".join(plain.split()), done.stderr


def options_of(parser: argparse.ArgumentParser) -> set[str]:
    named = {name for action in parser._actions for name in action.option_strings}
    return named.union(*map(options_of, subparsers_of(parser).values())) - {"-h", "--help"}


def test_page_has_every_command_with_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    page = printed(capsys).replace("\\-", "-")
    sections = dict(part.split('"\n', 1) for part in page.split('.SS "')[1:])
    for command in COMMANDS:
        own = "".join(
            text
            for heading, text in sections.items()
            if f"{heading} ".startswith(f"patrol {command} ")
        )
        for option in options_of(subparsers_of(make_parser(command))[command]):
            assert rf"\fB{option}\fR" in own, (command, option)
        assert COMMANDS[command] in own, command


def test_page_is_formatted_without_a_warning(capsys: pytest.CaptureFixture[str]) -> None:
    shown, complaints = formatted(printed(capsys))
    assert complaints == ""
    for words in (
        "patrol - ",
        "patrol map build",
        "--resolution",
        "patrol monitor --play robot1.mcap robot2.mcap",
        "Exit status: 0 ok, 1 failed, 2 wrong usage",
    ):
        assert words in shown


def test_text_is_shown_as_written() -> None:
    parser = argparse.ArgumentParser(prog="tool", description='A "tool".\n\n.x - \\n ~^`\n\n\'b')
    below = parser.add_subparsers().add_parser("do", help="does it", epilog=".so x\n'a ± 5 %")
    below.add_argument("--share", default=5, help="50 %% of %(default)s", metavar="N")
    shown, complaints = formatted(manual_page(parser, "1"))
    assert complaints == ""
    for words in (".x - \\n ~^`", "'b", ".so x", "'a ± 5 %", "50 % of 5 (default: 5)"):
        assert words in shown
