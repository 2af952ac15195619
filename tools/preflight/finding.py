"""Findings: results of checks, with remedies."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Result of a check."""

    OK = "ok"
    WARNING = "warning"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class Finding:
    """Subject of a check, its verdict, what was found, and the remedy; empty: none needed."""

    subject: str
    verdict: Verdict
    text: str
    remedy: str = ""


def ok(subject: str, text: str) -> Finding:
    """Return a finding that needs no action."""
    return Finding(subject, Verdict.OK, text)


def warning(subject: str, text: str, remedy: str) -> Finding:
    """Return a finding that does not prevent a patrol."""
    return Finding(subject, Verdict.WARNING, text, remedy)


def failed(subject: str, text: str, remedy: str) -> Finding:
    """Return a finding that prevents a patrol."""
    return Finding(subject, Verdict.FAILED, text, remedy)


def skipped(subject: str, text: str) -> Finding:
    """Return a check that was not made, with the reason as text."""
    return Finding(subject, Verdict.SKIPPED, text)
