"""The ``[mold]`` table: how a finger is cast. No analysis depends on it: it is not in the digest.

Lengths in mm, angles in degrees. Keys that are absent are computed from the process's profile
(mold/plan/plan.py), the bolts and the plates.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from fingerdesign.design.base import Table

ProcessName = Literal["sla", "fdm", "machined"]
BoltName = Literal["auto", "M2", "M2.5", "M3", "M4"]
FixtureName = Literal["comb", "jig", "slots"]


class MoldLimits(Table):
    """``[mold.limits]``: what your machine holds, where it differs from the process's profile."""

    wall_mm: float | None = Field(
        default=None, ge=0.1, le=20, examples=[1.0], description="least wall; absent: the profile's"
    )
    feature_mm: float | None = Field(
        default=None, ge=0.02, le=20, examples=[0.4], description="least web, rib or tip"
    )
    hole_mm: float | None = Field(
        default=None, ge=0.05, le=20, examples=[0.8], description="least diameter of a round hole"
    )
    slot_mm: float | None = Field(
        default=None, ge=0.02, le=20, examples=[0.3], description="least width of a slot"
    )
    clearance_mm: float | None = Field(
        default=None,
        ge=0.0,
        le=2,
        examples=[0.1],
        description="all round, between parts that slide",
    )
    pin_mm: float | None = Field(
        default=None, ge=0.2, le=20, examples=[2.0], description="least diameter of a pin"
    )
    tolerance_mm: float | None = Field(
        default=None, ge=0.0, le=2, examples=[0.1], description="of a place, to either side"
    )


class Comb(Table):
    """``[mold.comb]``: the cut or etched sheet whose slots hold the plates' ends."""

    sheet_mm: float = Field(default=0.3, ge=0.05, le=3, description="thickness of the sheet")
    slot_mm: float = Field(default=0.1, ge=0.01, le=3, description="least slot that can be cut")
    web_mm: float = Field(
        default=0.2, ge=0.02, le=5, description="least web between slots and to the sheet's edge"
    )
    clearance_mm: float = Field(
        default=0.02, ge=0, le=1, description="of a slot beyond the plate's thickness"
    )
    tolerance_mm: float = Field(default=0.02, ge=0, le=1, description="of a slot's place")


class Mold(Table):
    """A mold of parts that are drawn along the finger's faces, cast with the base up."""

    process: ProcessName = Field(
        default="sla", description="sla (resin print) | fdm (filament print) | machined (metal)"
    )
    cure: Literal["platinum", "condensation"] = Field(
        default="platinum", description="of the silicone: platinum | condensation (tin)"
    )
    shrinkage: float | None = Field(
        default=None,
        ge=0,
        le=0.1,
        examples=[0.0],
        description="linear, of the rubber; absent: 0 of platinum, 0.02 of condensation cure",
    )
    plate_fixture: FixtureName = Field(
        default="comb",
        description="comb (a cut sheet holds the plates) | jig (two made by the process, shifted "
        "to clamp) | slots (in the walls, filled by shims); slots where a side is not flat",
    )
    wall_mm: float | None = Field(
        default=None,
        ge=0.5,
        le=100,
        examples=[10.0],
        description="end walls' thickness; absent: what bolts, pins and the process need",
    )
    insert_mm: float = Field(
        default=6.0, ge=0.5, le=100, description="contact insert above the crest"
    )
    base_mm: float = Field(default=4.0, ge=0.5, le=50, description="base plate's thickness")
    draft_deg: float = Field(
        default=2.0, ge=0, le=45, description="of pins, keys and the insert's plug; not of faces"
    )
    bolt: BoltName = Field(
        default="auto",
        description="auto (M3, or what the walls' height holds) | M2 | M2.5 | M3 | M4",
    )
    tab_mm: float = Field(
        default=3.0, ge=0.2, le=50, description="legs of plates beyond the face or comb"
    )
    leg_mm: float | None = Field(
        default=None,
        ge=0.1,
        le=50,
        examples=[0.6],
        description="width of plates' legs; absent: by the sheet and the plate's thickness",
    )
    wire_mm: float = Field(
        default=0.3,
        ge=0,
        le=5,
        description="diameter of a plate's bundle of leads (four enamelled wires of 0.1 mm "
        "copper), which leave through a hole beside its slot at the front or right; 0: none",
    )
    gate_mm: float = Field(
        default=4.0, ge=0.2, le=50, description="diameter of gate and riser; shrunk to what fits"
    )
    vent_mm: float | None = Field(
        default=None,
        ge=0.05,
        le=10,
        examples=[1.0],
        description="diameter of a vent; absent: 1 mm, or the process's least hole",
    )
    lock_mm: float = Field(
        default=2.0, ge=0.2, le=50, description="diameter of the base's locks; shrunk to what fits"
    )
    excess: float = Field(
        default=0.15, ge=0, le=2, description="silicone mixed beyond what the cavity holds, share"
    )
    density_g_cm3: float | None = Field(
        default=None,
        ge=0.5,
        le=3,
        examples=[1.08],
        description="of the silicone; absent: typical of the body's material",
    )
    chord_mm: float = Field(
        default=0.01, ge=0.001, le=0.5, description="greatest distance of STL triangles to surfaces"
    )
    contact_margin_mm: float = Field(
        default=0.5, ge=0, le=20, description="seams keep this far from the contact zone"
    )
    limits: MoldLimits = Field(default_factory=MoldLimits)
    comb: Comb = Field(default_factory=Comb)

    @property
    def shrinkage_used(self) -> float:
        """Linear shrinkage, share: the given one, or 0 of platinum, 0.02 of condensation cure."""
        if self.shrinkage is not None:
            return self.shrinkage
        return 0.0 if self.cure == "platinum" else 0.02
