"""CARMEN logs: counts, geometry, the raw odometry between corrected poses, and broken files."""

from __future__ import annotations

import bz2
import gzip
import lzma
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from maps.pose import Pose
from tools.logs.carmen import CarmenLog, LogError, read_carmen

SCANS = {"intel": 910, "aces": 440, "seattle": 241}


def flaser(t: float, x: float, y: float, theta: float, readings: list[float]) -> str:
    words = " ".join(f"{value:g}" for value in readings)
    return f"FLASER {len(readings)} {words} {x} {y} {theta} {x} {y} {theta} {t} host {t}"


def odom(t: float, x: float, y: float, theta: float) -> str:
    return f"ODOM {x} {y} {theta} 0 0 0 {t} host {t}"


# A corrected log: each scan's pose is repeated by the next ODOM, the rest is raw steps onto it.
CORRECTED = [
    "# message formats defined: PARAM SYNC ODOM FLASER",
    "PARAM robot_frontlaser_offset 0.0 nohost 0",
    odom(1.0, 0.0, 0.0, 0.0),
    odom(2.0, 1.0, 0.0, 0.0),
    flaser(2.0, 10.0, 5.0, math.pi / 2, [1.5] * 180),
    odom(0.0, 10.0, 5.0, math.pi / 2),
    "NEFF 15",
    odom(2.9, 10.0, 5.5, math.pi / 2),
    odom(2.5, 10.0, 6.0, math.pi / 2),
    odom(3.0, 9.0, 6.0, math.pi),
    flaser(3.0, 9.3, 6.1, 3.0, [0.0, *[50.0] * 5, *[2.0] * 174]),
    odom(0.0, 9.3, 6.1, 3.0),
    odom(9.0, 9.3, 6.1, 3.0),
]


def write(folder: Path, lines: list[str]) -> Path:
    path = folder / "made.log"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def logs(data_folder: Path) -> dict[str, CarmenLog]:
    return {name: read_carmen(data_folder / "logs" / f"{name}-corrected.log.gz") for name in SCANS}


def test_known_logs_have_their_counts_and_beams(logs: dict[str, CarmenLog]) -> None:
    assert {name: len(log.scans) for name, log in logs.items()} == SCANS
    assert {scan.ranges.size for scan in logs["intel"].scans} == {180}
    assert {scan.ranges.size for scan in logs["seattle"].scans} == {361}
    last = logs["seattle"].scans[0]
    assert last.angle_min + 360 * last.angle_increment == pytest.approx(math.pi / 2)
    assert all(len(log.notes) == 1 for log in logs.values())


def test_first_scan_is_as_in_the_file(logs: dict[str, CarmenLog]) -> None:
    scan = logs["intel"].scans[0]
    assert scan.t == 32.9068
    assert scan.reference == (0.600266, -0.0320327, -0.354665)
    assert scan.odometry == (0.698035, -0.0132843, -0.460915)
    assert scan.angle_min == -math.pi / 2
    assert scan.angle_increment == pytest.approx(math.radians(1))


def test_no_return_is_infinite(logs: dict[str, CarmenLog]) -> None:
    limits = {"intel": 80.0, "aces": 49.95, "seattle": 80.0}
    for name, log in logs.items():
        ranges = np.concatenate([scan.ranges for scan in log.scans])
        assert 0.97 < np.isfinite(ranges).mean() < 1.0
        assert ranges[np.isfinite(ranges)].max() < limits[name]
        assert ranges.min() > 0.1


def test_raw_odometry_drifts_by_tens_of_metres(logs: dict[str, CarmenLog]) -> None:
    for name, least in {"intel": 50.0, "aces": 15.0, "seattle": 45.0}.items():
        scans = logs[name].scans
        assert max(math.dist(s.odometry[:2], s.reference[:2]) for s in scans) > least


def test_raw_steps_are_close_to_the_true_ones_but_not_corrected(
    logs: dict[str, CarmenLog],
) -> None:
    """Intel's odometry turns left about 3.3 degrees for each metre it travels."""
    scans = logs["intel"].scans
    travelled = turned_too_much = 0.0
    for before, after in pairwise(scans):
        raw = before.odometry.between(after.odometry)
        true = before.reference.between(after.reference)
        assert math.dist(raw[:2], true[:2]) < 0.3
        travelled += math.hypot(true.x, true.y)
        turned_too_much += math.remainder(raw.theta - true.theta, math.tau)
    assert abs(math.degrees(turned_too_much / travelled)) == pytest.approx(3.3, abs=0.3)


