"""Intruders: strangers that stay near the border, each reported once and then updated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from maps.border import Border
from robot_agent.perception.identity import Kind
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.track import TRACK_MEMORY, Track

_MEMORY = 60.0  # s unseen within which an intruder that comes back keeps its number
_SEEN_LATELY = 0.5  # s; the position of a track not seen for longer is uncertain
_WALK = 1.5  # m/s; speed assumed of a person unseen
_FARTHEST_WALK = 10.0  # m
_SAME_PLACE = 0.8  # m; detections this near are of one intruder
_SAME_STANDER = 0.5  # m; a track started this near the position of an intruder just lost is it
_TURNED_AWAY = 10.0  # s unseen within which that holds: robots turn round beside strangers
_DOUBT = 1.0  # s after a track was last a teammate during which it is no intruder
_EDGE = 0.3  # m; hysteresis of the zone's border for a track in it


@dataclass(frozen=True, slots=True)
class Intruder:
    """A stranger near the border.

    number: counts from 1. x, y: m, map frame, when last seen. abscissa, distance: along and from
    the border, m; closest: the smallest distance so far. first_seen, last_seen: times. track: id
    of its present track.
    """

    number: int
    track: int
    x: float
    y: float
    abscissa: float
    distance: float
    closest: float
    first_seen: float
    last_seen: float


@dataclass(frozen=True, slots=True)
class _Candidate:
    """A track near the border, since a time, that is not classified as a stranger yet.

    Once it is, its whole stay counts. began: x, y, m, where the track was first near the border.
    """

    track: int
    since: float
    last_seen: float
    x: float
    y: float
    began: tuple[float, float]
    taken_for_teammate: float  # when last; -inf if never


class Intruders:
    """Detects intruders among the tracks near a border."""

    def __init__(self, settings: PerceptionSettings, border: Border) -> None:
        self._settings = settings
        self._border = border
        self._candidates: dict[int, _Candidate] = {}
        self._number = 0
        self.known: list[Intruder] = []
        """Intruders seen within the last minute, oldest first."""

    def update(self, t: float, tracks: Sequence[Track]) -> list[Intruder]:
        """Process the tracks at t; return the intruders that are new, and update ``known``."""
        settings = self._settings
        self._forget(t)
        new: list[Intruder] = []
        for track in tracks:
            if t - track.last_seen > _SEEN_LATELY:
                continue
            foot = self._border.project(track.x, track.y)
            zone = settings.intruder_distance
            stays = track.id in self._candidates
            if foot.distance > zone + (_EDGE if stays else 0.0):
                self._candidates.pop(track.id, None)
                continue
            if track.teammate and not stays:
                continue
            candidate = self._candidate(track)
            self._candidates[track.id] = candidate
            stayed = track.last_seen - candidate.since
            doubted = track.last_seen - candidate.taken_for_teammate < _DOUBT
            if doubted or stayed < settings.intruder_time:
                continue
            if not (_is_stranger(track, t, settings) or self._stands_where_one_was(track)):
                continue
            known = self._known(t, track, tracks)
            if known is None and self._is_beside_one(t, track):
                continue
            intruder = Intruder(
                number=known.number if known else self._number + 1,
                track=track.id,
                x=track.x,
                y=track.y,
                abscissa=foot.abscissa,
                distance=foot.distance,
                closest=min(foot.distance, known.closest if known else math.inf),
                first_seen=known.first_seen if known else candidate.since,
                last_seen=track.last_seen,
            )
            if known is None:
                self._number += 1
                self.known.append(intruder)
                new.append(intruder)
            else:
                self.known[self.known.index(known)] = intruder
        return new

    def _candidate(self, track: Track) -> _Candidate:
        """Return the candidate of a track, whose stay may have begun under another track."""
        own = self._candidates.get(track.id)
        if own is None:
            own = next(
                (
                    each
                    for each in self._candidates.values()
                    if each.last_seen < track.first_seen
                    and _reachable(
                        each.x, each.y, (track.x, track.y), track.first_seen - each.last_seen
                    )
                ),
                None,
            )
        just_found = track.last_seen - track.first_seen < _SEEN_LATELY
        since = own.since if own else track.first_seen if just_found else track.last_seen
        taken_for_teammate = own.taken_for_teammate if own else -math.inf
        if track.teammate:
            taken_for_teammate = track.last_seen
        place = track.x, track.y
        began = own.began if own and own.track == track.id else place
        return _Candidate(track.id, since, track.last_seen, *place, began, taken_for_teammate)

    def _stands_where_one_was(self, track: Track) -> bool:
        """Return whether a track is a known intruder's, or began where one was last seen."""
        return any(
            each.track == track.id
            or (
                0.0 < track.first_seen - each.last_seen < _TURNED_AWAY
                and math.hypot(track.x - each.x, track.y - each.y) < _SAME_STANDER
            )
            for each in self.known
        )

    def _known(self, t: float, track: Track, tracks: Sequence[Track]) -> Intruder | None:
        """Return the known intruder that a track belongs to; None if there is none."""
        for each in self.known:
            if each.track == track.id:
                return each
        followed = {other.id for other in tracks if t - other.last_seen <= _SEEN_LATELY}
        began = self._candidates[track.id].began
        near = [
            each
            for each in self.known
            if each.track not in followed
            and _reachable(each.x, each.y, began, track.first_seen - each.last_seen)
        ]
        if not near:
            return None
        nearest = min(near, key=lambda each: math.hypot(each.x - track.x, each.y - track.y))
        moved = replace(nearest, track=track.id)
        self.known[self.known.index(nearest)] = moved
        return moved

    def _is_beside_one(self, t: float, track: Track) -> bool:
        """Return whether a track is so near an intruder just seen that both may be one.

        Legs in a wide stride are two tracks for a while; persons who part are reported then.
        """
        return any(
            t - each.last_seen <= _SEEN_LATELY
            and math.dist((track.x, track.y), (each.x, each.y)) <= _SAME_PLACE
            for each in self.known
        )

    def _forget(self, t: float) -> None:
        self.known = [each for each in self.known if t - each.last_seen <= _MEMORY]
        self._candidates = {
            number: each
            for number, each in self._candidates.items()
            if t - each.last_seen <= TRACK_MEMORY
        }


def _is_stranger(track: Track, t: float, settings: PerceptionSettings) -> bool:
    """Return whether a track is a stranger, or unknown for long and not the size of a robot."""
    if track.kind is Kind.UNKNOWN:
        old = t - track.first_seen >= settings.intruder_time
        return old and not track.robot_sized
    return track.kind is Kind.STRANGER


def _reachable(x: float, y: float, began: tuple[float, float], unseen: float) -> bool:
    walked = min(_WALK * max(unseen, 0.0), _FARTHEST_WALK)
    return math.dist((x, y), began) <= _SAME_PLACE + walked
