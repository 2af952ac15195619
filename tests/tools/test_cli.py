"""Bad input to the command line: one line with file and remedy, status 1 or 2, no traceback."""

import os
import shutil
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from robot_agent.config import find_map, parse_config
from tools.cli import COMMANDS, EXTRAS, main
from tools.monitor.endpoint import free_endpoint

ROOT = Path(__file__).parents[2]
MCAP_MAGIC = b"\x89MCAP0\r\n"


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    """Run the command in this process; return status, standard output, standard error."""
    try:
        status = main(list(words))
    except SystemExit as error:
        status = int(error.code or 0)
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def complaint(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Run a command that must fail with one line on standard error; return that line."""
    status, out, err = run(capsys, *words)
    assert status in (1, 2, os.EX_CONFIG)
    assert out == ""
    lines = err.strip().splitlines()
    assert len(lines) == 1, err
    return lines[0]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, command, "--help")
    assert status == 0
    assert "usage: patrol " + command in out


def test_unknown_commands_and_options_are_usage_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "dance")[0] == 2
    assert run(capsys, "bench", "--dance")[0] == 2
    assert run(capsys)[0] == 2


def test_missing_map_image_is_one_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(find_map("paper_lab", tmp_path), tmp_path / "lab")
    (tmp_path / "lab" / "map.pgm").unlink()
    line = complaint(capsys, "map", "show", str(tmp_path / "lab"), "-o", str(tmp_path / "x.png"))
    assert "map.pgm" in line
    line = complaint(capsys, "bench", "--map", str(tmp_path / "lab"), "--duration", "1")
    assert "map.pgm" in line


def test_border_through_a_wall_fails_the_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(find_map("paper_lab", tmp_path), tmp_path / "lab")
    border = tmp_path / "lab" / "border.toml"
    border.write_text(border.read_text().replace("[3.95, 13.75]", "[3.95, 16.50]"))
    status, out, _ = run(capsys, "map", "check", str(tmp_path / "lab"))
    assert status == 1
    assert "runs through a wall at" in out


def test_good_map_passes(capsys: pytest.CaptureFixture[str]) -> None:
    for border in ("border", "open"):
        status, out, _ = run(capsys, "map", "check", "paper_lab", "--border", border)
        assert status == 0, out
    assert run(capsys, "map", "check", "intel_lab")[0] == 0


def test_unknown_border_is_one_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert "nowhere.toml" in complaint(capsys, "bench", "--border", "nowhere")


def test_unknown_nested_configuration_key_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[localization.health]\nlost_bellow = 0.2\n")
    line = complaint(capsys, "agent", str(path))
    assert line.startswith(f"patrol agent: {path}: localization.health.lost_bellow: unknown key")


def test_print_config_is_the_effective_configuration(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text('[robot]\nname = "scout"\n')
    status, out, _ = run(capsys, "agent", str(path), "--print-config")
    assert status == 0
    config = parse_config(out.encode(), "printed")
    assert config.robot.name == "scout"
    assert "max_speed" in out


def test_list_settings_needs_no_configuration(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "agent", "--list-settings")
    assert status == 0
    assert out.splitlines()[-1].endswith(" settings")


@pytest.mark.parametrize("command", ["convert", "localize", "map build"])
def test_file_that_is_no_log_is_one_error(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "poem.log"
    path.write_text("Roses are red\n")
    options = {
        "convert": ("-o", str(tmp_path / "x.mcap")),
        "localize": ("--map", "paper_lab"),
        "map build": ("-o", str(tmp_path / "x")),
    }[command]
    line = complaint(capsys, *command.split(), str(path), *options)
    assert "poem.log: line 1: no FLASER or ROBOTLASER line" in line


def test_file_that_is_no_recording_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.mcap"
    path.write_text("no recording")
    assert "x.mcap: is not an MCAP file" in complaint(capsys, "replay", str(path))
    assert "y.mcap: cannot be read" in complaint(capsys, "replay", str(tmp_path / "y.mcap"))


@pytest.mark.parametrize(
    "words",
    [
        ("rules", "show", "-o"),
        ("map", "show", "paper_lab", "-o"),
        ("bench", "--sensing", "ideal", "--duration", "1", "--json"),
    ],
)
def test_a_full_disk_is_one_error(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    status, _, said = run(capsys, *words, "/dev/full")
    assert status == 1
    (line,) = said.splitlines()
    assert line.startswith(f"patrol {words[0]}: /dev/full: No space left on device; make room on")


@pytest.mark.parametrize(
    "words", [("map", "check", "paper_lab"), ("agent", "--list-settings"), ("--version",)]
)
def test_output_to_a_full_disk_is_no_traceback(words: tuple[str, ...]) -> None:
    command = [sys.executable, "-m", "tools.start", *words]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            command, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) <= 1


@pytest.mark.parametrize("module", ["tools.cli", "tools.commands.bench", "maps.map_folder"])
def test_ctrl_c_while_starting_is_silent(module: str) -> None:
    program = (
        "import signal, sys\n"
        "class Interrupting:\n"
        "    def find_spec(self, name, *_):\n"
        f"        if name == {module!r}: signal.raise_signal(signal.SIGINT)\n"
        "sys.meta_path.insert(0, Interrupting())\n"
        "from tools.start import main\n"
        "sys.argv = ['patrol', 'bench']\n"
        "sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_a_missing_extra_is_one_line_that_names_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, "tools.commands.monitor", raising=False)
    for module in [name for name in sys.modules if name.startswith("tools.monitor.")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    for words in (("monitor", "--duration", "1"), ("monitor", "--help")):
        line = complaint(capsys, *words)
        assert line == "patrol: needs aiohttp: pip install 'border-patrol[operator]'"


def test_every_extra_of_the_project_but_the_checkers_is_known() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for extra in ("operator", "cluster", "ros"):
        names = {each.split("[")[0] for each in project["optional-dependencies"][extra]}
        assert {EXTRAS[name] for name in names} == {extra}


def test_a_map_that_is_not_there_names_the_shipped_ones(capsys: pytest.CaptureFixture[str]) -> None:
    line = complaint(capsys, "bench", "--map", "nowhere", "--duration", "1")
    assert "Shipped maps are intel_lab, large_hall, paper_lab" in line


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_command_as_ctrl_c_does(tmp_path: Path, number: signal.Signals) -> None:
    target = tmp_path / "team.mcap"
    listen = free_endpoint()
    words = ["monitor", "--http", "127.0.0.1:0", "--listen", listen, "--record", str(target)]
    command = [sys.executable, "-m", "tools.cli", *words]
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert "robots report to" in process.stderr.readline()
        process.send_signal(number)
        _, said = process.communicate(timeout=30.0)
    assert process.returncode == 128 + number
    assert "Traceback" not in said
    assert target.read_bytes().endswith(MCAP_MAGIC)  # finished, with its index


def test_a_shell_completes_commands_options_and_choices() -> None:
    for line, expected in (
        ("patrol moni", "monitor"),
        ("patrol bench --sen", "--sensing"),
        ("patrol bench --sensing id", "ideal"),
    ):
        environment = {
            **os.environ,
            "_ARGCOMPLETE": "1",
            "_ARGCOMPLETE_STDOUT_FILENAME": "/dev/stdout",
            "COMP_LINE": line,
            "COMP_POINT": str(len(line)),
        }
        words = [sys.executable, "-m", "tools.cli"]
        done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, timeout=60)
        assert expected in done.stdout.decode().split("\v")[0]


@pytest.mark.parametrize(
    "command",
    [
        "agent",
        "bench",
        "convert",
        "doctor",
        "emulate",
        "install",
        "localize",
        "map",
        "ports",
        "record",
        "replay",
        "trial",
    ],
)
def test_commands_of_a_robot_need_no_extra(command: str) -> None:
    program = (
        "import sys; from tools.cli import EXTRAS, load_command\n"
        "for name in EXTRAS: sys.modules[name] = None\n"
        f"load_command('{command}')"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, timeout=60
    )
    assert done.returncode == 0, done.stderr.decode()
