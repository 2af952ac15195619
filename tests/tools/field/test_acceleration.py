"""Whether guests really run, and the slowed clock of an emulated machine."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tools.field.acceleration import Acceleration, TrialClock, runs_guest
from tools.field.needed_programs import missing_packages

MISSING = missing_packages()
needs_qemu = pytest.mark.skipif("qemu-system-x86" in MISSING, reason="qemu is not there")
needs_faketime = pytest.mark.skipif("faketime" in MISSING, reason="faketime is not there")
EMULATION = ("-accel", "tcg", "-cpu", "max")
SLEEP = "import time; t = time.monotonic(); time.sleep(0.2); print(time.monotonic() - t)"


@needs_qemu
def test_an_emulated_guest_executes_its_first_instructions() -> None:
    assert runs_guest(EMULATION)


@needs_qemu
def test_an_acceleration_that_is_not_there_runs_no_guest() -> None:
    assert not runs_guest(("-accel", "hvf"))


@needs_faketime
def test_a_slowed_program_waits_longer_by_our_clock_and_not_by_its_own() -> None:
    clock = TrialClock(0.25)
    begun = clock.now()
    command = [*Acceleration("emulation", EMULATION, clock.rate).prefix(), sys.executable, "-c"]
    done = subprocess.run([*command, SLEEP], capture_output=True, text=True, check=True)
    assert 0.2 <= float(done.stdout) <= clock.now() - begun


def test_real_time_needs_no_library() -> None:
    slowed = Acceleration("emulation", EMULATION, 0.25)
    assert "env" not in slowed.at_full_speed.prefix()
