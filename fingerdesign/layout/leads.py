"""Leads of a finger's gages as they are wired when it is cast: how many, of what, where."""

import math

from fingerdesign.design.gages import Gages
from fingerdesign.design.leads import COPPER_MPA, ENAMEL, FLEX_MM, GOLD_MPA, LEAST_WIRE_MM, Leads
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import GageType

# So many round wires in a round bundle take so many of their diameters.
_BUNDLES = {1: 1.0, 2: 2.0, 3: 2.155, 4: 1.0 + math.sqrt(2.0), 5: 2.702, 6: 3.0, 7: 3.0}


def bundle(count: int) -> float:
    """Diameter of a round bundle of wires, over that of one of them."""
    return _BUNDLES.get(count, 1.2 * math.sqrt(count))


def leads_width(gages: Gages, leads: Leads) -> float:
    """Width of a plate's leads side by side, mm: wires in their bundle, or the traces of a face,
    each its own width from the next.

    >>> gages = Gages(face="both", grid="tee")
    >>> round(leads_width(gages, Leads(kind="traces", width_mm=0.05)), 3)
    0.25
    """
    count = gages.lead_count if leads.number is None else leads.number
    if leads.kind == "none" or count == 0:
        return 0.0
    if leads.kind == "wire":
        return ENAMEL * leads.diameter_mm * bundle(count)
    return (2 * math.ceil(count / gages.faces) - 1) * leads.width_mm


def leads_as_cast(design: Design, type_: GageType | None) -> Leads:
    """The leads of a finger whose gages are of a type: given, or by ``mold.leads`` and the type.

    Wires are as thick as their bundle (``mold.wire_mm``) allows; gold of bars. Traces are of the
    film's own metal, or of copper on a flex circuit.
    """
    gages, mold = design.gages, design.mold
    if gages.leads is not None:
        return gages.leads
    if mold.leads == "leg":
        thick, modulus = FLEX_MM, COPPER_MPA
        if type_ is not None and type_.to_measure and type_.thickness_mm > 0.0:
            thick, modulus = type_.thickness_mm, type_.modulus_MPa
        return Leads(kind="traces", course="leg", thickness_mm=thick, modulus_MPa=modulus)
    wide = (mold.wire_mm or 0.3) / bundle(gages.lead_count) / ENAMEL
    bar = type_ is not None and type_.kind == "bar"
    wide, modulus = (min(wide, 0.05), GOLD_MPA) if bar else (wide, COPPER_MPA)
    return Leads(diameter_mm=round(wide, 4), modulus_MPa=modulus)


def lead_words(design: Design, leads: Leads) -> str:
    """The leads of a plate, in a few words."""
    count = design.gages.lead_count if leads.number is None else leads.number
    if leads.kind == "wire":
        metal = "gold" if leads.modulus_MPa == GOLD_MPA else "copper"
        return f"{count} wires of {leads.diameter_mm:.2g} mm {metal} a plate"
    if leads.kind == "none":
        return "no leads on the plates"
    micron = 1000.0 * leads.thickness_mm
    return f"{count} traces of {leads.width_mm:g} mm x {micron:.2g} micrometres a plate"


def traces_possible(design: Design, type_: GageType | None) -> bool:
    """True where traces can run on plates: a film gage brings insulation, polyimide is it."""
    return (type_ is not None and type_.to_measure) or "polyimide" in design.plates.material


def thin_bundle(design: Design) -> float:
    """``mold.wire_mm`` of the thinnest wires that can be handled, up to a hundredth, mm."""
    wide = ENAMEL * LEAST_WIRE_MM * bundle(design.gages.lead_count)
    return math.ceil(100.0 * wide) / 100.0
