"""A border drawn in Chromium on a map without one, checked and patrolled."""

from __future__ import annotations

import json
import os
import shutil
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By

from maps.map_folder import load_map_folder
from maps.zone_file import load_zones
from robot_agent.config import find_map
from tests.tools.monitor.browser import Browser, chromium
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench
from tools.border_editor.editor_server import EditorServer
from tools.mapping.map_check import check_map

CORNERS = [
    *((-6.6, 0.0), (8.1, 0.0), (9.7, -1.0), (10.8, -3.1), (12.4, -8.0), (13.07, -11.7)),
    *((12.9, -19.0), (3.5, -18.7), (-4.5, -19.0), (-5.8, -14.0), (-6.15, -9.2)),
]
"""Of the corridors round the lab, m; between two of them a wall is too near."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with chromium(tmp_path_factory.mktemp("profile")) as started:
        yield started


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """A copy of intel_lab, without a border."""
    folder = tmp_path / "lab"
    shutil.copytree(find_map("intel_lab", Path.cwd()), folder)
    for border in folder.glob("*.toml"):
        border.unlink()
    return folder


@pytest.fixture
def editor(lab: Path) -> Iterator[EditorServer]:
    occupancy = load_map_folder(lab).map
    with closing(EditorServer(lab / "border.toml", occupancy, "127.0.0.1:0")) as server:
        yield server


class Page:
    """The editor in a browser; counts what a person does."""

    def __init__(self, browser: Browser, link: str) -> None:
        self.browser, self.actions = browser, 0
        browser.open(link, 1280, 900)
        browser.wait(lambda: browser.run("return window.editor !== undefined"), "the editor")

    def click_at(self, x: float, y: float) -> None:
        """Click on a place of the map, m."""
        dx, dy = self._from_middle(x, y)
        canvas = self.browser.driver.find_element(By.ID, "map")
        count = self.corners() + 1
        ActionChains(self.browser.driver).move_to_element_with_offset(
            canvas, dx, dy
        ).click().perform()
        self.actions += 1
        self.browser.wait(lambda: self.corners() == count, "the corner")

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        canvas = self.browser.driver.find_element(By.ID, "map")
        chain = ActionChains(self.browser.driver)
        chain.move_to_element_with_offset(canvas, *self._from_middle(*start)).click_and_hold()
        chain.move_to_element_with_offset(canvas, *self._from_middle(*end)).release().perform()
        self.actions += 1

    def click(self, selector: str) -> None:
        self.browser.click(selector)
        self.actions += 1

    def corners(self) -> int:
        count = self.browser.run("return window.editor.draft.vertices.length")
        assert isinstance(count, int)
        return count

    def first(self) -> list[float]:
        place = self.browser.run("const [v] = window.editor.draft.vertices; return [v.x, v.y]")
        assert isinstance(place, list)
        return place

    def faults_only_near(self, place: str) -> bool:
        faults = self.browser.texts("#faults li")
        return bool(faults) and all(place in fault for fault in faults)

    def verdict(self) -> str:
        return self.browser.text("#verdict")

    def _from_middle(self, x: float, y: float) -> tuple[int, int]:
        view = "window.editor.view"
        place = self.browser.run(f"return {view}.toPixel({x}, {y})")
        size = self.browser.run(f"return [{view}.width, {view}.height]")
        assert isinstance(place, list)
        assert isinstance(size, list)
        return round(place[0] - size[0] / 2), round(place[1] - size[1] / 2)


def test_a_border_is_drawn_by_hand_checked_and_patrolled(
    browser: Browser, editor: EditorServer, lab: Path
) -> None:
    page = Page(browser, editor.link)
    for place in CORNERS:
        page.click_at(*place)
    browser.wait(lambda: page.faults_only_near("y -18."), "what is too near")
    page.click_at(-0.5, -18.85)  # on the line there: a corner between, moved to where there is room
    browser.wait(lambda: page.verdict() == "robots can patrol it", "a border without faults")
    if "PAGE_SCREENSHOT" in os.environ:
        browser.driver.save_screenshot(os.environ["PAGE_SCREENSHOT"])
    page.click("#save")
    browser.wait(lambda: browser.text("#saved") == "saved", "saved")
    assert page.actions < 30
    assert not browser.console_messages()
    assert check_map(lab).ok
    fleet = IdealFleet(load_map_folder(lab), 2, 1)
    figures = run_ideal_bench(fleet, 60.0)
    assert figures["contacts"] == 0
    assert None not in figures["reach_s"]


def test_a_suggested_loop_is_changed_undone_and_saved(
    browser: Browser, editor: EditorServer, lab: Path
) -> None:
    page = Page(browser, editor.link)
    page.click("#suggest")
    browser.wait(lambda: page.verdict() == "robots can patrol it", "the loop")
    corners = page.corners()
    first = page.first()
    page.drag((first[0], first[1]), (first[0] + 0.3, first[1] + 0.1))
    page.click("#undo")
    browser.wait(lambda: page.first() == first, "undone")
    assert page.corners() == corners
    page.click("#save")
    browser.wait(lambda: browser.text("#saved") == "saved", "saved")
    assert check_map(lab).ok


def test_zones_are_drawn_named_and_saved_beside_the_border(
    browser: Browser, editor: EditorServer, lab: Path
) -> None:
    page = Page(browser, editor.link)
    canvas = browser.driver.find_element(By.ID, "map")
    for name, corners in (("south hall", [(0, -20), (9, -20), (9, -17), (0, -17)]), ("", [(0, 0)])):
        page.click("#zone")
        for at, place in enumerate(corners):
            chain = ActionChains(browser.driver)
            chain.move_to_element_with_offset(canvas, *page._from_middle(*place)).click().perform()
            drawn = "return window.editor.zones.corners.length"
            browser.wait(lambda count=at + 1, script=drawn: browser.run(script) == count, "corner")
        page.click("#zone")  # closes it; of one corner: gives it up
        if name:
            ActionChains(browser.driver).send_keys(name).perform()
    assert page.corners() == 0
    page.click("#save")
    browser.wait(lambda: browser.text("#saved") == "zones saved", "saved")
    assert not (lab / "border.toml").exists()
    (zone,) = load_zones(lab)
    assert zone.name == "south hall"
    assert zone.contains(4.0, -18.0)
    assert not zone.contains(4.0, -15.0)
    browser.run("window.editor.zones.zones[0].name = ' '")
    page.click("#save")
    browser.wait(lambda: "zones not saved: the name" in browser.text("#saved"), "why not")
    browser.run("window.editor.zones.zones[0].name = 'south hall'")
    assert not browser.console_messages()


def post(url: str, content: object, headers: dict[str, str] | None = None) -> object:
    request = urllib.request.Request(url, json.dumps(content).encode(), headers or {})
    with urllib.request.urlopen(request, timeout=5.0) as answer:
        return json.loads(answer.read())


def test_foreign_pages_and_broken_drafts_are_refused(editor: EditorServer, lab: Path) -> None:
    for content, headers, status in (
        ({"vertices": "none"}, {}, 400),
        ({}, {"Origin": "http://elsewhere.example"}, 403),
        ({}, {"Host": "elsewhere.example"}, 403),
    ):
        with pytest.raises(urllib.error.HTTPError) as caught:
            post(f"{editor.link}judge", content, headers)
        assert caught.value.code == status
        caught.value.close()
    answer = post(f"{editor.link}save", {"vertices": []})
    assert answer == {"saved": False, "why": "0 vertices, a border that is closed needs at least 3"}
    assert not (lab / "border.toml").exists()
