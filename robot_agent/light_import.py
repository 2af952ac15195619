"""Imports of packages without the SciPy that they import and an agent does not use.

filterpy takes matrix functions and distributions from SciPy for its other filters and for plots,
scikit-fuzzy distances for its clustering. Here these imports are deferred to their first use. With
SciPy filterpy's filter and scikit-fuzzy's sets take 72 MB and 0.56 s, without it 9 MB and 0.02 s
(filterpy 2.0.0, scikit-fuzzy 0.5.0, SciPy 1.17.1, x86-64).
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

_DEFERRED = (
    *("scipy", "scipy.linalg", "scipy.ndimage", "scipy.sparse", "scipy.sparse.linalg"),
    *("scipy.spatial", "scipy.spatial.distance", "scipy.stats"),
)


def import_lightly(module: str) -> Any:
    """Import a module of filterpy or scikit-fuzzy; later imports of SciPy get the real one."""
    replaced = [name for name in _DEFERRED if name not in sys.modules]
    sys.modules.update({name: _StandIn(name) for name in replaced})
    try:
        return import_module(module)
    finally:
        for name in replaced:
            del sys.modules[name]


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
    """Placeholder of a module during the import."""

    def __getattr__(self, name: str) -> _DeferredName:
        if name.startswith("__"):
            raise AttributeError(name)
        return _DeferredName(self.__name__, name)
