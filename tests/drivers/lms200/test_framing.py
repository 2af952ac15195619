"""Frames of the LMS 200: the documented vectors, the CRC, noise."""

from __future__ import annotations

import timeit

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.lms200.framing import (
    HOST_ADDRESSES,
    LASER_ADDRESSES,
    MAX_PAYLOAD,
    Ack,
    Nak,
    Telegram,
    TelegramFramer,
    crc16,
    encode_telegram,
)

TO_LASER = [
    "02 00 01 00 10 34 12",
    "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5",
    "02 00 02 00 20 10 00 08",
    "02 00 02 00 20 24 34 08",
    "02 00 02 00 20 25 35 08",
    "02 00 02 00 20 2A 3A 08",
    "02 00 02 00 20 40 50 08",
    "02 00 02 00 20 41 51 08",
    "02 00 02 00 20 42 52 08",
    "02 00 02 00 20 48 58 08",
    "02 00 02 00 30 01 31 18",
    "02 00 01 00 31 15 12",
    "02 00 01 00 32 16 12",
    "02 00 01 00 3A 1E 12",
    "02 00 01 00 74 50 12",
    "02 00 05 00 3B B4 00 64 00 97 49",
    "02 00 05 00 3B B4 00 32 00 3B 1F",
    "02 00 05 00 3B B4 00 00 00 5F 2D",
    "02 00 05 00 3B 64 00 64 00 1D 0F",
    "02 00 05 00 3B 64 00 32 00 B1 59",
    "02 00 05 00 3B 64 00 19 00 E7 72",
    "02 00 02 00 66 00 9C 4E",
    "02 00 02 00 66 01 9D 4E",
    "02 00 06 00 20 27 01 00 B5 00 12 09",
    "02 00 06 00 20 27 1B 00 2B 01 FF FE",
    "02 00 0A 00 20 30 53 49 43 4B 5F 4C 4D 53 EE F5",
    "02 00 23 00 77 00 00 46 00 00 00 01 00 00 02 02 02 00 00 0A 0A 50 64 00 0A 0A 50 80 00 0A 0A"
    " 50 64 00 00 00 00 02 00 7B 4B",
    "02 00 08 00 77 00 00 46 00 00 00 01 A0 4F",
    "02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02" + " 00" * 21 + " 5B 51",
]
FROM_LASER = [
    "02 80 03 00 A0 00 10 16 0A",
    "02 80 07 00 BB 01 B4 00 32 00 10 03 9D",
    "02 80 07 00 BB 01 B4 00 64 00 10 5B 30",
    "02 80 02 00 92 10 7F 33",
    "02 80 02 00 91 10 79 30",
    "02 80 02 00 B2 10 3F 13",
    "02 80 0A 00 B0 03 40 E8 03 C4 09 FF 1F 10 26 28",
    "02 80 6E 01 B0 B5 40" + " E8 03" * 181 + " 10 95 6D",
    "02 80 D6 02 B0 69 41" + " E8 03" * 361 + " 10 55 F1",
]
VECTORS = [(frame, HOST_ADDRESSES) for frame in TO_LASER]
VECTORS += [(frame, LASER_ADDRESSES) for frame in FROM_LASER]

POWER_ON = bytes.fromhex("90") + b"LMS200;301063;V02.10 " + bytes.fromhex("10")


def shift_register_crc(data: bytes) -> int:
    crc = previous = 0
    for byte in data:
        crc = ((crc << 1) & 0xFFFF) ^ (0x8005 if crc & 0x8000 else 0)
        crc ^= byte | previous << 8
        previous = byte
    return crc


def telegrams_in(items: list[Telegram | Ack | Nak]) -> list[bytes]:
    return [item.payload for item in items if isinstance(item, Telegram)]


def test_crc_matches_the_worked_example_after_each_byte() -> None:
    frame = bytes.fromhex("02 00 02 00 20 24")
    steps = [crc16(frame[:end]) for end in range(1, 7)]
    assert steps == [0x0002, 0x0204, 0x040A, 0x0A14, 0x1408, 0x0834]


@given(st.binary(max_size=812))
def test_crc_equals_the_shift_register(data: bytes) -> None:
    assert crc16(data) == shift_register_crc(data)


def test_power_on_example_has_the_computed_crc() -> None:
    assert encode_telegram(POWER_ON, 0x80)[-2:] == bytes.fromhex("63 5E")


@pytest.mark.parametrize(("text", "addresses"), VECTORS)
def test_documented_vector_is_encoded_and_decoded(text: str, addresses: range) -> None:
    frame = bytes.fromhex(text)
    payload, address = frame[4:-2], frame[1]
    assert encode_telegram(payload, address) == frame

    whole = TelegramFramer(addresses)
    assert whole.feed(frame) == [Telegram(address, payload)]
    assert whole.counters.good == 1
    assert whole.counters.discarded_bytes == 0

    bytewise = TelegramFramer(addresses)
    for byte in frame[:-1]:
        assert bytewise.feed(bytes((byte,))) == []
    assert bytewise.feed(frame[-1:]) == [Telegram(address, payload)]

    twice = TelegramFramer(addresses)
    noise = b"\xff\x00\x03"
    found = twice.feed(noise + frame + frame + noise)
    assert telegrams_in(found) == [payload, payload]
    assert twice.counters.discarded_bytes == 6

    spoiled = TelegramFramer(addresses)
    wrong = frame[:-1] + bytes((frame[-1] ^ 1,))
    items = spoiled.feed(wrong) + spoiled.flush() + spoiled.feed(frame)
    assert telegrams_in(items) == [payload]
    assert spoiled.counters.bad_checksum >= 1


