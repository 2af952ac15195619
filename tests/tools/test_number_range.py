"""Numbers on the command line: every one has its range."""

from __future__ import annotations

import argparse

import pytest

from tests.tools.command_actions import command_actions
from tools.cli import COMMANDS, main
from tools.number_range import not_negative, positive, real, whole


@pytest.mark.parametrize("text", ["0", "-1", "1e3", "nan", "x" * 5000, "9" * 5000])
def test_what_is_no_count_of_robots_is_one_short_line(
    capsys: pytest.CaptureFixture[str], text: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["bench", f"--robots={text}"])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--robots" in line
    assert len(line) < 200


@pytest.mark.parametrize(
    ("parse", "text"),
    [
        (positive, "0"),
        (positive, "inf"),
        (not_negative, "-0.1"),
        (real, "nan"),
        (real, "1e300"),
        (whole(1, 5), "6"),
    ],
)
def test_numbers_out_of_range_are_refused(parse: object, text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        parse(text)  # type: ignore[operator]


def test_numbers_in_range_are_taken() -> None:
    assert (positive("0.5"), not_negative("0"), real("-3"), whole()("7")) == (0.5, 0.0, -3.0, 7)


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_takes_a_number_without_a_range(command: str) -> None:
    for action in command_actions(command):
        if not isinstance(action, argparse._SubParsersAction):
            bounded = action.choices is not None or action.type not in (int, float)
            assert bounded, action.option_strings