def test_knots_increase_and_agree_with_the_scans(logs: dict[str, CarmenLog]) -> None:
    for log in logs.values():
        times = [t for t, _ in log.odometry]
        assert all(before < after for before, after in pairwise(times))
        knots = dict(log.odometry)
        assert all(knots[scan.t] == scan.odometry for scan in log.scans)
        assert len(knots) > 8 * len(log.scans)
        steps = [math.dist(a[:2], b[:2]) for (_, a), (_, b) in pairwise(log.odometry)]
        assert np.percentile(steps, 99) < 0.5


def test_raw_steps_are_composed_onto_the_first_odometry(tmp_path: Path) -> None:
    log = read_carmen(write(tmp_path, CORRECTED))
    first, second = log.scans
    assert first.reference == (10.0, 5.0, math.pi / 2)
    assert first.odometry == (1.0, 0.0, 0.0)
    # From the first scan: 1 m ahead, then 1 m to the left, turned by 90 degrees to the left.
    assert second.odometry == pytest.approx((2.0, 1.0, math.pi / 2))
    assert second.ranges[:7].tolist() == [math.inf] * 6 + [2.0]
    assert [t for t, _ in log.odometry] == [1.0, 2.0, 2.9, 3.0, 9.0]
    assert log.odometry[2][1] == pytest.approx((1.5, 0.0, 0.0))


def test_scans_out_of_order_are_put_in_file_order(tmp_path: Path) -> None:
    lines = [flaser(t, 0, 0, 0, [1.0] * 181) for t in (5.0, 4.0, 4.5, 6.0)]
    times = [scan.t for scan in read_carmen(write(tmp_path, lines)).scans]
    assert times == sorted(times)
    assert times[0] == 5.0
    assert times[3] == 6.0
    assert len(set(times)) == 4


def test_uncorrected_log_keeps_its_own_odometry(tmp_path: Path) -> None:
    def scan(t: float, x: float) -> str:
        head = f"FLASER 180 {' '.join(['1'] * 180)}"
        return f"{head} {x + 0.1} 0 0 {x} 0 0 {t} host {t}"

    lines = [scan(1.0, 0.0), odom(1.5, 0.5, 0, 0), scan(2.0, 1.0), odom(2.5, 1.5, 0, 0)]
    log = read_carmen(write(tmp_path, lines))
    assert not log.referenced
    assert [scan.odometry.x for scan in log.scans] == pytest.approx([0.1, 1.1])
    assert [t for t, _ in log.odometry] == [1.0, 1.5, 2.0, 2.5]
    assert [pose.x for _, pose in log.odometry] == pytest.approx([0.1, 0.6, 1.1, 1.6])
    assert "the laser is 0.100 m ahead" in log.notes[-1]


@pytest.mark.parametrize("count", [180, 181, 360, 361])
def test_known_beam_counts_have_their_geometry(tmp_path: Path, count: int) -> None:
    (scan,) = read_carmen(write(tmp_path, [flaser(1, 0, 0, 0, [2.0] * count)])).scans
    assert scan.angle_increment == pytest.approx(math.radians(1.0 if count < 200 else 0.5))
    points = scan.points()
    assert points.shape == (count, 2)
    assert points[0] == pytest.approx((0.0, -2.0))


def test_robot_laser_line_has_its_own_geometry(tmp_path: Path) -> None:
    line = (
        "ROBOTLASER1 0 -1.5 3.0 0.75 8.0 0.01 0 5 1.0 2.0 8.1 3.0 4.0 2 7 8 "
        "1.5 2.5 0.5 1.4 2.5 0.5 0.1 0.2 0.3 0.3 0.0 77.5 host 77.25"
    )
    (scan,) = read_carmen(write(tmp_path, [line])).scans
    assert scan.t == 77.25
    assert scan.ranges.tolist() == [1.0, 2.0, math.inf, 3.0, 4.0]
    assert (scan.angle_min, scan.angle_increment) == (-1.5, 0.75)
    assert scan.reference == Pose(1.5, 2.5, 0.5)
    assert scan.odometry == Pose(1.4, 2.5, 0.5)


