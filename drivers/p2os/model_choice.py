"""Which model a robot is driven by: the one it reports, or the file that describes it."""

from __future__ import annotations

from typing import NamedTuple

from drivers.p2os.model import DEFAULT_MODEL, RobotModel, UnknownModelError, load_model
from drivers.p2os.settings import BaseSettings


class ModelChoice(NamedTuple):
    """The model of a session. trouble: why it is not known to be the robot's; None if it is."""

    model: RobotModel
    trouble: str | None


def configured_model(settings: BaseSettings) -> RobotModel | None:
    """Return the model that the settings name; None if they leave it to the robot.

    Raises UnknownModelError for a name without a model.
    """
    if settings.model_file is not None:
        return settings.model_file
    return None if settings.model is None else load_model(settings.model)


def expected_model(settings: BaseSettings) -> RobotModel:
    """Return the model to assume before the robot has said what it is; raises as above."""
    return configured_model(settings) or load_model(DEFAULT_MODEL)


def choose_model(settings: BaseSettings, subclass: str) -> ModelChoice:
    """Return the model for a robot that reports ``subclass``.

    A configured model must be that of the reported subclass. In trouble the robot must not move:
    its distances are then those of the reported model, or of the expected one.
    """
    configured = configured_model(settings)
    if configured is not None and configured.subclass.lower() == subclass.lower():
        return ModelChoice(configured, None)
    try:
        reported = load_model(subclass)
    except UnknownModelError:
        remedy = (
            f'write a model file with subclass = "{subclass}" beside the robot\'s file and set '
            'base.model = "./mine.toml"'
        )
        trouble = f"robot is a {subclass!r}, of which no model is known: {remedy}"
        return ModelChoice(configured or load_model(DEFAULT_MODEL), trouble)
    if configured is None:
        return ModelChoice(reported, None)
    trouble = (
        f"base.model {settings.model} is a {configured.subclass!r}, but the robot says that it is "
        f"a {subclass!r}: delete base.model, or set it to {reported.subclass}"
    )
    return ModelChoice(reported, trouble)
