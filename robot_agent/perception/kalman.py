"""filterpy's Kalman filter, without the tens of MB of SciPy that come with all of filterpy.

filterpy takes distributions and image filters from SciPy for plots, log-likelihoods and grids,
which no robot asks for. They are put off until somebody does.

What that saves a robot, which may use 150 MB in all: with what an agent has of SciPy anyway loaded,
``from filterpy.kalman import KalmanFilter`` takes another 22.6 MB and 0.24 s, this module 0.8 MB
and 0.005 s (filterpy 2.0.0, SciPy 1.17.1, x86-64; nearly all of it is scipy.stats). Once that is
below 10 MB, the plain import is to take this module's place.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

_PUT_OFF = ("scipy.stats", "scipy.ndimage")


class _PutOff:
    """A name of a module that is put off, looked up there at its first use."""

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name

    def __getattr__(self, attribute: str) -> Any:
        if isinstance(sys.modules.get(self._module), _StandIn):
            return lambda *_arguments, **_keywords: None  # filterpy tries what SciPy can
        return getattr(getattr(import_module(self._module), self._name), attribute)

    def __call__(self, *arguments: Any, **keywords: Any) -> Any:
        return getattr(import_module(self._module), self._name)(*arguments, **keywords)


class _StandIn(ModuleType):
    """Stands for a module while filterpy is imported."""

    def __getattr__(self, name: str) -> _PutOff:
        if name.startswith("__"):
            raise AttributeError(name)
        return _PutOff(self.__name__, name)


def _import_lightly() -> Any:
    """Import filterpy's filter; whoever imports what was put off later gets the real modules."""
    stood_for = [name for name in _PUT_OFF if name not in sys.modules]
    sys.modules.update({name: _StandIn(name) for name in stood_for})
    try:
        return import_module("filterpy.kalman").KalmanFilter
    finally:
        for name in stood_for:
            del sys.modules[name]


KalmanFilter = _import_lightly()
