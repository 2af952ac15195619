"""The laser's health: status byte, status telegram and error list combined.

Source: SICK telegram listing 8007954/Q501, status byte, telegrams B1 and B2.
"""

from __future__ import annotations

from dataclasses import dataclass

from drivers.lms200.errors import ErrorEntry, Severity

_SEVERITY_BITS = 0x07
_IMPLAUSIBLE = 0x40
_POLLUTION = 0x80


@dataclass(frozen=True, slots=True)
class LaserHealth:
    """The laser's condition as it reports it.

    level: the status byte's severity.
    pollution: the front window is dirty. implausible: measured values are flagged implausible.
    defective: the status telegram's flag. errors: the error list, past entries too.
    """

    level: Severity
    pollution: bool = False
    implausible: bool = False
    defective: bool = False
    errors: tuple[ErrorEntry, ...] = ()

    @property
    def present_errors(self) -> tuple[ErrorEntry, ...]:
        """The entries that are still present and more severe than information."""
        return tuple(e for e in self.errors if e.present and e.severity != Severity.INFO)

    @property
    def ok(self) -> bool:
        """Whether there is no warning, error or flag; the level "info" is ok."""
        doubts = self.pollution or self.implausible or self.defective or self.present_errors
        return self.level <= Severity.INFO and not doubts

    @property
    def text(self) -> str:
        """The condition in one line for people, with what to do about it."""
        if self.ok:
            return "ok"
        findings = [error.text for error in self.present_errors]
        if self.pollution:
            findings.append("front window polluted: wipe it with a soft cloth")
        if self.implausible:
            findings.append("measured values implausible: is it dazzled or covered?")
        if self.defective:
            findings.append("laser says it is defective: switch it off and on, else have it mended")
        return "; ".join(findings or [f"status {self.level.name.lower()}"])


def health_of(status: int, errors: tuple[ErrorEntry, ...], *, defective: bool) -> LaserHealth:
    """Combine a telegram's status byte, the error list and the status telegram's defect flag."""
    return LaserHealth(
        level=Severity(min(status & _SEVERITY_BITS, Severity.FATAL)),
        pollution=bool(status & _POLLUTION),
        implausible=bool(status & _IMPLAUSIBLE),
        defective=defective,
        errors=errors,
    )


def status_byte(health: LaserHealth, device: int) -> int:
    """Return the status byte of a laser in this condition; ``device`` is its type, bits 3-4."""
    flags = health.pollution * _POLLUTION | health.implausible * _IMPLAUSIBLE
    return device | flags | health.level
