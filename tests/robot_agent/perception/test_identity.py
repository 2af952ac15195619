"""Accumulation of evidence to the kind of a track, with hysteresis."""

from __future__ import annotations

import pytest

from robot_agent.perception.identity import Identity, Kind


def test_kind_is_unknown_at_first() -> None:
    identity = Identity()
    assert identity.kind is Kind.UNKNOWN
    assert identity.probabilities.unknown == 1.0


def test_two_pictures_with_a_band_make_a_teammate() -> None:
    identity = Identity()
    identity.on_band(0.9)
    assert identity.kind is Kind.UNKNOWN
    identity.on_band(0.9)
    assert identity.kind is Kind.TEAMMATE
    assert identity.probabilities.teammate > 0.6


def test_two_pictures_without_one_make_a_stranger() -> None:
    identity = Identity()
    identity.on_missing_band()
    identity.on_missing_band()
    assert identity.kind is Kind.STRANGER
    assert identity.probabilities.stranger > 0.5


def test_teammate_with_a_band_hidden_for_a_second_remains_one() -> None:
    identity = Identity()
    for _ in range(10):
        identity.on_band(0.9)
    for _ in range(5):
        identity.on_missing_band()
        assert identity.kind is Kind.TEAMMATE
    for _ in range(5):
        identity.on_missing_band()
    assert identity.kind is Kind.STRANGER, "but not for ever"


def test_robot_shape_and_speed_make_a_teammate_until_pictures_contradict() -> None:
    identity = Identity()
    for _ in range(3):
        identity.on_robot_shape()
        assert identity.kind is Kind.UNKNOWN
    for _ in range(50):
        identity.on_robot_shape()
    assert identity.kind is Kind.TEAMMATE
    assert not identity.by_color
    for _ in range(3):
        identity.on_missing_band()
    assert identity.kind is Kind.UNKNOWN, "laser evidence never outweighs three pictures"
    for _ in range(2):
        identity.on_missing_band()
    assert identity.kind is Kind.STRANGER


def test_other_shape_makes_a_stranger_until_pictures_show_a_band() -> None:
    identity = Identity()
    for _ in range(5):
        identity.on_other_shape()
    assert identity.kind is Kind.STRANGER
    for _ in range(50):
        identity.on_other_shape()
    for _ in range(4):
        identity.on_band(0.9)
    assert identity.kind is Kind.TEAMMATE


def test_shape_does_not_change_a_kind_decided_by_pictures() -> None:
    banded, bare = Identity(), Identity()
    for _ in range(4):
        banded.on_band(0.9)
        bare.on_missing_band()
    for _ in range(50):
        banded.on_other_shape()  # a teammate that carries something
        bare.on_robot_shape()  # a robot of another team
    assert banded.kind is Kind.TEAMMATE
    assert bare.kind is Kind.STRANGER


def test_probabilities_add_up_to_one() -> None:
    identity = Identity()
    for note in (identity.on_too_fast, identity.on_wrong_size, identity.on_reflector):
        note()
        told = identity.probabilities
        assert told.teammate + told.stranger + told.unknown == pytest.approx(1.0)
