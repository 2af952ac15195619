"""An installation below a temporary root: files written, checks, refusals."""

import os
import shutil
from pathlib import Path

import pytest

from robot_agent.config import ConfigError, load_config, parse_config
from robot_agent.patrol.rules import RULES_FILE
from tools.cli import main
from tools.deploy.service import (
    CAMERA_DRIVERS,
    DEPLOY,
    MODULES,
    RULES,
    SERIAL_DRIVERS,
    UNIT,
    DeploymentError,
    activate,
    check_unit,
    deploy,
    next_steps,
    this_program,
)
from tools.deploy.service_paths import examine_paths, may_read
from tools.preflight.doctor import load_patrol_map
from tools.preflight.finding import Verdict

needs_systemd = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None, reason="systemd-analyze is not there"
)


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "robot1.toml"
    path.write_text('[robot]\nname = "robot1"\n')
    return path


def test_writes_unit_rules_user_and_configuration(tmp_path: Path, config: Path) -> None:
    root = tmp_path / "root"
    done = deploy(root, [config], "patrol", this_program())
    names = {str(path.relative_to(root)) for path in done.written}
    assert names == {
        "etc/systemd/system/patrol@.service",
        "etc/udev/rules.d/60-patrol.rules",
        "etc/sysusers.d/patrol.conf",
        "etc/modules-load.d/patrol.conf",
        "etc/patrol/robot1.toml",
    }
    assert {path for path in root.rglob("*") if path.is_file()} == set(done.written)
    unit = (root / UNIT).read_text()
    assert f"ExecStart={this_program()} agent /etc/patrol/%i.toml" in unit
    assert "User=patrol" in unit
    assert "@PATROL@" not in unit
    assert "@USER@" not in unit


def test_no_example_of_a_serial_number_is_installed_as_this_robots(tmp_path: Path) -> None:
    deploy(tmp_path, [], "patrol", this_program())
    lines = (tmp_path / RULES).read_text().splitlines()
    assert [line for line in lines if line and not line.startswith("#")] == []
    assert sum('ID_MM_DEVICE_IGNORE}="1"' in line for line in lines) == 6


def test_existing_udev_rules_are_kept(tmp_path: Path, config: Path) -> None:
    rules = tmp_path / RULES
    rules.parent.mkdir(parents=True)
    rules.write_text("# mine\n")
    done = deploy(tmp_path, [config], "patrol", this_program())
    assert rules.read_text() == "# mine\n"
    assert done.kept == [rules]


def test_drivers_of_adapters_are_loaded_before_the_service_and_a_cameras_where_there_is_one(
    tmp_path: Path, config: Path
) -> None:
    deploy(tmp_path / "a", [config], "patrol", this_program())
    loaded = (tmp_path / "a" / MODULES).read_text().split("\n")[1:-1]
    assert loaded == list(SERIAL_DRIVERS)
    config.write_text('[camera]\nurl = "/dev/video0"\n')
    deploy(tmp_path / "b", [config], "patrol", this_program())
    assert (tmp_path / "b" / MODULES).read_text().split("\n")[1:-1] == [
        *SERIAL_DRIVERS,
        *CAMERA_DRIVERS,
    ]
    assert "systemd-modules-load.service" in (tmp_path / "a" / UNIT).read_text()


def test_an_installation_elsewhere_activates_nothing_and_lists_what_remains(
    tmp_path: Path,
) -> None:
    assert activate(tmp_path) == []
    remaining = next_steps(["robot7"], activated=False)
    assert remaining[0] == "systemd-sysusers"
    assert "systemctl daemon-reload" in remaining
    assert remaining[-2:] == [
        "systemctl enable --now patrol@robot7",
        "journalctl -fu patrol@robot7",
    ]
    assert next_steps(["robot7"], activated=True)[0] == "patrol doctor /etc/patrol/robot7.toml"


@pytest.mark.parametrize(
    ("written", "says"),
    [
        ("[start]\nx = 500.0\ny = 0.0\ntheta = 0.0\n", "outside the map"),
        ("[map]\nfolder = 'lab'\n", "leaves the map"),
        ("[map]\nfolder = 'lab'\nborder = 'other'\n", "no such border"),
    ],
)
def test_a_configuration_that_can_never_patrol_is_refused_by_install_and_agent_alike(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], written: str, says: str
) -> None:
    shutil.copytree(Path(__file__).parents[3] / "maps" / "paper_lab", tmp_path / "lab")
    border = "closed = false\ncorner_radius = 1.0\nvertices = [[5.0, 5.0], [900.0, 5.0]]\n"
    (tmp_path / "lab" / "border.toml").write_text(border)
    config = tmp_path / "robot1.toml"
    config.write_text(written)
    with pytest.raises(DeploymentError, match=says):
        deploy(tmp_path / "root", [config], "patrol", this_program())
    assert main(["agent", str(config)]) == os.EX_CONFIG
    told = capsys.readouterr().err
    assert says in told
    assert told.count("\n") == 1
    prevented = f"RestartPreventExitStatus={os.EX_CONFIG}"
    assert prevented in (DEPLOY / UNIT.name).read_text()