def test_truncated_gzip_keeps_complete_lines(tmp_path: Path, data_folder: Path) -> None:
    whole = (data_folder / "logs" / "aces-corrected.log.gz").read_bytes()
    path = tmp_path / "cut.log.gz"
    path.write_bytes(whole[: len(whole) // 2])
    log = read_carmen(path)
    assert 150 < len(log.scans) < 300
    assert str(path) in log.notes[0]
    assert "end early, in line" in log.notes[0]


def test_plain_log_truncated_in_its_last_line_is_read(tmp_path: Path) -> None:
    path = tmp_path / "cut.log"
    path.write_text("\n".join(CORRECTED[:11])[:-40])
    log = read_carmen(path)
    assert len(log.scans) == 1
    assert "ends within line" in log.notes[0]


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"\x00\xff\x01 not a log", 1),
        (b"", 1),
        (b"# nothing here\nODOM 0 0 0 0 0 0 1 h 1\n", 1),
        (b"# ok\nODOM 0 0 zero 0 0 0 1 h 1\n", 2),
        (b"# ok\n\nFLASER 180 1 2 3 0 0 0 0 0 0 1 h 1\n", 3),
        (b"FLASER 1 1 0 0 0 0 0 0 1 h 1\n", 1),
        (b"FLASER 4 8.191 8.191 8.191 8.191 0 0 0 0 0 0 1 h 1\n", 1),
        (b"FLASER 4 210 220 230 240 0 0 0 0 0 0 1 h 1\n", 1),
        (b"ODOM 0 nan 0 0 0 0 1 h 1\n", 1),
        (b"ROBOTLASER1 0 -1.5 3.0 0.75 8.0 0.01 0 5 1.0\n", 1),
        (gzip.compress(b"hello\n" * 50, mtime=0)[:-20] + b"\xff" * 40, None),
    ],
)
def test_invalid_log_is_refused_with_file_line_and_remedy(
    tmp_path: Path, content: bytes, line: int | None
) -> None:
    path = tmp_path / "wrong.log"
    path.write_bytes(content)
    with pytest.raises(LogError) as caught:
        read_carmen(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{path}: line {'' if line is None else line}")
    assert message.count(":") >= 3


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"absent\.log"):
        read_carmen(tmp_path / "absent.log")


# --- logs as people have them ---------------------------------------------------------------------

READINGS = [2.0 + 0.01 * beam for beam in range(180)]
WORDS = " ".join(f"{value:g}" for value in READINGS)
POSES = "1.5 2.5 0.5 1.4 2.5 0.5"
ROBOT_TAIL = f"0 {POSES} 0.1 0.2 0.3 0.3 0.0 77.5 host 77.25"


@pytest.mark.parametrize(
    "line",
    [
        f"FLASER 180 {WORDS} {POSES} 77.25 host 77.25",
        f"FLASER 180 {WORDS} {POSES} 77.25",
        f"FLASER 180 {WORDS} {POSES}",
        f"  FLASER\t180 {WORDS}\t{POSES} 77.25 host 77.25\r",
        f"ROBOTLASER1 0 -1.570796 3.12414 0.0174533 81.0 0.01 0 180 {WORDS} {ROBOT_TAIL}",
        f"ROBOTLASER0 0 -1.570796 3.12414 0 0 0.01 0 180 {WORDS} {ROBOT_TAIL}",
        f"ROBOTLASER2 0 -90 179 1 81.0 0.01 0 180 {WORDS} {ROBOT_TAIL}",
        f"RAWLASER1 0 -1.570796 3.12414 0.0174533 81.0 0.01 0 180 {WORDS} 0 77.5 host 77.25",
        "ROBOTLASER1 0 -1.570796 3.12414 0.0174533 81000 10 0 180 "
        + " ".join(f"{1000 * value:g}" for value in READINGS)
        + f" {ROBOT_TAIL}",
    ],
)
def test_forms_of_a_scan_line_are_one_scan(tmp_path: Path, line: str) -> None:
    (scan,) = read_carmen(write(tmp_path, ["# Gr\u00f6\u00dfe", line])).scans
    assert scan.ranges == pytest.approx(READINGS, abs=1e-3)
    assert scan.angle_min == pytest.approx(-math.pi / 2, abs=1e-5)
    assert scan.angle_increment == pytest.approx(math.radians(1.0), abs=1e-6)


