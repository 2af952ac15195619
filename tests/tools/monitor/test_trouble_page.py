"""A team of eight in trouble on the page: header, list, map, log; at three sizes; by keys alone."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from tests.tools.monitor.accessibility import (
    names_of,
    poor_contrasts,
    small_targets,
    unnamed,
)
from tests.tools.monitor.agent_recordings import START
from tests.tools.monitor.browser import Browser
from tests.tools.monitor.trouble_team import INTRUDER, TROUBLE_AT, trouble_recording
from tools.monitor.playback import Playback
from tools.monitor.playback_page import playback_page

SIZES = [(1600, 1000), (1280, 720), (390, 844)]
SHOWN_AT = TROUBLE_AT + 10.0


@dataclass
class TroublePage:
    """The page of a paused playback, and the browser that shows it."""

    browser: Browser
    playback: Playback
    url: str

    def open(self, width: int, height: int) -> None:
        """Open the page anew at the time of trouble."""
        self.browser.open("about:blank")
        self.browser.open(self.url, width, height)
        self.browser.run("localStorage.clear()")
        self.browser.open(self.url, width, height)
        self.browser.wait(lambda: self.run("return window.patrol !== undefined"), "the page")
        epoch, shown_at = self.playback.epoch, START + SHOWN_AT
        self.playback.steer(pause=True, speed=None, seek=shown_at)
        self.browser.wait(
            lambda: self.playback.epoch > epoch and self.playback.t == shown_at, "the time"
        )
        self.browser.open(self.url, width, height)  # nothing of another time is on it
        self.browser.wait(lambda: len(self.alarms()) == 5, "five alarms")
        self.browser.wait(lambda: "intruder" in self.browser.text("#trouble"), "the intruder")
        self.browser.wait(lambda: len(self.browser.texts(".card .name")) == 8, "eight robots")

    def alarms(self) -> list[str]:
        return self.browser.texts("#alarms .words > span:first-child")

    def run(self, script: str) -> Any:
        return self.browser.run(script)

    def press(self, *keys: str) -> None:
        """Press keys, whatever has focus."""
        ActionChains(self.browser.driver).send_keys(*keys).perform()

    def focused(self) -> str:
        return str(self.run("return document.activeElement.id || document.activeElement.className"))

    def tab_to(self, wanted: str) -> None:
        """Press Tab until an element of an id or class has focus."""
        for _ in range(120):
            if self.focused() == wanted:
                return
            self.press(Keys.TAB)
        raise AssertionError(f"Tab never comes to {wanted}")

    def screenshot(self, name: str) -> None:
        """Save a picture of the page where the variable TROUBLE_SCREENSHOTS names a folder."""
        folder = os.environ.get("TROUBLE_SCREENSHOTS")
        if folder:
            self.browser.driver.save_screenshot(str(Path(folder) / f"{name}.png"))


@pytest.fixture(scope="module")
def running(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TroublePage]:
    path = trouble_recording(tmp_path_factory.mktemp("trouble") / "team.mcap", 8, SHOWN_AT + 20.0)
    playback = Playback([path])
    with playback_page(playback, playback.site(), "127.0.0.1:0") as server:
        yield TroublePage(browser, playback, server.url)


@pytest.fixture(params=SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def page(running: TroublePage, request: pytest.FixtureRequest) -> TroublePage:
    """The page at each of the sizes."""
    running.open(*request.param)
    return running


@pytest.fixture
def wide(running: TroublePage) -> TroublePage:
    """The page at one size."""
    running.open(1280, 720)
    return running


def test_header_list_and_map_tell_the_trouble(page: TroublePage) -> None:
    browser = page.browser
    width = int(page.run("return innerWidth"))
    page.screenshot(f"trouble_{width}")
    assert browser.text("#trouble").startswith("robot2: intruder at 9.5, 14.6 m (north corridor)")
    assert browser.text("#trouble").endswith("· 4 more")
    assert page.run("return document.title") == "(5) Border patrol"
    assert browser.text("#summary").startswith("6 of 8 robots heard · 1 held back")
    kinds = page.run(
        "return [...document.querySelectorAll('#alarms li')]"
        ".map((li) => [li.dataset.robot.slice(6), li.dataset.kind])"
    )
    assert kinds[0] == ["robot2", "intruder"]
    assert sorted(kinds[1:4]) == [
        *(["robot3", "link laser"], ["robot5", "silent"], ["robot7", "silent"])
    ]
    assert kinds[4] == ["robot4", "map"]
    names = browser.texts(".card .name")
    assert names[:5] == ["robot2", "robot3", "robot5", "robot7", "robot4"], "trouble comes first"
    assert names[5:] == ["robot1", "robot6", "robot8"]
    badges = browser.texts(".card .badge:not([hidden])")
    assert badges == ["▲", "▲", "▲", "▲", "◆"]
    silent = page.run(
        "return [...document.querySelectorAll('.card.silent')].map((card) => card.dataset.robot)"
    )
    assert silent == ["north/robot5", "north/robot7"]
    labels = page.run("return patrol.map.labels.last")
    assert {label["id"].removeprefix("north/") for label in labels} == {
        f"robot{number}" for number in range(1, 9)
    }
    troubled = {label["id"][-1] for label in labels if label["words"][0] in "▲◆"}
    assert troubled == {"2", "3", "4", "5", "7"}
    (seen,) = page.run("return patrol.team.alarms.filter((alarm) => alarm.seen !== null)")
    assert seen["place"] == list(INTRUDER)
    assert "last seen" in browser.text("#alarms li:first-child .when")
    loaded = "return document.querySelector('#alarms img')?.naturalWidth ?? 0"
    browser.wait(lambda: page.run(loaded) == 120, "the intruder's picture")
    drawn = "return [...patrol.map.intruders.pictures.values()].map((each) => each.naturalWidth)"
    browser.wait(lambda: page.run(drawn) == [120], "the picture on the map")


def test_names_on_the_map_never_overprint(page: TroublePage) -> None:
    boxes = page.run("return patrol.map.labels.last.map((label) => label.box)")
    for index, (ax0, ay0, ax1, ay1) in enumerate(boxes):
        for bx0, by0, bx1, by1 in boxes[:index]:
            assert ax0 >= bx1 or bx0 >= ax1 or ay0 >= by1 or by0 >= ay1


def test_everything_has_a_name_and_enough_contrast(page: TroublePage) -> None:
    page.run("patrol.selection.choose('north/robot3')")
    assert unnamed(page.browser) == []
    for _theme in ("light", "dark"):
        assert poor_contrasts(page.browser) == []
        page.run("document.getElementById('theme').click()")
    assert small_targets(page.browser) == []
    assert {"critical", "warning"} <= set(names_of(page.browser, "image"))
    buttons = names_of(page.browser, "button")
    assert any(each.startswith("critical alarm 2 robot2 Keep going") for each in buttons)
    for button in ("open-log", "layers"):
        page.run(f"document.getElementById('{button}').click()")
    page.browser.wait(lambda: page.browser.texts("#log tbody tr"), "the log's entries")
    page.screenshot(f"log_{page.run('return innerWidth')}")
    assert unnamed(page.browser) == []
    assert poor_contrasts(page.browser) == []


def test_nothing_lies_outside_the_screen_or_over_the_map(page: TroublePage) -> None:
    assert int(page.run("return document.documentElement.scrollWidth - innerWidth")) <= 0
    cut = page.run("""
        return [...document.querySelectorAll("button, select, input, canvas, summary")]
          .filter((node) => node.checkVisibility({ visibilityProperty: true }))
          .filter((node) => { const box = node.getBoundingClientRect();
            return box.width && (box.left < -0.5 || box.right > innerWidth + 0.5); })
          .map((node) => node.id || node.className)""")
    assert cut == []
    over = page.run("""
        const map = document.getElementById("map").getBoundingClientRect();
        return document.querySelector(".tools").getBoundingClientRect().bottom - map.top""")
    assert over <= 0.5


def test_click_on_an_alarm_chooses_centres_and_jumps(wide: TroublePage) -> None:
    page = wide
    page.run("document.querySelector('#alarms li[data-robot=\"north/robot7\"] .words').click()")
    page.browser.wait(
        lambda: abs(page.playback.t - (START + TROUBLE_AT + 1.5)) < 1.5, "the alarm's time"
    )
    assert page.run("return patrol.selection.id") == "north/robot7"
    off = (
        "const [x, y] = patrol.team.robots.get('north/robot7')?.pose ?? [1e9, 1e9];"
        "return Math.hypot(x - patrol.map.viewport.x, y - patrol.map.viewport.y)"
    )
    page.browser.wait(lambda: float(page.run(off)) < 0.3, "the robot in the middle")


def test_click_on_the_header_shows_the_worst_alarm(wide: TroublePage) -> None:
    wide.run("document.querySelector('#trouble button').click()")
    wide.browser.wait(lambda: abs(wide.playback.t - (START + TROUBLE_AT)) < 1.5, "its time")
    assert wide.run("return patrol.selection.id") == "north/robot2"
    middle = wide.run("return [patrol.map.viewport.x, patrol.map.viewport.y]")
    assert middle == pytest.approx(INTRUDER, abs=0.01)


def test_survey_marks_the_slider_and_fills_plots_and_log(wide: TroublePage) -> None:
    page = wide
    page.browser.wait(lambda: page.run("return patrol.history.surveyed !== null"), "the survey")
    page.browser.wait(lambda: page.run("return patrol.playback.marks.entries.length") == 5, "marks")
    window = page.run("return patrol.history.window()")
    assert window["from"] == pytest.approx(START, abs=0.5)
    assert window["to"] > window["present"] == pytest.approx(START + SHOWN_AT, abs=0.5)
    page.run("document.getElementById('distance').focus()")
    page.press(Keys.ARROW_LEFT * 5)
    assert "robot1" in page.browser.text("#distance-reading")
    assert "Keep going" in page.browser.text("#actions-reading")
    page.press(Keys.ENTER)
    page.browser.wait(lambda: page.playback.t < START + SHOWN_AT - 4.0, "the cursor's time")


def test_keys_alone_do_everything(wide: TroublePage) -> None:
    page, browser = wide, wide.browser
    page.press("7")
    browser.wait(lambda: page.run("return patrol.selection.id") == "north/robot7", "robot 7")
    page.press("f")
    assert page.run("return patrol.map.following")
    page.press("0")
    page.press("/")
    page.press("laser")
    browser.wait(lambda: browser.texts(".card .name") == ["robot3"], "the robot that is found")
    assert browser.text("#robot-count") == "1 of 8"
    page.press(" ")  # a space is a letter of what is looked for
    assert page.playback.paused
    page.press(Keys.BACKSPACE * 9)
    page.tab_to("robot-filter")
    page.press("i")  # "in trouble"
    browser.wait(lambda: len(browser.texts(".card .name")) == 5, "those in trouble")
    page.press(" ")
    browser.wait(lambda: not page.playback.paused, "that space goes on, whatever has focus")
    browser.wait(lambda: browser.text("#playback button") == "Pause", "that the page knows")
    page.press(" ")
    browser.wait(lambda: page.playback.paused, "the pause")
    page.tab_to("row")
    page.press(Keys.ENTER)
    browser.wait(lambda: browser.texts(".card .body:not([hidden])"), "an open card")
    page.tab_to("pin")
    page.press(Keys.ENTER)
    assert len(page.run("return patrol.roster.plotted()")) == 1
    page.press(Keys.ENTER)
    page.run("document.getElementById('operator').focus()")
    page.press("Mia")
    page.run("document.activeElement.blur()")
    page.press("a")
    browser.wait(
        lambda: "acknowledged by Mia" in browser.text("#alarms li .when.quiet"), "who acknowledged"
    )
    page.press("l")
    browser.wait(lambda: len(browser.texts("#log tbody tr")) == 5, "the log")
    page.press("north corridor")
    browser.wait(lambda: len(browser.texts("#log tbody tr")) == 2, "the log's filter")
    assert "words=north+corridor" in str(page.run("return document.querySelector('#log a').href"))
    page.press(Keys.ESCAPE, Keys.ESCAPE)  # the first empties the field
    page.run("document.getElementById('map').focus()")
    page.press("m", Keys.ENTER)
    page.press(Keys.ARROW_RIGHT, Keys.ENTER)
    scale = float(page.run("return patrol.map.viewport.scale"))
    assert page.run("return patrol.map.measure.total") == pytest.approx(60.0 / scale)
    assert browser.text("#place").startswith("measured ")
    page.press(Keys.ESCAPE)
    assert not page.run("return patrol.map.measure.on")
    page.tab_to("coverage")
    page.press(Keys.ARROW_RIGHT * 3)
    assert "s = 3.0 m (north corridor): visited" in str(
        page.run("return document.activeElement.getAttribute('aria-valuetext')")
    )
    page.press(Keys.ENTER)
    assert page.run("return patrol.map.place") is not None


def test_focus_is_seen_on_every_control(page: TroublePage) -> None:
    unseen = set()
    for _ in range(45):
        page.press(Keys.TAB)
        shown = page.run("""
            const style = getComputedStyle(document.activeElement);
            return document.activeElement === document.body || style.outlineStyle !== "none" """)
        if not shown:
            unseen.add(page.focused())
    assert unseen == set()


def test_sound_and_notification_are_switched_off_and_stay_so(wide: TroublePage) -> None:
    page = wide
    assert json.loads(page.run("return JSON.stringify(patrol.signal.on)"))["sound"]
    page.run("document.getElementById('sound').click()")
    page.browser.open(page.url, 1280, 720)
    page.browser.wait(lambda: page.run("return window.patrol !== undefined"), "the page")
    assert page.run("return patrol.signal.on.sound") is False
    assert page.run("return document.getElementById('sound').getAttribute('aria-pressed')") == (
        "false"
    )
