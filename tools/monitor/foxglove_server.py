"""Serves live telemetry and zones to Foxglove viewers, by Foxglove's SDK (extra ``foxglove``)."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import msgspec

from maps.zone import Zone
from robot_agent.messages.streams import STREAMS
from tools.monitor.foxglove_zones import ZONES_TOPIC, zones_scene
from tools.monitor.page_server import WebError, parsed_address

if TYPE_CHECKING:
    import foxglove
    from foxglove.websocket import ChannelView, Client

MAX_CHANNELS = 2000
_AGAIN_S = 1.0


class FoxgloveServer:
    """One channel per telemetry key, with the stream's schema; payloads are passed unchanged.

    One channel more draws the zones, if there are any.
    """

    def __init__(self, address: str, zones: Sequence[Zone] = ()) -> None:
        """Listen for viewers on an address such as ``127.0.0.1:8765``; zones: the site's.

        Raises:
            WebError: the address is invalid or taken, or the SDK is not installed.
        """
        try:
            import foxglove
        except ImportError as error:
            raise WebError(
                f"--foxglove: {error}; install foxglove-sdk (the extra `foxglove`)"
            ) from error
        host, port = parsed_address(address, "--foxglove")
        self._foxglove = foxglove
        self._context = foxglove.Context()
        self._channels: dict[str, foxglove.Channel] = {}
        # Its protocol names every call; the server makes those that are there.
        drawn: Any = _ZonesChannel(self._context, zones) if zones else None
        try:
            self._server = foxglove.start_server(
                name="border patrol",
                host=host,
                port=port,
                context=self._context,
                server_listener=drawn,
            )
        except Exception as error:
            raise WebError(f"--foxglove {address}: {error}; give a free address") from error

    @property
    def port(self) -> int:
        """TCP port of the server."""
        return self._server.port

    def on_payload(self, key: str, payload: bytes, wall: float) -> None:
        """Publish a payload received under a key at wall, s since 1970.

        Payloads of unknown streams, and keys beyond ``MAX_CHANNELS``, are ignored.
        """
        channel = self._channels.get(key)
        if channel is None:
            stream = STREAMS.get(key.rpartition("/")[2])
            if stream is None or len(self._channels) >= MAX_CHANNELS:
                return
            definition = msgspec.json.encode(stream.json_schema())
            channel = self._channels[key] = self._foxglove.Channel(
                f"/{key}",
                schema=self._foxglove.Schema(
                    name=stream.schema_name, encoding="jsonschema", data=definition
                ),
                message_encoding="json",
                context=self._context,
            )
        channel.log(payload, log_time=round(wall * 1e9))

    def close(self) -> None:
        """Stop listening."""
        self._server.stop()


class _ZonesChannel:
    """Draws the zones for each viewer when it subscribes: they never change."""

    def __init__(self, context: foxglove.Context, zones: Sequence[Zone]) -> None:
        from foxglove import channels

        self._scene = zones_scene(zones)
        self._channel = channels.SceneUpdateChannel(ZONES_TOPIC, context=context)

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Send the zones, and once more, as the first may come before the subscription is known.

        Called by Foxglove's server.
        """
        if channel.topic == ZONES_TOPIC:
            self._send(client.id)
            again = threading.Timer(_AGAIN_S, self._send, (client.id,))
            again.daemon = True
            again.start()

    def _send(self, viewer: int) -> None:
        self._channel.log(self._scene, sink_id=viewer)
