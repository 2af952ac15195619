"""Findings: results of checks, with remedies."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Result of a check."""

    OK = "ok"
    WARNING = "warning"
    FAILED = "failed"
    NOT_YET = "not yet"
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


def not_yet(subject: str, text: str, remedy: str) -> Finding:
    """Return a finding of what a new robot still lacks; the remedy says what comes first.

    It prevents a patrol as one that failed does.
    """
    return Finding(subject, Verdict.NOT_YET, text, remedy)


def prevents_patrol(finding: Finding) -> bool:
    """Return whether a robot with this finding may not patrol."""
    return finding.verdict in (Verdict.FAILED, Verdict.NOT_YET)


def skipped(subject: str, text: str) -> Finding:
    """Return a check that was not made, with the reason as text."""
    return Finding(subject, Verdict.SKIPPED, text)
