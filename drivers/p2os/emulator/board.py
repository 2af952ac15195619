"""The controller's board in an emulated robot: what it has besides motors, battery and line."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.p2os.emulator.aux_ports import PORTS, AuxPort
from drivers.p2os.emulator.controller_settings import ControllerSettings
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.gyro import EmulatedGyro
from drivers.p2os.emulator.make import BaseMake
from drivers.p2os.emulator.sonar_firing import SonarFiring
from drivers.p2os.emulator.streams import EmulatedStreams
from drivers.p2os.extended_packets import BatteryPacket, GripperPacket, JoystickPacket

CENTRE = 512  # counts of a joystick at rest
NO_GRIPPER = GripperPacket(0, 0, 0)
NO_SMART_BATTERY = BatteryPacket(record_size=5, records=())
"""Lead-acid batteries tell nothing: a client learns that none does."""


@dataclass(slots=True)
class EmulatedPins:
    """The user's digital outputs and inputs, and the analog input selected for the SIP."""

    analog_port: int = 5
    inputs: int = 0xFF
    outputs: int = 0x00

    def set_outputs(self, mask: int, states: int) -> None:
        """Set the outputs in ``mask`` to the bits of ``states``."""
        self.outputs = (self.outputs & ~mask | states & mask) & 0xFF


class EmulatedBoard:
    """Pins, sonar, requested packets, auxiliary ports, settings; made anew by a reset, but for what
    is attached to the ports."""

    def __init__(
        self, make: BaseMake, firmware: Firmware, aux: dict[int, AuxPort] | None = None
    ) -> None:
        self.firmware = firmware
        self.pins = EmulatedPins()
        self.sonar = SonarFiring(make.transducers)
        self.streams = EmulatedStreams()
        self.aux = aux or {number: AuxPort(number) for number in PORTS}
        self.settings = ControllerSettings()
        self.gyro = EmulatedGyro()
        self.joystick = JoystickPacket(0, 0, CENTRE, CENTRE, 0)
        """What the joystick port reads; at rest where nothing is plugged in."""

    def end_session(self) -> None:
        """Stop what a client started; what it set stays until the next reset."""
        self.sonar.stop()
        self.streams.stop()
        for port in self.aux.values():
            port.cancel()
