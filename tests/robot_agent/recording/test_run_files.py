"""Names of recordings count the starts: clocks of robots do not tell the order."""

from __future__ import annotations

import multiprocessing
from pathlib import Path

import pytest

from robot_agent.recording.run_files import (
    NumberedRuns,
    OneFile,
    RecordingExistsError,
    refuse_existing,
)


def start(folder: Path, robot: str = "r") -> Path:
    """Open a robot's next run and return its file."""
    runs = NumberedRuns(folder, robot)
    runs.open_next().close()
    return runs.path


def number(path: Path) -> int:
    return int(path.name.split("-")[-2])


def test_every_start_has_the_next_number_and_makes_the_folder(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "yet"
    paths = [start(folder) for _ in range(12)]
    assert [number(path) for path in paths] == list(range(1, 13))
    assert sorted(paths) == paths


@pytest.mark.parametrize("content", [None, b"", b"00", b"0000", b"\0" * 7, b"999999", b"000001\nx"])
def test_missing_or_torn_counter_goes_on_after_the_largest_number_there(
    tmp_path: Path, content: bytes | None
) -> None:
    for _ in range(3):
        start(tmp_path)
    counter = tmp_path / "r.counter"
    counter.unlink()
    if content is not None:
        counter.write_bytes(content)
    assert number(start(tmp_path)) == 4
    assert counter.read_bytes() == b"000004\n"


def test_numbers_are_not_used_again_when_runs_were_moved_away(tmp_path: Path) -> None:
    for path in [start(tmp_path) for _ in range(3)]:
        path.unlink()
    assert number(start(tmp_path)) == 4


def test_processes_starting_at_once_write_different_files(tmp_path: Path) -> None:
    with multiprocessing.get_context("fork").Pool(4) as pool:
        paths = pool.map(start, [tmp_path] * 40, chunksize=1)
    assert sorted(map(number, paths)) == list(range(1, 41))


def test_older_runs_are_the_robots_own_by_number_after_those_without_one(tmp_path: Path) -> None:
    earlier = [tmp_path / f"r-{stamp}.mcap" for stamp in ("19700101T000004Z", "20260101T000000Z")]
    for path in earlier:
        path.touch()
    for name in ("s-000009-20260101T000000Z.mcap", "r-mine.mcap", "r-s-20260101T000000Z.mcap"):
        (tmp_path / name).touch()
    first, second = start(tmp_path), start(tmp_path)
    runs = NumberedRuns(tmp_path, "r")
    runs.open_next().close()
    assert runs.older() == [*earlier, first, second]


def test_file_of_the_users_choice_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(b"the only one of that day")
    with pytest.raises(RecordingExistsError, match=r"run\.mcap exists.*another name"):
        refuse_existing(path)
    with pytest.raises(FileExistsError):
        OneFile(path).open_next()
    assert path.read_bytes() == b"the only one of that day"


def test_continuations_of_a_chosen_file_are_beside_it(tmp_path: Path) -> None:
    file = OneFile(tmp_path / "run.mcap")
    for _ in range(3):
        file.open_next().close()
    assert file.path == tmp_path / "run.3.mcap"
    assert len(list(tmp_path.iterdir())) == 3


def test_devices_are_written_to() -> None:
    refuse_existing(Path("/dev/null"))
    OneFile(Path("/dev/null")).open_next().close()
