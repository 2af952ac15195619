"""The page in Chromium, with three live emulated robots and the shipped monitor."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import zenoh

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.messages.foxglove import Log, timestamp_at
from robot_agent.messages.streams import encode
from robot_agent.process.telemetry import session_config
from tests.tools.monitor.browser import Browser
from tests.tools.monitor.reports import decision, status
from tools.demo.demo import Demo, DemoOptions
from tools.monitor.endpoint import free_endpoint
from tools.monitor.monitor import Monitor, MonitorOptions
from tools.monitor.robot_state import RobotState
from tools.monitor.site import Site

FIRST = "demo/robot1"


@dataclass
class LiveTeam:
    """A running demo, its monitor and the browser that shows it."""

    browser: Browser
    monitor: Monitor
    demo: Demo

    def all_decide(self) -> bool:
        cards = [f'[data-robot="demo/robot{number}"] .action' for number in (1, 2, 3)]
        return not {"", "silent", "no decision"} & {self.browser.text(card) for card in cards}

    def robot(self, name: str) -> RobotState:
        return next(robot for robot in self.monitor.watch.robots if robot.id == name)

    def fact(self, name: str, robot: str = FIRST) -> str:
        """Return a figure on a robot's card; opens the card."""
        if self.browser.run(f"return window.patrol.selection.id !== '{robot}'"):
            self.browser.run(f"window.patrol.selection.choose('{robot}')")
        return self.browser.text(f'[data-robot="{robot}"] [data-fact="{name}"]')

    def wait_for(self, name: str, pattern: str) -> None:
        """Wait until a figure on the first robot's card is as the pattern says, whole."""
        try:
            self.browser.wait(lambda: re.fullmatch(pattern, self.fact(name)), name)
        except AssertionError:
            raise AssertionError(f"{name}: {self.fact(name)!r} is not {pattern}") from None

    def battery_agrees(self) -> bool:
        status = self.robot(FIRST).status
        return status is not None and self.fact("battery") == f"{status.battery:.1f} V"

    def alarm(self, robot: str, kind: str, state: str) -> bool:
        selector = f'#alarms li{state}[data-robot="{robot}"][data-kind="{kind}"]'
        return bool(self.browser.texts(selector))


@pytest.fixture(scope="module")
def running(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveTeam]:
    """One team for all tests of this file."""
    path = find_map("paper_lab", Path())
    endpoint = free_endpoint()
    record = tmp_path_factory.mktemp("page")
    site = Site(load_map_folder(path))
    options = DemoOptions(path, "border", 3, 1, endpoint, record)
    with ExitStack() as stack:
        monitor = Monitor(MonitorOptions(endpoint, "127.0.0.1:0", site))
        stack.callback(monitor.close)
        demo = stack.enter_context(Demo(options).running())
        team = LiveTeam(browser, monitor, demo)
        stack.callback(lambda: team.monitor.close())
        yield team


@pytest.fixture
def live(running: LiveTeam) -> LiveTeam:
    """Return the team on a freshly opened page."""
    assert running.monitor.url is not None
    running.browser.open(running.monitor.url)
    running.browser.wait(running.all_decide, "three robots that decide")
    return running


