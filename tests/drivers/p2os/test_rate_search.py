from __future__ import annotations

from drivers.p2os.rate_search import TRIES, TRIES_AT_KNOWN_RATE, RateSearch


def rates(search: RateSearch, count: int) -> list[int]:
    found = [search.baud]
    for _ in range(count - 1):
        search.advance()
        found.append(search.baud)
    return found


def test_first_sweep_begins_as_configured_and_takes_every_rate_once() -> None:
    search = RateSearch(19200)
    search.restart()
    assert rates(search, 5) == [19200, 9600, 38400, 115200, 57600]
    assert search.tries == TRIES


def test_later_sweeps_alternate_with_the_configured_rate() -> None:
    search = RateSearch(9600)
    search.restart()
    ends = [search.advance() for _ in range(5)]
    assert ends == [False] * 4 + [True]
    assert rates(search, 8) == [9600, 38400, 9600, 19200, 9600, 115200, 9600, 57600]
    assert search.advance()


def test_known_rate_is_tried_first_with_more_attempts() -> None:
    search = RateSearch(9600)
    search.restart()
    search.advance()
    search.on_success()
    search.advance()
    search.restart()
    assert (search.baud, search.tries) == (38400, TRIES_AT_KNOWN_RATE)
    search.advance()
    assert (search.baud, search.tries) == (9600, TRIES)


def test_return_to_the_configured_rate_returns_whether_it_changed() -> None:
    search = RateSearch(9600)
    search.restart()
    assert not search.return_to_configured()
    search.advance()
    assert search.return_to_configured()
    assert search.baud == 9600
