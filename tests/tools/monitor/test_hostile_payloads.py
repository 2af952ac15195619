"""Ten thousand broken, huge or hostile payloads are counted, raise an alarm and nothing else."""

from __future__ import annotations

import json
import random
import time
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np

from maps.pose import Pose
from robot_agent.messages.foxglove import Log, PosesInFrame, laser_scan, pose3, timestamp_at
from robot_agent.messages.streams import STREAMS, encode
from tests.tools.monitor.reports import decision, pose, status
from tests.tools.monitor.trouble_team import intruder
from tools.monitor.page_message import PageFeed
from tools.monitor.robot_choice import RobotChoice
from tools.monitor.site import Site
from tools.monitor.team_state import MAX_PAYLOAD_BYTES, MAX_ROBOTS, TeamState
from tools.monitor.text_view import plain_view
from tools.monitor.watch import Watch

COUNT = 10_000
KEY = "patrol/north/anna"
NUMBERS = (1e308, -1e308, 5e-324, 2**63, -(2**63), 2**64, 2**200, 0, -1, 1e999)
WORDS = ("<script>document.title='gone'</script>", "\x1b[2J", "\u202e", "a" * 5000, "']; --", "\0")


def samples() -> dict[str, bytes]:
    scan = laser_scan(timestamp_at(1.0), "laser", -1.5, 0.1, np.ones(31))
    log = Log(timestamp=timestamp_at(1.0), level=3, message="words", name="patrol")
    cloud = PosesInFrame(
        timestamp=timestamp_at(1.0), frame_id="map", poses=[pose3(Pose(1.0, 2.0, 0.5))] * 5
    )
    payloads = {"scan": scan, "event": log, "particles": cloud}
    payloads["intruder"] = intruder(1.0)
    payloads |= {"status": status(1.0), "decision": decision(1.0), "pose": pose(1.0)}
    return {stream: encode(payload) for stream, payload in payloads.items()}


def with_hostile_leaf(value: Any, rng: random.Random) -> Any:
    """Return a decoded payload with one leaf replaced by a hostile value of any type."""
    if isinstance(value, dict) and value:
        key = rng.choice(list(value))
        return {**value, key: with_hostile_leaf(value[key], rng)}
    if isinstance(value, list) and value:
        place = rng.randrange(len(value))
        return [*value[:place], with_hostile_leaf(value[place], rng), *value[place + 1 :]]
    kinds: list[Any] = [rng.choice(NUMBERS), rng.choice(WORDS), None, [], {}]
    return kinds[0] if isinstance(value, (int, float)) and rng.random() < 0.6 else rng.choice(kinds)


def hostile_messages(rng: random.Random) -> Iterator[tuple[str, bytes]]:
    sane = samples()
    decoded = {stream: json.loads(data) for stream, data in sane.items()}
    streams = [*sane]
    for number in range(COUNT):
        stream = rng.choice(streams)
        data = sane[stream]
        match number % 6:
            case 0:
                data = rng.randbytes(rng.randrange(200))
            case 1:
                cut = rng.randrange(len(data))
                data = data[:cut] + rng.randbytes(1) + data[cut + 1 :]
            case 2:
                data = data[: rng.randrange(len(data))]
            case 3 | 4:
                data = json.dumps(with_hostile_leaf(decoded[stream], rng)).encode()
            case _:
                data = b"[" * rng.randrange(1, 20_000)
        yield f"{KEY}/{rng.choice([stream, stream, 'nonsense', *STREAMS])}", data


def test_hostile_payloads_are_counted_and_raise_one_alarm() -> None:
    rng = random.Random(1)
    team = TeamState()
    watch = Watch(team, Site(None))
    feed = PageFeed(watch)
    started = time.process_time()
    for number, (key, data) in enumerate(hostile_messages(rng)):
        t = 0.001 * number
        team.receive(key, data, t, t)
        if number % 50 == 0:
            watch.advance(t, t)
            json.loads(feed.message({}))
            plain_view(watch, RobotChoice("anna")).encode()
    (robot,) = team.snapshot()
    assert robot.malformed > COUNT / 2
    (alarm,) = [alarm for alarm in watch.alarms.alarms() if alarm.kind == "malformed"]
    assert alarm.active
    assert "payloads could not be read" in alarm.text
    team.receive(f"{KEY}/status", encode(status(11.0)), 11.0, 11.0)
    assert team.snapshot()[0].status == status(11.0)
    assert time.process_time() - started < 30.0


def test_huge_payload_is_counted_and_not_decoded() -> None:
    team = TeamState()
    scan = laser_scan(timestamp_at(1.0), "laser", -1.5, 0.1, np.ones(MAX_PAYLOAD_BYTES))
    team.receive(f"{KEY}/scan", encode(scan), 1.0)
    (robot,) = team.snapshot()
    assert (robot.malformed, robot.scan) == (1, None)


def test_large_lists_and_texts_are_cut_for_the_page() -> None:
    team = TeamState()
    watch = Watch(team, Site(None))
    many = laser_scan(timestamp_at(1.0), "laser", -1.5, 0.1, np.ones(40_000))
    wordy = msgspec.structs.replace(decision(1.0), action="x" * 100_000)
    team.receive(f"{KEY}/pose", encode(pose(1.0)), 1.0)
    team.receive(f"{KEY}/scan", encode(many), 1.0)
    team.receive(f"{KEY}/decision", encode(wordy), 1.0)
    watch.advance(1.0, 1.0)
    assert len(PageFeed(watch).message({})) < 10_000


def test_invalid_names_are_stray_and_robots_beyond_the_maximum_are_named() -> None:
    team = TeamState()
    watch = Watch(team, Site(None))
    for key in ("patrol", "patrol//anna/pose", "patrol/north/<b>/pose", "a/b/c/d", ""):
        team.receive(key, encode(pose(1.0)), 1.0)
    for number in range(MAX_ROBOTS + 10):
        team.receive(f"patrol/north/r{number}/pose", encode(pose(1.0)), 1.0)
    watch.advance(1.0, 1.0)
    assert len(team.snapshot()) == MAX_ROBOTS
    texts = {alarm.kind: alarm.text for alarm in watch.alarms.alarms()}
    assert team.stray == 5
    assert "5 messages" in texts["stray"]
    assert "not shown: north/r64, north/r65" in texts["hidden"]
    assert "5 more" in texts["hidden"]
