"""Sends telemetry from the robot to the operator, and nothing the other way.

One Zenoh session that only publishes: it dials the operator and listens to nobody, so no other
robot can reach it. It lives on a thread of its own behind a short queue that drops the oldest, so
a slow, absent or hanging network never holds the agent up.
"""

from __future__ import annotations

import json
import math
import re
import threading
import time
from collections import deque
from typing import TYPE_CHECKING

from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import key_of

if TYPE_CHECKING:
    import zenoh

CLOSE_S = 1.0
LOOK_S = 1.0
"""How often it is looked whether the operator is connected."""
RECONNECT_MS = {"period_init_ms": 250, "period_max_ms": 1000, "period_increase_factor": 2}
LEASE_MS = 4000
"""A peer that was silent this long is gone; both ends send a sign of life every quarter of it."""
QUEUE = 256
"""Payloads that may wait for the network before the oldest is dropped."""


class Telemetry:
    """Publishes one robot's payloads until closed.

    ``sent`` counts payloads handed to the network, which may still lose them; ``dropped`` those
    that had to make room in the queue, also while the network takes nothing. ``failed`` is empty,
    or one line that says why there is no telemetry at all; an operator that is absent is no
    failure, the session waits for it. One
    thread at a time may call the methods.
    """

    def __init__(
        self, settings: TelemetrySettings, *, robot: str, team: str, queue: int = QUEUE
    ) -> None:
        """Start the thread that opens the session; without an operator do nothing at all.

        queue: payloads that may wait for the network before the oldest is dropped.
        """
        self.sent = 0
        self.dropped = 0
        self.failed = ""
        self.connected: bool | None = None
        """Whether the operator was there at the last look, once a second; None: no telemetry."""
        self._operator = settings.operator
        self._keys = settings.keys
        self._robot = robot
        self._team = team
        self._queue: deque[tuple[str, bytes]] = deque(maxlen=queue)
        self._waiting = threading.Event()
        self._ending = False
        self._thread: threading.Thread | None = None
        if settings.operator:
            self._thread = threading.Thread(target=self._run, name="telemetry", daemon=True)
            self._thread.start()

    def publish(self, stream: str, payload: bytes) -> None:
        """Queue a payload; takes microseconds whatever the network does."""
        if self._thread is None:
            return
        if len(self._queue) == self._queue.maxlen:
            self.dropped += 1
        self._queue.append((stream, payload))
        if not self._waiting.is_set():
            self._waiting.set()

    def close(self) -> None:
        """Close the session, within a second whatever the network does; idempotent."""
        if self._thread is not None:
            self._ending = True
            self._waiting.set()
            self._thread.join(CLOSE_S)

    def _run(self) -> None:
        """Open the session and publish until told to end; what else ends it becomes ``failed``."""
        trouble = "its thread has died: start the agent again"
        try:
            trouble = self._publish_all()
        finally:
            self.failed = trouble and f"no telemetry to {self._operator}: {trouble}"
            self.connected = None

    def _publish_all(self) -> str:
        """Publish until told to end; return what was in the way, empty for nothing."""
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

    def _serve(self, session: zenoh.Session) -> None:
        """Say that the robot is there, then publish what is queued as it comes."""
        import zenoh

        token = session.liveliness().declare_token(key_of(self._team, self._robot))
        looked_at = -math.inf
        while not self._ending:
            self._waiting.wait(LOOK_S)
            self._waiting.clear()
            if (now := time.monotonic()) - looked_at >= LOOK_S:
                self.connected = bool(session.info.routers_zid() or session.info.peers_zid())
                looked_at = now
            while self._queue:
                stream, payload = self._queue.popleft()
                # Not a declared publisher: that one sends only to subscribers it was told of, and
                # the operator tells robots nothing.
                session.put(
                    key_of(self._team, self._robot, stream),
                    payload,
                    encoding=zenoh.Encoding.APPLICATION_JSON,
                    # Zenoh would drop the newest, uncounted; while this thread waits, the queue
                    # drops the oldest and counts it.
                    congestion_control=zenoh.CongestionControl.BLOCK,
                )
                self.sent += 1
        token.undeclare()  # type: ignore[no-untyped-call]


def session_config(operator: str, keys: str = "") -> zenoh.Config:
    """Return the configuration of a session that dials the operator and nobody else.

    keys: folder with ``ca.pem``, ``certificate.pem`` and ``key.pem``, for a tls endpoint.

    It listens on no port and looks for no peers; an absent operator is dialled again for ever, in
    the background, so that opening never waits.
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
    """Return what Zenoh complains of in one line, without the places in its source."""
    return re.sub(r" at /[^\s\]]*", "", str(error)).replace("\n", " ")
