"""Robots, laptop and attacker in network namespaces on one bridge."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO

import pytest

from robot_agent.config import find_map
from tools.logs.recording import read_recording
from tools.monitor.recorded_payloads import RecordedPayloads
from tools.replay.replay import Replay

REPOSITORY = Path(__file__).resolve().parents[3]
TIMEOUT_S = 60.0
LAPTOP, ROBOTS, ATTACKER = "10.77.0.1", ("10.77.0.11", "10.77.0.12"), "10.77.0.66"

ATTACK = """
import socket, sys, time
import zenoh
from robot_agent.process.telemetry import session_config
laptop, *robots = sys.argv[1:]
with zenoh.open(session_config(f"tcp/{laptop}:7447")) as session:
    while True:
        for robot in ("robot1", "robot2", "*"):
            for key in ("command", "stop", "pose", "decision", "base/rx", "tick", "**"):
                if "*" not in key + robot:
                    session.put(f"patrol/demo/{robot}/{key}", b'{"v": 1.0, "w": 1.0}')
        session.put("cmd_vel", b"1.0")
        session.delete("patrol/demo/robot1/pose")
        list(session.get("patrol/**", timeout=0.05))
        for address in robots:
            for port in (22, 80, 7446, 7447, 7448, 8080):
                with socket.socket() as probe:
                    probe.settimeout(0.02)
                    if probe.connect_ex((address, port)) == 0:
                        print("open", address, port, flush=True)
        time.sleep(0.05)
"""


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True)


@contextmanager
def networks() -> Iterator[dict[str, str]]:
    """Make a namespace per address on the laptop's bridge; skip the test where that fails."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        pytest.skip("network namespaces need root and iproute2")
    names = {
        address: f"patrol{os.getpid()}n{number}"
        for number, address in enumerate((LAPTOP, *ROBOTS, ATTACKER))
    }
    laptop = names[LAPTOP]
    try:
        try:
            for name in names.values():
                ip("netns", "add", name)
                inside(name, "sysctl", "-qw", "net.ipv6.conf.all.disable_ipv6=1", check=False)
                ip("-n", name, "link", "set", "lo", "up")
            ip("-n", laptop, "link", "add", "bridge", "type", "bridge")
        except subprocess.CalledProcessError as error:
            pytest.skip(f"this machine makes no network namespaces: {error.stderr.decode()}")
        ip("-n", laptop, "addr", "add", f"{LAPTOP}/24", "dev", "bridge")
        ip("-n", laptop, "link", "set", "bridge", "up")
        for number, (address, name) in enumerate(names.items()):
            if address != LAPTOP:
                plug_in(laptop, name, address, f"port{number}")
        yield names
    finally:
        for name in names.values():
            subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)


def plug_in(laptop: str, name: str, address: str, port: str) -> None:
    """Connect a namespace to the laptop's bridge, with an address."""
    ip("-n", laptop, "link", "add", port, "type", "veth", "peer", "name", "eth0", "netns", name)
    ip("-n", laptop, "link", "set", port, "master", "bridge", "up")
    ip("-n", name, "addr", "add", f"{address}/24", "dev", "eth0")
    ip("-n", name, "link", "set", "eth0", "up")


def inside(name: str, *words: str, check: bool = True) -> str:
    command = ["ip", "netns", "exec", name, *words]
    return subprocess.run(command, check=check, capture_output=True, text=True).stdout


@contextmanager
def process(
    *words: str, out: IO[str] | int = subprocess.DEVNULL
) -> Iterator[subprocess.Popen[str]]:
    """Run a process; end it by SIGTERM afterwards, by SIGKILL if it does not end."""
    with subprocess.Popen(
        words, stdout=out, stderr=subprocess.DEVNULL, text=True, cwd=REPOSITORY
    ) as started:
        try:
            yield started
        finally:
            started.send_signal(signal.SIGTERM)
            try:
                started.wait(10.0)
            except subprocess.TimeoutExpired:
                started.kill()


