"""Trials of endurance: what a cycle leaves behind is seen."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tools.campaign.endurance import (
    EnduranceError,
    Outcome,
    Trial,
    endure,
    markdown,
)
from tools.campaign.endurance_list import TRIALS, chosen_trials
from tools.campaign.endurance_series import check_series, write_series
from tools.campaign.footprint import Footprint, footprint_of

FLAT = Footprint(12, 3, 100.0)


def trial(*footprints: Footprint, fails: bool = False) -> Trial:
    def run(cycles: int) -> Iterator[Footprint]:
        yield from footprints[:cycles]
        if fails:
            raise EnduranceError("the port was not opened again")

    return Trial("replug", "cable", len(footprints), run)


def outcome_of(*footprints: Footprint, fails: bool = False) -> Outcome:
    return endure(trial(*footprints, fails=fails), len(footprints), lambda _: None)


def test_what_grows_after_the_first_cycles_is_told() -> None:
    assert outcome_of(*[FLAT] * 10).complaints == []
    start = Footprint(4, 1, 50.0)  # before everything was used once
    assert outcome_of(start, *[FLAT] * 9).complaints == []
    leak = [Footprint(12 + cycle, 3 + cycle, 100.0 + 2.0 * cycle) for cycle in range(10)]
    assert outcome_of(*leak).complaints == [
        "handles not flat",
        "threads not flat",
        "memory not flat",
    ]


def test_cycle_that_fails_ends_the_trial_with_its_number() -> None:
    outcome = outcome_of(FLAT, FLAT, fails=True)
    assert outcome.complaints == ["cycle 3: the port was not opened again"]
    assert outcome_of(fails=True).complaints == ["cycle 1: the port was not opened again"]


def test_table_has_the_figures_when_warm_and_at_the_end() -> None:
    table = markdown([outcome_of(*[FLAT] * 4, Footprint(13, 3, 101.5))])
    assert "| cable | 5 | 0 | 12, 13 | 3, 3 | 100.0, 101.5 | ok |" in table


CHILD = """
import os, threading
print("before", flush=True)
input()
threading.Thread(target=threading.Event().wait, daemon=True).start()
os.pipe()
print("after", flush=True)
input()
"""
"""Of its own process: in this one threads of other tests may end meanwhile."""


def test_footprint_counts_handles_threads_and_memory_of_a_process() -> None:
    command = [sys.executable, "-c", CHILD]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdin is not None
        assert child.stdout is not None
        child.stdout.readline()
        before = footprint_of(child.pid)
        print(file=child.stdin, flush=True)
        child.stdout.readline()
        after = footprint_of(child.pid)
        print(file=child.stdin, flush=True)
    assert (after.handles, after.threads) == (before.handles + 2, before.threads + 1)
    assert after.memory_mb > 1.0


def test_footprint_of_an_ended_process_is_an_error() -> None:
    with subprocess.Popen(["true"]) as ended:
        ended.wait()
    with pytest.raises(OSError, match="No such"):
        footprint_of(ended.pid)


def test_unknown_trial_is_named() -> None:
    assert chosen_trials([]) == list(TRIALS)
    with pytest.raises(EnduranceError, match="no trial 'x'"):
        chosen_trials(["x"])


@pytest.mark.parametrize("name", ["replug", "come-and-go"])
def test_few_cycles_are_flat(name: str) -> None:
    (chosen,) = chosen_trials([name])
    outcome = endure(chosen, 6, lambda _: None)
    assert outcome.complaints == []
    assert outcome.cycles == 6


def test_series_is_a_table_or_a_figure(tmp_path: Path) -> None:
    outcomes = [outcome_of(*[FLAT] * 3, Footprint(13, 3, 101.5))]
    write_series(outcomes, tmp_path / "series.csv")
    lines = (tmp_path / "series.csv").read_text().splitlines()
    assert lines[0] == "trial,cycle,handles,threads,memory_mb"
    assert lines[-1] == "replug,4,13,3,101.50"
    write_series(outcomes, tmp_path / "series.svg")
    assert "<svg" in (tmp_path / "series.svg").read_text()
    with pytest.raises(EnduranceError, match=r"series\.txt: name it \.csv"):
        check_series(tmp_path / "series.txt")
