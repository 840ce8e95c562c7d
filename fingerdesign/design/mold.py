"""The ``[mold]`` table: how a finger is cast. No analysis depends on it: it is not in the digest.

Lengths in mm, angles in degrees. Keys that are absent are computed from the process's profile
(mold/plan/plan.py), the bolts and the plates.
"""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from fingerdesign.design.base import Many, Table, bounded, key, refuse, refuse_key
from fingerdesign.design.leads import ENAMEL, LEAST_WIRE_MM
from fingerdesign.design.stock import GageType

ProcessName = Literal["sla", "fdm", "machined"]
BoltName = Literal["auto", "M2", "M2.5", "M3", "M4"]
PourName = Literal["auto", "open", "closed"]


def _no_jig(value: object) -> object:
    if value == "jig":
        raise refuse(
            value, "comb or slots: no jigs are made", "take 'comb', which holds plates closer"
        )
    return value


FixtureName = Annotated[Literal["comb", "slots"], BeforeValidator(_no_jig)]


class MoldLimits(Table):
    """``[mold.limits]``: what your machine holds, where it differs from the process's profile."""

    wall_mm: float | None = bounded(None, 0.1, 20, "least wall; absent: the profile's", example=1.0)
    feature_mm: float | None = bounded(None, 0.02, 20, "least web, rib or tip", example=0.4)
    hole_mm: float | None = bounded(None, 0.05, 20, "least diameter of a round hole", example=0.8)
    slot_mm: float | None = bounded(None, 0.02, 20, "least width of a slot", example=0.3)
    clearance_mm: float | None = bounded(
        None, 0.0, 2, "all round, between parts that slide", example=0.1
    )
    pin_mm: float | None = bounded(None, 0.2, 20, "least diameter of a pin", example=2.0)
    tolerance_mm: float | None = bounded(None, 0.0, 2, "of a place, to either side", example=0.1)
    form_mm: float | None = bounded(
        None, 0.0, 2, "of a face over the finger's width, to either side", example=0.05
    )


class Comb(Table):
    """``[mold.comb]``: the cut or etched sheet whose slots hold the plates' ends."""

    sheet_mm: float = bounded(0.3, 0.05, 3, "thickness of the sheet")
    slot_mm: float = bounded(0.1, 0.01, 3, "least slot that can be cut")
    web_mm: float = bounded(0.2, 0.02, 5, "least web between slots and to the sheet's edge")
    clearance_mm: float = bounded(0.02, 0, 1, "of a slot beyond the plate's thickness")
    tolerance_mm: float | None = bounded(
        None,
        0,
        1,
        "of a cut edge's place; absent: 0.01 (stencil laser, wire erosion), with machined parts "
        "0.005 (fine wire erosion)",
        example=0.01,
    )


