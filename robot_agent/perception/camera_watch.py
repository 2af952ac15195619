"""State of the camera, from its events."""

from __future__ import annotations

from drivers.camera_source import CameraSettings
from robot_agent.messages.events import BlobsSeen

SILENCE = 1.0  # s without a picture after which the camera is silent
_BLIND_S = 1.0  # without a clear picture, while pictures come, after which the camera is blind


class CameraWatch:
    """Keeps the camera's state; without an address there is no camera."""

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
        """Whether a camera is configured, or pictures came all the same."""
        return bool(self._settings.url) or self.pictures > 0

    def opened(self, t: float) -> None:
        """Note that the camera was opened at t, s."""
        self.up, self.reason, self._up_at = True, "", t

    def lost(self, reason: str) -> None:
        """Note that the camera is lost, and why."""
        self.up, self.reason = False, reason

    def on_picture(self, event: BlobsSeen) -> None:
        """Take note of a picture."""
        self.latest = event
        self.pictures += 1
        if event.sight == "clear":
            self._clear_at = event.t

    def state(self, t: float) -> str:
        """Return off, down, silent, dark, glare, covered, or clear."""
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
        """Return what is lost while the camera does not see, empty while it does."""
        state = self.state(t)
        if state in ("off", "clear"):
            return ""
        why = f" ({self.reason})" if state == "down" else ""
        return f"camera {state}{why}: robots are told by outline and motion alone"
