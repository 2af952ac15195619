"""Tells that certificates of the monitor's own are not valid, or that others may read their key."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

from robot_agent.process.certificate_dates import read_dates
from robot_agent.process.key_rights import rights_trouble
from tools.monitor.alarm import Condition, Severity


class CertificateWatch:
    """Compares the dates of one folder's certificates with this computer's clock."""

    def __init__(
        self,
        keys: Path | None,
        wall: Callable[[], float] = time.time,
        consequence: str = "no robot can report",
    ) -> None:
        """keys: the folder; None: no certificates. Raises CertificateError.

        consequence: of certificates that are not valid, in words.
        """
        self._certificates = [] if keys is None else read_dates(keys)
        self._rights = "" if keys is None else rights_trouble(keys)
        self._wall = wall
        self._consequence = consequence

    def conditions(self) -> Iterator[Condition]:
        """Yield a condition for each certificate that is refused, now or soon, and for the key."""
        if self._rights:
            yield Condition("", "keys key.pem", Severity.WARNING, self._rights)
        wall = self._wall()
        for certificate in self._certificates:
            if words := certificate.trouble(wall):
                words = f"{self._consequence}: {words}"
                yield Condition("", f"keys {certificate.path.name}", Severity.CRITICAL, words)
            elif words := certificate.ends_soon(wall):
                yield Condition("", f"keys {certificate.path.name}", Severity.WARNING, words)
