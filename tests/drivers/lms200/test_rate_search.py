from __future__ import annotations

from drivers.lms200.rate_search import COMMON_RATES, RateSearch


def _tried(search: RateSearch, first: int) -> list[tuple[int, bool]]:
    search.restart(first)
    tried = []
    while not search.ends:
        search.advance()
        tried.append((search.baud, search.glances))
    return tried


def test_each_rate_gets_a_quick_look_before_any_gets_all_tries() -> None:
    order = (500000, 38400, 9600, 19200)
    quick = [(rate, True) for rate in order]
    thorough = [(rate, False) for rate in order]
    assert _tried(RateSearch(500000), 500000) == quick + thorough


def test_search_begins_at_the_first_rate_then_the_wanted_one() -> None:
    tried = [rate for rate, _ in _tried(RateSearch(38400), 19200)]
    assert tried[:4] == [19200, 38400, 9600, 500000]
    assert set(tried) == set(COMMON_RATES)


def test_rate_of_earlier_scans_is_tried_thoroughly_between_any_two_others() -> None:
    search = RateSearch(38400)
    search.restart(9600)
    search.advance()
    search.on_scan()
    assert _tried(search, 38400) == [(rate, False) for rate in (38400, 9600, 19200, 9600, 500000)]
