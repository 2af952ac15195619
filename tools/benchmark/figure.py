"""One measured figure with its unit and its limit."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tools.benchmark.calibration_kernel import REFERENCE_S, kernel_s

SEED = 1
"""Random seed of every measured run."""
SETTLED_S = 12.0
"""Time after which an agent has connected, localized and started to patrol."""
MEASURED_S = 20.0

_SECONDS = {"s": 1.0, "s of CPU": 1.0, "ms": 1e-3, "us": 1e-6, "%": 1e-2}
"""Units of costs, in s of processor time; a share of a core is that in one second. Else a rate."""


@dataclass(frozen=True)
class Figure:
    """One line of the table."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    """Largest value allowed (smallest if ``at_least``); None: no limit, for information."""
    at_least: bool = False
    """Whether the limit is a lower bound."""
    speed: bool = False
    """Whether the value is processor time, or work in it, and so depends on the processor: then it
    is judged by its multiple of the calibration kernel, the limit by that where it was set."""
    kernel_s: float | None = None
    """Of a speed: processor time of the calibration kernel in the same minute, s."""

    def beside_kernel(self) -> Figure:
        """Return the figure with the kernel's time now, if it is a speed."""
        return replace(self, kernel_s=kernel_s()) if self.speed else self

    @property
    def multiple(self) -> float | None:
        """How many kernels a cost equals, or how much of a rate is done in one; None: no speed."""
        return None if self.kernel_s is None else self._in_kernels(self.value, self.kernel_s)

    @property
    def kept(self) -> bool:
        """Whether the value is within its limit; True without a limit."""
        if self.limit is None:
            return True
        value, limit = self.value, self.limit
        if self.multiple is not None:
            value, limit = self.multiple, self._in_kernels(limit, REFERENCE_S)
        return value >= limit if self.at_least else value <= limit

    def cells(self) -> tuple[str, str, str, str, str]:
        """Return name, value, multiple, limit and verdict as text, empty where there is none."""
        bound = "at least" if self.at_least else "at most"
        limit = "" if self.limit is None else f"{bound} {self.limit:g}"
        verdict = "" if self.limit is None else ("ok" if self.kept else "MISSED")
        multiple = ""
        if self.multiple is not None:
            multiple = f"{self.multiple:.3g}"
            if self.limit is not None:
                limit = f"{bound} {self._in_kernels(self.limit, REFERENCE_S):.3g} kernels"
        return self.name, f"{self.value:.4g} {self.unit}", multiple, limit, verdict

    def _in_kernels(self, value: float, kernel: float) -> float:
        if self.unit in _SECONDS:
            return value * _SECONDS[self.unit] / kernel
        return value * kernel  # work in a second
