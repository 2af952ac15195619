"""`patrol doctor` on an emulated robot: no finding on a sound one; one failed check for each fault,
with a remedy that repairs it."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from queue import Empty, SimpleQueue

import msgspec
import numpy as np
import pytest

from drivers.camera import Picture
from drivers.camera_source import CameraSettings
from drivers.emulation.fault_plan import FaultPlan
from drivers.emulation.line_faults import LineFaults
from drivers.lms200.errors import Severity
from drivers.lms200.health import LaserHealth
from drivers.p2os.base_state import BaseState
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.model import load_model
from drivers.p2os.robot_identity import RobotIdentity
from maps.map_folder import load_map_folder
from robot_agent.config import AgentConfig, TelemetrySettings, load_config
from tools.campaign.agent_stage import START, make_room
from tools.cli import main
from tools.commands.doctor import plain_lines
from tools.preflight.doctor import (
    examine,
    examine_clock,
    examine_devices,
    examine_map,
    examine_recorder,
    is_fit,
)
from tools.preflight.doctor_base import (
    examine_battery,
    examine_contacts,
    examine_laser_type,
    examine_motors,
)
from tools.preflight.doctor_camera import CameraExamination, examine_adjustments, examine_picture
from tools.preflight.doctor_keys import examine_operator
from tools.preflight.doctor_laser import best_rate, examine_health
from tools.preflight.doctor_port import examine_port
from tools.preflight.finding import Finding, Verdict
from tools.simulation.cable import Cable
from tools.simulation.emulated_camera import CameraServer, EmulatedCamera
from tools.simulation.real_time_rig import RealTimeRig
from tools.simulation.rig import RobotRig
from tools.simulation.world import World

UNPRIVILEGED = 65534  # the user and group without rights
DEVICE_LIMIT = 3.0  # s; reached by silent devices only

MODEL = load_model("p2dx")


class RobotOnTheBench:
    """An emulated robot in a small room, its lines and its camera, run on a thread."""

    def __init__(self, folder: Path) -> None:
        make_room(folder / "room")
        rng = np.random.default_rng(1)
        world = World(load_map_folder(folder / "room").map, rng)
        now = time.monotonic()
        self.rig = RobotRig(
            *("robot1", world, world.add_body(START), now), firmware=Firmware.ARCOS, watchdog=1.2
        )
        self.base_line = LineFaults(self.rig.base, FaultPlan(), rng)
        self.laser_line = LineFaults(self.rig.laser, FaultPlan(), rng)
        self.base_cable = Cable(self.base_line, folder / "base")
        self.laser_cable = Cable(self.laser_line, folder / "laser")
        self.camera = CameraServer(EmulatedCamera(world, self.rig.body).picture_at)
        self.operator = socket.create_server(("127.0.0.1", 0))
        self.config_path = folder / "robot1.toml"
        self.config_path.write_text(self._configuration(folder))
        ports = (self.base_cable, self.laser_cable, self.camera)
        self._real_time = RealTimeRig(self.rig, ports)
        self._requests: SimpleQueue[Callable[[], object]] = SimpleQueue()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _configuration(self, folder: Path) -> str:
        endpoint = f"tcp/127.0.0.1:{self.operator.getsockname()[1]}"
        return f"""
