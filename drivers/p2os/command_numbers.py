"""The numbers of the commands a Pioneer 2-DX understands, and the arguments each takes.

Source: Pioneer 2 and H8-series Operations Manuals, command tables. Left out: the arm, the
commands of other robots (Seekur, PatrolBot, PowerBot), the sound commands on whose numbers the
sources disagree, and MAINTENANCE, which no driver uses.
"""

from __future__ import annotations

from enum import IntEnum

MAX_MAGNITUDE = 0xFFFF


class CommandNumber(IntEnum):
    """Command numbers.

    0, 1, 2 are SYNC0, SYNC1, SYNC2 until the servers are open and PULSE, OPEN, CLOSE afterwards.
    """

    SYNC0 = 0
    SYNC1 = 1
    SYNC2 = 2
    PULSE = 0
    OPEN = 1
    CLOSE = 2
    POLLING = 3
    ENABLE = 4
    SETA = 5
    SETV = 6
    SETO = 7
    MOVE = 8
    ROTATE = 9
    SETRV = 10
    VEL = 11
    HEAD = 12
    DHEAD = 13
    SAY = 15
    JOYINFO = 17
    CONFIG = 18
    ENCODER = 19
    RVEL = 21
    DCHEAD = 22
    SETRA = 23
    SONAR = 28
    STOP = 29
    DIGOUT = 30
    VEL2 = 32
    GRIPPER = 33
    ADSEL = 35
    GRIPPERVAL = 36
    GRIPREQUEST = 37
    GYROCALCW = 38
    GYROCALCCW = 39
    IOREQUEST = 40
    PTUPOS = 41
    TTY2 = 42
    GETAUX = 43
    BUMP_STALL = 44
    TCM2 = 45
    DOCK = 46
    JOYDRIVE = 47
    SONARCYCLE = 48
    HOSTBAUD = 50
    AUX1BAUD = 51
    AUX2BAUD = 52
    AUX3BAUD = 53
    E_STOP = 55
    E_STALL = 56
    QSTOP = 57
    GYRO = 58
    TTY4 = 60
    GETAUX3 = 61
    BATTERYINFO = 62
    CALCOMP = 65
    TTY3 = 66
    GETAUX2 = 67
    CHARGE = 68
    ROTKP = 82
    ROTKV = 83
    ROTKI = 84
    TRANSKP = 85
    TRANSKV = 86
    TRANSKI = 87
    REVCOUNT = 88
    DRIFTFACTOR = 89
    SOUNDTOG = 92
    TICKSMM = 93
    BATTEST = 250
    RESET = 253


_N = CommandNumber

