"""Metrics of fingers: each one's unit, which end of it is better, and its meaning.

search/run/measured.py computes them. A change of a meaning raises ``METRICS_VERSION``,
which is part of every outcome's digest. The standard library only.
"""

import difflib
from dataclasses import dataclass
from typing import Literal

from fingerdesign.design.base import refuse

METRICS_VERSION = 15
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


_ROWS: tuple[tuple[str, str, Goal | None, str], ...] = (  # name, unit, better, meaning
    (
        "grip_success",
        "",
        "max",
        "share of the grips lifted without complete slip, at the worst mass",
    ),
    ("safety_margin", "", None, "median of F_n / (F_t / mu) at lift, over grips that lifted"),
    ("least_margin", "", "max", "least margin of the grips that lifted; 1 is on the edge of slip"),
    ("peak_force_N", "N", "min", "greatest normal force of all grips"),
    (
        "peak_ratio",
        "",
        "min",
        "median of peak F_n over the least that holds to the end; grips that lifted",
    ),
    ("stick_error", "", "min", "RMS error of the stick ratio as estimated from noisy gages"),
    ("gage_response", "microstrain/N", "max", "greatest reading per tangential force"),
    (
        "smallest_stick_change",
        "",
        "min",
        "smallest change of the stick ratio that gages show above the noise of one sample",
    ),
    (
        "area_correlation",
        "",
        "max",
        "least rank correlation of gage area and stick area, over five frictions",
    ),
    (
        "best_area_share",
        "",
        None,
        "value of gages.area_share with the greatest least rank correlation",
    ),
    ("failed_verdicts", "", "min", "verdicts of analyse that fail"),
    ("shortfall", "", "min", "distance from passing all verdicts; 0: all pass with room to spare"),
    ("normal_force_N", "N", None, "F_n at the end of the scene's path"),
    ("tangential_force_N", "N", None, "F_t at the end of the scene's path"),
    ("stiffness_N_per_mm", "N/mm", None, "F_n over approach at the deepest approach"),
    (
        "first_slip_N",
        "N",
        None,
        "F_t where the stick ratio falls below 0.9 of its most in the pull",
    ),
    (
        PLACEMENT,
        "",
        "min",
        "greatest change of a reading by plates off their places in the mold, a share of the "
        "largest; on request",
    ),
    (
        SPREAD[0],
        "",
        "min",
        "standard deviation of the readings of fingers as made, a share of the largest of their "
        "row; on request",
    ),
    (
        SPREAD[1],
        "",
        "min",
        "the same of calibrated fingers, whose rubber, plates' modulus and gages a bench measured",
    ),
    (
        SPREAD[2],
        "",
        "max",
        "share of fingers as made that grip with 1.1 to 1.5 x least force, closed alike; on "
        "request",
    ),
    (
        SPREAD[3],
        "microstrain/N",
        "max",
        "greatest reading per tangential force that nine of ten fingers as made reach; on request",
    ),
    ("peak_pressure_MPa", "MPa", "min", "greatest contact pressure of the path"),
    ("plates", "", "min", "plates used"),
    ("cost", "", "min", "what [cost] adds up: plates, gages, rubber"),
    ("rubber_volume_ml", "ml", "min", "volume of the elastomer"),
    ("plane_strain_error", "", None, "forecast of what plane strain overstates F_n by"),
    ("core_seconds", "s", None, "processor time of the variant"),
)
_SCALES = {  # good, poor
    "grip_success": (0.95, 0.75),
    "least_margin": (1.2, 1.05),
    "peak_ratio": (1.5, 3.0),
    "stick_error": (0.1, 0.2),
    "smallest_stick_change": (0.1, 0.3),
    "area_correlation": (0.8, 0.5),
}
_CHANCE = {  # share, step, noisy
    "safety_margin": (0.02, 0.0, 0.18),
    "least_margin": (0.035, 0.0, 0.4),
    "peak_force_N": (0.06, 0.0, 0.11),
    "peak_ratio": (0.03, 0.0, 0.19),
    "stick_error": (0.0, 0.007, 0.0),
    "gage_response": (0.005, 0.0, 0.0),
    "smallest_stick_change": (0.02, 0.0, 0.0),
    "normal_force_N": (0.002, 0.0, 0.0),
    "tangential_force_N": (0.002, 0.0, 0.0),
    "stiffness_N_per_mm": (0.001, 0.0, 0.0),
    "first_slip_N": (0.003, 0.0, 0.0),
    "peak_pressure_MPa": (0.007, 0.0, 0.0),
}
METRICS: dict[str, Metric] = {}
for _name, _unit, _better, _words in _ROWS:
    _good, _poor = _SCALES.get(_name, (None, None))
    _share, _step, _noisy = _CHANCE.get(_name, (0.0, 0.0, 0.0))
    METRICS[_name] = Metric(
        _name, _unit, _better, _words, _good, _poor, share=_share, step=_step, noisy=_noisy
    )


def known_metric(name: str) -> str:
    """The name itself; a fault that names the nearest where there is no such metric."""
    if name in METRICS:
        return name
    near = difflib.get_close_matches(name, METRICS, 1, 0.5)
    remedy = f"did you mean '{near[0]}'?" if near else "choose one of them"
    raise refuse(name, f"one of {', '.join(METRICS)}", remedy)
