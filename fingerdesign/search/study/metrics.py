"""Metrics of fingers, described in metrics.toml.

search/run/measured.py computes them. A change of a meaning raises ``METRICS_VERSION``,
which is part of every outcome's digest. The standard library only.
"""

import difflib
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from fingerdesign.design.base import refuse

METRICS_VERSION = 16
# Computed on request: each group costs as much as a section's analysis, or twice that.
PLACEMENT = "placement_effect"
SPREAD = ("reading_std", "reading_std_calibrated", "yield_by_motion", "gage_response_90")
ON_REQUEST = (PLACEMENT, *SPREAD)
# Of the fundamental case with its grips and frictions; a scene has neither, and one verdict alone.
OF_GRIPS = (
    *("grip_success", "safety_margin", "least_margin", "peak_force_N", "peak_ratio"),
    *("area_correlation", "best_area_share", "failed_verdicts", "shortfall"),
)
Goal = Literal["min", "max"]


@dataclass(frozen=True)
class Metric:
    """A metric: ``unit`` "" where it has none; ``better`` None where neither end is.

    good, poor: from these on it is one or the other; None: no number says so for every finger.
    share, step: standard deviation by chance (another mesh, another seed), of the value and in the
    metric's unit; noisy: ``share`` of three grips whose gages are noisy. How each of the
    numbers was measured: docs/how_to/compare.md.
    """

    name: str
    unit: str = ""
    better: Goal | None = None
    words: str = ""
    good: float | None = None
    poor: float | None = None
    share: float = 0.0
    step: float = 0.0
    noisy: float = 0.0

    def grade(self, value: float) -> str:
        """ "good", "fair" or "poor" on the metric's scale; "" where it has none.

        >>> METRICS["peak_ratio"].grade(1.4), METRICS["least_margin"].grade(1.1)
        ('good', 'fair')
        """
        if self.good is None or self.poor is None:
            return ""
        sign = 1.0 if self.better == "max" else -1.0
        if sign * value >= sign * self.good:
            return "good"
        return "poor" if sign * value <= sign * self.poor else "fair"

    @property
    def scale(self) -> str:
        """The scale as text: "good from 0.95, poor to 0.75"; "" where there is none."""
        if self.good is None or self.poor is None:
            return ""
        ends = ("from", "to") if self.better == "max" else ("to", "from")
        return f"good {ends[0]} {self.good:g}, poor {ends[1]} {self.poor:g}"


_FILE = Path(__file__).with_suffix(".toml")
METRICS: dict[str, Metric] = {
    name: Metric(**{"name": name, **facts})
    for name, facts in tomllib.loads(_FILE.read_text(encoding="utf-8")).items()
}


def known_metric(name: str) -> str:
    """The name itself; a fault that names the nearest where there is no such metric."""
    if name in METRICS:
        return name
    near = difflib.get_close_matches(name, METRICS, 1, 0.5)
    remedy = f"did you mean '{near[0]}'?" if near else "choose one of them"
    raise refuse(name, f"one of {', '.join(METRICS)}", remedy)
