"""How the base of ``patrol emulate`` is, where not as the truth says."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import msgspec

from drivers.emulation.fault_plan import Span
from drivers.emulation.port import PtyPort, TcpPort
from drivers.p2os.commands import HOST_BAUDS
from drivers.p2os.emulator.base import FACTORY_WATCHDOG
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from tools.number_range import positive
from tools.simulation.emulate_error import EmulateError
from tools.simulation.hanging_up_port import HangingUpPort
from tools.simulation.truth.robot_truth import BumperTruth, ChargingTruth, RobotTruth

NEVER = Span(0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class BaseOptions:
    """Firmware, rate and state of an emulated base; the defaults change nothing of the truth."""

    firmware: Firmware | None = None
    """Of its controller; None: as the truth says."""
    baud: int = HOST_BAUDS[0]
    """Rate at which its line starts, and to which it falls back."""
    watchdog: float = FACTORY_WATCHDOG
    """Watchdog in its FLASH, s."""
    stop_button: Span = NEVER
    """When its stop button is held, s since the start."""
    charging: bool = False
    bumpers: bool = True
    """False: none is fitted, its inputs are open; True: as the truth says."""
    loop_back: bool = False
    """Whether a plug on each auxiliary port returns what is sent there."""
    hang_up: bool = False
    """Whether it ends a TCP connection when its client closes the session."""

    def applied(self, robot: RobotTruth) -> RobotTruth:
        """Return the robot as these options make it; EmulateError where its firmware cannot."""
        firmware = self.firmware or Firmware(robot.base.firmware)
        if self.charging and not firmware.reports_stop_button:
            raise EmulateError(
                f"--charging: {firmware} has no report of a charger; add --firmware arcos"
            )
        charging = robot.charging.connected or self.charging
        return msgspec.structs.replace(
            robot,
            base=msgspec.structs.replace(robot.base, firmware=firmware.value),
            charging=ChargingTruth(connected=charging),
            bumpers=BumperTruth(
                fitted=robot.bumpers.fitted and self.bumpers, segments=robot.bumpers.segments
            ),
        )

    def pumped(
        self, port: PtyPort | TcpPort, base: P2osEmulator
    ) -> PtyPort | TcpPort | HangingUpPort:
        """Return what pumps the base's port; EmulateError where that cannot hang up."""
        if not self.hang_up:
            return port
        if isinstance(port, PtyPort):
            raise EmulateError("--hang-up: a pty has no connection to end; add --p2os tcp:8101")
        return HangingUpPort(port, base)

    def plug_in(self, base: P2osEmulator) -> None:
        """Put the plugs on a base's auxiliary ports."""
        for port in base.board.aux.values():
            port.loop_back = self.loop_back

    def press(self, base: P2osEmulator, elapsed: float) -> None:
        """Hold or release the stop button as it is to be, ``elapsed`` s after the start."""
        held = elapsed in self.stop_button
        if held and not base.base.stop_button_pressed:
            base.press_stop_button()
        elif not held and base.base.stop_button_pressed:
            base.release_stop_button()


def add_base_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    group = parser.add_argument_group("base")
    group.add_argument(
        "--firmware",
        type=Firmware,
        choices=list(Firmware),
        help="of its controller: what its reports have; default by the model",
    )
    group.add_argument(
        "--p2os-baud",
        type=int,
        choices=HOST_BAUDS,
        default=HOST_BAUDS[0],
        help="rate at which its line starts (default: %(default)s)",
    )
    group.add_argument(
        "--watchdog",
        type=positive,
        default=FACTORY_WATCHDOG,
        metavar="S",
        help="watchdog time-out in its FLASH (default: %(default)s)",
    )
    group.add_argument(
        "--stop-button",
        default="0:0",
        metavar="FROM:TO",
        help="its stop button is held from then to then, s since the start",
    )
    group.add_argument("--charging", action="store_true", help="a charger is connected")
    group.add_argument("--no-bumpers", action="store_true", help="none fitted: inputs read 1")
    group.add_argument(
        "--loop-back", action="store_true", help="plugs on the auxiliary ports return what is sent"
    )
    group.add_argument(
        "--hang-up", action="store_true", help="it ends the TCP connection after CLOSE"
    )


def chosen_base(options: argparse.Namespace) -> BaseOptions:
    """Return what the options say. Raises EmulateError."""
    return BaseOptions(
        firmware=options.firmware,
        baud=options.p2os_baud,
        watchdog=options.watchdog,
        stop_button=_parse_span(options.stop_button),
        charging=options.charging,
        bumpers=not options.no_bumpers,
        loop_back=options.loop_back,
        hang_up=options.hang_up,
    )


def _parse_span(text: str) -> Span:
    begin, _, end = text.partition(":")
    try:
        return Span(float(begin), float(end))
    except ValueError as error:
        raise EmulateError(f"--stop-button {text}: is not FROM:TO; use e.g. 5:8") from error
