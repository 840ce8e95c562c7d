"""What fingers are compared by: each metric's unit, which end of it is better, and its meaning.

What computes them is search/run/evaluate.py. A change of a meaning raises ``METRICS_VERSION``,
which is part of every outcome's digest. The standard library only.
"""

import difflib
from dataclasses import dataclass
from typing import Literal

from fingerdesign.design.base import refuse

METRICS_VERSION = 7
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
        """As "good from 0.95, poor to 0.75"; "" where there is none."""
        if self.good is None or self.poor is None:
            return ""
        ends = ("from", "to") if self.better == "max" else ("to", "from")
        return f"good {ends[0]} {self.good:g}, poor {ends[1]} {self.poor:g}"


_ALL = (
    Metric(
        "grip_success",
        "",
        "max",
        "share of the grips lifted without complete slip",
        good=0.95,
        poor=0.75,
    ),
    Metric(
        "safety_margin",
        "",
        None,
        "median of F_n / (F_t / mu) at lift, over grips that lifted",
        share=0.02,
        noisy=0.18,
    ),
    Metric(
        "least_margin",
        "",
        "max",
        "least margin of the grips that lifted; 1 is on the edge of slip",
        good=1.2,
        poor=1.05,
        share=0.035,
        noisy=0.4,
    ),
    Metric(
        "peak_force_N", "N", "min", "greatest normal force of all grips", share=0.06, noisy=0.11
    ),
    Metric(
        "peak_ratio",
        "",
        "min",
        "median of peak F_n over the least that holds, mg / 2 mu; grips that lifted",
        good=1.5,
        poor=3.0,
        share=0.03,
        noisy=0.19,
    ),
    Metric(
        "stick_error",
        "",
        "min",
        "RMS error of the stick ratio as estimated from noisy gages",
        good=0.1,
        poor=0.2,
        step=0.007,
    ),
    Metric(
        "gage_response",
        "microstrain/N",
        "max",
        "greatest reading per tangential force",
        share=0.005,
    ),
    Metric(
        "smallest_stick_change",
        "",
        "min",
        "smallest change of the stick ratio that gages show above the noise of one sample",
        good=0.1,
        poor=0.3,
        share=0.02,
    ),
    Metric("normal_force_N", "N", None, "F_n at the end of the scene's path", share=0.002),
    Metric("tangential_force_N", "N", None, "F_t at the end of the scene's path", share=0.002),
    Metric(
        "stiffness_N_per_mm", "N/mm", None, "F_n over approach at the deepest approach", share=0.001
    ),
    Metric(
        "first_slip_N",
        "N",
        None,
        "F_t where the stick ratio falls below 0.9 of its most in the pull",
        share=0.003,
    ),
    Metric("peak_pressure_MPa", "MPa", "min", "greatest contact pressure of the path", share=0.007),
    Metric("plates", "", "min", "plates used"),
    Metric("cost", "", "min", "what [cost] adds up: plates, gages, rubber"),
    Metric("rubber_volume_ml", "ml", "min", "volume of the elastomer"),
    Metric("plane_strain_error", "", None, "forecast of what plane strain overstates F_n by"),
    Metric("core_seconds", "s", None, "processor time of the variant"),
)
METRICS: dict[str, Metric] = {metric.name: metric for metric in _ALL}


def known_metric(name: str) -> str:
    """The name itself; a fault that names the nearest where there is no such metric."""
    if name in METRICS:
        return name
    near = difflib.get_close_matches(name, METRICS, 1, 0.5)
    remedy = f"did you mean '{near[0]}'?" if near else "choose one of them"
    raise refuse(name, f"one of {', '.join(METRICS)}", remedy)
