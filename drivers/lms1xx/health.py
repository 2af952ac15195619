"""The scanner's health: the status in its scans and the state of its front window.

Source: SICK "Telegram Listing" 8014631, device status and LCMstate.
"""

from __future__ import annotations

from dataclasses import dataclass

from drivers.lms1xx import measurement
from drivers.lms1xx.telegrams import Contamination


@dataclass(frozen=True, slots=True)
class LaserHealth:
    """The scanner's condition as it reports it. error: of the device, in its last scan."""

    error: bool = False
    contamination: Contamination = Contamination.NONE

    @property
    def pollution(self) -> bool:
        """Whether the front window is dirty."""
        return self.contamination in (Contamination.WARNING, Contamination.ERROR)

    @property
    def ok(self) -> bool:
        """Whether there is neither error nor warning."""
        return not self.error and self.contamination is Contamination.NONE

    @property
    def text(self) -> str:
        """The condition in one line for people, with what to do about it."""
        findings = []
        if self.error:
            findings.append("laser reports an error: switch it off and on, else have it mended")
        if self.pollution:
            level = self.contamination.name.lower()
            findings.append(f"front window polluted ({level}): wipe it with a soft cloth")
        if self.contamination is Contamination.DEFECT:
            findings.append("laser cannot measure how dirty its window is: have it mended")
        return "; ".join(findings) or "ok"


def health_of(status: int, contamination: Contamination = Contamination.NONE) -> LaserHealth:
    """Combine a scan's status with what the scanner last said of its window: the worse counts."""
    if status & measurement.STATUS_CONTAMINATION_ERROR:
        contamination = max(contamination, Contamination.ERROR)
    elif status & measurement.STATUS_CONTAMINATION_WARNING:
        contamination = max(contamination, Contamination.WARNING)
    return LaserHealth(bool(status & measurement.STATUS_ERROR), contamination)


def status_of(health: LaserHealth) -> int:
    """Return the status in the scans of a scanner in this condition."""
    dirty = {
        Contamination.WARNING: measurement.STATUS_CONTAMINATION_WARNING,
        Contamination.ERROR: measurement.STATUS_CONTAMINATION_ERROR,
    }
    return health.error * measurement.STATUS_ERROR | dirty.get(health.contamination, 0)
