"""Recordings of a lockstep fleet: one file per robot, as the live recorder writes them."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from maps.map_folder import MapFolder
from robot_agent.config import AgentConfig
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_files import refuse_existing
from robot_agent.recording.run_header import header_of_run
from tools.replay.carmen_recording import RecordingObserver


class FleetRecorder:
    """Makes the observer of each robot; ``close`` completes the files."""

    def __init__(self, folder: MapFolder, target: Path) -> None:
        """Record to ``target``/<robot>.mcap."""
        self._folder = folder
        self._target = target
        self._files = ExitStack()
        self.paths: list[Path] = []
        target.mkdir(parents=True, exist_ok=True)

    def close(self) -> None:
        """Complete the files."""
        self._files.close()

    def observe(self, name: str, config: AgentConfig) -> RecordingObserver:
        """Start the recording of one robot; its clock starts at 0.

        Raises RecordingExistsError if the file exists.
        """
        path = self._target / f"{name}.mcap"
        refuse_existing(path)
        header = header_of_run(config, self._folder, source="bench", start_wall_ns=0)
        writer = RecordingWriter(self._files.enter_context(path.open("xb")), header)
        self._files.callback(writer.finish)
        self.paths.append(path)
        return RecordingObserver(writer)
