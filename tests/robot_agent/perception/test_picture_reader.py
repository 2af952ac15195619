"""From the emulated robot's MJPEG stream through the camera driver into the inbox."""

from __future__ import annotations

import math
import time
from queue import Empty, SimpleQueue

import numpy as np
import pytest

from drivers.camera import Camera
from drivers.camera_source import CameraSettings
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.messages.events import BlobsSeen, Event, LinkDown, LinkUp, PictureTaken
from robot_agent.perception.camera_watch import CameraWatch
from robot_agent.perception.color_settings import ColorSettings
from robot_agent.perception.picture_reader import PictureReader
from tools.simulation.emulated_camera import CameraServer, EmulatedCamera
from tools.simulation.world import World

LIMIT_S = 20.0


def world() -> World:
    cells = np.full((122, 202), OCCUPIED, dtype=np.uint8)
    cells[1:-1, 1:-1] = FREE
    hall = OccupancyMap(cells=cells, resolution=0.05, origin=Pose(-0.05, -0.05, 0.0))
    return World(hall, np.random.default_rng(1))


def next_of(inbox: SimpleQueue[Event], kind: type, server: CameraServer | None = None) -> Event:
    """Return the next event of a kind, serving pictures meanwhile."""
    give_up = time.monotonic() + LIMIT_S
    while time.monotonic() < give_up:
        if server is not None:
            server.pump(time.monotonic())
        try:
            event = inbox.get(timeout=0.02)
        except Empty:
            continue
        if isinstance(event, kind):
            return event
    raise AssertionError(f"no {kind.__name__} within {LIMIT_S:g} s")


def test_band_and_lost_camera_arrive_as_events() -> None:
    scene = world()
    own = scene.add_body(Pose(3.0, 3.0, 0.0))
    scene.add_body(Pose(5.0, 3.4, 2.0))
    server = CameraServer(EmulatedCamera(scene, own).picture_at)
    inbox: SimpleQueue[Event] = SimpleQueue()
    settings = CameraSettings(url=server.url, delay=0.15)
    reader = PictureReader(settings, ColorSettings(), inbox.put)
    camera = Camera(settings, time.monotonic, reader)
    camera.start()
    try:
        assert next_of(inbox, LinkUp, server).t > 0.0
        seen = next_of(inbox, BlobsSeen, server)
        assert isinstance(seen, BlobsSeen)
        assert seen.sight == "clear"
        assert seen.t - seen.taken == pytest.approx(0.15, abs=1e-5)
        [blob] = seen.blobs
        assert blob.bearing == pytest.approx(math.atan2(0.4, 1.9), abs=0.06)
        assert blob.range == pytest.approx(1.75, abs=0.35)
        reader.request_picture()
        picture = next_of(inbox, PictureTaken, server)
        assert isinstance(picture, PictureTaken)
        assert picture.jpeg.startswith(b"\xff\xd8")
        server.close()
        down = next_of(inbox, LinkDown)
        assert isinstance(down, LinkDown)
        assert down.link == "camera"
        assert down.reason
    finally:
        camera.close()
        server.close()


def test_watch_reports_the_state_of_the_camera() -> None:
    watch = CameraWatch(CameraSettings())
    assert watch.state(0.0) == "off"
    assert watch.trouble(0.0) == ""
    watch = CameraWatch(CameraSettings(url="/dev/video0"))
    assert watch.state(0.0) == "down"
    watch.opened(1.0)
    watch.on_picture(BlobsSeen(1.2, 1.1, "clear", ()))
    assert watch.state(1.5) == "clear"
    assert watch.state(3.0) == "silent"
    for k in range(12):
        watch.on_picture(BlobsSeen(3.0 + 0.2 * k, 3.0 + 0.2 * k, "glare", ()))
    assert watch.state(5.3) == "glare"
    assert "camera glare" in watch.trouble(5.3)
    watch.lost("unplugged")
    assert watch.state(5.4) == "down"
    assert "unplugged" in watch.trouble(5.4)
