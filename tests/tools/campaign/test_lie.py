"""Lies: what robots do and say that are told something wrong."""

import dataclasses

import pytest

from tools.campaign import lie as lie_module
from tools.campaign.lie import Lie, Told, lies_table, seconds_of, tell
from tools.campaign.lie_list import LIES, LieError, chosen_lies
from tools.simulation.truth.truth import load_truth

TOLD = Told(LIES[0], 0, 3, (31.2, 40.0), "laser: it | repeats", {"laser.mount": (31.0,)}, 0.123)


def test_every_lie_has_its_truth_and_its_own_name() -> None:
    assert len({lie.name for lie in LIES}) == len(LIES)
    for lie in LIES:
        assert load_truth(lie.truth).name == lie.truth


def test_lies_are_chosen_by_name() -> None:
    assert chosen_lies(()) == LIES
    assert [lie.name for lie in chosen_lies(["scaled", "crowd"])] == ["scaled", "crowd"]
    with pytest.raises(LieError, match="truth is no lie; there are half-stuck"):
        chosen_lies(["truth"])


def test_a_laser_that_sees_turns_the_wrong_way_is_named_and_nothing_is_touched(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(lie_module, "_DURATION_S", 20.0)
    times: list[float] = []
    told = tell(dataclasses.replace(chosen_lies(["mirrored"])[0], robots=1), [2], times.append)
    assert told.contacts == 0
    assert told.complaints == []
    assert told.robots == len(told.after_s) == 1
    assert "laser.mount: mirrored" in told.said
    assert len(told.warned["laser.mount"]) == 1
    assert times[-1] == pytest.approx(20.0, abs=0.2)


def test_a_contact_is_a_complaint() -> None:
    touched = dataclasses.replace(TOLD, contacts=2)
    assert touched.complaints == ["2 contacts"]
    assert lies_table([touched]).splitlines()[-1].endswith("| 2 contacts |")


def test_table_has_what_was_said() -> None:
    row = lies_table([TOLD]).splitlines()[-1]
    assert "| 2 of 3, 31 to 40 s | laser.mount: 1 of 3, 31 to 31 s | 0.12 m |" in row
    assert row.endswith("| laser: it / repeats | ok |")
    silent = lies_table([dataclasses.replace(TOLD, after_s=(), said="", warned={})]).splitlines()[
        -1
    ]
    assert "| 0 of 3 |  | 0.12 m |  | ok |" in silent


def test_robots_at_a_blind_corner_come_from_both_sides() -> None:
    [corner] = chosen_lies(["blind-corner"])
    assert corner.starts is not None
    assert len(corner.starts) == 2
    assert isinstance(corner, Lie)
    assert seconds_of([1, 2]) == 360.0
