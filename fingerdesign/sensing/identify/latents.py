"""Hidden values of a finger: its plates' places, its moduli, its gages' gains, its bench's lean."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.design.schema import Design
from fingerdesign.layout.rows import plate_frames
from fingerdesign.sensing.perturb.finger import placement_keys, places_of, training_faults

_EVEN = 3.0**-0.5  # The standard deviation of values that lie evenly between -1 and 1.
# Standard deviations before the fit: those of sensing/perturb's draws; the touch is seen by eye.
PRIOR = {
    "x": 0.1 * _EVEN,
    "y": 0.1 * _EVEN,
    "angle": 1.0 * _EVEN,
    "modulus": 0.15 * _EVEN,
    "poisson": 0.015 * _EVEN,
    "plate_modulus": 0.2 * _EVEN,
    "lean": 2.0 * _EVEN,
    "touch": 0.01,
    "gain": 0.03,
}
# The unit of all others is a share, a fraction of the design's own value.
UNITS = {"x": "mm", "y": "mm", "angle": "degrees", "poisson": "", "lean": "degrees", "touch": "mm"}
AXES = ("x", "y", "angle")
TOLERANCE = {"x": 0.1, "y": 0.1, "angle": 1.0}  # Tolerances of a plate's place, mm and degrees.
MOST_POISSON = 0.4999
# Slopes are differences over a small share (sensitivities.py) of so many standard deviations.
_STEP = 0.25


@dataclass(frozen=True)
class Latent:
    """A hidden value, as its difference from the design's. kind: a key of PRIOR; number: of the
    plate, or of the gage in the readings' order; deviation: before the fit."""

    kind: str
    number: int | None = None

    @property
    def name(self) -> str:
        """Its name in records and tables."""
        if self.kind == "gain":
            return f"gage_{self.number}.gain"
        return self.kind if self.number is None else f"plate_{self.number}.{self.kind}"

    @property
    def unit(self) -> str:
        return UNITS.get(self.kind, "share")

    @property
    def deviation(self) -> float:
        return PRIOR[self.kind]

    @property
    def step(self) -> float:
        """The step to either side of a sensitivity."""
        return _STEP * self.deviation


def latents_of(design: Design, gages: int, tilted: bool) -> tuple[Latent, ...]:
    """The hidden values of a design: places of plates in one level row; moduli where rubber and
    plates are of two materials; the bench's lean where a press was tilted."""
    possible = training_faults(design)
    plates = range(len(plate_frames(design))) if "plates" in possible else ()
    found = [Latent(axis, plate) for plate in plates for axis in AXES]
    found += [Latent(kind) for kind in ("modulus", "plate_modulus") if "modulus" in possible]
    found += [Latent("poisson"), *([Latent("lean")] if tilted else []), Latent("touch")]
    return (*found, *(Latent("gain", number) for number in range(1, gages + 1)))


def material_value(design: Design, kind: str) -> tuple[str, float]:
    """The material's key that a latent of this kind changes, and its value in the design."""
    table: Literal["body", "plates"] = "plates" if kind == "plate_modulus" else "body"
    key = "poissons_ratio" if kind == "poisson" else "youngs_modulus_MPa"
    name = f"materials.{getattr(design, table).material}.{key}"
    return name, getattr(design.material_of(table), key)


def with_latents(design: Design, latents: Sequence[Latent], values: Array) -> Design:
    """The design with these hidden values. DesignError where it is not sound."""
    keys: dict[str, object] = {}
    frames = plate_frames(design)
    places = places_of(frames)
    for latent, value in zip(latents, values, strict=True):
        if latent.kind in AXES and latent.number is not None:
            places[latent.number, AXES.index(latent.kind)] += value
        elif latent.kind in ("modulus", "plate_modulus"):
            key, own = material_value(design, latent.kind)
            keys[key] = own * (1.0 + float(value))
        elif latent.kind == "poisson":
            key, own = material_value(design, latent.kind)
            keys[key] = min(own + float(value), MOST_POISSON)
    if not np.array_equal(places, places_of(frames)):
        keys |= placement_keys(frames, places)
    return with_values(design, keys)
