from __future__ import annotations

import msgspec
import pytest

from drivers.p2os.model import UnknownModelError, load_model
from drivers.p2os.model_choice import choose_model, expected_model
from drivers.p2os.settings import BaseSettings

MINE = msgspec.structs.replace(load_model("p3at"), subclass="P9ZZ")
OWN_FILE = BaseSettings(model="./mine.toml", model_file=MINE)


def test_reported_model_is_used_where_none_is_configured() -> None:
    assert choose_model(BaseSettings(), "P3DX") == (load_model("p3dx"), None)


def test_configured_model_that_the_robot_reports_is_used() -> None:
    assert choose_model(BaseSettings(model="p3dx"), "P3DX") == (load_model("p3dx"), None)


def test_contradiction_names_both_models_and_the_remedy() -> None:
    model, trouble = choose_model(BaseSettings(model="p2dx"), "p3at")
    assert model is load_model("p3at")
    assert trouble == (
        "base.model p2dx is a 'p2dx', but the robot says that it is a 'p3at': "
        "delete base.model, or set it to p3at"
    )


@pytest.mark.parametrize("settings", [BaseSettings(), BaseSettings(model="p3at")])
def test_unknown_subclass_says_how_to_add_a_model(settings: BaseSettings) -> None:
    trouble = choose_model(settings, "p9zz").trouble
    assert trouble == (
        "robot is a 'p9zz', of which no model is known: write a model file with subclass = "
        '"p9zz" beside the robot\'s file and set base.model = "./mine.toml"'
    )


def test_model_file_describes_a_robot_that_is_not_shipped() -> None:
    assert choose_model(OWN_FILE, "p9zz") == (MINE, None)


def test_model_file_of_a_shipped_subclass_takes_its_place() -> None:
    changed = msgspec.structs.replace(load_model("p2dx"), top_speed=1.0)
    settings = BaseSettings(model="./mine.toml", model_file=changed)
    assert choose_model(settings, "p2dx") == (changed, None)


def test_model_file_of_another_subclass_is_a_contradiction() -> None:
    trouble = choose_model(OWN_FILE, "p2dx").trouble
    assert trouble is not None
    assert "./mine.toml is a 'P9ZZ'" in trouble


def test_model_is_assumed_before_the_robot_has_said_what_it_is() -> None:
    assert expected_model(BaseSettings()) is load_model("p2dx")
    assert expected_model(BaseSettings(model="p3at")) is load_model("p3at")
    assert expected_model(OWN_FILE) is MINE
    with pytest.raises(UnknownModelError):
        expected_model(BaseSettings(model="p9"))
