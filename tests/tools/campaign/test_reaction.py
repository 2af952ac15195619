"""Measurement of a robot's reaction and its limits, on moments written by hand."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tools.campaign.agent_stage import Moment
from tools.campaign.fault import Expected, FaultError
from tools.campaign.fault_list import FAULTS, chosen_faults
from tools.campaign.fault_table import HEADINGS, markdown, row
from tools.campaign.line_fault_list import LINE_FAULTS
from tools.campaign.reaction import (
    SAMPLING_S,
    STEADY_S,
    Reaction,
    complaints,
    measure_stop,
    new_reaction,
    patrols,
    steady_since,
)

STEP = 0.01


def moments(*parts: tuple[float, float, str]) -> list[Moment]:
    """Return moments every STEP from t = 100 s: (duration s, speed m/s, order) each."""
    made: list[Moment] = []
    for duration, v, order in parts:
        for _ in range(round(duration / STEP)):
            made.append(Moment(100.0 + STEP * len(made), v, 0.0, order, 0))
    return made


def reaction(**changes: object) -> Reaction:
    """Return a reaction to an unplugged cable within all limits, with the given changes."""
    well: dict[str, object] = {
        "fault": "base-unplugged",
        "what": "base's cable unplugged",
        "expected": Expected.BASE_STOPS,
        "back_within": 1.0,
        "ordered": 1.2,
        "ordered_by": "watchdog",
        "speed": 0.3,
        "stopped": 1.72,
        "back": 0.4,
        "recovered": 1.0,
        "first_order": "STOP",
    }
    return Reaction(**{**well, **changes})  # type: ignore[arg-type]


def test_stop_is_measured_by_order_and_by_wheels() -> None:
    seen = reaction(ordered=None, stopped=None)
    measure_stop(seen, 100.0, moments((1.0, 0.3, ""), (0.5, 0.2, "watchdog"), (1.0, 0.0, "agent")))
    assert seen.ordered == pytest.approx(1.0)
    assert seen.ordered_by == "watchdog"
    assert seen.speed == 0.3
    assert seen.stopped == pytest.approx(1.5)


def test_wheels_that_pass_zero_have_not_stopped() -> None:
    seen = reaction(ordered=None, stopped=None)
    measure_stop(seen, 100.0, moments((1.0, 0.3, ""), (0.1, 0.0, ""), (1.0, -0.3, "")))
    assert (seen.ordered, seen.stopped) == (None, None)


def test_patrolling_is_motion_without_a_break() -> None:
    assert patrols(moments((STEADY_S + 0.1, 0.3, "")))
    assert not patrols(moments((STEADY_S - 0.1, 0.3, "")))
    broken = moments((2.0, 0.3, ""), (0.1, 0.0, ""), (0.5, 0.3, ""))
    assert not patrols(broken)
    assert steady_since(broken) == pytest.approx(102.1)


def test_faultless_reaction_has_no_complaint() -> None:
    assert complaints(reaction()) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"ordered": None}, "no standing order within 2 s"),
        ({"ordered": 2.0 + 2 * SAMPLING_S}, "no standing order within 2 s"),
        ({"stopped": None}, "not at rest"),
        ({"stopped": 2.0 + 2 * SAMPLING_S}, "not at rest within 2.00 s"),
        ({"back": None}, "not back within 1 s"),
        ({"back": 1.2}, "not back within 1 s"),
        ({"recovered": None}, "not patrolling within 10 s"),
        ({"recovered": 10.1}, "not patrolling within 10 s"),
        ({"contacts": 1}, "1 contacts"),
        ({"first_order": "VEL 327"}, "first order after it was VEL 327"),
        ({"first_order": "ENABLE 1"}, "first order after it was ENABLE 1"),
        ({"expected": Expected.AGENT_STOPS, "ordered": 0.6}, "no standing order within 0.3 s"),
        ({"expected": Expected.AGENT_STOPS, "stopped": 2.1}, "not at rest within 2.00 s"),
    ],
)
def test_each_missed_limit_is_named(changes: dict[str, object], words: str) -> None:
    assert any(words in complaint for complaint in complaints(reaction(**changes)))


def test_fault_with_patrol_allowed_needs_no_stop() -> None:
    lived = {"expected": Expected.MAY_PATROL, "ordered": None, "stopped": None, "back": None}
    assert complaints(reaction(**lived, first_order="VEL 350")) == []
    assert complaints(reaction(**lived, contacts=2)) == ["2 contacts"]


def test_faults_are_chosen_by_name() -> None:
    assert chosen_faults([]) == list(FAULTS)
    assert [fault.name for fault in chosen_faults(["laser-silent"])] == ["laser-silent"]
    with pytest.raises(FaultError, match="no fault 'fire'"):
        chosen_faults(["fire"])


def test_every_fault_that_unplugs_a_cable_has_a_return_limit() -> None:
    own_pace = {"base-reset", "laser-power", "laser-absent"}
    without_cable = {"base-stuck", "laser-stuck", "laser-blind"}
    stopping = [fault for fault in LINE_FAULTS if fault.expected is not Expected.MAY_PATROL]
    assert {f.name for f in stopping if f.back_within is None} == own_pace | without_cable


def test_fault_names_are_unique() -> None:
    names = [fault.name for fault in FAULTS]
    assert len(set(names)) == len(names)


def test_faults_own_limits_replace_the_usual_ones() -> None:
    slow = {"expected": Expected.AGENT_STOPS, "ordered": 2.4, "stopped": 3.5}
    assert complaints(reaction(**slow, order_within=2.5)) == []
    assert complaints(reaction(**slow)) == [
        "no standing order within 0.3 s",
        "not at rest within 2.00 s",
    ]
    assert complaints(reaction(recovered=50.0, recover_within=60.0)) == []
    assert complaints(reaction(recovered=50.0)) == ["not patrolling within 10 s"]


def test_table_has_a_row_for_each_reaction() -> None:
    poor = reaction(detected=0.1, detected_by="event: base", contacts=1)
    poor.complaints = complaints(poor)
    cells = row(poor)
    assert len(cells) == len(HEADINGS)
    assert cells[1] == "0.10"
    assert cells[-1] == "1 contacts"
    lines: Sequence[str] = markdown([poor, new_reaction(FAULTS[0])]).splitlines()
    assert len({line.count("|") for line in lines[:4]}) == 1
    assert lines[3].split(" | ")[1] == "-"


def hung_disk(**changes: object) -> Reaction:
    """Return a reaction of a robot that patrols on and tells what hangs, with changes."""
    well = {"expected": Expected.PATROLS_ON, "ordered": None, "detected": 5.4, "hunger": 1.2}
    return reaction(**{**well, **changes})


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, []),
        ({"ordered": 0.2}, ["ordered to stand"]),
        ({"detected": None}, ["nothing was said"]),
        ({"hunger": 3.5}, ["watchdog not fed for 3.5 s"]),
        ({"detected": None, "recovered": None, "skipped": "mount: it needs root"}, []),
    ],
)
def test_robot_patrols_on_while_a_disk_hangs(
    changes: dict[str, object], expected: list[str]
) -> None:
    assert complaints(hung_disk(**changes)) == expected


def test_fault_that_cannot_be_made_here_says_why() -> None:
    assert row(hung_disk(skipped="mount: it needs root"))[-1] == "skipped: mount: it needs root"
