"""Differences from finger to finger: parameters, by how much, and who would tighten them.

Tolerances are to either side, and any value within them is as likely: a standard deviation of the
tolerance over the root of three. Plates go by what holds them in the mold, the rubber by its
batches, gages by their factors.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.placement import row_tolerances, tolerances
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.sensitivity.variant import PLACES

RUBBER, GAINS = 0.15, 0.03  # Of a batch of silicone, and of gage factors (sensing/perturb/draws.py)
UNIFORM = float(1.0 / np.sqrt(3.0))


@dataclass(frozen=True)
class Source:
    """A cause of scatter: its words, and the parameters that it moves, each by itself.

    tolerances (P,): to either side, in ``unit``; known: a bench measures it, so that a calibrated
    finger does without.
    """

    words: str
    parameters: tuple[str, ...]
    tolerances: tuple[float, ...]
    unit: str
    known: bool = False

    @property
    def stds(self) -> Array:
        """Standard deviations (P,)."""
        return UNIFORM * np.array(self.tolerances)

    @property
    def largest(self) -> float:
        """The largest of the tolerances."""
        return max(self.tolerances)


def sources_of(design: Design, plan: MoldPlan) -> list[Source]:
    """The sources of scatter of fingers that are cast in a mold; gains of gages are not among them,
    for they are no parameters of the model."""
    found = []
    flat = design.plates.model == "solid" and design.body.core is None
    frames = plate_frames(design)
    if frames and flat and all(f.along == "x" and f.bend_radius is None for f in frames):
        off = [tolerances(plan, frame.index) for frame in frames]
        for key, words in zip(
            PLACES, ("plates along x", "plates in height", "plates' angles"), strict=True
        ):
            angle = key == "angle_deg"
            sizes = tuple(pair[angle] for pair in off)
            names = tuple(f"placement[{k}].{key}" for k in range(len(frames)))
            found.append(Source(words, names, sizes, "degrees" if angle else "mm"))
        x, y = row_tolerances(plan)
        found.append(Source("row along x", ("placement.x_mm",), (x,), "mm"))
        found.append(Source("row in height", ("placement.y_mm",), (y,), "mm"))
    name = f"materials.{design.body.material}.youngs_modulus_MPa"
    young = design.material_of("body").youngs_modulus_MPa
    found.append(Source("rubber's modulus", (name,), (RUBBER * young,), "MPa", known=True))
    return found
