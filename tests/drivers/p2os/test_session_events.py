"""What a session tells of itself: its states, and each trouble once, with a remedy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from drivers.p2os.commands import Command
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.session_events import SESSION, SessionEvent, SessionEvents
from drivers.p2os.settings import BaseSettings
from drivers.p2os.trouble import Trouble, TroubleKind
from drivers.requests import Write

if TYPE_CHECKING:
    from conftest import Bench

MakeBench = Callable[..., "Bench"]


def told(session: P2osSession) -> list[tuple[str, str]]:
    return [(event.subject, event.words) for event in session.pop_events()]


def tick(session: P2osSession, start: float, end: float) -> None:
    for step in range(round((end - start) / 0.05)):
        session.tick(start + 0.05 * step)
        session.pop_requests()


def test_states_of_a_session_are_told_in_order(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.run(2.0)
    wire.session.shut_down(wire.t)
    events = wire.session.pop_events()
    assert [(event.words, event.severity) for event in events] == [
        ("waits for the robot: is it switched on?", "info"),
        ("robot Emulated, a p2dx, answers at 9600 baud", "info"),
        ("ready", "info"),
        ("session closed, motors off", "info"),
    ]
    assert [event.t for event in events] == sorted(event.t for event in events)
    assert wire.session.pop_events() == []


def test_rate_that_is_not_the_configured_one_is_told(bench: MakeBench) -> None:
    wire = bench(robot_baud=38400)
    wire.connect()
    assert told(wire.session)[1] == (
        SESSION,
        "robot Emulated, a p2dx, answers at 38400 baud: base.baud = 38400 finds it at once",
    )


def test_robot_that_is_off_is_told_once_however_long_the_search() -> None:
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    tick(session, 0.0, 60.0)
    events = session.pop_events()
    assert [event.subject for event in events] == [SESSION, TroubleKind.NO_REPLY]
    assert events[1].severity == "error"
    assert "robot switched on? cable?" in events[1].words
    tick(session, 60.0, 120.0)
    assert session.pop_events() == []
    assert session.handshake.sweeps > 3


def test_echo_is_told_once() -> None:
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    for step in range(400):
        t = 0.05 * step
        session.tick(t)
        for request in session.pop_requests():
            if isinstance(request, Write):
                session.feed(request.data, t)
    assert [subject for subject, _ in told(session)] == [SESSION, TroubleKind.ECHO]


def test_silence_is_told_when_it_begins_and_when_it_ends(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    told(wire.session)
    for number in (1, 2):
        wire.cut = True
        wire.run(1.6)
        [event] = wire.session.pop_events()
        assert (event.subject, event.severity) == (TroubleKind.SILENT, "error")
        assert "fell silent at 9600 baud: robot switched off? cable?" in event.words
        wire.cut = False
        wire.run_until(lambda: wire.session.state is SessionState.READY, 10.0)
        assert told(wire.session) == [
            (SESSION, "robot found in this session: stops it, goes on"),
            (TroubleKind.SILENT, "over"),
            (SESSION, "ready"),
        ]
        assert wire.session.counters.silences == wire.session.counters.resumptions == number


def test_reset_of_the_controller_is_told(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    told(wire.session)
    wire.emulator.reset(wire.t)
    wire.run_until(lambda: wire.session.counters.controller_resets == 1, 5.0)
    wire.run_until(lambda: wire.session.state is SessionState.READY, 20.0)
    events = wire.session.pop_events()
    resets = [event for event in events if event.subject == TroubleKind.RESET]
    assert [(event.words, event.severity) for event in resets] == [
        ("the robot's controller has reset itself: opens a new session", "warning"),
        ("over", "info"),
    ]


def test_session_that_another_client_left_open_is_told_once(bench: MakeBench) -> None:
    wire = bench()
    for number in (0, 1, 2, 1):
        wire.emulator.feed(Command(number).encode(), 0.0)
    wire.run(0.5)
    wire.connect()
    words = "another client left its session open: stops the robot, closes it"
    assert told(wire.session).count((SESSION, words)) == 1


def test_unknown_model_is_told_with_the_remedy_and_counted(bench: MakeBench) -> None:
    wire = bench(make=replace(PIONEER_2DX, subclass="p9zz"))
    wire.session.link_up(0.0)
    wire.run(5.0)
    [event] = [event for event in wire.session.pop_events() if event.subject == TroubleKind.MODEL]
    assert event.severity == "error"
    assert 'set base.model = "./mine.toml"' in event.words
    assert wire.session.counters.unknown_models == 1


def test_limits_that_the_robot_keeps_are_told_and_counted(bench: MakeBench) -> None:
    wire = bench(max_speed=1.0, make=replace(PIONEER_2DX, top_speed=0.3))
    wire.connect()
    [event] = [event for event in wire.session.pop_events() if event.subject == TroubleKind.LIMITS]
    assert event.severity == "warning"
    assert "SETV 300 mm/s, asked for 1000" in event.words
    assert wire.session.counters.refused_limits == 1


def test_stop_button_is_told_when_pressed_and_when_the_motors_are_on_again(
    bench: MakeBench,
) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    told(wire.session)
    wire.emulator.press_stop_button()
    wire.run(1.0)
    wire.emulator.release_stop_button()
    wire.emulator.press_motors_button()
    wire.run(0.5)
    pressed, released = wire.session.pop_events()
    assert "press MOTORS on the robot" in pressed.words
    assert (released.subject, released.words) == (TroubleKind.STOP_BUTTON, "over")
    assert released.t - pressed.t == pytest.approx(1.0, abs=0.2)


def test_lost_line_ends_no_trouble_and_a_new_one_tells_of_waiting_again(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.cut = True
    wire.run(2.0)
    told(wire.session)
    wire.session.link_down(wire.t)
    assert told(wire.session) == []
    wire.session.link_up(wire.t)
    assert told(wire.session) == [(SESSION, "waits for the robot: is it switched on?")]


@pytest.mark.parametrize("kind", list(TroubleKind))
def test_each_kind_has_a_severity(kind: TroubleKind) -> None:
    events = SessionEvents()
    events.update(1.0, [Trouble(kind, "broken: mend it")])
    events.update(2.0, [Trouble(kind, "broken: mend it, and more")])
    events.update(3.0, [])
    begun, ended = events.pop()
    assert begun.severity in ("warning", "error")
    assert ended == SessionEvent(3.0, kind, "over", "info")
