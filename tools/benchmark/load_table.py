"""Load of the monitor and its page under many robots: CPU, frame rate, robot-to-pixel latency."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import psutil
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from tools.deploy.child_program import environment, program
from tools.monitor.endpoint import free_endpoint

SETTLED_S = 8.0
CHROMIUM_ARGUMENTS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@dataclass(frozen=True)
class LoadFigures:
    """Figures of the monitor process and of its page."""

    robots: int
    server_cpu: float
    """Share of one core."""
    server_mb: float
    messages_per_s: float
    """Payloads per second sent to the operator, all robots together."""
    page: PageFigures | None
    """None where no browser is installed."""


@dataclass(frozen=True)
class PageFigures:
    """Figures of the page in Chromium without a graphics card.

    Latency, s, is from a pose's own time stamp until the page has drawn it.
    """

    robots: int
    """Number of robots shown."""
    frames_per_s: float
    cpu_per_frame: float
    """CPU time of all Chromium processes per redraw, s."""
    latency_median: float  # s
    latency_p99: float  # s


@contextmanager
def _process(module: str, *words: str) -> Iterator[subprocess.Popen[str]]:
    command = program(module, *words)
    with subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def measure_load(robots: int, seconds: float) -> LoadFigures:
    """Run a monitor with its page under a number of robots and measure for some seconds."""
    endpoint = free_endpoint()
    http = free_endpoint().removeprefix("tcp/")
    with ExitStack() as stack:
        words = ("tools.cli", "monitor", "--map", "paper_lab")
        monitor = stack.enter_context(_process(*words, "--listen", endpoint, "--http", http))
        module = "tools.benchmark.telemetry_load"
        load = stack.enter_context(_process(module, endpoint, str(robots)))
        assert load.stdout is not None
        rate = float(load.stdout.readline())  # it has begun
        page = stack.enter_context(_page(f"http://{http}/"))
        server = psutil.Process(monitor.pid)
        time.sleep(SETTLED_S)
        page.run("window.patrol.figures.delays.length = 0")
        started = time.monotonic()
        server_before, page_before = _cpu(server), page.cpu()
        drawn = page.run("return window.patrol.figures.count")
        time.sleep(seconds)
        elapsed = time.monotonic() - started
        server_used, page_used = _cpu(server) - server_before, page.cpu() - page_before
        return LoadFigures(
            robots,
            server_used / elapsed,
            server.memory_info().rss / 2**20,
            rate,
            _page_figures(page, drawn, elapsed, page_used),
        )


def _cpu(process: psutil.Process) -> float:
    """Return the CPU time a process has used, s."""
    times = process.cpu_times()
    return times.user + times.system


class Page:
    """The page in Chromium; without a driver (None) its methods return None and 0."""

    def __init__(self, driver: webdriver.Chrome | None) -> None:
        self._driver = driver

    def run(self, script: str) -> Any:
        """Run a script in the page and return its result; None without a browser."""
        return None if self._driver is None else self._driver.execute_script(script)

    def cpu(self) -> float:
        """Return the CPU time of the browser's processes, s; 0 without a browser."""
        if self._driver is None or self._driver.service.process is None:
            return 0.0
        driver = psutil.Process(self._driver.service.process.pid)
        return sum(_cpu(child) for child in driver.children(recursive=True))


def _page_figures(page: Page, drawn: int | None, elapsed: float, used: float) -> PageFigures | None:
    if drawn is None:
        return None
    frames = page.run("return window.patrol.figures.count") - drawn
    delays = np.array(page.run("return window.patrol.figures.delays")) / 1e3
    shown = page.run("return window.patrol.team.ordered.length")
    median, p99 = (float(np.percentile(delays, share)) for share in (50, 99))
    return PageFigures(shown, frames / elapsed, used / max(frames, 1), median, p99)


@contextmanager
def _page(url: str) -> Iterator[Page]:
    """Open a URL in Chromium; yield a page without browser where it is not installed."""
    program, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if program is None or driver is None:
        print("no chromium and chromedriver here: the page is not measured", file=sys.stderr)
        yield Page(None)
        return
    options = webdriver.ChromeOptions()
    options.binary_location = program
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        for argument in (*CHROMIUM_ARGUMENTS, f"--user-data-dir={profile}"):
            options.add_argument(argument)
        chrome = webdriver.Chrome(options=options, service=Service(driver))
        try:
            size = {"width": 1366, "height": 768, "deviceScaleFactor": 1, "mobile": False}
            chrome.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
            chrome.get(url)
            yield Page(chrome)
        finally:
            chrome.quit()
