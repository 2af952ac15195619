"""filterpy's Kalman filter, imported without the tens of MB of SciPy that filterpy imports.

filterpy imports distributions and image filters from SciPy for plots, log-likelihoods and grids,
which an agent does not use. Their import is deferred to their first use.

Savings, with a limit of 150 MB per agent: with the SciPy that an agent needs anyway loaded,
``from filterpy.kalman import KalmanFilter`` takes another 22.6 MB and 0.24 s, this module 0.8 MB
and 0.005 s (filterpy 2.0.0, SciPy 1.17.1, x86-64; nearly all of it is scipy.stats). Once that is
below 10 MB, the plain import is to replace this module.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

_DEFERRED = ("scipy.stats", "scipy.ndimage")


class _DeferredName:
    """A name of a module whose import is deferred; resolved at its first use."""

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name

    def __getattr__(self, attribute: str) -> Any:
        if isinstance(sys.modules.get(self._module), _StandIn):
            return lambda *_arguments, **_keywords: None  # filterpy probes SciPy while imported
        return getattr(getattr(import_module(self._module), self._name), attribute)

    def __call__(self, *arguments: Any, **keywords: Any) -> Any:
        return getattr(import_module(self._module), self._name)(*arguments, **keywords)


class _StandIn(ModuleType):
    """Placeholder of a module while filterpy is imported."""

    def __getattr__(self, name: str) -> _DeferredName:
        if name.startswith("__"):
            raise AttributeError(name)
        return _DeferredName(self.__name__, name)


def _import_lightly() -> Any:
    """Import filterpy's filter; later imports of the deferred modules get the real ones."""
    replaced = [name for name in _DEFERRED if name not in sys.modules]
    sys.modules.update({name: _StandIn(name) for name in replaced})
    try:
        return import_module("filterpy.kalman").KalmanFilter
    finally:
        for name in replaced:
            del sys.modules[name]


KalmanFilter = _import_lightly()