def wait_until(condition: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < deadline, f"never: {what}"
        time.sleep(0.1)


def write_config(robot: dict[str, object], folder: Path) -> Path:
    x, y, theta = robot["start"]  # type: ignore[misc]
    path = folder / f"{robot['name']}.toml"
    path.write_text(
        f'[robot]\nname = "{robot["name"]}"\nteam = "demo"\n'
        f'[base]\nurl = "{robot["base"]}"\n[laser]\nurl = "{robot["laser"]}"\n'
        f"[start]\nx = {x}\ny = {y}\ntheta = {theta}\n"
        f'[telemetry]\noperator = "tcp/{LAPTOP}:7447"\n'
    )
    return path


def sockets(name: str) -> list[tuple[str, str, str]]:
    """Return protocol, peer's address and state of every socket in a namespace."""
    found = []
    for protocol in ("tcp", "udp", "raw"):
        for line in inside(name, "cat", f"/proc/net/{protocol}").splitlines()[1:]:
            _, _, peer, state, *_ = line.split()
            octets = re.findall("..", peer.split(":")[0])
            address = ".".join(str(int(octet, 16)) for octet in reversed(octets))
            found.append((protocol, address, state))
    return found


def test_robots_connect_to_the_operator_only_under_attack(tmp_path: Path) -> None:
    python = sys.executable
    patrol = (python, "-m", "tools.cli")
    world_command = (python, "-m", "tools.demo.world_server", str(find_map("paper_lab", Path())))
    options = ("--border", "border", "--robots", "2", "--seed", "5")
    team_file = tmp_path / "team.mcap"
    with ExitStack() as stack:
        names = stack.enter_context(networks())
        enter = {address: ("ip", "netns", "exec", name) for address, name in names.items()}
        world = stack.enter_context(
            process(
                *world_command,
                *options,
                "--truth",
                "plain",
                "--poses",
                str(tmp_path / "poses"),
                out=subprocess.PIPE,
            )
        )
        assert world.stdout is not None
        robots = json.loads(world.stdout.readline())
        counter = stack.enter_context(
            process(
                *enter[LAPTOP],
                python,
                "-m",
                "tests.tools.monitor.traffic",
                out=subprocess.PIPE,
            )
        )
        assert counter.stdout is not None
        assert counter.stdout.readline() == "listening\n"
        monitor = ("monitor", "--text", "--listen", f"tcp/{LAPTOP}:7447", "--record")
        stack.enter_context(process(*enter[LAPTOP], *patrol, *monitor, str(team_file)))
        attack_log = stack.enter_context((tmp_path / "attack").open("w+"))
        with ExitStack() as running:
            running.enter_context(
                process(*enter[ATTACKER], python, "-c", ATTACK, LAPTOP, *ROBOTS, out=attack_log)
            )
            for address, robot in zip(ROBOTS, robots, strict=True):
                record = ("--record", str(tmp_path / f"{robot['name']}.mcap"))
                config = write_config(robot, tmp_path)
                running.enter_context(
                    process(*enter[address], *patrol, "agent", str(config), *record)
                )
            wait_until(lambda: decisions(team_file) > 40, "decisions of both robots")
            open_sockets = {address: sockets(names[address]) for address in ROBOTS}
        counter.send_signal(signal.SIGTERM)
        counted = json.load(counter.stdout)

    for address in ROBOTS:
        assert open_sockets[address] == [("tcp", LAPTOP, "01")], "one connection, no open port"
        assert counted[f"{address} {LAPTOP}"] > 10_000
    between = {pair: size for pair, size in counted.items() if pair.split()[0] in ROBOTS}
    assert set(between) == {
        *(f"{address} {LAPTOP}" for address in ROBOTS),
        *(f"{address} {ATTACKER}" for address in ROBOTS),  # refusals of its connections
    }
    assert (tmp_path / "attack").read_text() == "", "no port of a robot is open"
    for robot in robots:
        replay = Replay(read_recording(tmp_path / f"{robot['name']}.mcap")).run()
        assert replay.difference is None
        assert replay.decisions > 20


def decisions(path: Path) -> int:
    """Return the smaller count of the robots' recorded decisions, without forged ones."""
    if not path.exists() or path.stat().st_size < 1000:
        return 0
    try:
        payloads = list(RecordedPayloads(path).payloads(0.0))
    except ValueError:
        return 0
    heard = [payload.key for payload in payloads if b"timestamp" in payload.data]
    return min(heard.count(f"patrol/demo/{name}/decision") for name in ("robot1", "robot2"))
