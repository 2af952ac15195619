from __future__ import annotations

import pytest

from drivers.lms200.exchange import ACK_LIMIT, NAK_PAUSE, TRIES, Exchange
from drivers.lms200.framing import TelegramFramer, encode_telegram

REPLY = encode_telegram(b"\xa0\x00\x10", 0x80)


def begun() -> tuple[Exchange, TelegramFramer]:
    framer = TelegramFramer()
    exchange = Exchange(framer)
    exchange.begin(b"\x20\x25", 3.0)
    return exchange, framer


def test_command_is_framed_and_tries_are_limited() -> None:
    exchange, _ = begun()
    assert exchange.tries_left == TRIES
    for left in range(TRIES - 1, -1, -1):
        assert exchange.send(1.0, 9600) == encode_telegram(b"\x20\x25")
        assert exchange.tries_left == left


def test_deadline_follows_ack_and_nak() -> None:
    exchange, _ = begun()
    exchange.send(1.0, 9600)
    assert exchange.deadline == 1.0 + ACK_LIMIT
    exchange.acknowledged(1.1)
    assert exchange.deadline == pytest.approx(4.1)
    exchange.refused(1.2)
    assert exchange.deadline == pytest.approx(1.2 + NAK_PAUSE)


def test_incoming_bytes_extend_the_deadline_by_one_frame_at_most() -> None:
    exchange, _ = begun()
    exchange.send(1.0, 9600)
    for step in range(30):
        exchange.on_bytes(1.0 + 0.1 * step)
    assert exchange.deadline == pytest.approx(1.0 + ACK_LIMIT + 814 * 10 / 9600)


def test_noise_is_distinguished_from_silence_and_telegrams() -> None:
    exchange, framer = begun()
    framer.feed(b"\xff")
    exchange.send(1.0, 9600)
    assert not exchange.amid_noise
    assert not exchange.only_noise
    framer.feed(b"\xff\x03")
    assert exchange.amid_noise
    assert exchange.only_noise
    framer.feed(REPLY)
    assert exchange.amid_noise
    assert not exchange.only_noise


def test_incomplete_telegram_alone_counts_as_noise() -> None:
    exchange, framer = begun()
    exchange.send(1.0, 9600)
    framer.feed(REPLY[:5])
    assert exchange.only_noise
    assert not exchange.amid_noise
