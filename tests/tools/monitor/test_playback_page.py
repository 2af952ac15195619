"""Playback of recordings on the page, in Chromium."""

from __future__ import annotations

from pathlib import Path

from tests.tools.monitor.agent_recordings import START, agent_recording
from tests.tools.monitor.browser import Browser
from tools.monitor.playback import Playback
from tools.monitor.playback_page import playback_page


def test_recordings_play_pause_and_seek(browser: Browser, tmp_path: Path) -> None:
    paths = [
        agent_recording("anna", tmp_path / "anna.mcap", START, 60.0),
        agent_recording("bob", tmp_path / "bob.mcap", START, 60.0),
    ]
    playback = Playback(paths)
    with playback_page(playback, playback.site(), "127.0.0.1:0") as server:
        browser.open(server.url)
        browser.wait(lambda: browser.texts(".card .name") == ["anna", "bob"], "both robots")
        assert browser.text("#link") == "playback"
        assert browser.text("#site") == "paper_lab"
        browser.press(" ")
        browser.wait(lambda: browser.text("#playback button") == "Play", "the pause")
        browser.run(
            f"const slider = document.querySelector('#playback input');"
            f"slider.value = {START + 30.0}; slider.dispatchEvent(new Event('change'))"
        )
        browser.wait(lambda: "30 s of 60 s" in browser.text("#playback span"), "the time wanted")
        browser.wait(
            lambda: abs(float(str(pose_x(browser))) - 3.0) < 0.11, "anna where she was then"
        )
        samples = browser.run("return window.patrol.team.robots.get('north/anna').samples.length")
        assert int(str(samples)) > 20, "what came before is there for the plots"
        browser.press(" ")
        browser.wait(lambda: playback.t > START + 30.5, "that it goes on")
    assert [line for line in browser.console_messages() if "JavaScript" in line] == []


def pose_x(browser: Browser) -> object:
    return browser.run("return window.patrol.team.robots.get('north/anna')?.pose?.[0] ?? -1")
