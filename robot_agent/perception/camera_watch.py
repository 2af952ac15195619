"""State of the camera, from its events."""

from __future__ import annotations

from drivers.camera_source import CameraSettings
from robot_agent.messages.events import BlobsSeen

SILENCE = 1.0  # s without a picture after which the camera is silent
_BLIND_S = 1.0  # without a clear picture, while pictures arrive, after which it is blind


class CameraWatch:
    """Keeps the camera's state.

    up: whether it is open; reason: why not. latest: the last picture's event, None before the
    first. pictures: their number.
    """

    def __init__(self, settings: CameraSettings) -> None:
        self._settings = settings
        self.up = False
        self.reason = "not opened yet"
        self.latest: BlobsSeen | None = None
        self.pictures = 0
        self._clear_at: float | None = None
        self._up_at = 0.0

    @property
    def exists(self) -> bool:
        """Whether a camera is configured (has an address), or pictures have arrived anyway."""
        return bool(self._settings.url) or self.pictures > 0

    def opened(self, t: float) -> None:
        """Record that the camera was opened at t."""
        self.up, self.reason, self._up_at = True, "", t

    def lost(self, reason: str) -> None:
        """Record that the camera is lost, with the reason."""
        self.up, self.reason = False, reason

    def on_picture(self, event: BlobsSeen) -> None:
        """Record a picture."""
        self.latest = event
        self.pictures += 1
        if event.sight == "clear":
            self._clear_at = event.t

    def state(self, t: float) -> str:
        """Return the state at t: off, down, silent, dark, glare, covered, or clear."""
        if not self.exists:
            return "off"
        if not self.up:
            return "down"
        heard = self._up_at if self.latest is None else self.latest.t
        if t - heard > SILENCE:
            return "silent"
        if self.latest is None:
            return "clear"
        clear_at = self._up_at if self._clear_at is None else self._clear_at
        return self.latest.sight if t - clear_at > _BLIND_S else "clear"

    def trouble(self, t: float) -> str:
        """Return a sentence for people on what fails without the camera; empty while it works."""
        state = self.state(t)
        if state in ("off", "clear"):
            return ""
        why = f" ({self.reason})" if state == "down" else ""
        return f"camera {state}{why}: robots are told by outline and motion alone"
