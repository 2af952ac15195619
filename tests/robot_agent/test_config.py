"""The configuration: strict at every depth, defaults in code, survives a round trip."""

from pathlib import Path

import pytest

from drivers.p2os.model import load_model
from maps.map_folder import load_map_folder
from robot_agent.config import (
    AgentConfig,
    ConfigError,
    find_map,
    format_config,
    load_config,
    parse_config,
)
from robot_agent.pose.start_pose import StartPose


def test_empty_file_gives_the_defaults() -> None:
    assert parse_config(b"", "robot.toml") == AgentConfig()


def test_effective_configuration_survives_a_round_trip() -> None:
    config = AgentConfig(start=StartPose(x=1.0, y=2.0, theta=-0.5))
    assert parse_config(format_config(config).encode(), "printed") == config


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[laser]\nbauds = 9600", "robot.toml: laser.bauds: unknown key"),
        (
            "[localization.health]\nlost_bellow = 0.1",
            "robot.toml: localization.health.lost_bellow: unknown key",
        ),
        (
            "[localization.health]\nlost_below = 0.3",
            "robot.toml: localization.health.lost_below: is no setting any more but always 0.45",
        ),
        (
            "[perception]\nmost_extent = 0.3",
            "robot.toml: perception.most_extent: is no setting any more but always 0.75",
        ),
        (
            "[localization.samples]\nfixed = 900",
            "robot.toml: localization.samples.fixed: is called localization.particles now",
        ),
        ("[lasers]\nbaud = 9600", "robot.toml: lasers: unknown key"),
        ("[base]\nmax_speed = 20.0", "robot.toml: base.max_speed: expected `float` <= 2.2"),
        ('[base]\nmax_speed = "fast"', "robot.toml: base.max_speed: expected `float`, got `str`"),
        ("[robot]\nseed = -1", "robot.toml: robot.seed: expected `int` >= 0"),
        ('[robot]\nname = "a/b"', "robot.toml: robot.name: expected `str` matching"),
        (
            "[patrol]\npatrolling_distance = 3.0",
            "robot.toml: patrol: patrolling_distance 3.0 m must be below",
        ),
        ("[start]\nx = 1.0", "robot.toml: start: object missing required field `y`"),
        ("[robot\n", "robot.toml: is not TOML"),
        ("\xff", "robot.toml: is not TOML"),
        ("[start]\nx = nan\ny = 1.0\ntheta = 0.0", "robot.toml: start.x: is nan"),
        ("[laser]\nmount = [0.1, inf, 0.0]", "robot.toml: laser.mount: is inf"),
    ],
)
def test_errors_name_file_and_key(text: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_config(text.encode("latin-1"), "robot.toml")
    message = str(caught.value)
    assert message.startswith(complaint)
    assert "\n" not in message
    assert ";" in message, "a remedy follows"


def test_missing_file_raises_with_its_path(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.toml: cannot be read"):
        load_config(tmp_path / "nowhere.toml")


def test_map_is_a_shipped_name_or_a_path_from_the_configuration(tmp_path: Path) -> None:
    assert find_map("paper_lab", tmp_path).name == "paper_lab"
    assert (find_map("paper_lab", tmp_path) / "map.yaml").is_file()
    assert find_map("my_map", tmp_path) == tmp_path / "my_map"
    assert find_map("../maps/x", tmp_path) == tmp_path / "../maps/x"


def test_a_map_beside_the_configuration_wins_over_a_shipped_one_of_its_name(tmp_path: Path) -> None:
    (tmp_path / "paper_lab").mkdir()
    assert find_map("paper_lab", tmp_path) != tmp_path / "paper_lab", "a folder without a map"
    (tmp_path / "paper_lab" / "map.yaml").write_text("")
    assert find_map("paper_lab", tmp_path) == tmp_path / "paper_lab"


def test_home_of_the_user_is_understood(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    assert find_map("~/lab", Path("/etc/patrol")) == tmp_path / "lab"


def test_mark_of_windows_editors_at_the_beginning_is_skipped() -> None:
    assert parse_config(b'\xef\xbb\xbf[robot]\nname = "r7"', "robot.toml").robot.name == "r7"


def test_configured_map_is_loaded_with_its_border(tmp_path: Path) -> None:
    config = parse_config(b'[map]\nfolder = "paper_lab"\nborder = "open"', "robot.toml")
    folder = load_map_folder(find_map(config.map.folder, tmp_path), config.map.border)
    assert folder.border is not None
    assert not folder.border.closed


def test_model_file_beside_the_robots_file_is_loaded_and_kept_in_the_configuration(
    tmp_path: Path,
) -> None:
    (tmp_path / "mine.toml").write_text('like = "p3at"\nsubclass = "p9zz"\n')
    robot = tmp_path / "robot.toml"
    robot.write_text('[base]\nmodel = "./mine.toml"\n')
    config = load_config(robot)
    assert config.base.model_file is not None
    assert config.base.model_file.subclass == "p9zz"
    assert config.base.model_file.body == load_model("p3at").body
    assert parse_config(format_config(config).encode(), "x") == config


@pytest.mark.parametrize("content", [None, "width = 1", 'like = "p9"', "like"])
def test_unusable_model_file_is_named(tmp_path: Path, content: str | None) -> None:
    if content is not None:
        (tmp_path / "mine.toml").write_text(content)
    robot = tmp_path / "robot.toml"
    robot.write_text('[base]\nmodel = "mine.toml"\n')
    with pytest.raises(ConfigError, match=r"base\.model: .*mine\.toml"):
        load_config(robot)


def test_name_of_no_model_is_refused_where_the_file_is_loaded(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text('[base]\nmodel = "p9"\n')
    with pytest.raises(ConfigError, match=r"base\.model: robot model 'p9': no such model"):
        load_config(robot)


def test_unknown_model_does_not_raise_in_parsing() -> None:
    assert parse_config(b'[base]\nmodel = "p9"\n', "x").base.model == "p9"


@pytest.mark.parametrize(
    ("section", "key"),
    [
        ("recorder", "folder"),
        ("memory", "file"),
        ("patrol", "rules_file"),
        ("telemetry", "keys"),
    ],
)
def test_path_is_relative_to_the_robots_file_and_not_to_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, section: str, key: str
) -> None:
    (tmp_path / "robots").mkdir()
    robot = tmp_path / "robots" / "robot.toml"
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", "/home/robot")
    for written, expected in {
        "own/place": str(tmp_path / "robots" / "own" / "place"),
        "/srv/place": "/srv/place",
        "~/place": "/home/robot/place",
        "": "",
    }.items():
        robot.write_text(f'[{section}]\n{key} = "{written}"\n')
        for path in (robot, Path("robots/robot.toml")):
            assert getattr(getattr(load_config(path), section), key) == expected


def test_map_folder_is_relative_to_the_robots_file(tmp_path: Path) -> None:
    assert find_map("lab", tmp_path) == tmp_path / "lab"
    assert find_map("../lab", tmp_path) == tmp_path / ".." / "lab"
