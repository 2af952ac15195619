"""Sound and desktop notification of new alarms, in Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import pytest

from tests.tools.monitor.browser import Browser
from tools.monitor.alarm import Condition, Severity
from tools.monitor.site import Site
from tools.monitor.source import LiveSource
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch
from tools.monitor.web_server import WebServer


@pytest.fixture
def conditions() -> list[Condition]:
    """What is wrong; tests add to it while the page is shown."""
    return []


@pytest.fixture
def page(browser: Browser, conditions: list[Condition]) -> Iterator[Browser]:
    watch = Watch(TeamState(), Site(None), lambda: tuple(conditions))
    with closing(WebServer(watch, LiveSource(), "127.0.0.1:0")) as server:
        permissions = {"origin": server.url.rstrip("/"), "permissions": ["notifications"]}
        browser.driver.execute_cdp_cmd("Browser.grantPermissions", permissions)
        browser.open(server.url)
        browser.wait(lambda: browser.text("#link") == "live", "the page")
        yield browser
        browser.open("about:blank")


def trouble(kind: str, severity: Severity) -> Condition:
    return Condition("", kind, severity, f"{kind} it is")


def test_new_alarm_sounds_once_and_a_silenced_page_does_not(
    page: Browser, conditions: list[Condition]
) -> None:
    count = "return patrol.signal.count"
    assert page.run(count) == 0
    conditions.append(trouble("first", Severity.WARNING))
    page.wait(lambda: page.run(count) == 1, "a sound")
    page.press("t")  # any key: from then on the browser lets the page sound
    page.wait(lambda: page.run("return patrol.signal.audio.state") == "running", "the loudspeaker")
    conditions.append(trouble("second", Severity.CRITICAL))
    page.wait(lambda: page.run(count) == 2, "another")
    page.click("#sound")
    conditions.append(trouble("third", Severity.CRITICAL))
    page.wait(lambda: len(page.texts("#alarms li")) == 3, "the third alarm")
    assert page.run(count) == 2
    assert page.run("return document.querySelector('#sound').ariaPressed") == "false"
    page.click("#sound")


def test_notification_takes_a_click_once_and_names_the_alarm(
    page: Browser, conditions: list[Condition]
) -> None:
    page.run(
        "window.told = []; window.Notification = class {"
        " constructor(words) { told.push(words); }"
        " static permission = 'granted'; static requestPermission() {} }"
    )
    conditions.append(trouble("first", Severity.WARNING))
    page.wait(lambda: page.texts("#alarms .mark"), "the first alarm")
    assert page.run("return told") == []
    page.click("#notify")
    assert page.run("return document.querySelector('#notify').ariaPressed") == "true"
    conditions.append(trouble("second", Severity.CRITICAL))
    conditions.append(trouble("remark", Severity.INFO))
    page.wait(lambda: len(page.texts("#alarms li")) == 3, "all alarms")
    assert page.run("return told") == ["monitor: second it is"]
    page.click("#notify")
