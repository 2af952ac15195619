"""``patrol convert``: logs and captures to recordings of real device bytes, and back."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from maps.map_folder import MapFolder, load_map_folder
from maps.occupancy_map import save_map
from robot_agent.config import find_map
from tools.commands.log_option import add_no_return, add_topics, print_notes, topics_of
from tools.localize.localize import map_of_log
from tools.logs.capture import capture_to_recording, recording_to_capture
from tools.logs.carmen import CarmenLog
from tools.logs.carmen_writer import recording_to_carmen
from tools.logs.laser_log import read_laser_log
from tools.logs.recording import Recording, read_recording
from tools.logs.ros_bag import RosTopics, is_ros_bag
from tools.logs.ros_bag_writer import recording_to_ros
from tools.logs.stream_table import stream_to_csv
from tools.output_path import output_path
from tools.progress import progress_line
from tools.replay.carmen_recording import as_lms_scans, convert

RESOLUTION = 0.05  # m


class ConvertError(ValueError):
    """The requested conversion does not exist; the message names those that do."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = """what becomes what follows from the names:
  CARMEN log (any name, plain or .gz), ROS bag (.bag, .db3, ROS 2 .mcap or folder) or
    capture (.jsonl) to recording (.mcap)
  recording (.mcap) to CARMEN log (.log), ROS 2 bag (.ros2, a folder), capture (.jsonl), or
    one stream as table (.csv)

examples:
  patrol convert intel.log.gz -o intel.mcap --map intel_lab
  patrol convert drive.bag -o drive.mcap --map my_lab
  patrol convert robot1.mcap -o robot1.log
  patrol convert robot1.mcap -o robot1.ros2
  patrol convert robot1.mcap -o decisions.csv --stream decision"""
    parser.add_argument("source", type=Path, help="CARMEN log, ROS bag, capture or recording")
    parser.add_argument("-o", "--output", type=output_path, required=True, metavar="FILE")
    parser.add_argument(
        "--map",
        metavar="DIR",
        help="of a log: map folder or shipped map of its place; built from it when absent",
    )
    parser.add_argument("--stream", metavar="NAME", help="of a .csv: e.g. decision, base/rx")
    add_no_return(parser)
    add_topics(parser)


def run(options: argparse.Namespace) -> int:
    """Convert one file."""
    source, output = options.source, options.output
    if source.suffix == ".mcap" and not is_ros_bag(source):
        print(f"{output}: {_from_recording(source, output, options.stream)}")
    elif output.suffix != ".mcap":
        raise ConvertError(f"{output}: a log or capture becomes a recording: name it .mcap")
    elif source.suffix == ".jsonl":
        summary = capture_to_recording(source, output)
        print(
            f"{output}: {summary.received} bytes of the devices and {summary.sent} of the host "
            f"in {summary.duration:.0f} s"
        )
        if summary.abridged:
            print(
                f"patrol convert: {source}: {summary.abridged} abridged lines left out, "
                "the capture does not hold their bytes",
                file=sys.stderr,
            )
    else:
        _from_log(source, output, options.map, options.no_return, topics_of(options))
    return 0


def _from_recording(source: Path, output: Path, stream: str | None) -> str:
    """Convert a recording; return what was written as text, e.g. ``120 scans``."""
    write = _writer(output, stream)
    recording = read_recording(source)
    words = write(recording)
    if recording.truncated:
        print(f"patrol convert: {recording.truncated}", file=sys.stderr)
    return words


def _writer(output: Path, stream: str | None) -> Callable[[Recording], str]:
    """Return what writes a recording as the output's suffix wants; ConvertError: there is none."""
    if output.suffix == ".log":
        return lambda recording: f"{recording_to_carmen(recording, output)} scans"
    if output.suffix == ".ros2":
        return lambda recording: f"{recording_to_ros(recording, output)} scans, for ROS 2"
    if output.suffix == ".jsonl":
        return lambda recording: f"{recording_to_capture(recording, output)} lines"
    if output.suffix == ".csv" and stream:
        return lambda recording: f"{stream_to_csv(recording, stream, output)} rows"
    raise ConvertError(
        f"{output}: a recording becomes a .log, .ros2 or .jsonl, or with --stream NAME a .csv"
    )


def _from_log(
    source: Path, output: Path, place: str | None, max_range: float | None, topics: RosTopics
) -> None:
    """Convert a CARMEN log or a ROS bag to a recording."""
    log = read_laser_log(source, max_range, topics)
    if is_ros_bag(source):
        log = as_lms_scans(log)
    if place:
        folder = load_map_folder(find_map(place, Path.cwd()))
    else:
        print("patrol convert: no --map given: building one from the log", file=sys.stderr)
        folder = map_of(log)
    with progress_line("convert", log.odometry[-1][0] - log.odometry[0][0], "s") as progress:
        conversion = convert(log, folder, output, progress)
    print_notes("convert", log.notes)
    print(
        f"{output}: {conversion.scans} scans and {conversion.base_reports} base reports "
        f"in {conversion.duration:.0f} s, as device bytes"
    )


def map_of(log: CarmenLog) -> MapFolder:
    """Return a map folder without border, built from a log's scans at their reference poses."""
    with progress_line("map", len(log.scans), "scans") as progress:
        built = map_of_log(log, RESOLUTION, "all", progress)
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / log.path.name.split(".")[0]
        save_map(built.map, folder)
        return load_map_folder(folder)