ARGUMENT_RANGES: dict[CommandNumber, tuple[int, int]] = {
    _N.OPEN: (1, 1),
    _N.CLOSE: (1, 1),
    _N.ENABLE: (0, 1),
    _N.SETA: (-5000, 5000),  # mm/s^2; negative sets the deceleration
    _N.SETV: (0, 5000),  # mm/s
    _N.MOVE: (-5000, 5000),  # mm
    _N.ROTATE: (-500, 500),  # deg/s
    _N.SETRV: (0, 500),  # deg/s
    _N.VEL: (-2200, 2200),  # mm/s
    _N.HEAD: (-359, 359),  # deg, absolute
    _N.DHEAD: (-359, 359),  # deg, relative to the heading
    _N.JOYINFO: (0, 2),  # 0 stop, 1 one packet, 2 stream
    _N.CONFIG: (1, 1),
    _N.ENCODER: (0, 2),  # 0 stop, 1 one packet, 2 stream
    _N.RVEL: (-500, 500),  # deg/s
    _N.DCHEAD: (-359, 359),  # deg, relative to the heading setpoint
    _N.SETRA: (-2000, 2000),  # deg/s^2; negative sets the deceleration
    _N.SONAR: (0, 9),  # 0 off, 1 on; later firmware: 2 * array number more for one array
    _N.DIGOUT: (0, MAX_MAGNITUDE),  # mask * 256 + states
    _N.VEL2: (0, MAX_MAGNITUDE),  # left count * 256 + right count
    _N.GRIPPER: (1, 17),
    _N.ADSEL: (1, 5),  # analog port
    _N.GRIPPERVAL: (0, MAX_MAGNITUDE),
    _N.GRIPREQUEST: (0, 2),  # 0 stop, 1 one packet, 2 stream
    _N.GYROCALCW: (-MAX_MAGNITUDE, MAX_MAGNITUDE),
    _N.GYROCALCCW: (-MAX_MAGNITUDE, MAX_MAGNITUDE),
    _N.IOREQUEST: (0, 2),  # 0 stop, 1 one packet, 2 stream
    _N.PTUPOS: (0x0100, 0x04FF),  # port * 256 + pulse in 10 us
    _N.GETAUX: (0, 200),  # bytes; 0 discards those waiting
    _N.BUMP_STALL: (0, 3),  # 0 off, 1 front, 2 rear, 3 both
    _N.TCM2: (0, 7),
    _N.DOCK: (0, 255),
    _N.JOYDRIVE: (0, 1),
    _N.SONARCYCLE: (2, 120),  # ms
    _N.HOSTBAUD: (0, 4),
    _N.AUX1BAUD: (0, 4),
    _N.AUX2BAUD: (0, 4),
    _N.AUX3BAUD: (0, 4),
    _N.E_STALL: (0, 1),
    _N.GYRO: (0, 1),
    _N.GETAUX3: (0, 200),
    _N.BATTERYINFO: (0, 2),
    _N.CALCOMP: (0, 255),
    _N.GETAUX2: (0, 200),
    _N.CHARGE: (0, 1),
    _N.ROTKP: (0, MAX_MAGNITUDE),
    _N.ROTKV: (0, MAX_MAGNITUDE),
    _N.ROTKI: (0, MAX_MAGNITUDE),
    _N.TRANSKP: (0, MAX_MAGNITUDE),
    _N.TRANSKV: (0, MAX_MAGNITUDE),
    _N.TRANSKI: (0, MAX_MAGNITUDE),
    _N.REVCOUNT: (1, MAX_MAGNITUDE),  # encoder counts of a full turn on the spot
    _N.DRIFTFACTOR: (-MAX_MAGNITUDE, MAX_MAGNITUDE),
    _N.SOUNDTOG: (0, 1),
    _N.TICKSMM: (1, MAX_MAGNITUDE),
    _N.BATTEST: (0, 255),  # decivolts to simulate, 0 = measured
}
"""Allowed integer arguments by command; a command not listed takes none."""

OPTIONAL_ARGUMENT = frozenset((_N.OPEN, _N.CLOSE, _N.CONFIG))

MOTION = frozenset(
    {
        *(_N.MOVE, _N.ROTATE, _N.VEL, _N.HEAD, _N.DHEAD, _N.RVEL, _N.DCHEAD, _N.VEL2),
        *(_N.STOP, _N.E_STOP, _N.QSTOP),
    }
)
"""Commands that set or end a motion."""

LIMITS = frozenset({_N.SETA, _N.SETV, _N.SETRV, _N.SETRA})
"""Commands that bound speeds and accelerations."""

RESERVED = (
    MOTION
    | LIMITS
    | {_N.SYNC0, _N.SYNC1, _N.SYNC2, _N.ENABLE, _N.SETO, _N.CONFIG, _N.HOSTBAUD, _N.RESET}
    | {_N.BUMP_STALL, _N.REVCOUNT, _N.DRIFTFACTOR, _N.TICKSMM, _N.JOYDRIVE}
    | {_N.ROTKP, _N.ROTKV, _N.ROTKI, _N.TRANSKP, _N.TRANSKV, _N.TRANSKI}
)
"""Commands that move the robot, change how it moves or touch its session."""