[map]
folder = "room"
[start]
x = {START.x}
y = {START.y}
theta = {START.theta}
[base]
url = "{self.base_cable.path}"
[laser]
url = "{self.laser_cable.path}"
mount = [0.017, 0.008, 0.0]
[camera]
url = "{self.camera.url}"
[telemetry]
operator = "{endpoint}"
[recorder]
folder = "{folder / "recordings"}"
"""

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                self._requests.get_nowait()()
            except Empty:
                self._real_time.step()

    def do(self, requested: Callable[[], object]) -> None:
        """Call a function on the thread that runs the robot, and wait for it."""
        done = threading.Event()
        self._requests.put(lambda: (requested(), done.set()))
        assert done.wait(5.0)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self.base_cable.pull()
        self.laser_cable.pull()
        self.camera.close()
        self.operator.close()


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[RobotOnTheBench]:
    robot = RobotOnTheBench(tmp_path)
    yield robot
    robot.close()


def test_sound_robot_passes_every_check(
    robot: RobotOnTheBench, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", str(robot.config_path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["fit"] is True
    found = {row["check"]: row["found"] for row in report["checks"]}
    verdicts = {row["check"]: row["verdict"] for row in report["checks"]}
    assert verdicts.pop("camera colours") == "skipped", "a network camera has none to fix"
    assert verdicts.pop("keys") == "skipped", "its telemetry has no certificates"
    assert set(verdicts.values()) == {"ok"}
    assert not any(row["remedy"] for row in report["checks"])
    assert found["base"] == "robot1, Pioneer p2dx, at 9600 baud"
    assert "2.2 m/s" in found["base limits"]
    assert found["base watchdog"] == "stops the robot 1.2 s after silence"
    assert found["battery"] == "13.0 V"
    assert "tried 9600 baud" in found["base line"]
    assert "last " in found["base line"]
    assert re.search(r"base -> /dev/pts/\d+, \w+:\w+ \d{4}$", found["base port"])
    assert found["laser"].startswith("LMS200")
    assert found["laser"].endswith("38400 baud")
    rate = float(found["laser scans"].split()[0])
    assert 7.5 < rate < 11.0, "372 bytes at 38400 baud, in whole turns of the mirror: 9.4"
    assert "320 x 240" in found["camera"]
    assert {"configuration", "map and border", "start", "rules", "clock", "disk"} < set(found)
    assert found["operator"].endswith("answers")
    base = robot.rig.base
    assert not base.session_open, "left as found"
    assert not base.motors_enabled
    assert base.velocity == (0.0, 0.0)


@dataclasses.dataclass(frozen=True)
class BrokenSetUp:
    """A fault of a robot: the check that must fail, part of its remedy, the functions that cause
    and repair it."""

    subject: str
    remedy: str
    break_it: Callable[[RobotOnTheBench], object]
    repair: Callable[[RobotOnTheBench], object]


def cut(line: LineFaults, *, whole: bool) -> None:
    line.deaf = line.mute = not whole


def garble(line: LineFaults, share: float) -> None:
    line.spoilt = share


BROKEN_SET_UPS = (
    BrokenSetUp(
        "base port",
        "plug the adapter in",
        lambda robot: robot.do(robot.base_cable.pull),
        lambda robot: robot.do(robot.base_cable.put_back),
    ),
    BrokenSetUp(
        "base",
        "switch the robot on",
        lambda robot: cut(robot.base_line, whole=False),
        lambda robot: cut(robot.base_line, whole=True),
    ),
    BrokenSetUp(
        "base",
        "check the cable: bytes come garbled",
        lambda robot: garble(robot.base_line, 1.0),
        lambda robot: garble(robot.base_line, 0.0),
    ),
    BrokenSetUp(
        "motors",
        "release the STOP button",
        lambda robot: robot.do(robot.rig.base.press_stop_button),
        lambda robot: robot.do(robot.rig.base.release_stop_button),
    ),
    BrokenSetUp(
        "battery",
        "charge or swap it",
        lambda robot: setattr(robot.rig.base.battery, "volts", 10.4),
        lambda robot: setattr(robot.rig.base.battery, "volts", 13.0),
    ),
    BrokenSetUp(
        "laser",
        "switch the laser on",
        lambda robot: robot.do(lambda: robot.rig.laser.power_off(time.monotonic())),
        lambda robot: robot.do(lambda: robot.rig.laser.power_on(time.monotonic())),
    ),
    BrokenSetUp(
        "laser status",
        "wipe the front window",
        lambda robot: setattr(robot.rig.laser, "polluted", True),
        lambda robot: setattr(robot.rig.laser, "polluted", False),
    ),
)


def devices_of(robot: RobotOnTheBench) -> AgentConfig:
    """Return the robot's configuration without its camera."""
    return msgspec.structs.replace(load_config(robot.config_path), camera=CameraSettings())


