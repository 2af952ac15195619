"""Frames of both dialects, from examples of the listing, recordings' and our own."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.lms1xx.framing import (
    MAX_PAYLOAD,
    Dialect,
    Telegram,
    TelegramFramer,
    encode_telegram,
)

VECTORS = {
    "login, A": (
        b"\x02sMN SetAccessMode 03 F4724744\x03",
        Dialect.A,
        "sMN SetAccessMode",
        b"03 F4724744",
    ),
    "login, B": (
        bytes.fromhex("0202020200000017734d4e205365744163636573734d6f64652003f4724744b3"),
        Dialect.B,
        "sMN SetAccessMode",
        bytes.fromhex("03f4724744"),
    ),
    "without fields, A": (b"\x02sRN LMPscancfg\x03", Dialect.A, "sRN LMPscancfg", b""),
    "without fields, B": (
        bytes.fromhex("0202020200000007734d4e2052756e19"),
        Dialect.B,
        "sMN Run",
        b"",
    ),
    "spaces in the fields, B": (
        bytes.fromhex("0202020200000021735241204c4d506f757470757452616e676520")
        + bytes.fromhex("000100001388fff922330022550d86"),
        Dialect.B,
        "sRA LMPoutputRange",
        bytes.fromhex("000100001388fff922330022550d"),
    ),
}
GARBAGE = (b"\x00\xff", b"\x02", b"\x02\x02\x02", b"\x02\x02\x02\x02\x02", b"\x03", b"\x02sRA cut")


@pytest.mark.parametrize("vector", VECTORS.values(), ids=VECTORS)
@pytest.mark.parametrize("before", [b"", *GARBAGE])
@pytest.mark.parametrize("behind", [b"", *GARBAGE])
def test_a_vector_is_found_whole_and_byte_by_byte_amid_garbage(
    vector: tuple[bytes, Dialect, str, bytes], before: bytes, behind: bytes
) -> None:
    frame, dialect, command, data = vector
    stream = before + frame + behind
    whole, single = TelegramFramer(), TelegramFramer()
    found = whole.feed(stream) + whole.flush()
    one_by_one = [item for octet in stream for item in single.feed(bytes((octet,)))]
    one_by_one += single.flush()
    for telegrams in (found, one_by_one):
        (telegram,) = telegrams
        assert (telegram.dialect, telegram.command, telegram.data) == (dialect, command, data)
    assert found[0].bytes_after == len(behind)
    assert whole.counters == single.counters
    assert whole.counters.discarded_bytes == len(before) + len(behind)


@pytest.mark.parametrize("name", ["login, B", "without fields, B", "spaces in the fields, B"])
def test_binary_vectors_are_encoded_as_they_were_recorded(name: str) -> None:
    frame, dialect, _command, _data = VECTORS[name]
    (telegram,) = TelegramFramer().feed(frame)
    assert encode_telegram(telegram.payload, dialect) == frame


@pytest.mark.parametrize("dialect", Dialect)
@given(
    texts=st.lists(
        st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=30), max_size=5
    )
)
def test_frames_in_a_row_come_back(dialect: Dialect, texts: list[str]) -> None:
    payloads = [b"sRA x " + text.encode() for text in texts]
    stream = b"".join(encode_telegram(payload, dialect) for payload in payloads)
    framer = TelegramFramer()
    assert [telegram.payload for telegram in framer.feed(stream)] == payloads
    assert not framer.pending


def test_a_wrong_checksum_costs_that_frame_only() -> None:
    spoilt = bytearray(VECTORS["login, B"][0])
    spoilt[-1] ^= 1
    framer = TelegramFramer()
    (telegram,) = framer.feed(bytes(spoilt) + VECTORS["without fields, B"][0])
    assert telegram.command == "sMN Run"
    assert framer.counters.bad_checksum == 1


def test_a_text_that_begins_anew_costs_only_its_beginning() -> None:
    (telegram,) = TelegramFramer().feed(b"\x02sRA LMDscanda\x02sRA LMPscancfg 0\x03")
    assert telegram.command == "sRA LMPscancfg"


@pytest.mark.parametrize("start", [b"\x02s", b"\x02\x02\x02\x02\x00\x00\xff\xffsRA"])
def test_at_most_one_frame_is_kept(start: bytes) -> None:
    framer = TelegramFramer()
    framer.feed(start)
    for _ in range(5):
        framer.feed(b"A" * 50_000)
    assert framer.counters.discarded_bytes > 250_000 - MAX_PAYLOAD


@pytest.mark.parametrize("length", [0, MAX_PAYLOAD + 1])
def test_what_cannot_be_framed_is_refused(length: int) -> None:
    with pytest.raises(ValueError, match=str(MAX_PAYLOAD)):
        encode_telegram(b"s" * length, Dialect.B)


def test_a_telegram_without_a_space_has_neither_name_nor_data() -> None:
    telegram = Telegram(Dialect.B, b"sFA\x00\x0a")
    assert (telegram.command, telegram.data) == ("sFA\x00\n", b"")
