"""Strangers that stay near the border are reported once, also when their tracks change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from robot_agent.perception.identity import Kind, Probabilities
from robot_agent.perception.intruders import Intruders
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.track import Track

STRANGER = Track(
    id=7, x=5.0, y=1.0, vx=0.0, vy=0.0, covariance=0.01 * np.eye(2), first_seen=0.0,
    last_seen=0.0, kind=Kind.STRANGER, probabilities=Probabilities(0.0, 1.0, 0.0),
    robot_sized=False, moving=True, by_color=True,
)  # fmt: skip


@pytest.fixture
def intruders() -> Intruders:
    border = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
    return Intruders(PerceptionSettings(), border)


def stay(
    intruders: Intruders, track: Track, start: float, end: float, step: float = 0.1
) -> list[int]:
    """Show a track from start to end, s; return the numbers reported as new."""
    numbers = []
    for k in range(round((end - start) / step) + 1):
        t = start + k * step
        seen = replace(track, last_seen=t, first_seen=max(track.first_seen, start))
        numbers += [each.number for each in intruders.update(t, [seen])]
    return numbers


def test_a_stranger_is_reported_after_three_seconds_and_only_once(intruders: Intruders) -> None:
    assert stay(intruders, STRANGER, 0.0, 2.9) == []
    assert stay(intruders, STRANGER, 3.0, 30.0) == [1]
    [known] = intruders.known
    assert (known.x, known.distance) == (5.0, pytest.approx(1.0))
    assert known.abscissa == pytest.approx(5.0)
    assert known.first_seen == pytest.approx(0.0)
    assert known.last_seen == pytest.approx(30.0)


def test_new_track_of_a_known_stranger_is_not_reported_again(intruders: Intruders) -> None:
    assert stay(intruders, STRANGER, 0.0, 5.0) == [1]
    again = replace(STRANGER, id=9, x=7.0, first_seen=12.0)
    assert stay(intruders, again, 12.0, 20.0) == []
    assert [each.number for each in intruders.known] == [1]
    assert intruders.known[0].track == 9


@pytest.mark.parametrize(("x", "back", "updated"), [(5.2, 9.0, True), (5.9, 9.0, False),
                                                    (5.2, 18.0, False)])  # fmt: skip
def test_unknown_track_at_the_place_of_a_lost_intruder_is_that_intruder(
    intruders: Intruders, x: float, back: float, updated: bool
) -> None:
    """A robot turns round beside a person and sees them from the front, as wide as a robot."""
    assert stay(intruders, STRANGER, 0.0, 5.0) == [1]
    unknown = replace(STRANGER, id=9, x=x, kind=Kind.UNKNOWN, robot_sized=True)
    assert stay(intruders, unknown, back, back + 5.0) == []
    [known] = intruders.known
    assert (known.last_seen == pytest.approx(back + 5.0)) == updated
    assert (known.track == 9) == updated


def test_two_strangers_are_two_intruders(intruders: Intruders) -> None:
    other = replace(STRANGER, id=8, x=12.0)
    numbers = []
    for k in range(60):
        t = 0.1 * k
        tracks = [replace(each, last_seen=t) for each in (STRANGER, other)]
        numbers += [each.number for each in intruders.update(t, tracks)]
    assert numbers == [1, 2]


def test_a_track_lost_for_a_moment_does_not_restart_the_three_seconds(
    intruders: Intruders,
) -> None:
    assert stay(intruders, STRANGER, 0.0, 2.0) == []
    again = replace(STRANGER, id=9, x=5.5, first_seen=2.5)
    assert stay(intruders, again, 2.5, 3.2) == [1]


@pytest.mark.parametrize("robot_sized", [False, True])
def test_stay_before_the_classification_counts(intruders: Intruders, robot_sized: bool) -> None:
    unknown = replace(STRANGER, kind=Kind.UNKNOWN, robot_sized=robot_sized)
    assert stay(intruders, unknown, 0.0, 2.7) == []
    assert stay(intruders, STRANGER, 2.8, 3.1) == [1]
    assert intruders.known[0].first_seen == pytest.approx(0.0)


def test_the_time_as_a_teammate_does_not_count(intruders: Intruders) -> None:
    assert stay(intruders, replace(STRANGER, kind=Kind.TEAMMATE), 0.0, 9.9) == []
    assert stay(intruders, STRANGER, 10.0, 12.9) == []
    assert stay(intruders, STRANGER, 13.0, 13.1) == [1]


@pytest.mark.parametrize(
    "nobody",
    [
        replace(STRANGER, kind=Kind.TEAMMATE),
        replace(STRANGER, kind=Kind.UNKNOWN, robot_sized=True),
        replace(STRANGER, y=2.5),
    ],
)
def test_teammates_unclassified_robots_and_distant_tracks_are_not_reported(
    intruders: Intruders, nobody: Track
) -> None:
    assert stay(intruders, nobody, 0.0, 20.0) == []


def test_stranger_back_after_a_minute_is_reported_again(intruders: Intruders) -> None:
    assert stay(intruders, STRANGER, 0.0, 5.0) == [1]
    assert stay(intruders, replace(STRANGER, id=9, first_seen=80.0), 80.0, 90.0) == [2]


def test_stay_counts_from_its_start_though_taken_for_a_teammate(
    intruders: Intruders,
) -> None:
    """A person approaches straight from afar and is classified when near."""
    unknown = replace(STRANGER, kind=Kind.UNKNOWN, robot_sized=True)
    assert stay(intruders, unknown, 0.0, 1.0) == []
    assert stay(intruders, replace(STRANGER, kind=Kind.TEAMMATE), 1.1, 2.5) == []
    reported_at = [t for t in np.arange(2.6, 6.0, 0.1) if stay(intruders, STRANGER, t, t)]
    assert reported_at == pytest.approx([3.5])  # a second after the doubt
    assert intruders.known[0].first_seen == pytest.approx(0.0)


def test_teammate_briefly_taken_for_a_stranger_is_not_reported(
    intruders: Intruders,
) -> None:
    unknown, teammate = (replace(STRANGER, kind=kind) for kind in (Kind.UNKNOWN, Kind.TEAMMATE))
    assert stay(intruders, replace(unknown, robot_sized=True), 0.0, 1.0) == []
    for k in range(10):
        start = 1.1 + 2.0 * k
        assert stay(intruders, teammate, start, start + 1.0) == []
        assert stay(intruders, STRANGER, start + 1.1, start + 1.8) == []


def test_new_track_counts_from_where_it_began(intruders: Intruders) -> None:
    """A person's track is lost; the next one has walked on by the time it is a stranger's."""
    assert stay(intruders, STRANGER, 0.0, 5.0) == [1]
    for k in range(50):
        t = 5.1 + 0.1 * k
        kind = Kind.STRANGER if k > 20 else Kind.UNKNOWN
        walker = replace(STRANGER, id=9, x=5.2 + 0.1 * k, first_seen=5.1, last_seen=t, kind=kind)
        assert intruders.update(t, [walker]) == []
    assert [(each.number, each.track) for each in intruders.known] == [(1, 9)]


def test_two_tracks_within_a_stride_are_one_intruder_until_they_part(intruders: Intruders) -> None:
    numbers = []
    for k in range(120):
        t, apart = 0.1 * k, 0.5 if k < 80 else 1.5
        leg = replace(STRANGER, last_seen=t)
        other = replace(STRANGER, id=8, x=5.0 + apart, last_seen=t)
        numbers += [(k, each.number) for each in intruders.update(t, [leg, other])]
    assert numbers == [(30, 1), (80, 2)]
