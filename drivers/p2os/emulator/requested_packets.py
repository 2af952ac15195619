"""The packets that an emulated controller sends with a SIP because its client asked for them."""

from __future__ import annotations

from collections.abc import Callable

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.emulator.board import NO_GRIPPER, NO_SMART_BATTERY, EmulatedBoard
from drivers.p2os.emulator.reports import encoder_report, io_report
from drivers.p2os.framing import encode_packet
from drivers.p2os.packets import ExtendedPacket

BEFORE_SIP = (CommandNumber.JOYINFO, CommandNumber.GYRO)
"""Commands whose packets go before the SIP, the others behind it (H8-series manual)."""


class RequestedPackets:
    """Chooses the packets of each cycle: what the line has no room for comes in another one."""

    def __init__(self, base: EmulatedBase) -> None:
        self._base = base
        self._cycles = 0

    def packets(
        self, board: EmulatedBoard, t: float, fits: Callable[[int], bool]
    ) -> tuple[list[bytes], list[bytes]]:
        """Return the packets before and behind the SIP of ``t``. fits: whether so many bytes do."""
        before, behind = list[bytes](), list[bytes]()
        size = 0
        for number in board.streams.due(self._cycles):
            packet = encode_packet(self._report(board, number, t).encode())
            if fits(size + len(packet)):
                size += len(packet)
                board.streams.on_sent(number)
                (before if number in BEFORE_SIP else behind).append(packet)
        self._cycles += 1
        return before, behind

    def _report(self, board: EmulatedBoard, number: CommandNumber, t: float) -> ExtendedPacket:
        match number:
            case CommandNumber.JOYINFO:
                return board.joystick
            case CommandNumber.GYRO:
                return board.gyro.pop_packet(t, self._base.velocity[1])
            case CommandNumber.IOREQUEST:
                return io_report(self._base, board)
            case CommandNumber.ENCODER:
                return encoder_report(self._base)
            case CommandNumber.GRIPREQUEST:
                return NO_GRIPPER
            case _:
                return NO_SMART_BATTERY