def failures(findings: list[Finding]) -> dict[str, Finding]:
    return {f.subject: f for f in findings if f.verdict is Verdict.FAILED}


def test_each_broken_device_fails_one_check_until_repaired(robot: RobotOnTheBench) -> None:
    config = devices_of(robot)
    for set_up in BROKEN_SET_UPS:  # each examination also shows that the one before is repaired
        set_up.break_it(robot)
        findings = examine_devices(config, DEVICE_LIMIT)
        assert list(failures(findings)) == [set_up.subject], set_up.remedy
        assert set_up.remedy in failures(findings)[set_up.subject].remedy
        assert not is_fit(findings)
        set_up.repair(robot)
    assert is_fit(examine_devices(config, DEVICE_LIMIT))


def test_absent_camera_fails_with_a_remedy() -> None:
    with socket.create_server(("127.0.0.1", 0)) as place:
        port = place.getsockname()[1]
    config = AgentConfig(camera=CameraSettings(url=f"http://127.0.0.1:{port}/camera.mjpeg"))
    absent = CameraExamination(config.camera, limit=0.5).findings()
    assert [f.verdict for f in absent] == [Verdict.FAILED]
    assert "nothing listens" in absent[0].text
    assert absent[0].remedy


def test_port_held_by_another_process_fails_until_it_ends(robot: RobotOnTheBench) -> None:
    config = devices_of(robot)
    path = str(robot.laser_cable.path)
    program = f"port = open({path!r}, 'rb', 0); print('open', flush=True); input()"
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"open\n"
        found = examine_port("laser port", config.laser.url)
        assert found.verdict is Verdict.FAILED
        remedy = re.search(r"`kill (\d+)`", found.remedy)
        assert remedy is not None
        os.kill(int(remedy[1]), signal.SIGTERM)
        assert holder.wait(10.0) == -signal.SIGTERM
    assert examine_port("laser port", config.laser.url).verdict is Verdict.OK


def test_port_without_permission_fails_and_names_its_group(robot: RobotOnTheBench) -> None:
    path = robot.base_cable.path.resolve()
    mode = path.stat().st_mode & 0o777
    path.chmod(0o600 if os.geteuid() == 0 else 0o000)
    text = as_plain_user(lambda: "\n".join(plain_lines([examine_port("base port", str(path))])))
    assert text.startswith("failed")
    group = re.search(r"no permission \(\w+:(\w+) \d{4}\)", text)
    assert group is not None
    assert f"`sudo adduser $USER {group[1]}`" in text
    path.chmod(0o666)  # what being in the group amounts to
    assert as_plain_user(lambda: examine_port("base port", str(path)).verdict) == "ok"
    path.chmod(mode)


def as_plain_user(work: Callable[[], str]) -> str:
    """Return the result of work done as a user without rights."""
    if os.geteuid() != 0:
        return work()
    for module in ("grp", "pwd"):  # of Path.owner; that user may not read where Python is
        import_module(module)
    groups = os.getgroups()
    os.setgroups([])
    os.setresgid(UNPRIVILEGED, UNPRIVILEGED, 0)
    os.setresuid(UNPRIVILEGED, UNPRIVILEGED, 0)
    try:
        return work()
    finally:
        os.setresuid(0, 0, 0)
        os.setresgid(0, 0, 0)
        os.setgroups(groups)


def test_base_and_laser_fail_independently(robot: RobotOnTheBench) -> None:
    """Base and laser are checked independently: both can fail at once."""
    robot.rig.base.battery.volts = 10.0
    robot.do(robot.laser_cable.pull)
    findings = examine_devices(devices_of(robot), DEVICE_LIMIT)
    assert set(failures(findings)) == {"battery", "laser port"}


