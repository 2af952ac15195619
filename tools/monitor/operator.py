"""The operator's end of the network: receives every robot's telemetry and sends nothing.

A Zenoh router that the robots connect to. Its access control denies everything but ingress of
``put`` and ``liveliness_token``, which robots need to report: no peer can subscribe, query or
receive through it, so robots cannot receive from each other or from anybody else.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import zenoh

from maps.input_limits import MAX_MESSAGE_BYTES, MAX_PAYLOAD_BYTES
from robot_agent.messages.streams import key_of
from robot_agent.process.telemetry import LEASE_MS, plain_reason, tls_settings
from tools.deploy.certificates import RobotName, known_robots, known_sites
from tools.monitor.team_state import TeamState

Tap = Callable[[str, bytes, float], None]
"""Called with key, bytes and reception time (s since 1970) of every payload, undecoded.

Payloads beyond MAX_PAYLOAD_BYTES are dropped before."""


class OperatorError(ValueError):
    """The operator cannot listen; the message names endpoint, reason and remedy."""


class Operator:
    """Listens to robots and keeps ``team`` up to date until closed."""

    def __init__(self, listen: str, taps: Sequence[Tap] = (), keys: Path | None = None) -> None:
        """Listen on an endpoint such as ``tcp/0.0.0.0:7447``; ``taps`` get every payload too.

        keys: the operator's folder of ``patrol keys``, needed for a tls endpoint: each robot can
        then publish only under the name in its certificate.

        Raises:
            OperatorError: the endpoint is invalid or taken, or is tls without keys.
            KeysError: the keys cannot be read.
        """
        self.team = TeamState()
        self._taps = tuple(taps)
        if listen.startswith("tls/") and keys is None:
            raise OperatorError(f"{listen} needs certificates: give --keys, see `patrol keys`")
        try:
            self._session = zenoh.open(_session_config(listen, keys))
        except zenoh.ZError as error:
            raise OperatorError(
                f"cannot listen on {listen}: {plain_reason(error)}; "
                "give a free endpoint, e.g. tcp/0.0.0.0:7447"
            ) from error
        self._own_id = str(self._session.info.zid())
        self._session.declare_subscriber("patrol/*/*/*", self._on_sample)
        self._session.liveliness().declare_subscriber(
            "patrol/*/*", self._on_liveliness, history=True
        )

    def _on_sample(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            key, wall = str(sample.key_expr), time.time()
            if len(sample.payload) > MAX_PAYLOAD_BYTES:
                self.team.refuse(key.split("/")[:-1], time.monotonic())
                return
            payload = bytes(sample.payload)
            for tap in self._taps:
                tap(key, payload, wall)
            self.team.receive(key, payload, time.monotonic(), wall, self._source_of(sample))

    def _source_of(self, sample: zenoh.Sample) -> str:
        """Return the session that stamped a payload; "" if this router did, in its place."""
        stamp = sample.timestamp
        source = "" if stamp is None else str(stamp.get_id())
        return "" if source == self._own_id else source

    def _on_liveliness(self, sample: zenoh.Sample) -> None:
        online = sample.kind == zenoh.SampleKind.PUT
        self.team.set_liveliness(str(sample.key_expr), online=online, t=time.monotonic())

    def close(self) -> None:
        """Stop listening; idempotent."""
        self._session.close()  # type: ignore[no-untyped-call]


def access_control(
    robots: Sequence[RobotName] | None, sites: Sequence[str] = ()
) -> dict[str, object]:
    """Return Zenoh's access control that lets robots report and denies everything else.

    robots: those that may report, each under its certificate's name only; None: any client. sites:
    teams whose site may report all their robots, with the team's certificate.
    """
    allowed: list[tuple[str, list[str], dict[str, list[str]]]]
    if robots is None:
        allowed = [("robots report", ["patrol/**"], {})]
    else:
        allowed = [
            (
                f"{robot.common_name} reports",
                [key_of(robot.team, robot.robot), key_of(robot.team, robot.robot, "**")],
                {"cert_common_names": [robot.common_name]},
            )
            for robot in robots
        ]
        allowed += [
            (f"site of {team} reports", [f"patrol/{team}/**"], {"cert_common_names": [team]})
            for team in sites
        ]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [
            {
                "id": name,
                "permission": "allow",
                "flows": ["ingress"],
                "messages": ["put", "liveliness_token"],
                "key_exprs": keys,
            }
            for name, keys, _ in allowed
        ],
        "subjects": [{"id": name, **subject} for name, _, subject in allowed],
        "policies": [{"rules": [name], "subjects": [name]} for name, _, _ in allowed],
    }


def _session_config(listen: str, keys: Path | None) -> zenoh.Config:
    config = zenoh.Config()
    for key, value in {
        "mode": "router",
        "listen/endpoints": [listen],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/rx/max_message_size": MAX_MESSAGE_BYTES,
        "access_control": (
            access_control(None)
            if keys is None
            else access_control(known_robots(keys), known_sites(keys))
        ),
    }.items():
        config.insert_json5(key, json.dumps(value))
    if keys is not None:
        config.insert_json5("transport/link/tls", json.dumps(tls_settings(str(keys.resolve()))))
    return config
