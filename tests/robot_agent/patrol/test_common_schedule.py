"""Turns of a team from a shared secret: the same for all, and no place waits too long."""

import numpy as np
import pytest

from robot_agent.patrol.common_schedule import TICK_S, TURN_S, CommonSchedule

GAP_S = 48.6


def schedule(seed: int, limit: float = 102.0) -> CommonSchedule:
    return CommonSchedule(np.random.default_rng(seed), GAP_S, limit, 0.2)


def longest_wait(turns: list[bool], ticks: int) -> float:
    """Return the longest time without a visit of any place in one gap."""
    step, places = 0.05, 400  # s
    last = (np.arange(places) / places - 1.0) * GAP_S
    place, way, turning, longest = 0.0, 1, 0.0, 0.0
    for number in range(round(ticks * TICK_S / step)):
        t = number * step
        if number % round(TICK_S / step) == 0 and turns[round(t / TICK_S)]:
            way, turning = -way, TURN_S
        if turning > 0.0:
            turning -= step
            continue
        place = (place + way * step) % GAP_S
        here = int(place / GAP_S * places) % places
        longest = max(longest, t - last[here])
        last[here] = t
    return max(longest, float((ticks * TICK_S - last).max()))


def test_the_same_secret_gives_the_same_turns_in_any_order_of_asking():
    one, other = schedule(3), schedule(3)
    turns = [one.turns_at(tick) for tick in range(300)]
    assert other.turns_at(299) == turns[299]
    assert [other.turns_at(tick) for tick in range(300)] == turns
    assert 10 < sum(turns) < 100


@pytest.mark.parametrize("limit", [102.0, 150.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_no_place_waits_longer_than_the_limit(seed, limit):
    one = schedule(seed, limit)
    turns = [one.turns_at(tick) for tick in range(450)]
    assert 60.0 < longest_wait(turns, 450) <= limit + 1.0


def test_a_limit_below_two_gaps_leaves_no_turn():
    one = schedule(1, 60.0)
    assert not any(one.turns_at(tick) for tick in range(300))


def test_other_futures_have_the_same_past():
    one = schedule(4, 150.0)
    past = [one.turns_at(tick) for tick in range(100)]
    other = one.going_on(np.random.default_rng(9))
    assert [other.turns_at(tick) for tick in range(100)] == past
    future = range(100, 400)
    assert [one.turns_at(tick) for tick in future] != [other.turns_at(tick) for tick in future]
