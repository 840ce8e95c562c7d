"""The ``[gages]`` table: the grids on each plate and the bridge that they are wired into.

With e_a the mean strain along the plate over a gage and e_t that across it, on the same face and
over the same rectangle, a gage reads

    axial          e_a
    tee            e_a + w e_t       w = nu of the plate: (1 - nu^2) / E times its own axial stress
    double_axial   half the difference of two plates of opposite angles, + less -

and face = "both" is the mean of the two faces'. A grid of transverse sensitivity k, whose gage
factor its maker found in a bar with nu = 0.285, reads (e + k e_across) / (1 - 0.285 k) for e.
"""

import math
from collections.abc import Iterator
from typing import Literal

from pydantic_core import PydanticCustomError

from fingerdesign.design.base import Table, bounded, key, positive, refuse_key
from fingerdesign.design.leads import Leads

MAKERS_NU = 0.285  # of the bar on which gage factors are measured
# Half of the design's own largest response at full stick: one rule for every design and friction
# coefficient, which a hand can apply too, by a first shear on a rough object; 0.45 and 0.55 do too.
AREA_SHARE = 0.5
METAL_FACTOR = 2.0  # Gage factor of metal foil.


class Gages(Table):
    """The strain gages that each plate carries on one face or on both, and their bridge."""

    length_mm: float = bounded(1.0, 0.01, 200, "averaged along the plate, centred on it")
    width_mm: float = bounded(
        1.0, 0.01, 500, "averaged across the plate (along z), centred on z_mm"
    )
    z_mm: float = bounded(0.0, -250, 250, "the gage's middle, from its plate's middle")
    face: Literal["upper", "lower", "both"] = key(
        "both",
        "upper (90 degrees anticlockwise from the plate's axis) | lower | both "
        "(their mean: membrane)",
    )
    grid: Literal["axial", "tee", "double_axial"] = key(
        "axial",
        "axial (strain along the plate) | tee (two grids across each other: along + "
        "transverse_weight x across, the plate's axial stress) | double_axial (plates 0 and 1, 2 "
        "and 3, ... at opposite angles: half their difference)",
    )
    transverse_weight: float | None = bounded(
        None, -1, 1, "of a tee's grid across; absent: Poisson's ratio of the plates", example=0.33
    )
    kind: str | None = key(
        None,
        "what is bonded: a type of `fingerdesign list gages` or of "
        "[[mold.gage_types]]; check compares its size and stiffness with the plates",
        max_length=60,
        examples=["silicon_bar_05"],
    )
    bridge: Literal["quarter", "half", "full"] | None = key(
        None,
        "arms of the bridge that strain: one, two or four; absent: as many as the grids can fill",
        examples=["half"],
    )
    gage_factor: float | None = key(
        None,
        "relative change of resistance per strain; absent: that of gages.kind, else 2",
        gt=0,
        le=500,
        examples=[2.1],
    )
    transverse_sensitivity: float = bounded(
        0.0, -0.2, 0.2, "of a grid, to strain across it, as a share of its own"
    )
    excitation_V: float = positive(2.5, 100, "of the bridge")
    area_share: float = key(
        AREA_SHARE,
        "the gage area of the slip study counts where the response to F_t exceeds this "
        "share of the strongest gage's at full stick",
        gt=0,
        lt=1,
    )

    leads: Leads | None = key(
        None, "bars along the plates in the model; absent: left out, as before they are cast"
    )

    def _misfits(self) -> Iterator[PydanticCustomError]:
        if self.transverse_weight is not None and self.grid != "tee":
            remedy = 'remove it or set gages.grid = "tee"'
            yield refuse_key(self, "gages.transverse_weight", "absent without a tee", remedy)

    @property
    def faces(self) -> int:
        """Number of faces of a plate that carry gages."""
        return len(self.sides)

    @property
    def sides(self) -> tuple[float, ...]:
        """The sides of a plate's middle that carry gages: 1 the upper, -1 the lower."""
        return {"upper": (1.0,), "lower": (-1.0,), "both": (1.0, -1.0)}[self.face]

    @property
    def lead_count(self) -> int:
        """Number of leads of a plate: given, or two a grid; tees have a common tab each."""
        if self.leads is not None and self.leads.number is not None:
            return self.leads.number
        return 2 * self.faces + (2 if self.grid == "tee" else 0)

    def transverse(self, poissons_ratio: float) -> float:
        """The weight w of the strain across, on plates with a Poisson's ratio."""
        if self.grid != "tee":
            return 0.0
        return poissons_ratio if self.transverse_weight is None else self.transverse_weight

    def weights(self, poissons_ratio: float) -> tuple[float, float]:
        """a and b of the reading a e_a + b e_t on plates with a Poisson's ratio."""
        w, k = self.transverse(poissons_ratio), self.transverse_sensitivity
        scale = 1.0 - MAKERS_NU * k
        return (1.0 + w * k) / scale, (w + k) / scale

    def bridges(self, poissons_ratio: float) -> dict[str, float]:
        """The bridges that these grids can make, weakest first, each with the arms n that say what
        it gives: output / excitation = gage factor x n / 4 x reading.

        Opposite arms add, neighbours subtract; grids in series in one arm give their mean. A tee's
        grid across is brought to |w| by a resistor next to it: in an arm of its own w R / (1 - w),
        R that of a grid; in series with its fellow, where the sum is (e_a + w e_t) / (1 + s), s is
        the root of w and the resistor s R / (1 - s).
        """
        two, w = self.faces == 2, self.transverse(poissons_ratio)
        if self.grid == "double_axial":
            return {"half": 2.0, "full": 4.0} if two else {"half": 2.0}
        if self.grid == "axial":
            return {"quarter": 1.0, "half": 2.0} if two else {"quarter": 1.0}
        if w < 0.0:
            return {"half": 1.0, "full": 2.0} if two else {"half": 1.0}
        series = 1.0 / (1.0 + math.sqrt(w))
        return {"quarter": series, "half": 2.0 * series if two else 1.0}
