"""``--truth`` of the commands that simulate robots."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from tools import cli
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.simulation.truth.truth import Truth, TruthError


def chosen(*words: str) -> Truth:
    parser = argparse.ArgumentParser()
    add_truth_option(parser)
    return chosen_truth(parser.parse_args(words))


def test_the_default_is_rough() -> None:
    assert chosen().name == "rough"


def test_a_file_is_taken_like_a_name(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('like = "rough"\n[people]\nleg = 0.2\n')
    assert chosen("--truth", str(path)).people.leg == 0.2
    assert chosen("--truth", "p3at").robot.subclass == "p3at"
    with pytest.raises(TruthError, match="no such truth; use"):
        chosen("--truth", "rouhg")


@pytest.mark.parametrize("command", ["bench", "paper"])
def test_ideal_sensing_has_no_truth(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [command, "--truth", "octagon", "--sensing", "ideal"]
    assert cli.main(words if command == "bench" else [*words, "-o", str(tmp_path)]) == 2
    assert "--truth needs --sensing bytes" in capsys.readouterr().err


def test_emulate_names_a_truth_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["emulate", "--truth", "nowhere"]) == 1
    assert "patrol emulate: truth 'nowhere': no such truth" in capsys.readouterr().err