def test_a_map_beside_the_configuration_is_copied_with_it(tmp_path: Path, config: Path) -> None:
    shutil.copytree(Path(__file__).parents[3] / "maps" / "paper_lab", tmp_path / "lab")
    config.write_text("[map]\nfolder = 'lab'\n")
    deploy(tmp_path / "root", [config], "patrol", this_program())
    installed = tmp_path / "root" / "etc" / "patrol"
    assert (installed / "lab" / "map.pgm").read_bytes() == (tmp_path / "lab/map.pgm").read_bytes()
    assert load_patrol_map(load_config(installed / "robot1.toml"), installed).border is not None


def test_rules_beside_the_configuration_are_copied_and_found_from_any_folder(
    tmp_path: Path, config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "own.toml").write_bytes(RULES_FILE.read_bytes())
    config.write_text("[patrol]\nrules_file = 'own.toml'\n")
    deploy(tmp_path / "root", [config], "patrol", this_program())
    installed = tmp_path / "root" / "etc" / "patrol"
    monkeypatch.chdir("/")
    rules = load_config(installed / "robot1.toml").patrol.rules_file
    assert rules == str(installed / "own.toml")
    assert Path(rules).is_file()


def test_a_map_that_names_its_image_by_the_whole_path_is_readable_where_it_is_installed(
    tmp_path: Path, config: Path
) -> None:
    shutil.copytree(Path(__file__).parents[3] / "maps" / "paper_lab", tmp_path / "lab")
    text = (tmp_path / "lab" / "map.yaml").read_text()
    whole = text.replace("image: map.pgm", f"image: {tmp_path / 'lab'}/map.pgm")
    assert whole != text
    (tmp_path / "lab" / "map.yaml").write_text(whole)
    config.write_text("[map]\nfolder = 'lab'\n")
    deploy(tmp_path / "root", [config], "patrol", this_program())
    installed = tmp_path / "root" / "etc" / "patrol"
    (tmp_path / "lab").rename(tmp_path / "gone")
    assert (installed / "lab" / "map.yaml").read_text() == text
    assert load_patrol_map(load_config(installed / "robot1.toml"), installed).border is not None


@pytest.mark.parametrize(
    ("written", "subject", "says"),
    [
        ("[recorder]\nfolder = '/srv/runs'", "recorder.folder", "may write below /var/lib/patrol"),
        ("[memory]\nfile = 'pose.json'", "memory.file", "may write below /var/lib/patrol"),
        ("[telemetry]\nkeys = '/tmp/keys'", "telemetry.keys", "a /tmp of its own"),
        ("[telemetry]\nkeys = 'keys'", "telemetry.keys", "not copied"),
        ("[recorder]\nfolder = '/var/lib/patrol/runs'", "paths", "can read and write"),
    ],
)
def test_paths_are_judged_as_the_services_user_meets_them(
    written: str, subject: str, says: str
) -> None:
    (finding,) = examine_paths(parse_config(written.encode(), "robot.toml"), "patrol")
    assert finding.subject == subject
    assert says in finding.text


def test_a_folder_that_only_its_owner_may_enter_is_none_for_the_service(tmp_path: Path) -> None:
    private = tmp_path / "home"
    private.mkdir(mode=0o700)
    assert not may_read(private, "nobody")
    private.chmod(0o755)
    assert may_read(private, "nobody")
    assert may_read(private, "a-user-not-made-yet")
    assert may_read(private, "root")


@needs_systemd
def test_unit_passes_verification_and_exposure_limit(tmp_path: Path) -> None:
    done = deploy(tmp_path, [], "root", Path("/bin/true"))
    assert [finding.verdict for finding in done.findings] == [Verdict.OK] * 3
    assert done.fit
    exposure = next(finding for finding in done.findings if finding.subject == "exposure")
    assert float(exposure.text.split()[0]) < 3.0


@needs_systemd
def test_invalid_unit_is_a_failed_finding(tmp_path: Path) -> None:
    unit = tmp_path / "patrol@.service"
    unit.write_text("[Service]\nExecStart=/nowhere/patrol\n")
    verdicts = {finding.subject: finding.verdict for finding in check_unit(unit)}
    assert verdicts == {"unit": Verdict.FAILED, "exposure": Verdict.FAILED}


def test_bad_configurations_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    bad = tmp_path / "robot1.toml"
    bad.write_text("[robot]\nnmae = 'x'\n")
    with pytest.raises(ConfigError, match="unknown key"):
        deploy(tmp_path / "root", [bad], "patrol", this_program())
    shutil.copytree(Path(__file__).parents[3] / "maps" / "paper_lab", tmp_path / "lab")
    (tmp_path / "here").mkdir()
    bad = tmp_path / "here" / "robot1.toml"
    bad.write_text("[map]\nfolder = '../lab'\n")
    with pytest.raises(DeploymentError, match="lies above this file"):
        deploy(tmp_path / "root", [bad], "patrol", this_program())
    assert not (tmp_path / "root").exists()


def test_command_prints_the_next_steps(
    tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status = main(["install", str(config), "--root", str(tmp_path), "--user", "root"])
    out, err = capsys.readouterr()
    assert status == 0
    assert f"written  {tmp_path / UNIT}" in out
    assert "systemctl enable --now patrol@robot1" in err
