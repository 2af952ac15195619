"""The commands of an open session that concern an emulated robot, not its line."""

from __future__ import annotations

from collections.abc import Callable

from drivers.p2os.command_numbers import LIMITS, MOTION, CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.emulator.board import EmulatedBoard
from drivers.p2os.emulator.controller_settings import SETTERS
from drivers.p2os.emulator.streams import STREAM

_N = CommandNumber
STREAMED = frozenset(
    {_N.ENCODER, _N.IOREQUEST, _N.JOYINFO, _N.GRIPREQUEST, _N.BATTERYINFO},
)
"""Commands that ask for one packet or a stream of them."""
UNSEEN = frozenset(
    {
        *(_N.PULSE, _N.OPEN, _N.SAY, _N.GRIPPER, _N.GRIPPERVAL, _N.PTUPOS, _N.TCM2, _N.DOCK),
        *(_N.JOYDRIVE, _N.CALCOMP, _N.CHARGE, _N.SOUNDTOG),
    }
)
"""Commands that only reset the watchdog here: what they act on sends a client nothing, or is not
fitted (gripper, servos, compass, dock, joystick)."""
TTY_PORTS = {_N.TTY2: 1, _N.TTY3: 2, _N.TTY4: 3}
GETAUX_PORTS = {_N.GETAUX: 1, _N.GETAUX2: 2, _N.GETAUX3: 3}
SONAR_CYCLES = range(2, 121)  # ms


class CommandServer:
    """Carries out commands on the base's hardware and on the controller's board."""

    def __init__(self, base: EmulatedBase, board: EmulatedBoard) -> None:
        self.motion_refused = 0
        """Motion commands while the motors were off."""
        self._base = base
        self._board = board
        self._handlers: dict[int, Callable[[Command, float], None]] = {
            **dict.fromkeys(MOTION, self._obey_motion),
            **dict.fromkeys(LIMITS, self._set_limit),
            **dict.fromkeys(STREAMED, self._request_stream),
            **dict.fromkeys(SETTERS, self._set_value),
            **dict.fromkeys(TTY_PORTS, self._send_to_port),
            **dict.fromkeys(GETAUX_PORTS, self._request_from_port),
            **dict.fromkeys(UNSEEN, self._do_nothing),
            _N.POLLING: self._set_polling,
            _N.ENABLE: self._enable_motors,
            _N.SETO: self._zero_odometer,
            _N.SONAR: self._switch_sonar,
            _N.ADSEL: self._select_analog_port,
            _N.DIGOUT: self._set_outputs,
            _N.BUMP_STALL: self._set_bump_stall,
            _N.E_STALL: self._set_e_stall,
            _N.GYRO: self._switch_gyro,
            _N.SONARCYCLE: self._set_sonar_cycle,
            _N.BATTEST: self._pretend_battery,
        }

    def use(self, board: EmulatedBoard) -> None:
        """Carry out further commands on another board, that of a controller that was reset."""
        self._board = board

    def obey(self, command: Command, t: float) -> bool:
        """Carry out a command at ``t``; return False if its number is unknown here."""
        handler = self._handlers.get(command.number)
        if handler is None or not self._board.firmware.knows(command.number):
            return False
        handler(command, t)
        return True

    def _do_nothing(self, _command: Command, _t: float) -> None:
        """Only reset the watchdog."""

    def _obey_motion(self, command: Command, _t: float) -> None:
        self.motion_refused += not self._base.obey_motion(command)

    def _set_limit(self, command: Command, _t: float) -> None:
        self._base.controller.set_limit(command)

    def _enable_motors(self, command: Command, _t: float) -> None:
        self._base.enable_motors(on=command.integer != 0)

    def _zero_odometer(self, _command: Command, _t: float) -> None:
        self._base.set_odometry(0.0, 0.0, 0.0)

    def _set_polling(self, command: Command, _t: float) -> None:
        """POLLING: numbers from 1; an empty string silences the arrays and keeps their order."""
        if isinstance(command.argument, bytes) and command.argument:
            self._board.sonar.set_order([one_based - 1 for one_based in command.argument])
        elif command.argument == b"":
            self._board.sonar.stop()

    def _switch_sonar(self, command: Command, t: float) -> None:
        """SONAR: bit 0 on or off, later firmware: the bits above an array from 1, 0 for all."""
        number = command.integer >> 1 if self._board.firmware.has_sonar_arrays else 0
        array = number - 1 if number > 0 else None
        if command.integer & 1:
            self._board.sonar.start(t, array)
        else:
            self._board.sonar.stop(array)

    def _set_sonar_cycle(self, command: Command, t: float) -> None:
        if command.integer in SONAR_CYCLES:
            self._board.settings.set(command)
            self._board.sonar.set_period(0.001 * command.integer, t)

    def _request_stream(self, command: Command, _t: float) -> None:
        self._board.streams.request(command)

    def _switch_gyro(self, command: Command, t: float) -> None:
        """GYRO: 1 is a stream already."""
        on = command.integer != 0 and self._board.firmware.has_gyro
        self._board.streams.request(Command(_N.GYRO, STREAM * on))
        if on:
            self._board.gyro.start(t)

    def _set_value(self, command: Command, _t: float) -> None:
        self._board.settings.set(command)

    def _send_to_port(self, command: Command, _t: float) -> None:
        if isinstance(command.argument, bytes):
            self._board.aux[TTY_PORTS[_N(command.number)]].send(command.argument)

    def _request_from_port(self, command: Command, _t: float) -> None:
        self._board.aux[GETAUX_PORTS[_N(command.number)]].request(command.integer)

    def _select_analog_port(self, command: Command, _t: float) -> None:
        self._board.pins.analog_port = command.integer & 0xFF

    def _set_outputs(self, command: Command, _t: float) -> None:
        mask, states = command.two_bytes
        self._board.pins.set_outputs(mask, states)

    def _set_bump_stall(self, command: Command, _t: float) -> None:
        self._base.bump_stall = command.integer & 3

    def _set_e_stall(self, command: Command, _t: float) -> None:
        self._base.e_stall = command.integer != 0

    def _pretend_battery(self, command: Command, _t: float) -> None:
        """BATTEST: report these decivolts; 0 gives back the real battery."""
        decivolts = command.integer
        self._base.battery.pretended_volts = 0.1 * decivolts if decivolts > 0 else None
