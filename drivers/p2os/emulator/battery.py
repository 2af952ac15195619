"""The battery of an emulated robot: lead-acid blocks that drain with time and motion."""

from __future__ import annotations

from drivers.p2os.base_state import ChargeState

FULL = 13.0  # V, of one of 12 V
VOLTS_PER_JOULE = 2.0 / (252.0 * 3600.0)  # 13 V down to 11 V over 252 Wh
IDLE_POWER = 25.0  # W, controller and computer
MOTOR_POWER = 30.0  # W per m/s


class EmulatedBattery:
    """A voltage, ``volts``, that falls with time and motion and may be set.

    A battery of 24 V is made of two of 12 V. pretended_volts: what the controller reports instead,
    as BATTEST sets it; None: the real ones. charge_state: what later firmware reports of the
    charger; the voltage does not rise.
    """

    def __init__(self, nominal: float = 12.0) -> None:
        self._in_series = nominal / 12.0
        self.fill()
        self.pretended_volts: float | None = None
        self.charge_state = ChargeState.NOT_CHARGING

    @property
    def reported_volts(self) -> float:
        """The voltage that the controller reports."""
        return self.volts if self.pretended_volts is None else self.pretended_volts

    @property
    def reported_volts_of_12(self) -> float:
        """The same as that of a 12 V battery in this state."""
        return self.reported_volts / self._in_series

    @property
    def charging(self) -> bool:
        """Whether a charger is at work."""
        return self.charge_state is not ChargeState.NOT_CHARGING

    def fill(self) -> None:
        """Exchange it for a charged one."""
        self.volts = FULL * self._in_series

    def drain(self, duration: float, distance: float) -> None:
        """Use the energy of ``duration`` s and ``distance`` m of wheel motion."""
        energy = IDLE_POWER * duration + MOTOR_POWER * abs(distance)
        self.volts = max(0.0, self.volts - VOLTS_PER_JOULE * energy)
