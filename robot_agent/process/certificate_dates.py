"""When certificates are valid, by this computer's clock.

Robots have no clock battery: a certificate that is refused for its dates looks like an operator who
is absent, so the dates are read and told here. The robot has no library for certificates; of their
encoding (X.509 in DER) this reads only the way to the two dates.
"""

from __future__ import annotations

import base64
import binascii
import datetime
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

SOON = datetime.timedelta(days=30)
"""Time before its end from which a certificate is told to end soon."""

_PEM = re.compile(rb"-----BEGIN CERTIFICATE-----(.*?)-----END CERTIFICATE-----", re.DOTALL)
_VERSION, _SHORT_YEAR = 0xA0, 0x17
_VALIDITY = 3
"""Place of the dates in a certificate, behind serial number, algorithm and issuer."""


class CertificateError(ValueError):
    """A file is no readable certificate; the message names it."""


@dataclass(frozen=True, slots=True)
class CertificateDates:
    """Dates of one certificate, UTC."""

    path: Path
    begins: datetime.datetime
    ends: datetime.datetime

    def trouble(self, wall: float) -> str:
        """Return why it is invalid at wall, s since 1970, with the remedy; empty if it is not."""
        now = _date(wall)
        if now < self.begins:
            return (
                f"{self.path} is valid from {self.begins:%Y-%m-%d} on, and this computer's clock "
                f"says {now:%Y-%m-%d}: set the clock (`sudo date -s ...`)"
            )
        if now > self.ends:
            return (
                f"{self.path} was valid until {self.ends:%Y-%m-%d}, and this computer's clock says "
                f"{now:%Y-%m-%d}: set the clock if that is wrong, else make new certificates for "
                "all with `patrol keys` in a new folder"
            )
        return ""

    def ends_soon(self, wall: float) -> str:
        """Return that the certificate ends within SOON, with remedy; empty if not."""
        if self.trouble(wall) or self.ends - _date(wall) > SOON:
            return ""
        return (
            f"{self.path} is valid until {self.ends:%Y-%m-%d} only: make new certificates for all "
            "with `patrol keys` in a new folder"
        )


def read_dates(keys: Path) -> list[CertificateDates]:
    """Return the dates of the certificates in a folder of ``patrol keys``, the authority's first.

    Raises CertificateError for one that cannot be read.
    """
    return [_read(keys / name) for name in ("ca.pem", "certificate.pem")]


def first_trouble(certificates: Sequence[CertificateDates], wall: float) -> str:
    """Return the trouble of the first invalid certificate at wall, s since 1970; empty for none."""
    return next(filter(None, (each.trouble(wall) for each in certificates)), "")


def _read(path: Path) -> CertificateDates:
    try:
        found = _PEM.search(path.read_bytes())
        if found is None:
            raise CertificateError(f"{path}: holds no certificate")
        body = next(_elements(next(_elements(base64.b64decode(found[1])))[1]))[1]
        fields = [content for tag, content in _elements(body) if tag != _VERSION]
        begins, ends = (_parse(tag, content) for tag, content in _elements(fields[_VALIDITY]))
    except OSError as error:
        raise CertificateError(f"{path}: cannot be read ({error.strerror})") from error
    except (binascii.Error, IndexError, StopIteration) as error:
        raise CertificateError(f"{path}: is no certificate") from error
    return CertificateDates(path, begins, ends)


def _elements(der: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield tag and content of each element."""
    at = 0
    while at < len(der):
        tag, length = der[at], der[at + 1]
        at += 2
        if length & 0x80:
            size = length & 0x7F
            length = int.from_bytes(der[at : at + size], "big")
            at += size
        yield tag, der[at : at + length]
        at += length


def _parse(tag: int, text: bytes) -> datetime.datetime:
    """Return a date; one with two digits for the year is of 1950 to 2049."""
    digits = text.decode("ascii", "replace")
    if tag == _SHORT_YEAR:
        digits = ("19" if digits >= "5" else "20") + digits
    return datetime.datetime.strptime(digits, "%Y%m%d%H%M%SZ").replace(tzinfo=datetime.UTC)


def _date(wall: float) -> datetime.datetime:
    return datetime.datetime.fromtimestamp(wall, datetime.UTC)
