"""Telemetry from the robot to the operator; one way only.

One Zenoh session that only publishes: it connects to the operator and accepts no connections, so no
other robot can reach it. It runs on its own thread behind a short queue that drops the oldest, so a
slow, absent or hanging network never blocks the agent.
"""

from __future__ import annotations

import json
import math
import re
import threading
import time
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING

from maps.input_limits import MAX_QUEUE_BYTES
from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import key_of
from robot_agent.process.certificate_dates import CertificateError, first_trouble, read_dates

if TYPE_CHECKING:
    import zenoh

CLOSE_S = 1.0
CHECK_S = 1.0
"""s between two looks at the certificates while no operator is connected."""
RECONNECT_MS = {"period_init_ms": 250, "period_max_ms": 1000, "period_increase_factor": 2}
LEASE_MS = 4000
"""ms of silence after which a peer is lost; both ends send keep-alives at a quarter of it."""
QUEUE = 256
"""Payloads that may wait for the network before the oldest is dropped."""


class Telemetry:
    """Publishes one robot's payloads until closed.

    ``sent`` counts payloads passed to a connected operator; the network may still lose them.
    ``failed`` is empty, or one line with the reason why there is no telemetry at all; an absent
    operator is no failure, the session waits for it. One thread at a time may call the methods.
    """

    def __init__(
        self, settings: TelemetrySettings, *, robot: str, team: str, queue: int = QUEUE
    ) -> None:
        """Start the thread that opens the session; without a configured operator, do nothing.

        queue: payloads that may wait for the network before the oldest is dropped; MAX_QUEUE_BYTES
        bounds them too.
        """
        self.sent = 0
        self.failed = ""
        self.connected: bool | None = None
        """Whether the operator was connected at the last check; None: no telemetry."""
        self._operator = settings.operator
        self._keys = settings.keys
        self._robot = robot
        self._team = team
        self._most = queue
        self._queue: deque[tuple[str, bytes]] = deque()
        self._queued_bytes = 0
        self._lock = threading.Lock()
        self._waiting = threading.Event()
        self._overflowed = 0
        self._unheard = 0
        self._ending = False
        self._thread: threading.Thread | None = None
        if settings.operator:
            self._thread = threading.Thread(target=self._run, name="telemetry", daemon=True)
            self._thread.start()

    @property
    def dropped(self) -> int:
        """Payloads dropped from the full queue, or while no operator was connected."""
        return self._overflowed + self._unheard

    def publish(self, stream: str, payload: bytes) -> None:
        """Queue a payload; never blocks."""
        if self._thread is None:
            return
        with self._lock:
            self._queue.append((stream, payload))
            self._queued_bytes += len(payload)
            while len(self._queue) > self._most or self._queued_bytes > MAX_QUEUE_BYTES:
                self._take()
                self._overflowed += 1
        if not self._waiting.is_set():
            self._waiting.set()

    def _take(self) -> tuple[str, bytes]:
        """Remove and return the oldest queued payload."""
        stream, payload = self._queue.popleft()
        self._queued_bytes -= len(payload)
        return stream, payload

    def close(self) -> None:
        """Close the session, within CLOSE_S even if the network hangs; idempotent."""
        if self._thread is not None:
            self._ending = True
            self._waiting.set()
            self._thread.join(CLOSE_S)

    def _run(self) -> None:
        """Open the session and publish until ``close``; any other end is reported in ``failed``."""
        trouble = "its thread has died: start the agent again"
        try:
            trouble = self._publish_all()
        finally:
            self.failed = trouble and f"no telemetry to {self._operator}: {trouble}"
            self.connected = None

    def _publish_all(self) -> str:
        """Publish until ``close``; return the error that prevented it, empty if none."""
        try:
            import zenoh
        except ImportError as error:
            return f"{error}; install eclipse-zenoh"
        try:
            with zenoh.open(session_config(self._operator, self._keys)) as session:
                self._serve(session)
        except zenoh.ZError as error:
            return plain_reason(error)
        return ""

    def _certificate_trouble(self) -> str:
        """Return why certificates keep the operator away, empty if they do not."""
        if not self._keys:
            return ""
        try:
            trouble = first_trouble(read_dates(Path(self._keys)), time.time())
        except CertificateError as error:
            trouble = str(error)
        return trouble and f"no telemetry to {self._operator}: {trouble}"

    def _serve(self, session: zenoh.Session) -> None:
        """Declare the robot's liveliness, then publish queued payloads until ``close``."""
        import zenoh

        token = session.liveliness().declare_token(key_of(self._team, self._robot))
        checked_at = -math.inf
        while not self._ending:
            self._waiting.wait(CHECK_S)
            self._waiting.clear()
            self.connected = _has_operator(session)
            if (now := time.monotonic()) - checked_at >= CHECK_S:
                self.failed = "" if self.connected else self._certificate_trouble()
                checked_at = now
            while True:
                with self._lock:
                    if not self._queue:
                        break
                    stream, payload = self._take()
                heard = _has_operator(session)
                # Not a declared publisher: that sends only to subscribers it knows, and the
                # operator sends robots no declarations.
                session.put(
                    key_of(self._team, self._robot, stream),
                    payload,
                    encoding=zenoh.Encoding.APPLICATION_JSON,
                    # Zenoh itself would drop the newest, uncounted; while this thread blocks, the
                    # queue drops the oldest and counts it.
                    congestion_control=zenoh.CongestionControl.BLOCK,
                )
                self.sent += heard
                self._unheard += not heard
        token.undeclare()  # type: ignore[no-untyped-call]


def _has_operator(session: zenoh.Session) -> bool:
    return bool(session.info.routers_zid() or session.info.peers_zid())


def session_config(operator: str, keys: str = "") -> zenoh.Config:
    """Return the configuration of a session that connects to the operator only.

    keys: folder with ``ca.pem``, ``certificate.pem`` and ``key.pem``, for a tls endpoint.

    The session opens no listening port and does not scout for peers; it retries an absent operator
    for ever in the background, so that opening never blocks.
    """
    import zenoh

    config = zenoh.Config()
    for key, value in {
        "mode": "peer",
        "listen/endpoints": [],
        "connect/endpoints": [operator],
        "connect/timeout_ms": -1,
        "connect/retry": RECONNECT_MS,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "open/return_conditions": {"connect_scouted": False, "declares": False},
        "transport/shared_memory/enabled": False,
        # Names the session: the operator notices two under one name.
        "timestamping": {"enabled": True},
        "transport/link/tx/lease": LEASE_MS,
    }.items():
        config.insert_json5(key, json.dumps(value))
    if keys:
        config.insert_json5("transport/link/tls", json.dumps(tls_settings(keys)))
    return config


def tls_settings(keys: str) -> dict[str, object]:
    """Return Zenoh's settings for certificates at both ends, from a folder of ``patrol keys``."""
    return {
        "root_ca_certificate": f"{keys}/ca.pem",
        "enable_mtls": True,
        **{f"{end}_certificate": f"{keys}/certificate.pem" for end in ("connect", "listen")},
        **{f"{end}_private_key": f"{keys}/key.pem" for end in ("connect", "listen")},
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
    }


def plain_reason(error: BaseException) -> str:
    """Return an error message of Zenoh in one line, without the locations in its source."""
    return re.sub(r" at /[^\s\]]*", "", str(error)).replace("\n", " ")
