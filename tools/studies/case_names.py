"""Names of a study's cases: what all have in common is said once, the rest in short."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import PurePath

from tools.studies.study import Case, Setting, setting_label


class CaseNames:
    """Short names of keys and values.

    Keys that differ between the cases are told at each; the last of them makes the columns of the
    table and the colours of the figure.
    """

    def __init__(self, cases: Iterable[Case]) -> None:
        """cases: of one study, with the same keys in the same order; at least one."""
        cases = list(cases)
        first = dict(cases[0].values)
        values = {key: {dict(case.values)[key] for case in cases} for key in first}
        self.varied = [key for key, found in values.items() if len(found) > 1]
        self._constant = [(key, first[key]) for key in first if key not in self.varied]
        self._shorts = [key.rpartition(".")[2] for key in first]

    @property
    def title(self) -> str:
        """What all cases have in common; empty if that is nothing."""
        return ", ".join(self._told(key, value) for key, value in self._constant)

    @property
    def column_key(self) -> str:
        """The short name of the last varied key; empty if nothing is varied."""
        return self.short(self.varied[-1]) if self.varied else ""

    def row(self, case: Case) -> str:
        """Return the varied settings of a case but the last; empty if there are none."""
        values = dict(case.values)
        return ", ".join(self._told(key, values[key]) for key in self.varied[:-1])

    def column(self, case: Case) -> str:
        """Return the value of the last varied key of a case."""
        if not self.varied:
            return "all"
        key = self.varied[-1]
        return self._value(key, dict(case.values)[key])

    def short(self, key: str) -> str:
        """Return a key's last part, without underscores; all of it where that is not unique."""
        last = key.rpartition(".")[2]
        return (key if self._shorts.count(last) > 1 else last).replace("_", " ")

    def _told(self, key: str, value: Setting) -> str:
        return f"{self.short(key)} {self._value(key, value)}"

    def _value(self, key: str, value: Setting) -> str:
        label = setting_label(key, value)
        return PurePath(label).stem if "/" in label and key in ("map", "truth") else label
