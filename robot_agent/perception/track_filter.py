"""Kalman filter of a track: constant velocity while detected, decaying velocity while not."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.perception.identity import Identity, Kind
from robot_agent.perception.kalman import KalmanFilter
from robot_agent.perception.track import TRACK_MEMORY, Track, is_robot_like

CONFIRM_HITS = 3  # detections until a track is confirmed
VELOCITY_NOISE = 0.05  # m^2/s^3; spectral density of the acceleration
FIRST_SPEED_SIGMA = 0.35  # m/s; of a new track's velocity, per axis
GATE = 11.8  # squared Mahalanobis distance: 99.7 % of two dimensions
GATE_DISTANCE = 1.0  # m; no association beyond, whatever the covariance
VELOCITY_DECAY = 1.0  # s; time constant of an unseen track's velocity
MOTION_WINDOW = 2.5  # s over which displacement is measured
MOTION_DISTANCE = 0.20  # m beyond twice the position's sigma: a larger displacement is motion
MAX_ROBOT_SPEED = 0.65  # m/s; nothing faster is a teammate
_SAMPLE_PERIOD = 0.2  # s between the past positions kept to detect motion
_BROKEN_SIGHT = 3  # misses in a row after which the next detection may be of another object
_SIZE_KNOWN = 5  # detections of the whole object after which its size is evidence
_START = 0.1  # m; prediction error of an object that starts or stops between two scans
_MANOEUVRE_GATE = 9.2  # squared Mahalanobis distance (99 %) beyond which its speed has changed
_FITS, _FITS_NOT = 0.6, 1.0  # misfit below which most robots are, above which few are
_MIN_FITS = 3  # scans in a row whose outline fits, for a track that may be a robot
_COMES = 0.1  # m/s towards an observer at which it approaches
_MIN_SPEED, _MAX_SPEED = 0.2, 0.55  # m/s of a robot that patrols; people walk faster
_POSITION_OF_STATE = np.eye(2, 4)
_PLANE = np.eye(2)
_STILL = np.eye(4)


@dataclass(frozen=True, slots=True)
class Detection:
    """A measured centre: x, y in m, map frame; variances and covariance in m^2.

    whole: enough of it was seen to start a track. robot_sized: it may be a robot by its size.
    small: by a silhouette that a leg or a post has too. misfit: of the best silhouette
    (``OutlineFit``). reflecting: it wears reflecting tape, if the laser reports that. legs: it is
    a pair of them.
    """

    x: float
    y: float
    var_x: float
    var_y: float
    cov_xy: float
    whole: bool
    robot_sized: bool = True
    small: bool = False
    misfit: float = math.inf
    reflecting: bool = False
    legs: bool = False


@dataclass(frozen=True, slots=True)
class _PastPosition:
    t: float
    x: float
    y: float
    variance: float


class TrackFilter:
    """Filter of the state (x, y, vx, vy), map frame, m and m/s, with hits, misses and class."""

    def __init__(
        self,
        track_id: int,
        t: float,
        detection: Detection,
        *,
        reflecting_bands: bool = False,
        housing_ahead: float = 0.0,
    ) -> None:
        """Start a track at t from a detection.

        reflecting_bands: whether a reflector is evidence of a teammate. housing_ahead: m from the
        middle of a teammate's body to that of its scanner's housing.
        """
        self._reflecting_bands = reflecting_bands
        self._housing_ahead = housing_ahead
        self.id = track_id
        self.first_seen = t
        self.last_seen = t
        self.supported = t
        """Time of the last update by laser or sonar."""
        self.identity = Identity()
        self.hits = 1
        self.misses = 0
        self._t = t
        self._has_moved = False
        self._next_evidence = t
        self._whole, self._robot_sized = 1, int(detection.robot_sized)
        self._fits = self._small_fits = 0  # in a row
        self._legs = 0  # likewise, until they are enough: then one leg may hide the other
        self._approached = -math.inf  # when it last came nearer
        self._past: deque[_PastPosition] = deque()
        self._kalman = KalmanFilter(dim_x=4, dim_z=2)
        self._kalman.H = _POSITION_OF_STATE
        self._kalman.x = np.array((detection.x, detection.y, 0.0, 0.0))
        self._kalman.P = np.zeros((4, 4))
        self._kalman.P[:2, :2] = _covariance(detection)
        self._kalman.P[2, 2] = self._kalman.P[3, 3] = FIRST_SPEED_SIGMA**2

    @property
    def confirmed(self) -> bool:
        """Whether it was detected often enough to be no false detection."""
        return self.hits >= CONFIRM_HITS

    @property
    def robot_sized(self) -> bool:
        """Whether it was as large as a robot in most detections that showed it whole."""
        return self._robot_sized > 0.7 * self._whole

    @property
    def teammate(self) -> bool:
        """Whether it is a teammate."""
        return self.identity.kind is Kind.TEAMMATE

    @property
    def may_be_teammate(self) -> bool:
        """Whether its kind is unknown and its outline alone is a robot's."""
        return self.identity.kind is Kind.UNKNOWN and self._fits >= _MIN_FITS

    @property
    def position(self) -> tuple[float, float]:
        """x and y at the latest prediction, m, map frame."""
        x, y = self._kalman.x[:2].tolist()
        return x, y

    @property
    def robot_like(self) -> bool:
        """As of its ``Track``, without making one."""
        return is_robot_like(
            self.identity.kind,
            by_color=self.identity.by_color,
            moving=self._has_moved,
            robot_sized=self.robot_sized,
        )

    def watch_approach(self, t: float, pose: Pose) -> None:
        """Notice at t whether it comes nearer to a robot at a pose, map_from_base."""
        x, y, vx, vy = self._kalman.x.tolist()
        dx, dy = pose.x - x, pose.y - y
        comes = vx * dx + vy * dy > _COMES * math.hypot(dx, dy)
        if comes and not self.misses and self.robot_like:
            self._approached = t

    def approached_lately(self, t: float) -> bool:
        """Return whether something like a robot came nearer within ``TRACK_MEMORY`` before t."""
        return t - self._approached <= TRACK_MEMORY and self.robot_like

    def predict(self, t: float) -> None:
        """Predict the state to t; the velocity decays while the track has no detections."""
        dt = max(t - self._t, 0.0)
        self._t = max(t, self._t)
        reach, kept = (dt, 1.0) if self.misses == 0 else self._decay(dt)
        F = _STILL.copy()
        F[0, 2] = F[1, 3] = reach
        F[2, 2] = F[3, 3] = kept
        self._kalman.predict(F=F, Q=self._process_noise(dt))

    def gate_distance(self, detection: Detection, farthest: float = GATE_DISTANCE) -> float:
        """Return the squared Mahalanobis distance of a detection, infinite outside the gate.

        farthest: m; a detection farther away is outside, whatever the covariance.
        """
        x = self._kalman.x
        if math.hypot(detection.x - float(x[0]), detection.y - float(x[1])) > farthest:
            return math.inf
        squared = self._squared_distance(detection, _START**2)
        return squared if squared <= GATE else math.inf

    def _squared_distance(self, detection: Detection, more: float) -> float:
        """Return a detection's squared Mahalanobis distance, with extra variance, m^2, per axis."""
        x, P = self._kalman.x, self._kalman.P
        dx, dy = detection.x - float(x[0]), detection.y - float(x[1])
        sxx = float(P[0, 0]) + detection.var_x + more
        syy = float(P[1, 1]) + detection.var_y + more
        sxy = float(P[0, 1]) + detection.cov_xy
        return (syy * dx * dx - 2.0 * sxy * dx * dy + sxx * dy * dy) / (sxx * syy - sxy * sxy)

    def _inflate(self, dt: float) -> None:
        """Inflate the covariance as if the velocity had changed within the last dt, s.

        Its variance becomes at least that of a new track.
        """
        variance = FIRST_SPEED_SIGMA**2
        for place, speed in ((0, 2), (1, 3)):
            self._kalman.P[place, place] += variance * dt * dt
            self._kalman.P[place, speed] += variance * dt
            self._kalman.P[speed, place] += variance * dt
            self._kalman.P[speed, speed] += variance

    def hit(self, t: float, detection: Detection) -> None:
        """Update by a detection made at t; call ``predict(t)`` before."""
        if self._squared_distance(detection, 0.0) > _MANOEUVRE_GATE:
            self._inflate(t - self.last_seen)
        self._kalman.update(np.array((detection.x, detection.y)), R=_covariance(detection))
        self.hits += 1
        self.misses = 0
        self.last_seen = self.supported = t
        if detection.whole:
            self._whole += 1
            self._robot_sized += detection.robot_sized
        if self.confirmed:
            self._update_motion(t)
            self._update_identity(t, detection)

    def distance_to(self, other: TrackFilter) -> float:
        """Return the distance to another track, m, at the times both were last predicted to."""
        a, b = self._kalman.x, other._kalman.x
        return math.hypot(float(a[0] - b[0]), float(a[1] - b[1]))

    def merge(self, newer: TrackFilter) -> None:
        """Take over the state of a newer track of the same object; id and identity stay."""
        self._kalman, self._t, self.misses = newer._kalman, newer._t, newer.misses
        self.last_seen, self.supported = newer.last_seen, newer.supported

    def update_by_echo(self, t: float, x: float, y: float, sigma: float) -> None:
        """Update by a sonar echo at (x, y), m, map frame; call ``predict(t)`` before. sigma: m."""
        self._kalman.update(np.array((x, y)), R=sigma**2 * _PLANE)
        self.supported = t

    def miss(self) -> None:
        """Record a scan without a detection of it."""
        self.misses += 1
        if self.misses >= _BROKEN_SIGHT:
            self._past.clear()

    def track_at(self, t: float) -> Track:
        """Return the track predicted to t, without changing the filter.

        Its position is of the body's middle, also where the laser sees the housing alone.
        """
        reach, kept = self._decay(max(t - self._t, 0.0))
        x, y, vx, vy = self._kalman.x.tolist()
        covariance = self._kalman.P[:2, :2].copy()
        ahead_x, ahead_y = 0.0, 0.0
        if self._is_small:
            ahead_x, ahead_y, variance = self._seen_ahead()
            covariance += variance * _PLANE
        return Track(
            id=self.id,
            x=x + reach * vx - ahead_x,
            y=y + reach * vy - ahead_y,
            vx=kept * vx,
            vy=kept * vy,
            covariance=covariance,
            first_seen=self.first_seen,
            last_seen=self.last_seen,
            kind=self.identity.kind,
            probabilities=self.identity.probabilities,
            robot_sized=self.robot_sized,
            moving=self._has_moved,
            by_color=self.identity.by_color,
            small=self._is_small,
            legs=self._legs >= _MIN_FITS,
        )

    @property
    def _is_small(self) -> bool:
        """Whether the outline is that of a scanner's housing."""
        return self._small_fits >= _MIN_FITS

    def _seen_ahead(self) -> tuple[float, float, float]:
        """Return how far a housing is ahead of its robot's middle: x, y, m, and variance, m^2.

        The velocity gives the robot's heading, the better the larger it is against its sigma; of
        one that stands or turns in place the heading is unknown, and the mean offset 0.
        """
        vx, vy = self._kalman.x[2:].tolist()
        speed_squared = vx * vx + vy * vy
        known = speed_squared / (speed_squared + float(np.trace(self._kalman.P[2:, 2:])))
        scale = self._housing_ahead * math.sqrt(known / speed_squared) if known else 0.0
        return scale * vx, scale * vy, 0.5 * (1.0 - known) * self._housing_ahead**2

    def _decay(self, dt: float) -> tuple[float, float]:
        """Return (integral of the velocity's decay over dt, s, and the share left after dt)."""
        kept = math.exp(-dt / VELOCITY_DECAY)
        return VELOCITY_DECAY * (1.0 - kept), kept

    def _process_noise(self, dt: float) -> NDArray[np.float64]:
        """Return Q (4, 4) of white acceleration over dt, s."""
        density = VELOCITY_NOISE
        Q = np.zeros((4, 4))
        Q[0, 0] = Q[1, 1] = density * dt**3 / 3.0
        Q[0, 2] = Q[2, 0] = Q[1, 3] = Q[3, 1] = density * dt**2 / 2.0
        Q[2, 2] = Q[3, 3] = density * dt
        return Q

    def _update_identity(self, t: float, detection: Detection) -> None:
        """Add the laser's evidence of the track's kind: outline, speed, size, reflector."""
        if detection.whole:
            fits = detection.robot_sized and detection.misfit < _FITS
            self._fits = self._fits + 1 if fits else 0
            self._small_fits = self._small_fits + 1 if fits and detection.small else 0
            if self._legs < _MIN_FITS:
                self._legs = self._legs + 1 if detection.legs else 0
        if t < self._next_evidence:
            return
        self._next_evidence = t + _SAMPLE_PERIOD
        speed = math.hypot(*self._kalman.x[2:].tolist())
        if speed > MAX_ROBOT_SPEED:
            self.identity.on_too_fast()
        if detection.whole and detection.robot_sized:
            if detection.misfit > _FITS_NOT:
                self.identity.on_other_shape()
            elif detection.misfit < _FITS and self._has_moved and _MIN_SPEED < speed < _MAX_SPEED:
                self.identity.on_robot_shape(small=detection.small)
        if self._whole >= _SIZE_KNOWN and not self.robot_sized:
            self.identity.on_wrong_size()
        if detection.reflecting and self._reflecting_bands:
            self.identity.on_reflector()

    def _update_motion(self, t: float) -> None:
        """Set the moving flag once the track has moved farther than errors can explain.

        Measured over a window rather than the track's whole life: the centre of a standing box
        drifts by its own size while the robot drives round it, but only slowly. Over the window, a
        distance implies a sustained speed.
        """
        if self._has_moved:
            return
        x, y = float(self._kalman.x[0]), float(self._kalman.x[1])
        P = self._kalman.P
        variance = max(float(P[0, 0]), float(P[1, 1]))
        past = self._past
        while past and past[0].t < t - MOTION_WINDOW:
            past.popleft()
        if past:
            moved = math.hypot(x - past[0].x, y - past[0].y)
            noise = 2.0 * math.sqrt(variance + past[0].variance)
            self._has_moved = moved > MOTION_DISTANCE + noise
        if not past or t - past[-1].t >= _SAMPLE_PERIOD:
            past.append(_PastPosition(t, x, y, variance))


def _covariance(detection: Detection) -> NDArray[np.float64]:
    return np.array(((detection.var_x, detection.cov_xy), (detection.cov_xy, detection.var_y)))
