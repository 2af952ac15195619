"""``--set`` of bench, paper, demo and study."""

import argparse
import json
from pathlib import Path

import pytest

from robot_agent.config import AgentConfig, ConfigError
from robot_agent.patrol.settings import PAPER_STRATEGY
from tools import cli
from tools.commands.settings_option import add_set_option, chosen_config


def chosen(*words: str) -> AgentConfig:
    parser = argparse.ArgumentParser()
    add_set_option(parser)
    return chosen_config(parser.parse_args(words))


def test_paths_of_the_configuration_are_relative_to_its_file(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text('[patrol]\nrules_file = "own.toml"\n')
    assert chosen("--config", str(robot)).patrol.rules_file == str(tmp_path / "own.toml")


def test_without_the_option_the_configuration_is_the_default() -> None:
    assert chosen() == AgentConfig()


def test_values_are_read_as_toml_and_words_need_no_quotes() -> None:
    config = chosen("--set", "patrol.modifiers=[]", "--set", "patrol.supervisor=automaton")
    assert config.patrol.modifiers == ()
    assert config.patrol.supervisor == "automaton"


def test_a_commands_own_defaults_hold_unless_set_names_them() -> None:
    parser = argparse.ArgumentParser()
    add_set_option(parser)
    own = {"patrol.modifiers": list(PAPER_STRATEGY)}
    assert chosen_config(parser.parse_args([]), own).patrol.modifiers == PAPER_STRATEGY
    assert chosen_config(parser.parse_args(["--pure"]), own).patrol.modifiers == ()


def test_a_robots_file_is_what_set_changes(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[laser]\nmount = [0.1, 0.0, 0.5]\n[gate]\nmax_speed = 0.3\n")
    config = chosen("--config", str(path), "--set", "gate.max_speed=0.2")
    assert config.laser.mount == (0.1, 0.0, 0.5)
    assert config.gate.max_speed == 0.2
    path.write_text("[laser]\nmuont = 1\n")
    with pytest.raises(ConfigError, match=r"robot\.toml.*muont"):
        chosen("--config", str(path))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ("patrol.magic=1", "patrol.magic: unknown key"),
        ("patrol.strategy=even_gaps", "is called patrol.modifiers now"),
        ("patrol.reversal_rest=2.0", "no setting any more"),
        ("patrol", "is not SECTION.KEY=VALUE"),
    ],
)
def test_wrong_changes_are_refused_with_the_remedy(change: str, complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        chosen("--set", change)


def test_bench_runs_with_what_is_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    slow, usual = tmp_path / "slow.json", tmp_path / "usual.json"
    words = ["bench", "--robots", "1", "--duration", "40", "--sensing", "ideal"]
    assert cli.main([*words, "--json", str(usual)]) == 0
    assert cli.main([*words, "--set", "patrol.approach_speed=0.36", "--json", str(slow)]) == 0
    capsys.readouterr()
    reached = [json.loads(path.read_text())["reach_s"][0] for path in (usual, slow)]
    assert reached[0] < reached[1]
