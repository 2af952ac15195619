from __future__ import annotations

import pytest

from drivers.lms200.errors import ErrorEntry, Severity, decode_errors, encode_errors
from drivers.lms200.framing import Telegram


def telegram(payload: bytes) -> Telegram:
    return Telegram(0x80, payload)


def test_no_pair_is_no_error() -> None:
    assert decode_errors(telegram(bytes.fromhex("B2 10"))) == ()
    assert encode_errors(()) == bytes.fromhex("B2 10")


def test_pairs_are_type_and_number_with_a_bit_for_the_past() -> None:
    entries = (
        ErrorEntry(Severity.WARNING, 17, present=True),
        ErrorEntry(Severity.FATAL, 57, present=False),
        ErrorEntry(9, 200, present=True),
    )
    payload = bytes.fromhex("B2 02 11 84 39 09 C8 10")
    assert decode_errors(telegram(payload)) == entries
    assert encode_errors(entries) == payload


def test_half_a_pair_is_left_out() -> None:
    assert decode_errors(telegram(bytes.fromhex("B2 02 11 03 10"))) == (
        ErrorEntry(Severity.WARNING, 17, present=True),
    )


@pytest.mark.parametrize(
    ("entry", "text"),
    [
        (ErrorEntry(2, 17, present=True), "warning 17: front window polluted"),
        (ErrorEntry(4, 57, present=False), "fatal 57: no zero index (past)"),
        (ErrorEntry(3, 99, present=True), "error 99: not in the listing"),
        (ErrorEntry(9, 29, present=True), "type 9 29: motor speed"),
    ],
)
def test_entries_are_told_in_words(entry: ErrorEntry, text: str) -> None:
    assert entry.text == text
