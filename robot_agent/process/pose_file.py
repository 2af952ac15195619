"""The file that stores a robot's last localized pose over a restart of its agent."""

from __future__ import annotations

import hashlib
from pathlib import Path

import msgspec

from maps.map_folder import MapFolder
from robot_agent.pose.pose_memory import RememberedPose


class _Content(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Content of the file."""

    robot: str
    map: str
    """Digest of the map the pose is in."""
    pose: RememberedPose


class PoseFile:
    """Stores one robot's last localized pose in one map.

    Writes are not synced: after a power cut the odometer starts at zero and the pose is useless
    anyway. ``failed`` is empty, or one line with the last error.
    """

    def __init__(self, path: Path, robot: str, folder: MapFolder) -> None:
        """Prepare access; does not touch the file. folder: the map, whose digest is stored."""
        self._path = path
        self._robot = robot
        self._map = _digest(folder)
        self.failed = ""

    def load(self) -> RememberedPose | None:
        """Return the stored pose; None if there is none, or only another robot's or map's.

        For an unusable file ``failed`` is set and None returned, so that the robot can start.
        """
        try:
            content = msgspec.json.decode(self._path.read_bytes(), type=_Content)
        except FileNotFoundError:
            return None
        except (OSError, msgspec.MsgspecError, UnicodeDecodeError) as error:
            self._fail("no remembered pose", error)
            return None
        ours = content.robot == self._robot and content.map == self._map
        return content.pose if ours else None

    def keep(self, payload: bytes) -> None:
        """Store the payload of a ``Remember`` effect atomically; ``{}`` deletes the file.

        Sets ``failed`` on an OSError, and clears it once a pose is stored.
        """
        try:
            if payload == b"{}":
                self._path.unlink(missing_ok=True)
                return
            pose = msgspec.json.decode(payload, type=RememberedPose)
            self._path.parent.mkdir(parents=True, exist_ok=True)
            new = self._path.with_name(self._path.name + ".new")
            new.write_bytes(msgspec.json.encode(_Content(self._robot, self._map, pose)))
            new.replace(self._path)
            self.failed = ""
        except OSError as error:
            self._fail("pose not kept", error)

    def _fail(self, what: str, error: Exception) -> None:
        reason = getattr(error, "strerror", None) or str(error)
        self.failed = f"{self._path}: {what}: {reason}; remove the file or correct memory.file"


def _digest(folder: MapFolder) -> str:
    digest = hashlib.sha256()
    for name, data in sorted(folder.files.items()):
        digest.update(name.encode() + b"\0" + data)
    return digest.hexdigest()
