from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.lms1xx.fields import FieldError, FieldReader, FieldWriter, fields_of
from drivers.lms1xx.framing import Dialect, Telegram


def reader(dialect: Dialect, data: bytes) -> FieldReader:
    return fields_of(Telegram(dialect, b"sRA x " + data))


@pytest.mark.parametrize("dialect", Dialect)
@given(
    small=st.integers(0, 0xFF),
    number=st.integers(-(1 << 31), (1 << 31) - 1),
    text=st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=20),
    counts=st.lists(st.integers(0, 0xFFFF), max_size=20),
)
def test_fields_come_back(
    dialect: Dialect, small: int, number: int, text: str, counts: list[int]
) -> None:
    writer = FieldWriter("sRA x", dialect).unsigned(small, 1).signed(number, 4).text(text)
    writer.values(np.array(counts, dtype=np.uint16), 2).real(0.1).fixed_text("DIST1")
    fields = fields_of(Telegram(dialect, writer.payload))
    assert fields.unsigned(1) == small
    assert fields.signed(4) == number
    assert fields.text() == text
    assert fields.values(len(counts), 2).tolist() == counts
    assert fields.real() == pytest.approx(0.1)
    assert fields.fixed_text(5) == "DIST1"
    with pytest.raises(FieldError):
        fields.unsigned(1)


@pytest.mark.parametrize(
    ("written", "number"),
    [(b"+5000", 5000), (b"-450000", -450000), (b"FFF92230", -450000), (b"1388", 5000), (b"0", 0)],
)
def test_text_has_decimal_numbers_with_a_sign_and_hexadecimal_ones_without(
    written: bytes, number: int
) -> None:
    assert reader(Dialect.A, written).signed(4) == number


@pytest.mark.parametrize(
    "written", [b"", b"G", b"123456789", b"0x10", b"1_0", b"+", b"+9999999999"]
)
def test_text_that_is_no_number_of_that_size_is_refused(written: bytes) -> None:
    with pytest.raises(FieldError):
        reader(Dialect.A, written).signed(4)


@pytest.mark.parametrize("written", [b"1 2", b"1 2  3", b"1 2 12345", b"1 2 x", b"1 2 \xc3\xa4"])
def test_values_other_than_announced_are_refused(written: bytes) -> None:
    with pytest.raises(FieldError):
        reader(Dialect.A, written).values(3, 2)


@pytest.mark.parametrize(
    ("dialect", "written"), [(Dialect.A, b"7FC00000"), (Dialect.B, b"\x7f\xc0\0\0")]
)
def test_a_real_number_may_be_none(dialect: Dialect, written: bytes) -> None:
    assert math.isnan(reader(dialect, written).real())
