"""Faults, trials and lies by the names that a user gives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar


class Named(Protocol):
    """What has a name."""

    @property
    def name(self) -> str:
        """The name."""


T = TypeVar("T", bound=Named)


def chosen(
    things: Sequence[T], names: Sequence[str], refusal: Callable[[str, str], Exception]
) -> list[T]:
    """Return the things of these names, all if there are none.

    refusal: makes the error to raise of a name that nothing has and of all names there are.
    """
    known = {thing.name: thing for thing in things}
    for name in names:
        if name not in known:
            raise refusal(name, ", ".join(known))
    return [known[name] for name in names] or list(things)
