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
    """A metric: ``unit`` "" where it has none; ``better`` None where neither end is."""

    name: str
    unit: str = ""
    better: Goal | None = None
    words: str = ""


_ALL = (
    Metric("grip_success", "", "max", "share of the grips lifted without complete slip"),
    Metric("safety_margin", "", None, "median of F_n / (F_t / mu) at lift, over grips that lifted"),
    Metric(
        "least_margin", "", "max", "least margin of the grips that lifted; 1 is on the edge of slip"
    ),
    Metric("peak_force_N", "N", "min", "greatest normal force of all grips"),
    Metric(
        "peak_ratio",
        "",
        "min",
        "median of peak F_n over the least that holds, mg / 2 mu; grips that lifted",
    ),
    Metric("stick_error", "", "min", "RMS error of the stick ratio as estimated from noisy gages"),
    Metric("gage_response", "microstrain/N", "max", "greatest reading per tangential force"),
    Metric(
        "smallest_stick_change",
        "",
        "min",
        "smallest change of the stick ratio that gages show above the noise of one sample",
    ),
    Metric("normal_force_N", "N", None, "F_n at the end of the scene's path"),
    Metric("tangential_force_N", "N", None, "F_t at the end of the scene's path"),
    Metric("stiffness_N_per_mm", "N/mm", None, "F_n over approach at the deepest approach"),
    Metric(
        "first_slip_N",
        "N",
        None,
        "F_t where the stick ratio falls below 0.9 of its most in the pull",
    ),
    Metric("peak_pressure_MPa", "MPa", "min", "greatest contact pressure of the path"),
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