def test_ack_and_nak_before_a_reply_are_found() -> None:
    reply = encode_telegram(b"\xa0\x00\x10", 0x80)
    found = TelegramFramer().feed(b"\x15\x06" + reply)
    assert found == [Nak(), Ack(), Telegram(0x80, b"\xa0\x00\x10")]


def test_search_resumes_behind_the_failed_start_byte() -> None:
    reply = encode_telegram(b"\xa0\x00\x10", 0x80)
    hiding = bytes((0x02, 0x80, len(reply), 0x00)) + reply + b"\x00\x00"
    framer = TelegramFramer()
    assert framer.feed(hiding) == [Telegram(0x80, b"\xa0\x00\x10", bytes_after=2)]
    assert framer.counters.bad_checksum == 1


def test_flush_returns_telegrams_behind_an_incomplete_one() -> None:
    reply = encode_telegram(b"\xa0\x00\x10", 0x80)
    framer = TelegramFramer()
    assert framer.feed(bytes((0x02, 0x80, 0x00, 0x02)) + reply) == []
    assert framer.pending
    assert telegrams_in(framer.flush()) == [b"\xa0\x00\x10"]
    assert not framer.pending


def test_telegrams_with_other_addresses_are_ignored() -> None:
    assert telegrams_in(TelegramFramer(LASER_ADDRESSES).feed(encode_telegram(b"\x31"))) == []
    assert TelegramFramer(HOST_ADDRESSES).feed(encode_telegram(b"\xb2\x10", 0x80)) == []


def test_bytes_behind_a_telegram_are_counted() -> None:
    first, second = encode_telegram(b"\xa0\x00\x10", 0x80), encode_telegram(b"\xb2\x10", 0x80)
    found = TelegramFramer().feed(first + second)
    assert [item.bytes_after for item in found if isinstance(item, Telegram)] == [len(second), 0]


@pytest.mark.parametrize("length", [0, MAX_PAYLOAD + 1])
def test_invalid_lengths_are_refused(length: int) -> None:
    with pytest.raises(ValueError, match="1 to 808"):
        encode_telegram(bytes(length))


@given(st.lists(st.binary(max_size=60), max_size=20))
def test_arbitrary_bytes_are_counted_and_do_not_raise(chunks: list[bytes]) -> None:
    framer = TelegramFramer()
    items = [item for chunk in chunks for item in framer.feed(chunk)] + framer.flush()
    taken = sum(i.wire_length if isinstance(i, Telegram) else 1 for i in items)
    assert taken + framer.counters.discarded_bytes == sum(map(len, chunks))


@given(
    st.lists(st.binary(min_size=1, max_size=40), min_size=1, max_size=5),
    st.binary(max_size=30),
    st.integers(1, 17),
)
def test_telegrams_survive_noise_and_cutting(payloads: list[bytes], noise: bytes, cut: int) -> None:
    stream = noise + b"".join(encode_telegram(payload, 0x80) for payload in payloads)
    framer = TelegramFramer()
    items = [i for at in range(0, len(stream), cut) for i in framer.feed(stream[at : at + cut])]
    found = telegrams_in(items + framer.flush())
    assert found[-len(payloads) :] == payloads
    assert framer.counters.good == len(found)


def test_frame_is_decoded_fast() -> None:
    frame = bytes.fromhex(FROM_LASER[7])
    framer = TelegramFramer()
    seconds = min(timeit.repeat(lambda: framer.feed(frame), number=50, repeat=5)) / 50
    assert seconds < 1e-3  # measured: some 5 us


SCAN = encode_telegram(b"\xb0\xb5\x40" + b"\xe8\x03" * 181 + b"\x10", 0x80)
REPLY = encode_telegram(b"\xa0\x00\x10", 0x80)


@pytest.mark.parametrize("sent", [4, 5, 100, len(SCAN) - 20])
def test_reply_is_found_in_the_frame_that_was_broken_off_for_it(sent: int) -> None:
    framer = TelegramFramer()
    assert framer.feed(SCAN[:sent] + b"\x06" + REPLY[:-1]) in ([], [Ack()])
    assert framer.break_off() == []
    items = framer.feed(REPLY[-1:]) + framer.break_off()
    assert [i.payload for i in items if isinstance(i, Telegram)] == [b"\xa0\x00\x10"]
    assert not framer.pending
    assert framer.counters.discarded_bytes == 0


def test_ack_alone_counts_after_a_silence_only() -> None:
    framer = TelegramFramer()
    framer.feed(SCAN[:100] + b"\x06")
    assert framer.break_off() == []
    assert framer.break_off(silent=True) == [Ack()]
    assert not framer.pending


def test_frame_that_is_only_slow_is_not_broken_off() -> None:
    framer = TelegramFramer()
    framer.feed(SCAN[:100])
    assert framer.break_off() == framer.break_off(silent=True) == []
    (whole,) = framer.feed(SCAN[100:])
    assert isinstance(whole, Telegram)


@given(
    st.lists(st.one_of(st.binary(max_size=60), st.just(SCAN[:40] + b"\x06" + REPLY)), max_size=20)
)
def test_breaking_off_never_raises_nor_invents_bytes(chunks: list[bytes]) -> None:
    framer = TelegramFramer()
    items = []
    for number, chunk in enumerate(chunks):
        items += framer.feed(chunk) + framer.break_off(silent=number % 3 == 0)
    taken = sum(i.wire_length if isinstance(i, Telegram) else 1 for i in items)
    assert taken + framer.counters.discarded_bytes <= sum(map(len, chunks))