@pytest.mark.parametrize(
    ("count", "parameters", "first", "step"),
    [
        (721, [], -90.0, 0.25),
        (401, [], -50.0, 0.25),
        (101, [], -50.0, 1.0),
        (91, [], -90.0, 2.0),
        (181, ["laser_front_laser_resolution 0.5"], -45.0, 0.5),
        (180, ["laser_front_laser_resolution 1.0"], -90.0, 1.0),
        (541, ["laser_front_laser_fov 270.0"], -135.0, 0.5),
    ],
)
def test_beam_counts_and_parameters_give_the_geometry(
    tmp_path: Path, count: int, parameters: list[str], first: float, step: float
) -> None:
    lines = [*(f"PARAM {each} nohost 0" for each in parameters), flaser(1, 0, 0, 0, [2.0] * count)]
    (scan,) = read_carmen(write(tmp_path, lines)).scans
    assert math.degrees(scan.angle_min) == pytest.approx(first)
    assert math.degrees(scan.angle_increment) == pytest.approx(step)


def test_parameter_says_the_maximum_range(tmp_path: Path) -> None:
    lines = ["PARAM robot_front_laser_max 5.0 nohost 0", flaser(1, 0, 0, 0, [2.0, 4.9, 5.0, 7.0])]
    (scan,) = read_carmen(write(tmp_path, lines)).scans
    assert scan.ranges.tolist() == [2.0, 4.9, math.inf, math.inf]
    (scan,) = read_carmen(tmp_path / "made.log", 6.0).scans
    assert scan.ranges.tolist() == [2.0, 4.9, 5.0, math.inf]


@pytest.mark.parametrize("packed", [gzip.compress, bz2.compress, lzma.compress])
@pytest.mark.parametrize("padding", [b"", bytes(512)])
def test_compressed_log_is_read_with_its_padding(
    tmp_path: Path, packed: Callable[[bytes], bytes], padding: bytes
) -> None:
    path = tmp_path / "packed.log"
    path.write_bytes(packed(b"\xef\xbb\xbf" + "\r\n".join(CORRECTED).encode()) + padding)
    assert len(read_carmen(path).scans) == 2


def test_single_bad_lines_are_left_out_and_counted(tmp_path: Path) -> None:
    lines = [*CORRECTED[:6], "ODOM 1 2 what 0 0 0 1 h 1", *CORRECTED[6:], "ODOM 1 2", *CORRECTED]
    log = read_carmen(write(tmp_path, lines))
    assert len(log.scans) == 4
    assert "line 7" in log.notes[0]
    assert "2 such lines" in log.notes[0]


@pytest.mark.parametrize("jump", [1e5, -1e5, 1.6e9])
def test_clock_that_was_set_leaves_time_continuous(tmp_path: Path, jump: float) -> None:
    lines = []
    for number in range(40):
        t = 2e9 + 0.1 * number + (jump if number >= 20 else 0.0)
        lines += [odom(t, 0.1 * number, 0, 0), flaser(t, 0.1 * number, 0, 0, READINGS)]
    log = read_carmen(write(tmp_path, lines))
    steps = np.diff([scan.t for scan in log.scans])
    assert steps == pytest.approx(0.1, abs=0.1)
    assert any("clock was set 1 times" in note for note in log.notes)


def test_log_whose_robot_stands_keeps_all_of_its_odometry(tmp_path: Path) -> None:
    x, lines = 0.0, []
    for number in range(100):
        for _ in range(2):
            x += 0.05 if number >= 60 else 0.0
            lines.append(odom(0.2 * number, x, 0, 0))
        lines.append(flaser(0.2 * number, x, 0, 0, [2.0] * 180))
    log = read_carmen(write(tmp_path, lines))
    assert log.scans[-1].odometry.x == pytest.approx(4.0)
    assert np.isfinite(log.scans[-1].ranges).all()
    assert not log.referenced


def test_laser_that_is_off_centre_in_a_raw_log_is_no_correction(tmp_path: Path) -> None:
    mount, lines = Pose(0.15, -0.02, 0.1), []
    for number in range(30):
        robot = Pose(0.1 * number, 0.02 * number**2 / 10, 0.1 * number)
        laser = " ".join(f"{value:.6f}" for value in robot.compose(mount))
        base = " ".join(f"{value:.6f}" for value in robot)
        lines.append(f"FLASER 180 {WORDS} {laser} {base} {number} host {number}")
    log = read_carmen(write(tmp_path, lines))
    assert not log.referenced
    between = log.scans[3].odometry.between(log.scans[9].odometry)
    one, other = (Pose(0.1 * n, 0.02 * n**2 / 10, 0.1 * n).compose(mount) for n in (3, 9))
    assert between == pytest.approx(one.between(other), abs=1e-4)
    assert "the laser is 0.150 m ahead, -0.020 m left, 5.7 degrees" in log.notes[-1]


