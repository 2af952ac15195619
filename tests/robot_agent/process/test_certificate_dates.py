"""Certificates refused for their dates, and unset clocks, are told with the remedy."""

from __future__ import annotations

import datetime
import time
from pathlib import Path

import pytest

from robot_agent.process.certificate_dates import (
    CertificateDates,
    CertificateError,
    first_trouble,
    read_dates,
)
from robot_agent.process.wall_clock import clock_trouble
from tools.deploy.certificates import make_keys

DAY_S = 86400.0


def wall(year: int, month: int = 1, day: int = 1) -> float:
    return datetime.datetime(year, month, day, tzinfo=datetime.UTC).timestamp()


def test_certificates_are_valid_from_1970_for_clocks_that_are_not_set(tmp_path: Path) -> None:
    make_keys(tmp_path, "north", ["anna"], ["127.0.0.1"], days=100)
    now = datetime.datetime.now(datetime.UTC).timestamp()
    for party in ("anna", "operator"):
        dates = read_dates(tmp_path / party)
        assert [each.begins.timestamp() for each in dates] == [0.0, 0.0]
        assert first_trouble(dates, 4.0) == ""
        assert first_trouble(dates, now + 99 * DAY_S) == ""
        assert "ca.pem was valid until" in first_trouble(dates, now + 101 * DAY_S)


def test_dates_after_2049_are_read(tmp_path: Path) -> None:
    make_keys(tmp_path, "north", ["anna"], ["127.0.0.1"], days=36_500)
    assert read_dates(tmp_path / "anna")[1].ends.year > 2100


def test_trouble_names_both_dates_and_the_remedy() -> None:
    begins, ends = (datetime.datetime(year, 3, 1, tzinfo=datetime.UTC) for year in (2026, 2036))
    dates = CertificateDates(Path("certificate.pem"), begins, ends)
    assert dates.trouble(wall(2026, 3, 2)) == dates.trouble(wall(2036, 2, 28)) == ""
    early, late = dates.trouble(wall(1970)), dates.trouble(wall(2036, 4, 1))
    assert "valid from 2026-03-01 on, and this computer's clock says 1970-01-01: set" in early
    assert "valid until 2036-03-01, and this computer's clock says 2036-04-01" in late
    assert "make new certificates for all with `patrol keys`" in late
    assert dates.ends_soon(wall(2036, 1, 15)) == dates.ends_soon(wall(2036, 4, 1)) == ""
    assert "valid until 2036-03-01 only" in dates.ends_soon(wall(2036, 2, 15))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "cannot be read"),
        (b"nothing", "holds no certificate"),
        (b"-----BEGIN CERTIFICATE-----\nMAMCAQE=\n-----END CERTIFICATE-----", "is no certificate"),
        (b"-----BEGIN CERTIFICATE-----\nM\n-----END CERTIFICATE-----", "is no certificate"),
    ],
)
def test_files_that_are_no_certificates_are_one_error(
    tmp_path: Path, content: bytes | None, words: str
) -> None:
    if content is not None:
        (tmp_path / "ca.pem").write_bytes(content)
    with pytest.raises(CertificateError, match=rf"ca\.pem.*{words}"):
        read_dates(tmp_path)


def test_clock_before_this_program_is_not_set() -> None:
    assert clock_trouble(wall(2026), installed=wall(2026)) == ""
    assert clock_trouble(40.0).startswith("the clock is not set, it says 1970: times are wrong; ")
    assert clock_trouble(40.0) == clock_trouble(3000.0), "told once"


def test_clock_before_the_programs_installation_is_not_set() -> None:
    assert clock_trouble(wall(2027), installed=wall(2026)) == ""
    assert clock_trouble(wall(2026), installed=wall(2027)).startswith(
        "the clock is not set, it says 2026-01-01, and this program was installed on 2027-01-01: "
    )
    assert clock_trouble(time.time()) == ""
