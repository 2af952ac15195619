"""Serves live telemetry and zones to Foxglove viewers, by Foxglove's SDK (extra ``foxglove``)."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING

import msgspec

from maps.zone import Zone
from robot_agent.messages.streams import STREAMS
from tools.monitor.foxglove_zones import ZONES_TOPIC, zones_scene
from tools.monitor.page_server import WebError, parsed_address

if TYPE_CHECKING:
    import foxglove

MAX_CHANNELS = 2000
_ZONES_EACH_S = 1.0


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
        try:
            self._server = foxglove.start_server(
                name="border patrol", host=host, port=port, context=self._context
            )
        except Exception as error:
            raise WebError(f"--foxglove {address}: {error}; give a free address") from error
        self._zones = _ZonesChannel(self._context, zones) if zones else None

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
        if self._zones is not None:
            self._zones.close()
        self._server.stop()


class _ZonesChannel:
    """Draws the zones each second while somebody looks: the SDK keeps nothing for later viewers."""

    def __init__(self, context: foxglove.Context, zones: Sequence[Zone]) -> None:
        from foxglove import channels

        self._scene = zones_scene(zones)
        self._channel = channels.SceneUpdateChannel(ZONES_TOPIC, context=context)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._draw, name="foxglove zones", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Draw no more."""
        self._closing.set()
        self._thread.join()

    def _draw(self) -> None:
        while not self._closing.wait(_ZONES_EACH_S):
            if self._channel.has_sinks():
                self._channel.log(self._scene)
