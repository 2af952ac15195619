"""What is said while no robot has reported: what robots dial."""

from __future__ import annotations

import re
import socket
from contextlib import closing

import pytest

from tests.tools.monitor.agent_recordings import FOLDER
from tests.tools.monitor.browser import Browser
from tools.monitor.dial_address import dial_endpoints, reaches_this_computer_only
from tools.monitor.site import Site
from tools.monitor.source import LiveSource
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch
from tools.monitor.web_server import WebServer


@pytest.mark.parametrize("listen", ["tcp/192.168.1.10:7447", "tls/operator.example:7447"])
def test_address_listened_on_is_the_one_dialled(listen: str) -> None:
    assert dial_endpoints(listen) == [listen]
    assert not reaches_this_computer_only(listen)


@pytest.mark.parametrize("listen", ["tcp/0.0.0.0:7447", "tls/[::]:7447"])
def test_every_address_is_dialled_by_this_computers_own(listen: str) -> None:
    protocol = listen.partition("/")[0]
    *numbers, name = dial_endpoints(listen)
    assert name == f"{protocol}/{socket.gethostname()}:7447"
    assert all(re.fullmatch(rf"{protocol}/[\d.]+:7447", each) for each in numbers)
    assert not reaches_this_computer_only(listen)


@pytest.mark.parametrize("listen", ["tcp/127.0.0.1:7447", "tcp/[::1]:7447", "tcp/localhost:7447"])
def test_loopback_is_told(listen: str) -> None:
    assert reaches_this_computer_only(listen)


@pytest.mark.parametrize(
    ("listen", "only_here"), [("tcp/192.168.1.10:7447", False), ("tcp/127.0.0.1:7447", True)]
)
def test_empty_page_says_what_robots_dial(browser: Browser, listen: str, only_here: bool) -> None:
    watch = Watch(TeamState(), Site(FOLDER))
    with closing(WebServer(watch, LiveSource(listen), "127.0.0.1:0")) as server:
        browser.open(server.url)
        browser.wait(lambda: browser.text("#empty code") == listen, "the address")
        assert f'operator = "{listen}"' in browser.text("#empty pre")
        assert bool(browser.text("#empty .warn")) == only_here
        assert browser.text("#summary").startswith("0 of 0 robots heard")
        assert "all well" not in browser.text("#summary")
        browser.open("about:blank")
