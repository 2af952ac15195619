"""How an emulated laser is found: rate, variant, condition and pace, and the syntax for them."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.emulator.laser_state import POWER_ON_BAUD
from drivers.lms200.emulator.mirror import ReflectorSource, ScanSource
from drivers.lms200.errors import ErrorEntry, Severity
from drivers.lms200.framing import REPLY_BIT, encode_telegram
from drivers.lms200.telegrams import BAUD_MODES, SELECT_CONTINUOUS, VARIANTS, Variant

_EXAMPLE = "use e.g. baud=500000,variant=100:0.25,streaming,address=1,polluted,error=fatal:57,slow"
_ADDRESSES = range(1, 0x80)
_LARGEST_ERROR = 0xFF


class LaserStartError(ValueError):
    """A specification that cannot be used; the message names the part and a remedy."""


@dataclass(frozen=True, slots=True)
class LaserStart:
    """A laser as a client finds it.

    baud: the rate it is switched on at, None for 9600. variant: None for 180 degrees by 0.5.
    streaming: a client left it so. address: 1 to 127, in its replies with bit 7 set; 0 for none.
    polluted, errors: its condition. acknowledges: sends an ACK before each reply. slow: a mode
    change takes 2.8 s, writing its EEPROM 6 s, as long as the listing allows. paced: whether the
    line has a rate before one is ordered; a given ``baud`` is one.
    """

    baud: int | None = None
    variant: Variant | None = None
    streaming: bool = False
    address: int = 0
    polluted: bool = False
    errors: tuple[ErrorEntry, ...] = ()
    acknowledges: bool = True
    slow: bool = False
    paced: bool = True

    def make(
        self, scan_source: ScanSource, reflector_source: ReflectorSource, t: float
    ) -> Lms200Emulator:
        """Return such a laser, in this state at ``t`` (s)."""
        laser = Lms200Emulator(
            baud=self.baud or POWER_ON_BAUD,
            scan_source=scan_source,
            reflector_source=reflector_source,
            paced=self.paced or self.baud is not None,
        )
        laser.state.permanent_baud = self.baud or POWER_ON_BAUD
        laser.state.address = self.address
        if self.variant is not None:
            laser.state.variant = self.variant
        if self.streaming:
            laser.feed(encode_telegram(SELECT_CONTINUOUS), t)
        laser.polluted = self.polluted
        laser.acknowledges = self.acknowledges
        laser.slow = self.slow
        if self.errors:
            laser.set_errors(self.errors, t)
        return laser


def parse_laser_start(spec: str) -> LaserStart:
    """Parse ``name=value,name,...``; raises LaserStartError.

    baud=N, variant=DEG:STEP, streaming, address=N, polluted, error=SEVERITY:NUMBER, no-ack, slow.
    """
    start = LaserStart()
    for part in filter(None, (piece.strip() for piece in spec.split(","))):
        name, _, value = part.partition("=")
        start = _with(start, name.strip(), value.strip(), part)
    return start


def _with(start: LaserStart, name: str, value: str, part: str) -> LaserStart:
    if value and name in _VALUES:
        return replace(start, **_VALUES[name](value, part))
    if not value and name in _FLAGS:
        return replace(start, **_FLAGS[name])
    raise LaserStartError(f"laser state '{part}': no such state, or not its value; {_EXAMPLE}")


def _baud(value: str, part: str) -> dict[str, Any]:
    if not value.isdecimal() or int(value) not in BAUD_MODES:
        rates = ", ".join(map(str, sorted(BAUD_MODES)))
        raise LaserStartError(f"laser state '{part}': a laser has {rates} baud")
    return {"baud": int(value)}


def _address(value: str, part: str) -> dict[str, Any]:
    number = int(value, 0) if re.fullmatch(r"[1-9]\d*|0x[0-9a-f]+", value.lower()) else 0
    address = number & ~REPLY_BIT  # as in its replies will do
    if address not in _ADDRESSES:
        raise LaserStartError(f"laser state '{part}': an address is 1 to 127, or 0x81 to 0xFF")
    return {"address": address}


def _variant(value: str, part: str) -> dict[str, Any]:
    known = {f"{v.angle_deg}:{v.resolution_cdeg / 100:g}": v for v in VARIANTS}
    if value not in known:
        raise LaserStartError(f"laser state '{part}': a laser has {', '.join(known)}")
    return {"variant": known[value]}


def _error(value: str, part: str) -> dict[str, Any]:
    severity, _, number = value.partition(":")
    known = {level.name.lower(): level for level in Severity if level is not Severity.OK}
    if severity not in known or not number.isdecimal() or int(number) > _LARGEST_ERROR:
        raise LaserStartError(
            f"laser state '{part}': is not SEVERITY:NUMBER, of {', '.join(known)}"
        )
    return {"errors": (ErrorEntry(known[severity], int(number), present=True),)}


_VALUES: dict[str, Callable[[str, str], dict[str, Any]]] = {
    "baud": _baud,
    "variant": _variant,
    "address": _address,
    "error": _error,
}
_FLAGS: dict[str, dict[str, Any]] = {
    "streaming": {"streaming": True},
    "polluted": {"polluted": True},
    "no-ack": {"acknowledges": False},
    "slow": {"slow": True},
}
