"""The table of a bench."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tools.cli import main


def rows_of(text: str) -> dict[str, str]:
    return {line[:22].strip(): line[22:].strip() for line in text.splitlines()}


def test_table_says_what_the_figures_say(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["bench", "--sensing", "ideal", "--duration", "200", "--seed", "2"]
    assert main([*words, "--json", str(tmp_path / "out.json")]) == 0
    rows = rows_of(capsys.readouterr().out)
    figures = json.loads((tmp_path / "out.json").read_text())
    assert rows["contacts"] == "0"
    assert rows["meetings"].startswith(str(len(figures["meetings"])))
    worst = figures["idleness_s"]["worst"]
    assert rows["idleness"].endswith(f"worst {worst:.1f} s")
    assert rows["robots, seed, time"].startswith("3, 2, 200 s in ")


def test_a_run_without_arrival_has_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--robots", "1", "--duration", "2"]) == 0
    rows = rows_of(capsys.readouterr().out)
    assert rows["on the border after"] == "never"
    assert rows["idleness"] == "average -, worst_average -, worst -"
    assert rows["intruder of 60 s seen"] == "-"


def test_minus_prints_the_figures_alone(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "--sensing", "ideal", "--duration", "5", "--json", "-"]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["contacts"] == 0
    assert not Path("-").exists()
