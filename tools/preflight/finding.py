"""One line of a preflight check."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """What a check came to."""

    OK = "ok"
    WARNING = "warning"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class Finding:
    """What was checked, what was found, and what to do about it unless it is well."""

    subject: str
    verdict: Verdict
    text: str
    remedy: str = ""


def ok(subject: str, text: str) -> Finding:
    """Return a finding that needs no action."""
    return Finding(subject, Verdict.OK, text)


def warning(subject: str, text: str, remedy: str) -> Finding:
    """Return a finding with which the robot can still patrol."""
    return Finding(subject, Verdict.WARNING, text, remedy)


def failed(subject: str, text: str, remedy: str) -> Finding:
    """Return a finding that must be put right first."""
    return Finding(subject, Verdict.FAILED, text, remedy)


def skipped(subject: str, text: str) -> Finding:
    """Return a check that was not made, with the reason."""
    return Finding(subject, Verdict.SKIPPED, text)