class Mold(Table):
    """A mold of parts that are drawn along the finger's faces, cast with the base up."""

    process: ProcessName = key("sla", "sla (resin print) | fdm (filament print) | machined (metal)")
    cure: Literal["platinum", "condensation"] = key(
        "platinum", "of the silicone: platinum | condensation (tin)"
    )
    shrinkage: float | None = bounded(
        None,
        0,
        0.1,
        "linear, of the rubber; absent: 0 of platinum, 0.02 of condensation cure",
        example=0.0,
    )
    pour: PourName = key(
        "auto",
        "auto (open where the finger allows it: fewest parts) | open (two half frames, "
        "poured from above, the base plate pressed on last) | closed (four walls, gate and vents)",
    )
    plate_fixture: FixtureName = key(
        "comb",
        "comb (a cut sheet holds the plates) | slots (in the walls, filled by clay); "
        "slots where a side is not flat",
    )
    wall_mm: float | None = bounded(
        None,
        0.5,
        100,
        "end walls' thickness; absent: what bolts, pins and the process need",
        example=10.0,
    )
    insert_mm: float = bounded(6.0, 0.5, 100, "contact insert above the crest")
    base_mm: float = bounded(4.0, 0.5, 50, "base plate's thickness")
    draft_deg: float = bounded(2.0, 0, 45, "of pins and the insert's plug; not of faces")
    bolt: BoltName = key("auto", "auto (M3, or what the walls' height holds) | M2 | M2.5 | M3 | M4")
    tab_mm: float = bounded(3.0, 0.2, 50, "legs of plates beyond the face or comb")
    leg_mm: float | None = bounded(
        None,
        0.1,
        50,
        "width of plates' legs, at most; absent: the plate's length where it reaches the finger's "
        "end, half of it where its legs stay in the rubber, or what has room",
        example=0.6,
    )
    wire_mm: float = bounded(
        0.3,
        0,
        5,
        "diameter of a plate's bundle of leads (four enamelled wires of 0.1 mm "
        "copper), all of which leave through the base plate; 0: no hole for them",
    )
    leads: Literal["wires", "leg"] = key(
        "wires",
        "wires (along their plate, out through the base plate) | leg (traces of film "
        "and flex plates, on front legs that are bent down into a groove of the mount)",
    )
    mount: Literal["inserts", "iso9409"] = key(
        "inserts",
        "back of the receiver that the finger slides into: inserts (two, M3) | iso9409 "
        "(the holes of ISO 9409-1-50-4-M6)",
    )
    gate_mm: float = bounded(4.0, 0.2, 50, "diameter of gate and riser; shrunk to what fits")
    vent_mm: float | None = bounded(
        None, 0.05, 10, "diameter of a vent; absent: 1 mm, or the process's least hole", example=1.0
    )
    lock_mm: float = bounded(2.0, 0.2, 50, "diameter of the base's locks; shrunk to what fits")
    excess: float = bounded(0.15, 0, 2, "silicone mixed beyond what the cavity holds, share")
    gage: str = key(
        "auto",
        "auto (what is sold and fits the plates) | a type's name, as 'foil_1' or "
        "'sputtered_film' of the catalogue data/stock.toml, or of [[mold.gage_types]]",
    )
    gage_types: Many[GageType] = key(
        (),
        "gages of your own, before the catalogue's; [[mold.gage_types]] tables say the same",
        max_length=50,
        examples=[
            [
                {
                    "name": "mine",
                    "grid_length_mm": 0.5,
                    "grid_width_mm": 1.0,
                    "carrier_length_mm": 2.0,
                    "carrier_width_mm": 3.0,
                }
            ]
        ],
    )
    sheets_mm: Many[Annotated[float, Field(gt=0, le=20)]] = key(
        (),
        "thicknesses of sheet that you have; absent: those commonly sold",
        max_length=50,
        examples=[[0.1, 0.15, 0.2, 0.3]],
    )
    density_g_cm3: float | None = bounded(
        None, 0.5, 3, "of the silicone; absent: typical of the body's material", example=1.08
    )
    chord_mm: float = bounded(0.01, 0.001, 0.5, "greatest distance of STL triangles to surfaces")
    contact_margin_mm: float = bounded(0.5, 0, 20, "seams keep this far from the contact zone")
    limits: MoldLimits = Field(default_factory=MoldLimits)
    comb: Comb = Field(default_factory=Comb)

    def _misfits(self) -> Iterator[PydanticCustomError]:
        own = [each.name for each in self.gage_types]
        if "auto" in own:
            bound = "another name: mold.gage = 'auto' chooses one"
            yield refuse("auto", bound, "rename it", "mold.gage_types")
        if twice := [name for name in dict.fromkeys(own) if own.count(name) > 1]:
            bound = "types of different names"
            yield refuse(", ".join(twice), bound, "rename all but one", "mold.gage_types")
        least = ENAMEL * LEAST_WIRE_MM
        if 0.0 < self.wire_mm < least:
            bound = f"0, or at least {least:g}: one wire of {LEAST_WIRE_MM:g} mm and its enamel"
            yield refuse_key(self, "mold.wire_mm", bound, "0 makes no hole for leads")

    @property
    def shrinkage_used(self) -> float:
        """Linear shrinkage, share: the given one, or 0 of platinum, 0.02 of condensation cure."""
        if self.shrinkage is not None:
            return self.shrinkage
        return 0.0 if self.cure == "platinum" else 0.02
