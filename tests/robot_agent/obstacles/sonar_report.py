"""Base reports with readings of sonars, for tests."""

from __future__ import annotations

from dataclasses import replace

from drivers.p2os.base_state import BaseState, base_state
from drivers.p2os.fitted_bumpers import FittedBumpers
from drivers.p2os.model import load_model
from drivers.p2os.odometer import Odometer
from drivers.p2os.sip import decode_sip

MODEL = load_model("p2dx")
IDLE = bytes.fromhex("32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00")


def sonar_report(t: float, *readings: tuple[int, float]) -> BaseState:
    """Return the report of a base that stands, with readings (number of the transducer, m)."""
    sip = decode_sip(IDLE)
    assert sip is not None
    return replace(base_state(t, sip, Odometer(), MODEL, FittedBumpers((5, 5))), sonar=readings)
