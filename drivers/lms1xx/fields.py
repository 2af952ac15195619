"""The fields of a telegram, read and written alike in both dialects.

CoLa A writes numbers as hexadecimal text between spaces, real ones by their IEEE 754 bits; a host
may write decimal ones with a sign. CoLa B sends them big-endian. Source: SICK "Telegram Listing"
8014631, variable types.
"""

from __future__ import annotations

import re
import struct
from binascii import unhexlify
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.lms1xx.framing import Dialect, Telegram

_HEX = re.compile(rb"[0-9A-Fa-f]{1,8}")
_DECIMAL = re.compile(rb"[+-][0-9]{1,10}")
_DTYPES: dict[int, str] = {1: "u1", 2: ">u2"}


class FieldError(ValueError):
    """A telegram ends too early or a field is not what it should be."""


class FieldReader(Protocol):
    """Takes one field after another; every method raises FieldError where there is none."""

    def unsigned(self, size: int) -> int:
        """Take an unsigned number of ``size`` bytes."""

    def signed(self, size: int) -> int:
        """Take a signed number of ``size`` bytes."""

    def real(self) -> float:
        """Take a number of four bytes, IEEE 754; it may be nan."""

    def fixed_text(self, size: int) -> str:
        """Take a text of ``size`` characters without spaces."""

    def text(self) -> str:
        """Take a text that begins with its length."""

    def values(self, count: int, size: int) -> NDArray[np.integer]:
        """Take ``count`` unsigned numbers of ``size`` bytes, 1 or 2: (count,)."""


class AsciiReader:
    """Fields of CoLa A."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def _token(self) -> bytes:
        if self._at >= len(self._data):
            raise FieldError("the telegram ends")
        end = self._data.find(b" ", self._at)
        end = len(self._data) if end < 0 else end
        token = self._data[self._at : end]
        self._at = end + 1
        return token

    def _bits(self, size: int) -> int:
        """Return a hexadecimal number of at most ``size`` bytes."""
        token = self._token()
        if not _HEX.fullmatch(token) or len(token) > 2 * size:
            raise FieldError("not a hexadecimal number of that size")
        return int(token, 16)

    def unsigned(self, size: int) -> int:
        """Take an unsigned number of ``size`` bytes."""
        return self.signed(size) % (1 << 8 * size)

    def signed(self, size: int) -> int:
        """Take a signed number of ``size`` bytes, or an unsigned one with its highest bit clear."""
        before = self._at
        token = self._token()
        if _DECIMAL.fullmatch(token):
            number = int(token)
            if not -(1 << 8 * size - 1) <= number < 1 << 8 * size:
                raise FieldError("a number too large")
            return number
        self._at = before
        bits = self._bits(size)
        return bits - (1 << 8 * size) if bits >> (8 * size - 1) else bits

    def real(self) -> float:
        """Take a number of four bytes, IEEE 754; it may be nan."""
        number: float = struct.unpack(">f", self._bits(4).to_bytes(4, "big"))[0]
        return number

    def fixed_text(self, size: int) -> str:
        """Take a text of ``size`` characters without spaces."""
        token = self._token()
        if len(token) != size:
            raise FieldError("a text of another length")
        return token.decode("ascii", errors="replace")

    def text(self) -> str:
        """Take a text that begins with its length."""
        size = self.unsigned(2)
        found = self._data[self._at : self._at + size]
        if len(found) != size:
            raise FieldError("the telegram ends in a text")
        self._at += size + 1
        return found.decode("ascii", errors="replace")

    def values(self, count: int, size: int) -> NDArray[np.integer]:
        """Take ``count`` unsigned numbers of ``size`` bytes, 1 or 2: (count,)."""
        if not count:
            return np.empty(0, _DTYPES[size])
        tokens = self._data[self._at :].split(b" ", count)[:count]
        width = 2 * size
        joined = b"".join([token.rjust(width, b"0") for token in tokens])
        if len(tokens) != count or len(joined) != count * width or b"" in tokens:
            raise FieldError("other values than announced")
        try:
            bits = unhexlify(joined)
        except ValueError as error:
            raise FieldError("values that are no hexadecimal numbers") from error
        self._at += sum(map(len, tokens)) + count
        return np.frombuffer(bits, _DTYPES[size])


class BinaryReader:
    """Fields of CoLa B."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def _take(self, size: int) -> bytes:
        found = self._data[self._at : self._at + size]
        if len(found) != size:
            raise FieldError("the telegram ends")
        self._at += size
        return found

    def unsigned(self, size: int) -> int:
        """Take an unsigned number of ``size`` bytes."""
        return int.from_bytes(self._take(size), "big")

    def signed(self, size: int) -> int:
        """Take a signed number of ``size`` bytes."""
        return int.from_bytes(self._take(size), "big", signed=True)

    def real(self) -> float:
        """Take a number of four bytes, IEEE 754; it may be nan."""
        number: float = struct.unpack(">f", self._take(4))[0]
        return number

    def fixed_text(self, size: int) -> str:
        """Take a text of ``size`` characters."""
        return self._take(size).decode("ascii", errors="replace")

    def text(self) -> str:
        """Take a text that begins with its length."""
        return self.fixed_text(self.unsigned(2))

    def values(self, count: int, size: int) -> NDArray[np.integer]:
        """Take ``count`` unsigned numbers of ``size`` bytes, 1 or 2: (count,)."""
        return np.frombuffer(self._take(count * size), _DTYPES[size])


def fields_of(telegram: Telegram) -> FieldReader:
    """Return a reader of the fields behind a telegram's command."""
    reader = AsciiReader if telegram.dialect is Dialect.A else BinaryReader
    return reader(telegram.data)


class FieldWriter:
    """Writes a telegram's command and fields in one dialect; ``payload`` is the result."""

    def __init__(self, command: str, dialect: Dialect) -> None:
        self._dialect = dialect
        self._parts = [command.encode("ascii", errors="replace")]

    @property
    def payload(self) -> bytes:
        """Command and fields, to be framed."""
        if self._dialect is Dialect.A:
            return b" ".join(self._parts)
        # The space after the command is there also without any field, but for a host's commands.
        head, *fields = self._parts
        return head + b" " + b"".join(fields) if fields or head[2:3] == b"A" else head

    def unsigned(self, number: int, size: int) -> FieldWriter:
        """Add an unsigned number of ``size`` bytes."""
        self._parts.append(
            b"%X" % number if self._dialect is Dialect.A else number.to_bytes(size, "big")
        )
        return self

    def signed(self, number: int, size: int) -> FieldWriter:
        """Add a signed number of ``size`` bytes."""
        return self.unsigned(number % (1 << 8 * size), size)

    def real(self, number: float) -> FieldWriter:
        """Add a number of four bytes, IEEE 754."""
        return self.unsigned(int.from_bytes(struct.pack(">f", number), "big"), 4)

    def fixed_text(self, text: str) -> FieldWriter:
        """Add a text whose length the reader knows."""
        self._parts.append(text.encode("ascii", errors="replace"))
        return self

    def text(self, text: str) -> FieldWriter:
        """Add a text with its length before it."""
        return self.unsigned(len(text), 2).fixed_text(text)

    def values(self, numbers: NDArray[np.integer], size: int) -> FieldWriter:
        """Add unsigned numbers (n,) of ``size`` bytes, 1 or 2."""
        if self._dialect is Dialect.A:
            self._parts += [b"%X" % number for number in numbers.tolist()]
        else:
            self._parts.append(numbers.astype(_DTYPES[size]).tobytes())
        return self
