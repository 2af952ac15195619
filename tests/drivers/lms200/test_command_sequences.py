"""Valid commands in random order: no exception, and the session always comes back to a stream."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import encode_telegram
from drivers.lms200.session import Lms200Session, SessionState
from drivers.lms200.settings import LaserSettings
from drivers.lms200.telegrams import VARIANTS, Command

LISTING = Path(__file__).parent / "emulator" / "listing.toml"
COMMANDS = [
    bytes.fromhex(entry["command"]) for entry in tomllib.loads(LISTING.read_text())["telegram"]
]
LENGTH = 60  # commands in a sequence
SEQUENCES = 60
LONG_RUN = 3000
SPOILT_SHARE = 0.2
TOGETHER_SHARE = 0.1  # sent in one write
LONGEST_PAUSE = 0.3  # s
COMES_BACK_WITHIN = 25.0  # s: four rates are tried, at 9600 baud a status takes 0.2 s


class Scene:
    """Walls at 2 m, some beams without a return, some reflectors."""

    def __init__(self) -> None:
        self.beams = 0

    def __call__(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        self.beams = n
        ranges = np.full(n, 2.0)
        ranges[::7] = np.inf
        return ranges

    def reflectors(self) -> NDArray[np.bool_]:
        return np.arange(self.beams) % 11 == 0


def spoilt(command: bytes, rng: np.random.Generator) -> bytes:
    """Return a command with another parameter; the password stays what it is."""
    if len(command) < 2 or command[0] == Command.PASSWORD:
        return command
    place = int(rng.integers(1, len(command)))
    return command[:place] + bytes((int(rng.integers(256)),)) + command[place + 1 :]


def send_sequence(emulator: Lms200Emulator, rng: np.random.Generator, t: float) -> float:
    """Send commands, at the laser's rate; return the time of the last."""
    together = b""
    for _ in range(LENGTH):
        command = COMMANDS[int(rng.integers(len(COMMANDS)))]
        if rng.random() < SPOILT_SHARE:
            command = spoilt(command, rng)
        together += encode_telegram(command, emulator.state.address)
        if rng.random() < TOGETHER_SHARE:
            continue
        emulator.feed(together, t)
        together = b""
        t += float(rng.uniform(0.0, LONGEST_PAUSE))
        emulator.pop_output(t)
    return t


def check_sequence(line: Any, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = Scene()
    emulator = Lms200Emulator(
        baud=(9600, 38400, 500000)[seed % 3],
        scan_source=scene,
        reflector_source=scene.reflectors,
        variant=VARIANTS[seed % len(VARIANTS)],
        paced=seed % 4 > 0,
    )
    emulator.slow = seed % 5 == 0
    emulator.state.address = seed % 2
    t = send_sequence(emulator, rng, 1.0)
    session = Lms200Session(LaserSettings())
    wire = line(session, emulator)
    wire.t = t
    wire.connect()
    limit = COMES_BACK_WITHIN * (2 if emulator.slow else 1)
    wire.run_until(SessionState.STREAMING, limit)
    wire.run(1.0)
    assert len(wire.scans) >= 3
    assert wire.scans[-1].ranges.size == 181
    np.testing.assert_allclose(wire.scans[-1].ranges[np.isfinite(wire.scans[-1].ranges)], 2.0)


@pytest.mark.parametrize(
    ("first", "count"), [(0, SEQUENCES), pytest.param(SEQUENCES, LONG_RUN, marks=pytest.mark.long)]
)
def test_session_comes_back_after_any_sequence(line: Any, first: int, count: int) -> None:
    for seed in range(first, first + count):
        check_sequence(line, seed)