def test_every_figure_is_on_the_page_with_its_value(live: LiveTeam) -> None:
    browser = live.browser
    assert {"robot1", "robot2", "robot3"} <= set(browser.texts(".card .name"))
    assert browser.text("#site") == "paper_lab"
    browser.wait(lambda: "%" in live.fact("cpu"), "the share of the CPU")
    browser.wait(lambda: live.fact("motors") == "on", "motors that are on")
    browser.wait(live.battery_agrees, "the voltage the monitor received")
    live.wait_for("base", r"ready, \d+\.\d /s, 0 bad, \d+ B lost(; \d+ stale requests)?")
    written = "1 variant writes"  # a laser as it leaves the factory has another
    line = rf"streaming, \d+\.\d /s, 0 bad, \d+ B lost; .*{written}.*"
    live.wait_for("laser", line)
    live.wait_for("localization", r"(localized|unsure), σ \d+\.\d cm, n \d+, fit \d\.\d\d")
    live.wait_for("memory", r"\d+ MB")
    live.wait_for("dropped", r"\d+")  # those before the operator was connected
    live.wait_for("clock", r"[+−]0\.\d\d s")
    live.wait_for("gamma", r"-?\d+\.\d\d")
    live.wait_for("abscissa", r"\d+\.\d m c?cw")
    for twist in ("requested", "command"):
        live.wait_for(twist, r"-?\d\.\d\d m/s, -?\d\.\d\d rad/s")
    degrees = [float(text) for text in browser.texts(f'[data-robot="{FIRST}"] [data-degree]')]
    assert len(degrees) == 5
    assert max(degrees) > 0.0
    assert browser.texts(f'[data-robot="{FIRST}"] .winner') != []


def test_distances_on_the_page_follow_the_robot(live: LiveTeam) -> None:
    def agrees() -> bool:
        decision = live.robot(FIRST).decision
        assert decision is not None
        shown = re.match(r"\d+\.\d\d", live.fact("border"))
        near = live.fact("neighbor")
        return (
            shown is not None
            and abs(float(shown[0]) - decision.distance_from_border) < 0.02
            and (near == "–") == (decision.distance_from_neighbor is None)
        )

    live.browser.wait(agrees, "the distances the monitor received")


def test_map_plots_and_border_are_drawn(live: LiveTeam) -> None:
    browser = live.browser
    browser.wait(lambda: "average" in browser.text("#idleness"), "idleness of the border")
    kinds = {alarm.kind for alarm in live.monitor.watch.alarms.alarms()}
    assert not kinds & {"map", "border", "twin"}, "robots and monitor have the same map"
    for canvas in ("map", "coverage", "distance", "actions"):
        drawn = f"""
            const canvas = document.getElementById("{canvas}");
            const {{width, height}} = canvas;
            const pixels = canvas.getContext("2d").getImageData(0, 0, width, height).data;
            return new Set(new Uint32Array(pixels.buffer)).size"""
        browser.wait(lambda script=drawn: int(str(browser.run(script))) > 8, f"colours on {canvas}")
    parts = "scan particles tracks pose"
    seen = browser.run(
        f"return '{parts}'.split(' ').filter((part) => window.patrol.team.ordered[0][part])"
    )
    assert seen == parts.split()


def test_keyboard_alone_chooses_follows_and_zooms(live: LiveTeam) -> None:
    browser = live.browser
    browser.press("2f")
    browser.wait(lambda: browser.run("return window.patrol.map.following"), "following")
    assert browser.run("return window.patrol.selection.id") == "demo/robot2"
    scale = float(str(browser.run("return window.patrol.map.viewport.scale")))
    browser.press("+")
    assert float(str(browser.run("return window.patrol.map.viewport.scale"))) > scale
    browser.press("0")
    assert not browser.run("return window.patrol.map.following")


