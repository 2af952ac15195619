"""The bench's perception figures, with bodies and tracks placed by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import find_map
from robot_agent.perception.identity import Kind, Probabilities
from robot_agent.perception.intruders import Intruder
from robot_agent.perception.track import Track
from tools.bench.perception_log import PerceptionLog
from tools.simulation.robot_body import BodyKind, RobotBody
from tools.simulation.stranger import PERSON
from tools.simulation.world import World

S = 32.0  # m; a straight piece of the border


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path.cwd()))


class Stage:
    """A robot on the border, with a person 1.5 m ahead and another 1.2 m farther on."""

    def __init__(self, folder: MapFolder) -> None:
        assert folder.border is not None
        at = folder.border.at(S)
        self.here = Pose(at.x, at.y, math.atan2(at.ty, at.tx))
        self.world = World(folder.map, np.random.default_rng(1))
        self.robot = self.world.add_body(self.here)
        self.near, self.far = (self._person(ahead, 0.5 - ahead / 3) for ahead in (1.5, 2.7))
        self.log = PerceptionLog(self.world, folder.border)
        self.tracks: list[Track] = []
        self.known: list[Intruder] = []
        self.watched: set[int] = set()

    def _person(self, ahead: float, aside: float) -> RobotBody:
        body = self.world.add_body(self.here.compose(Pose(ahead, aside, 0.0)), PERSON)
        body.kind = BodyKind.PERSON
        return body

    def report(self, number: int, x: float, y: float, last_seen: float | None = None) -> None:
        """Add an intruder at a place to the robot's known ones, seen at a time or always."""
        self.known.append(Intruder(number, number, x, y, 0.0, 0.0, 0.0, 0.0, last_seen or 0.0))
        if last_seen is None:
            self.watched.add(number)

    def run(self, since: float, until: float) -> dict[str, Any]:
        """Sample ten times a second from one time to another, s; return the figures so far."""
        for step in range(round((until - since) * 10)):
            t = since + 0.1 * step
            known = [
                replace(each, last_seen=t) if each.number in self.watched else each
                for each in self.known
            ]
            sight = SimpleNamespace(
                tracker=SimpleNamespace(tracks_at=lambda _t: self.tracks),
                intruders=SimpleNamespace(known=known),
            )
            self.log.sample(t, self.robot, cast(Agent, SimpleNamespace(perception=sight)))
        return self.log.figures()


def place(body: RobotBody) -> tuple[float, float]:
    return body.pose.x, body.pose.y


def test_unreported_stay_is_counted(folder: MapFolder) -> None:
    strangers = Stage(folder).run(0.0, 6.0)["strangers"]
    assert strangers["stays"] == strangers["stays_unreported"] == 1
    assert strangers["stays_reported_once"] == 0


def test_too_short_stay_is_not_counted(folder: MapFolder) -> None:
    assert Stage(folder).run(0.0, 3.0)["strangers"]["stays"] == 0


def test_second_report_of_a_stay_is_not_counted_as_reported_once(folder: MapFolder) -> None:
    stage = Stage(folder)
    stage.report(1, *place(stage.near))
    assert stage.run(0.0, 6.0)["strangers"]["stays_reported_once"] == 1
    stage.report(2, *place(stage.near))
    figures = stage.run(6.0, 8.0)["strangers"]
    assert figures["stays"] == 1
    assert figures["stays_reported_once"] == figures["stays_unreported"] == 0


def test_old_report_at_the_place_does_not_count_for_a_new_stay(folder: MapFolder) -> None:
    stage = Stage(folder)
    stage.report(1, *place(stage.near), -20.0)
    assert stage.run(0.0, 6.0)["strangers"]["stays_unreported"] == 1


def test_report_counts_for_the_nearest_stranger(folder: MapFolder) -> None:
    stage = Stage(folder)
    assert stage.world.place(stage.far, stage.here.compose(Pose(1.5, -0.5, 0.0)))
    between = stage.here.compose(Pose(1.5, -0.3, 0.0))
    stage.report(1, between.x, between.y)
    figures = stage.run(0.0, 6.0)["strangers"]
    assert figures["stays"] == 2
    assert figures["stays_reported_once"] == figures["stays_unreported"] == 1


@pytest.mark.parametrize(("kind", "share"), [(Kind.TEAMMATE, 1.0), (Kind.STRANGER, 0.0)])
def test_stranger_classified_as_teammate_is_counted(
    folder: MapFolder, kind: Kind, share: float
) -> None:
    stage = Stage(folder)
    x, y = place(stage.near)
    stage.tracks = [
        Track(
            *(1, x, y, 0.0, 0.0, np.eye(2), 0.0, 1e3, kind, Probabilities(0.0, 0.0, 1.0)),
            robot_sized=True,
            moving=False,
            by_color=False,
        )
    ]
    figures = stage.run(0.0, 2.0)
    assert figures["strangers"]["taken_for_teammate"] == share
    assert figures["false_teammate"] == (1.0 if share else None)
