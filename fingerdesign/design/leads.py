"""``[gages.leads]``: what leads from the gages to where they are read, as bars along their plates.

Thin wires are stiff: six of copper, 0.1 mm, have 50 times the stiffness of a polyimide strip of
0.53 x 0.05 mm. Each lead is a bar of the stiffness E A (N) that is bonded to its plate from the
edge of the gage to the plate's front end (+z, of plates along z +x); with ``course = "leg"`` it
stays on the plate's leg, with ``"z"`` it goes down to the base there. What is beyond the plate is
not in the model. A section in plane strain has no strain along z, and knows no leads.
"""

import math
from typing import Literal

from fingerdesign.design.base import Table, key, positive

COPPER_MPA, GOLD_MPA = 120e3, 78e3
LEAST_WIRE_MM = 0.03  # a thinner enamelled wire can hardly be handled
ENAMEL = 1.25  # outer diameter over that of the metal
FLEX_MM, TRACE_MM = 0.005, 0.05  # copper on thin flex circuits, and a trace's width


class Leads(Table):
    """``[gages.leads]``: bars along the plates in the model; absent: the model leaves leads out."""

    kind: Literal["wire", "traces", "none"] = key(
        "wire", "wire (round) | traces (on the plate itself) | none"
    )
    number: int | None = key(
        None,
        "of a plate; absent: two a grid, and a common tab of tees on both faces",
        ge=0,
        le=100,
        examples=[6],
    )
    course: Literal["z", "leg"] = key(
        "z",
        "z (along the plate, then down to the base) | leg (along the plate and out on "
        "its front leg)",
    )
    diameter_mm: float = positive(0.1, 2, "of a wire's metal")
    width_mm: float = positive(TRACE_MM, 10, "of a trace")
    thickness_mm: float = positive(FLEX_MM, 1, "of a trace", least=1e-6)
    modulus_MPa: float = positive(COPPER_MPA, 1e6, "of their metal; copper, gold 78e3")

    @property
    def stiffness(self) -> float:
        """E A of one lead, N.

        >>> round(Leads(diameter_mm=0.1).stiffness)
        942
        """
        area = {
            "wire": 0.25 * math.pi * self.diameter_mm**2,
            "traces": self.width_mm * self.thickness_mm,
            "none": 0.0,
        }[self.kind]
        return self.modulus_MPa * area
