"""What is wrong with a robot, by kind and with a remedy, and how often it was."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from drivers.p2os.commands import Command
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.settings import BaseSettings
from drivers.p2os.trouble import TroubleKind
from drivers.requests import Write

if TYPE_CHECKING:
    from conftest import Bench

MakeBench = Callable[..., "Bench"]


def kinds(session: P2osSession) -> list[TroubleKind]:
    return [trouble.kind for trouble in session.troubles]


def test_sound_robot_has_no_trouble_and_no_count_of_any(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    assert wire.session.troubles == []
    counters = wire.session.counters
    assert (counters.old_sessions, counters.rate_searches, counters.silences) == (0, 0, 0)
    assert (counters.unknown_models, counters.refused_limits) == (0, 0)


def test_robot_that_is_off_is_no_reply_and_each_search_of_the_rates_is_counted() -> None:
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    for step in range(1200):
        session.tick(0.05 * step)
        session.pop_requests()
    assert kinds(session) == [TroubleKind.NO_REPLY]
    assert "robot switched on? cable?" in (session.trouble or "")
    assert session.counters.rate_searches > 3


def test_bytes_of_no_robot_are_noise_and_own_bytes_an_echo() -> None:
    for answer, kind in ((b"U\xaaU\xaa", TroubleKind.NOISE), (None, TroubleKind.ECHO)):
        session = P2osSession(BaseSettings())
        session.link_up(0.0)
        for step in range(600):
            t = 0.05 * step
            session.tick(t)
            for request in session.pop_requests():
                if isinstance(request, Write):
                    session.feed(answer or request.data, t)
        assert kinds(session) == [kind]


def test_silence_and_reset_are_told_apart_and_counted(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.cut = True
    wire.run(1.6)
    assert kinds(wire.session) == [TroubleKind.SILENT]
    assert "fell silent at 9600 baud: robot switched off? cable?" in (wire.session.trouble or "")
    wire.cut = False
    wire.run_until(lambda: wire.session.state is SessionState.READY, 10.0)
    assert wire.session.troubles == []
    wire.emulator.reset(wire.t)
    wire.run_until(lambda: TroubleKind.RESET in kinds(wire.session), 5.0)
    wire.run_until(lambda: wire.session.state is SessionState.READY, 20.0)
    counters = wire.session.counters
    assert (counters.silences, counters.resumptions, counters.controller_resets) == (2, 1, 1)


def test_session_that_another_client_left_open_is_counted(bench: MakeBench) -> None:
    wire = bench()
    for number in (0, 1, 2, 1):
        wire.emulator.feed(Command(number).encode(), 0.0)
    wire.run(0.5)
    wire.connect()
    assert wire.session.counters.old_sessions > 0


def test_unknown_model_is_told_with_the_remedy_and_counted(bench: MakeBench) -> None:
    wire = bench(make=replace(PIONEER_2DX, subclass="p9zz"))
    wire.session.link_up(0.0)
    wire.run(5.0)
    assert kinds(wire.session) == [TroubleKind.MODEL]
    assert 'set base.model = "./mine.toml"' in (wire.session.trouble or "")
    assert wire.session.counters.unknown_models == 1


def test_limits_that_the_robot_keeps_and_its_stop_button_are_both_told(bench: MakeBench) -> None:
    wire = bench(max_speed=1.0, make=replace(PIONEER_2DX, top_speed=0.3))
    wire.connect()
    assert kinds(wire.session) == [TroubleKind.LIMITS]
    assert "SETV 300 mm/s, asked for 1000" in (wire.session.trouble or "")
    assert wire.session.counters.refused_limits == 1
    wire.enable()
    wire.emulator.press_stop_button()
    wire.run(0.5)
    assert kinds(wire.session) == [TroubleKind.STOP_BUTTON, TroubleKind.LIMITS]
    wire.emulator.release_stop_button()
    wire.emulator.press_motors_button()
    wire.run(0.5)
    assert kinds(wire.session) == [TroubleKind.LIMITS]