def test_player_log_is_read(tmp_path: Path) -> None:
    scan = " ".join(f"{value:.3f} 0" for value in READINGS)
    lines = ["## Player version 2.0.4", "## File version 0.3.0"]
    for number in range(5):
        t, x = 100.0 + 0.2 * number, 0.1 * number
        head = f"{t:014.3f} 16777343 6665"
        lines.append(f"{head} position2d 00 001 001 {x:+.3f} +0.000 +0.000 +0.1 +0.0 +0.0 1")
        lines.append(f"{head} laser 00 001 001 {number:04d} -1.5708 +1.5533 +0.0175 8.0 180 {scan}")
    log = read_carmen(write(tmp_path, lines))
    assert [scan.odometry.x for scan in log.scans] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert log.scans[0].ranges == pytest.approx(READINGS, abs=1e-3)
    assert not log.referenced


def karto_pose(x: float, y: float, theta: float) -> str:
    """Return a pose in Karto's axes: X to the left, Y up, Z ahead."""
    half = 0.5 * theta
    return (
        f"<Pose><Position><X>{y:.3f}</X><Y>0.0</Y><Z>{x:.3f}</Z></Position><Orientation>"
        f"<X>0</X><Y>{math.sin(half):f}</Y><Z>0</Z><W>{math.cos(half):f}</W></Orientation></Pose>"
    )


def karto_scan(kind: str, laser: int, t: float, pose: str = "") -> str:
    """Return a scan of one of a robot's lasers."""
    readings = "".join(f"\t\t<float>{value:.3f}</float>\n" for value in READINGS)
    return (
        f"<{kind}>\n<DeviceID>6665:laser:{laser}</DeviceID>\n<Time>{t:.3f}</Time>\n"
        "<MinAngle>-1.5708</MinAngle>\n<MaxAngle>1.5533</MaxAngle>\n"
        f"<DistanceMeasurements>\n{readings}</DistanceMeasurements>{pose}\n</{kind}>"
    )


@pytest.mark.parametrize("kind", ["RangeScan", "LocalizedRangeScan"])
def test_karto_log_is_read(tmp_path: Path, kind: str) -> None:
    lines = [
        "<?xml version='1.0' encoding='utf-8'?>",
        '<KartoLogger version=\\"1.0\\">',
        f"<LaserRangeFinder>\n<ID>6665:laser:0</ID>\n{karto_pose(0.2, 0.05, 0.0)}",
        "</LaserRangeFinder>",
        f"<LaserRangeFinder>\n<ID>6665:laser:1</ID>\n{karto_pose(-0.2, 0.0, 3.1)}",
        "</LaserRangeFinder>",
    ]
    for number in range(5):
        t, pose = 0.2 * number, karto_pose(0.1 * number, 0.0, 0.5)
        place = pose if kind == "LocalizedRangeScan" else ""
        lines.append(f"<DrivePose><Time>{t:.3f}</Time>{pose}</DrivePose>")
        lines += [karto_scan(kind, 1, t), karto_scan(kind, 0, t + 0.01, place)]
    log = read_carmen(write(tmp_path, [*lines, "<RangeScan>\n<DeviceID>"]))
    step = Pose(0.1, 0.0, 0.5).compose(Pose(0.2, 0.05, 0.0))
    if kind == "LocalizedRangeScan":
        assert tuple(log.scans[1].odometry) == pytest.approx(tuple(step), abs=2e-3)
    between = log.scans[0].odometry.between(log.scans[4].odometry)
    along = (0.4 * math.cos(0.5), -0.4 * math.sin(0.5), 0.0)
    assert tuple(between) == pytest.approx(along, abs=2e-3)
    assert len(log.scans) == 5
    assert log.scans[0].ranges == pytest.approx(READINGS, abs=1e-3)
    assert not log.referenced


def test_karto_log_without_scans_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no FLASER"):
        read_carmen(write(tmp_path, ['<KartoLogger version=\\"1.0\\">', "<DeviceStates>"]))