def test_robot_with_an_open_session_is_fit(robot: RobotOnTheBench) -> None:
    config = devices_of(robot)
    base = robot.rig.base
    for packet in ("FAFB03000000", "FAFB03010001", "FAFB03020002", "FAFB03010001"):
        robot.do(lambda packet=packet: base.feed(bytes.fromhex(packet), time.monotonic()))
    assert base.session_open
    assert is_fit(examine_devices(config, 2 * DEVICE_LIMIT))


# What needs no devices


@pytest.fixture
def room(tmp_path: Path) -> Path:
    make_room(tmp_path / "room")
    return tmp_path


def configured(text: str, folder: Path) -> AgentConfig:
    path = folder / "robot.toml"
    path.write_text(text)
    return load_config(path)


def test_unknown_key_is_the_only_finding(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[base]\nbuad = 9600\n")
    (finding,) = examine(path)
    assert finding.verdict is Verdict.FAILED
    assert "base.buad: unknown key" in finding.text


def test_border_too_near_a_wall_fails(room: Path) -> None:
    config = configured('[map]\nfolder = "room"\n', room)
    assert not failures(examine_map(config, room, MODEL))
    border = room / "room" / "border.toml"
    sound = border.read_text()
    border.write_text(sound.replace("4.5]", "5.6]"))
    (finding,) = examine_map(config, room, MODEL)
    assert finding.subject == "map and border"
    assert finding.verdict is Verdict.FAILED
    assert "patrol map show" in finding.remedy
    border.write_text(sound)
    assert not failures(examine_map(config, room, MODEL))


def test_what_a_new_robot_lacks_is_not_yet_there(room: Path) -> None:
    (room / "room" / "border.toml").unlink()
    (undrawn,) = examine_map(configured('[map]\nfolder = "room"\n', room), room, MODEL)
    (absent,) = examine_map(configured('[map]\nfolder = "nowhere"\n', room), room, MODEL)
    for finding, text, first in (
        (undrawn, "border.toml is missing", "draw it with `patrol map border"),
        (absent, "no map is there; shipped maps are", "first `patrol record ROBOT.toml --teleop"),
    ):
        assert finding.verdict is Verdict.NOT_YET
        assert text in finding.text
        assert finding.remedy.startswith(first)
        assert not is_fit([finding])


@pytest.mark.parametrize(("x", "words"), [(0.02, "not on free ground"), (-5.0, "outside the map")])
def test_start_off_free_ground_fails(room: Path, x: float, words: str) -> None:
    text = f'[map]\nfolder = "room"\n[start]\nx = {x}\ny = 3.0\ntheta = 0.0\n'
    assert words in failures(examine_map(configured(text, room), room, MODEL))["start"].text


def test_unknown_start_is_a_warning(room: Path) -> None:
    findings = examine_map(configured('[map]\nfolder = "room"\n', room), room, MODEL)
    assert [f.verdict for f in findings if f.subject == "start"] == [Verdict.WARNING]
    assert is_fit(findings)


def test_unusable_rules_fail(room: Path) -> None:
    (room / "rules.toml").write_text("nonsense = 1\n")
    text = f'[map]\nfolder = "room"\n[patrol]\nrules_file = "{room / "rules.toml"}"\n'
    assert "rules" in failures(examine_map(configured(text, room), room, MODEL))


def test_disk_fails_if_full_or_not_writable(tmp_path: Path) -> None:
    assert examine_recorder("").verdict is Verdict.SKIPPED
    assert examine_recorder(str(tmp_path / "new" / "folder"), 0).verdict is Verdict.OK
    full = examine_recorder(str(tmp_path), 10**18)
    assert full.verdict is Verdict.FAILED
    assert "old recordings" in full.remedy
    (tmp_path / "file").touch()
    blocked = examine_recorder(str(tmp_path / "file"), 0)
    assert blocked.verdict is Verdict.FAILED
    (tmp_path / "file").unlink()
    (tmp_path / "file").mkdir()  # as the remedy demands
    assert examine_recorder(str(tmp_path / "file"), 0).verdict is Verdict.OK


def test_clock_fails_if_unset_or_not_running() -> None:
    assert examine_clock().verdict is Verdict.OK
    unset = examine_clock(wall=lambda: 86400.0)
    assert unset.verdict is Verdict.FAILED
    assert "1970-01-02" in unset.text
    assert examine_clock(monotonic=lambda: 1.0).verdict is Verdict.FAILED


def test_absent_operator_is_a_warning() -> None:
    assert examine_operator(TelemetrySettings()).verdict is Verdict.SKIPPED
    with socket.create_server(("127.0.0.1", 0)) as listener:
        endpoint = f"tcp/127.0.0.1:{listener.getsockname()[1]}"
        assert examine_operator(TelemetrySettings(operator=endpoint)).verdict is Verdict.OK
    absent = examine_operator(TelemetrySettings(operator=endpoint))
    assert absent.verdict is Verdict.WARNING, "a robot patrols without"
    assert "patrol monitor" in absent.remedy


def base_report(**changes: object) -> BaseState:
    fields = dict.fromkeys(("t", "x", "y", "theta", "v", "w", "v_left", "v_right"), 0.0)
    quiet = BaseState(
        **fields,
        battery=12.9,
        stall_left=False,
        stall_right=False,
        front_bumpers=0,
        rear_bumpers=0,
        motors_enabled=False,
        sonar_on=True,
        flags=0,
        sonar=(),
    )
    return dataclasses.replace(quiet, **changes)


@pytest.mark.parametrize(
    ("volts", "verdict"),
    [(12.5, Verdict.OK), (11.5, Verdict.WARNING), (10.9, Verdict.FAILED)],
)
def test_battery_verdict_follows_its_voltage(volts: float, verdict: Verdict) -> None:
    assert examine_battery(volts).verdict is verdict
    assert examine_battery(2.0 * volts, share=2.0).verdict is verdict


def test_laser_without_a_driver_is_warned_of() -> None:
    assert examine_laser_type(load_model("p2dx")).verdict is Verdict.OK
    other = examine_laser_type(load_model("p3dx-sh-lms500"))
    assert other.verdict is Verdict.WARNING
    assert "p3dx-sh-lms500 comes with a laser of type lms500" in other.text
    assert "no laser" in examine_laser_type(load_model("amigo")).text
    assert 'laser.kind = "lms1xx"' in other.remedy
    assert examine_laser_type(load_model("p3dx-sh-lms1xx"), "lms1xx").verdict is Verdict.OK
    assert examine_laser_type(load_model("p2dx"), "lms1xx").verdict is Verdict.WARNING


def test_unknown_subclass_fails_with_how_to_add_it(robot: RobotOnTheBench) -> None:
    robot.do(lambda: setattr(robot.rig.base, "identity", RobotIdentity("R", "Pioneer", "p9zz")))
    base = failures(examine_devices(devices_of(robot), DEVICE_LIMIT))["base"]
    assert "a 'p9zz', of which no model is known; it will not drive" in base.text
    assert 'base.model = "./mine.toml"' in base.remedy


def test_model_that_contradicts_the_robot_fails(robot: RobotOnTheBench) -> None:
    config = devices_of(robot)
    base = msgspec.structs.replace(config.base, model="p3at")
    contradicted = msgspec.structs.replace(config, base=base)
    found = failures(examine_devices(contradicted, DEVICE_LIMIT))["base"]
    assert "'p3at'" in found.text
    assert "'p2dx'" in found.text
    assert "delete base.model" in found.remedy


def test_border_must_leave_room_for_the_robots_model(room: Path) -> None:
    config = configured('[map]\nfolder = "room"\n', room)
    (finding,) = examine_map(config, room, load_model("seekur"))
    assert "at least 1.03 m needed" in finding.text


def test_base_on_its_charger_is_warned_of() -> None:
    charged = examine_battery(13.2, charging=True)
    assert charged.verdict is Verdict.WARNING
    assert "unplug" in charged.remedy


def test_bumpers_that_are_not_fitted_are_named() -> None:
    missing = "no bumpers fitted (every bit reads 1)"
    assert missing in examine_contacts(base_report(), missing).text


def test_stop_button_and_contacts_fail() -> None:
    assert examine_motors(base_report()).verdict is Verdict.OK
    assert examine_motors(base_report(motors_enabled=True)).verdict is Verdict.WARNING
    assert examine_motors(base_report(stop_button=True)).verdict is Verdict.FAILED
    assert examine_contacts(base_report()).verdict is Verdict.OK
    touched = examine_contacts(base_report(stall_left=True, front_bumpers=0b00101))
    assert touched.text == "left wheel stalled; bumper pressed: front 1, front 3"


def test_polluted_or_defective_laser_fails() -> None:
    assert examine_health(LaserHealth(Severity.OK)).verdict is Verdict.OK
    dirty = examine_health(LaserHealth(Severity.WARNING, pollution=True))
    assert "wipe" in dirty.remedy
    broken = examine_health(LaserHealth(Severity.FATAL, defective=True))
    assert broken.verdict is Verdict.FAILED


def test_best_rate_is_in_whole_turns_of_the_mirror() -> None:
    # 372 bytes take 97 ms at 38400 baud, a mirror's turn 13.3 ms: every eighth turn is sent.
    assert best_rate(181, 1, 38400) == pytest.approx(75 / 8, rel=2e-3)
    assert best_rate(361, 2, 500000) == pytest.approx(37.5, rel=2e-3)


def picture(level: int, spread: int = 40) -> Picture:
    pixels = np.full((48, 64, 3), level, np.uint8)
    pixels[:, ::2] += np.uint8(spread)
    return Picture(0.0, 1, pixels)


def test_dark_or_flat_picture_is_a_warning() -> None:
    assert examine_picture("cam", picture(100), 10.0).verdict is Verdict.OK
    capped = examine_picture("cam", picture(0, 3), 10.0)
    assert capped.verdict is Verdict.WARNING
    assert "lens cap" in capped.remedy
    assert "shows nothing" in examine_picture("cam", picture(100, 0), 10.0).text
    assert examine_adjustments(("exposure", "white balance")).verdict is Verdict.OK
    assert examine_adjustments(("exposure",)).text == "white balance cannot be fixed from here"


def test_plain_lines_hold_verdict_text_and_remedy() -> None:
    lines = plain_lines([Finding("battery", Verdict.FAILED, "10.0 V", "charge it")])
    assert lines[0].split() == ["failed", "battery", "10.0", "V"]
    assert lines[1].strip() == "-> charge it"


def test_factory_watchdog_is_a_warning(
    robot: RobotOnTheBench, capsys: pytest.CaptureFixture[str]
) -> None:
    robot.rig.base.base.watchdog = 2.0
    assert main(["doctor", str(robot.config_path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    (row,) = [row for row in report["checks"] if row["check"] == "base watchdog"]
    assert (row["verdict"], row["found"]) == (
        "warning",
        "stops the robot 2 s after silence, then its ramp",
    )
    assert "to 1.2 s with its FLASH tool" in row["remedy"]


def test_watchdog_test_measures_the_time_to_rest(
    robot: RobotOnTheBench, capsys: pytest.CaptureFixture[str]
) -> None:
    test = ["doctor", str(robot.config_path), "--watchdog-test"]
    assert main(test) == 2
    assert robot.rig.base.counters.sessions == 0, "nothing moves without confirmation"
    assert main([*test, "--wheels-off-ground"]) == 0
    out = capsys.readouterr().out
    after = float(re.search(r"at rest ([0-9.]+) s after the last command", out)[1])  # type: ignore[index]
    assert 1.1 < after < 1.9
    assert not robot.rig.base.motors_enabled
    assert robot.rig.base.velocity == (0.0, 0.0)
