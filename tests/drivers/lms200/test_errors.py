from __future__ import annotations

import pytest

from drivers.lms200.errors import ErrorEntry, Severity, decode_errors, encode_errors
from drivers.lms200.framing import Telegram


def telegram(payload: bytes) -> Telegram:
    return Telegram(0x80, payload)


def test_empty_list_has_no_entries() -> None:
    assert decode_errors(telegram(bytes.fromhex("B2 10"))) == ()
    assert encode_errors(()) == bytes.fromhex("B2 10")


def test_pairs_decode_to_type_number_and_presence() -> None:
    entries = (
        ErrorEntry(Severity.WARNING, 17, present=True),
        ErrorEntry(Severity.FATAL, 57, present=False),
        ErrorEntry(9, 200, present=True),
    )
    payload = bytes.fromhex("B2 02 11 84 39 09 C8 10")
    assert decode_errors(telegram(payload)) == entries
    assert encode_errors(entries) == payload


def test_incomplete_pair_is_ignored() -> None:
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
def test_entries_have_texts(entry: ErrorEntry, text: str) -> None:
    assert entry.text == text
