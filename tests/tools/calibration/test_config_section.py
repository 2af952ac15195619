"""Keys are set in valid TOML files of any layout, and nothing else changes."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_agent.config import ConfigError, load_config
from tools.calibration import config_section
from tools.calibration.config_section import set_keys, with_keys

MEAN = [0.1, -0.2]
CAMERA = {"mount": [0.1, 0.0, 0.2], "focal_length": 210.0}
CONFIGS = {
    "missing section": '[map]\nborder = "x"\n',
    "empty": "",
    "comment only": "# mine",
    "no final newline": "[robot]\nname = 'anna'",
    "inline table": 'camera = { url = "x", mount = [0.0, 0.1, 0.0] } # front\n[map]\nborder="x"\n',
    "inline parent": "perception = { color = { gate = 7.0 } }\n",
    "dotted keys": (
        "perception.color.band.mean = [1.0, 2.0]\ncamera.focal_length = 200.0 # f\n"
        'map.border = "x"\nperception.lens.k1 = 1\n'
    ),
    "dotted parent": (
        'perception.color.band_height = 0.2\ncamera.url = "x"\n'
        "perception.color.band_width = 0.4\n[map]\n"
    ),
    "array over lines": (
        '[camera]\nmount = [0.0, # left ]\n  0.1, # [camera]\n  0.0]  # end\nurl = "a]b[c" # q\n'
        "\n# about the map\n[map]\nborder='x'\n"
    ),
    "spaces and quotes": (
        '[ camera ] # c\n"mount" = [0.0, 0.0, 0.0]\n[ \'perception\' . color . "band" ]\n'
        "'mean' = [1.0, 2.0]\n"
    ),
    "sections in any order": (
        '[perception.color.band]\nmean = [1.0, 2.0]\n[map]\nborder = "x"\n[perception.color]\n'
        'gate = 7.0\n[camera]\nurl = "x"\n[perception]\nother = 2\n'
    ),
    "header in a string": 'motto = """\n[camera]\nmount = 1\n"""\n[camera]\nurl = "x"\n',
    "Windows lines": '[camera]\r\nurl = "x"\r\n\r\n# map\r\n[map]\r\nborder = "x"\r\n',
}


def merged(content: dict[str, Any], section: str, values: dict[str, Any]) -> dict[str, Any]:
    table = content
    for name in section.split("."):
        table = table.setdefault(name, {})
    table |= values
    return content


@pytest.mark.parametrize("text", CONFIGS.values(), ids=CONFIGS)
@pytest.mark.parametrize(
    ("section", "values"),
    [("camera", CAMERA), ("perception.color.band", {"mean": MEAN, "covariance": [1.0, 0.0]})],
)
def test_keys_are_set_and_nothing_else(text: str, section: str, values: dict[str, Any]) -> None:
    changed = with_keys(text, section, values)
    assert tomllib.loads(changed) == merged(tomllib.loads(text), section, values)
    assert with_keys(changed, section, values) == changed
    kept = [line for line in text.splitlines() if not line.lstrip("'\"").startswith(section[:4])]
    lines = changed.splitlines()
    order = [lines.index(line) for line in kept if line.startswith(("#", "[map", "url", "map."))]
    assert order == sorted(order)
    assert ("\r\n" in text) == ("\r\n" in changed)
    assert changed.count("\r\n") in (0, changed.count("\n"))


def test_comment_stays_above_its_section() -> None:
    changed = with_keys(CONFIGS["array over lines"], "camera", CAMERA)
    assert changed == (
        '[camera]\nmount = [0.1, 0.0, 0.2]  # end\nurl = "a]b[c" # q\nfocal_length = 210.0\n'
        "\n# about the map\n[map]\nborder='x'\n"
    )


SCALARS = st.integers(0, 9) | st.sampled_from(["'[camera]'", '"# ]"', "[1, # ]\n 2]", "[[1]]"])
TABLES = st.permutations(["[camera]", "[perception]", "[perception.color]", "[ 'map' ]"])


@given(TABLES, st.lists(SCALARS, min_size=4, max_size=4), st.integers(0, 4), st.booleans())
def test_keys_are_set_in_any_layout(
    headers: list[str], values: list[Any], count: int, dotted: bool
) -> None:
    blocks = [
        f"{header} # of {number}\nkey = {value} # {number}\n\n# before the next\n"
        for number, (header, value) in enumerate(zip(headers[:count], values, strict=False))
    ]
    text = ("robot.x = 1\nperception_x.color.q = 2\n" if dotted else "") + "".join(blocks)
    changed = with_keys(text, "perception.color.band", {"mean": MEAN})
    assert tomllib.loads(changed) == merged(
        tomllib.loads(text), "perception.color.band", {"mean": MEAN}
    )
    assert changed.count("#") == text.count("#")


@pytest.mark.parametrize("name", ["inline table", "dotted parent", "array over lines"])
def test_robots_file_keeps_its_other_settings_and_mode(tmp_path: Path, name: str) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text(CONFIGS[name])
    robot.chmod(0o640)
    before = load_config(robot)
    set_keys(robot, "camera", CAMERA)
    config = load_config(robot)
    assert (config.camera.mount, config.camera.focal_length) == ((0.1, 0.0, 0.2), 210.0)
    assert (config.camera.url, config.map) == (before.camera.url, before.map)
    assert robot.stat().st_mode & 0o777 == 0o640
    assert list(tmp_path.iterdir()) == [robot]


def test_missing_file_is_made(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    set_keys(robot, "camera", CAMERA)
    assert load_config(robot).camera.focal_length == 210.0


def test_symbolic_link_stays_a_link(tmp_path: Path) -> None:
    robot, link = tmp_path / "robot.toml", tmp_path / "link.toml"
    robot.write_text("[robot]\nname = 'anna'\n")
    link.symlink_to(robot)
    set_keys(link, "camera", CAMERA)
    assert link.is_symlink()
    assert load_config(robot).camera.focal_length == 210.0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"[camera\n", r"robot\.toml: is not TOML"),
        (b"\xff", r"robot\.toml: is not TOML"),
        (b"camera = 3\n", r"robot\.toml: camera: "),
    ],
)
def test_file_that_is_no_configuration_is_an_error_naming_it(
    tmp_path: Path, content: bytes, words: str
) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_bytes(content)
    with pytest.raises(ConfigError, match=words):
        set_keys(robot, "camera", CAMERA)
    assert robot.read_bytes() == content


def test_unwritable_file_is_an_error_and_unchanged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("[robot]\nname = 'anna'\n")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ConfigError, match=r"robot\.toml: cannot be changed \(No space left"):
        set_keys(robot, "camera", CAMERA)
    assert robot.read_text() == "[robot]\nname = 'anna'\n"
    assert list(tmp_path.iterdir()) == [robot]


def test_keys_that_cannot_be_written_are_listed_in_the_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("[robot]\nname = 'anna'\n")
    monkeypatch.setattr(config_section.tomlkit, "dumps", lambda _: "")
    with pytest.raises(ConfigError, match=r"\[camera\]: .* by hand: .*focal_length = 210\.0"):
        set_keys(robot, "camera", CAMERA)
