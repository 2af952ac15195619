"""Tells that the operator's own certificates are not valid, or will not be soon."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

from robot_agent.process.certificate_dates import read_dates
from tools.monitor.alarm import Condition, Severity


class CertificateWatch:
    """Compares the dates of the operator's certificates with this computer's clock."""

    def __init__(self, keys: Path | None, wall: Callable[[], float] = time.time) -> None:
        """keys: the operator's folder; None: no certificates. Raises CertificateError."""
        self._certificates = [] if keys is None else read_dates(keys)
        self._wall = wall

    def conditions(self) -> Iterator[Condition]:
        """Yield a condition for each certificate that keeps robots out, now or soon."""
        wall = self._wall()
        for certificate in self._certificates:
            if words := certificate.trouble(wall):
                words = f"no robot can report: {words}"
                yield Condition("", f"keys {certificate.path.name}", Severity.CRITICAL, words)
            elif words := certificate.ends_soon(wall):
                yield Condition("", f"keys {certificate.path.name}", Severity.WARNING, words)