def test_silent_robot_raises_an_alarm_within_two_seconds_that_clears(live: LiveTeam) -> None:
    browser = live.browser
    pid = live.demo.agent_pids()[2]
    os.kill(pid, signal.SIGSTOP)
    try:
        browser.wait(lambda: live.alarm("demo/robot3", "silent", ":not(.over)"), "silence")
        alarm = next(a for a in live.monitor.watch.alarms.alarms() if a.kind == "silent")
        last_heard = live.robot("demo/robot3").last_heard
        assert last_heard is not None
        assert alarm.raised - last_heard < 2.0
        card = '[data-robot="demo/robot3"] .action'
        browser.wait(lambda: browser.text(card) == "silent", "silence on the card")
        said = '[data-robot="demo/robot3"].critical .badge'
        browser.wait(lambda: browser.texts(said) == ["▲"], "the badge of a robot in trouble")
        browser.wait(lambda: browser.texts("#trouble.critical"), "the header")  # or another's, on
        assert browser.text("#trouble") != ""  # a computer too slow for three robots
        assert "all well" not in browser.text("#summary")
        assert re.match(r"\(\d+\) Border patrol", str(browser.run("return document.title")))
        before = browser.texts('.card:has(~ [data-robot="demo/robot3"]):not(.critical) .name')
        assert before == [], "trouble comes first"
        silent = '#alarms [data-robot="demo/robot3"][data-kind="silent"] .words'
        browser.run(f"document.querySelector('{silent}').click()")
        assert browser.run("return window.patrol.selection.id") == "demo/robot3"
        pose = browser.run("return window.patrol.team.robots.get('demo/robot3').pose.slice(0, 2)")
        middle = "const {x, y} = window.patrol.map.viewport; return [x, y]"
        assert browser.run(middle) == pose, "the map shows the alarm's robot"
        screenshot = os.environ.get("PAGE_SCREENSHOT")
        if screenshot:
            browser.driver.save_screenshot(screenshot)
    finally:
        os.kill(pid, signal.SIGCONT)
    browser.wait(lambda: live.alarm("demo/robot3", "silent", ".over"), "the end of the silence")
    browser.press("a")
    browser.wait(lambda: browser.texts("#alarms li.seen"), "the acknowledgement")
    assert any(alarm.acknowledged for alarm in live.monitor.watch.alarms.alarms())


def test_hostile_payloads_are_shown_as_text_and_not_executed(live: LiveTeam) -> None:
    browser = live.browser
    attack = "<img src=x onerror=\"document.title='gone'\"><script>document.title='gone'</script>"
    words = Log(timestamp=timestamp_at(1.0), level=5, message=attack, name="<b>patrol</b>")
    key = "patrol/demo/stranger"
    with zenoh.open(session_config(live.monitor.options.listen)) as stranger:
        browser.wait(lambda: list(stranger.info.routers_zid()), "the stranger's connection")
        stranger.put(f"{key}/event", encode(words))
        stranger.put(f"{key}/status", encode(status(1.0, health=attack)))
        for number in range(500):
            stranger.put(f"{key}/decision", b"[" * number)
        huge = decision(1.0, action=attack, abscissa=1e308, distance_from_border=-1e308)
        stranger.put(f"{key}/decision", encode(huge))
        card = '[data-robot="demo/stranger"]'
        browser.wait(lambda: "stranger" in browser.texts(".card .name"), "the attacker's card")
        browser.run("window.patrol.selection.choose('demo/stranger')")
        browser.wait(lambda: attack in browser.text(f"{card} .log"), "the attack as plain words")
        browser.wait(lambda: live.alarm("demo/stranger", "malformed", ""), "the alarm")
    assert str(browser.run("return document.title")).endswith(") Border patrol")
    assert browser.texts("main img, main script, .log b") == []
    assert "stranger" in browser.texts(".card .name")


@pytest.mark.parametrize(("width", "height"), [(1366, 768), (390, 844)])
def test_page_fits_the_width_of_the_screen(live: LiveTeam, width: int, height: int) -> None:
    assert live.monitor.url is not None
    live.browser.open(live.monitor.url, width, height)
    live.browser.wait(lambda: len(live.browser.texts(".card .name")) >= 3, "the team")
    assert int(str(live.browser.run("return document.documentElement.scrollWidth"))) <= width


def test_page_reconnects_to_a_restarted_monitor(live: LiveTeam) -> None:
    browser, options = live.browser, live.monitor.options
    assert live.monitor.url is not None
    http = urlsplit(live.monitor.url).netloc
    live.monitor.close()
    browser.wait(lambda: browser.text("#link") == "monitor gone", "that the monitor is gone")
    live.monitor = Monitor(MonitorOptions(options.listen, http, options.site))
    browser.wait(lambda: browser.text("#link") == "live", "the monitor again")
    browser.wait(
        lambda: browser.text("#summary").startswith("3 of 3 robots heard"), "the robots again"
    )
    assert [
        line for line in browser.console_messages() if "SEVERE" in line or "Content" in line
    ] == []
