"""Casting notes before the mold is closed: parts, cleanliness, plates and gages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fingerdesign.mold.part import CORE, INSERT, WORDS, PartMesh

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.plan.plan import BaseHole, MoldPlan
    from fingerdesign.mold.products.bill import Silicone
    from fingerdesign.mold.products.flat_pattern import FlatPattern


# What casting notes are made from, and the words that they share.


@dataclass(frozen=True)
class Bench:
    """What the notes are made from."""

    design: Design
    plan: MoldPlan
    parts: Sequence[PartMesh]
    patterns: Sequence[FlatPattern]
    silicone: Silicone

    @property
    def polyurethane(self) -> bool:
        """Whether the elastomer is no silicone."""
        return self.design.body.material.startswith("polyurethane")

    @property
    def elastomer(self) -> str:
        """What is poured, in a word."""
        return "polyurethane" if self.polyurethane else "silicone"

    @property
    def core(self) -> bool:
        """Whether a core is cast in."""
        return any(part.name == CORE for part in self.parts)


def of_kind(holes: Sequence[BaseHole], kind: str) -> list[BaseHole]:
    """The base plate's holes of a kind."""
    return [hole for hole in holes if hole.kind == kind]


def count_text(number: int, what: str) -> str:
    """``number`` things in words."""
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def numbers_text(plates: Sequence[int]) -> str:
    """Whole numbers, runs shortened.

    >>> numbers_text([0, 1, 2, 5, 7, 8])
    '0-2, 5, 7-8'
    """
    runs: list[list[int]] = []
    for plate in sorted(plates):
        if runs and plate == runs[-1][-1] + 1:
            runs[-1].append(plate)
        else:
            runs.append([plate])
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]}-{r[-1]}" for r in runs)


def listed(names: Sequence[str]) -> str:
    """Words as a list in a sentence."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def words(name: str) -> str:
    """A name as a reader meets it: without underscores."""
    return name.replace("_", " ")


ETCHED = 0.9  # least width of an etched slot over the sheet's thickness, about; assumed


def making(bench: Bench) -> Iterator[str]:
    """Prints, sheets, the insert's finish, the core."""
    mold = bench.design.mold
    names = [words(p.name) for p in bench.parts if p.made == "process"]
    how = "Machine" if mold.process == "machined" else "Print"
    yield f"{how} {listed(names)}."
    if mold.process == "machined":
        yield (
            "The parts' STEP files are exact. Drill and ream the dowel holes of parts that share a "
            "dowel together, where your machine allows it."
        )
        dowels = [pin for pin in bench.plan.pins if pin.dowel]
        if dowels:
            parts = listed(sorted({words(pin.on) for pin in dowels}))
            yield f"Press the {len(dowels)} dowel pins into {parts}; they slide in the other part."
    else:
        yield (
            "mold.3mf holds them in millimetres, each on its largest flat face with the side that "
            "forms the finger up; keep supports off that side. The STL files have the same parts "
            "in their places in the closed mold."
        )
        lying = sorted(
            {words(pin.on) for pin in bench.plan.pins if not pin.dowel and pin.on != INSERT}
        )
        if lying:
            yield (
                f"The pins of {listed(lying)} lie level over the bed: support them from below "
                "alone, and trim what the supports leave until they slide into their sockets."
            )
    for sheet in (p for p in bench.parts if p.made == "sheet"):
        thick = _thickness(sheet)
        yield (
            f"{_cut(bench, thick)} {words(sheet.name)} from {thick:g} mm sheet by {sheet.name}.dxf."
        )
    if bench.core and bench.design.body.core is not None:
        material = words(bench.design.body.core.material)
        yield f"Make the core of {material} by core.step, with its holes; roughen it."


def _cut(bench: Bench, thick: float) -> str:
    """How a comb is cut: etching makes no slot much narrower than the sheet is thick."""
    held = [slot.width for s in bench.plan.sides if s.holding == "comb" for slot in s.slots]
    if held and min(held) < ETCHED * thick:
        return "Laser-cut or wire-cut (its slots are too narrow to be etched in this thickness)"
    return "Cut or etch"


def _surface(bench: Bench, coated: bool) -> Iterator[str]:
    """The contact insert's face, before anything is degreased."""
    steps = {
        "sla": "wet-sand the contact insert's face from 400 to 2000 grit and polish it",
        "fdm": "fill and sand the contact insert's face until no layer line can be felt",
        "machined": "polish the contact insert's face from 600 grit to a mirror",
    }
    step = steps[bench.design.mold.process]
    if coated:
        step = (
            "wet-sand the contact insert's face from 400 to 800 grit; the coat that comes is what "
            "you polish"
        )
    flat = ""
    if bench.design.body.kind.flat:
        flat = (
            " It is flat: you can bond glass over it instead, and make the insert thinner by the "
            "glass (mold.insert_mm)."
        )
    yield (
        f"The contact surface copies every scratch: {step}. Stay off its rim, where the seam "
        f"lies.{flat}"
    )


def preparing(bench: Bench) -> Iterator[str]:
    """What must not be in the rubber, and a dry run."""
    mold = bench.design.mold
    if mold.process == "sla":
        yield "Wash the prints twice in fresh isopropanol, 5 min each, and let them dry for 30 min."
        yield "Cure them under ultraviolet light as the resin's maker says, both sides."
    coated = mold.process == "sla" and mold.cure == "platinum" and not bench.polyurethane
    if coated:
        yield (
            "Bake the cured prints for 2 h at 80 degrees C (or what the resin stands): that drives "
            "out what would stop a platinum cure."
        )
    yield (
        "Dry fit: close the mold without plates, by the steps of its closing. Every part slides "
        "into its place without force; trim what does not."
    )
    yield from _surface(bench, coated)
    yield "Degrease every face with isopropanol and let it dry; from now on wear nitrile gloves."
    if bench.polyurethane:
        yield "Dry parts, tools and plates at 60 degrees C for an hour: moisture makes it foam."
    elif coated:
        yield (
            "Spray two thin barrier coats (clear acrylic lacquer, or polyvinyl alcohol where it is "
            "not to be polished) onto every face that meets silicone, not onto pins, sockets and "
            "keys; let them harden for a day."
        )
        yield (
            "Polish the coat on the contact insert's face with 2000 grit and plastic polish, then "
            "degrease it. Where you sand through to the resin, coat it again."
        )
    if mold.cure == "platinum" and not bench.polyurethane:
        where = "the coated face of the insert, outside the finger" if coated else "one part"
        again = "; else bake and coat again" if coated else ""
        yield (
            f"Inhibition test: cure a drop of mixed silicone on {where}, one on the tape you will "
            f"use and one on a scrap plate with gage, solder and glue as on the real ones. Go on "
            f"only if none stays tacky underneath{again}."
        )


def plates_and_gages(bench: Bench) -> Iterator[str]:
    """Plates cut, gages bonded, wires led."""
    design = bench.design
    if not bench.patterns:
        return
    material = words(design.plates.material)
    platinum = design.mold.cure == "platinum" and not bench.polyurethane
    for pattern in bench.patterns:
        count = len(pattern.plates)
        bend, after = "", "Deburr; keep them flat"
        if pattern.bend_radius is not None:
            bend = f", and bend them over a rod to a radius of {pattern.bend_radius:.2f} mm"
            after = "Deburr before bending; the lower side is hollow"
        yield (
            f"Cut {count} of {words(pattern.name)} (plates {numbers_text(pattern.plates)}) from "
            f"{pattern.thickness:g} mm {material} by plates.dxf{bend}. {after}."
        )
    yield "Mark each plate's number on a leg: the placement table says where each one goes."
    faces = {"upper": "the upper face", "lower": "the lower face", "both": "both faces"}
    glue = "cyanoacrylate or a gage epoxy that was cured hot"
    yield (
        f"Bond the gages at the marks of layer GAGES on {faces[design.gages.face]}, with a film of "
        f"{glue} as thin as it gets. Solder the leads at the gage's end toward the leg where they "
        f"leave: {_lead_ends(bench)}."
    )
    if platinum:
        yield (
            "Wash every trace of solder flux off with isopropanol and a brush. Flux, epoxies with "
            "amine hardeners, sulfur and tin stop a platinum cure around the gage: seal joints and "
            "glue lines with a thin coat of acrylic lacquer."
        )
    else:
        yield "Wash the flux off; seal the joints with a thin coat of acrylic lacquer."
    if design.mold.wire_mm > 0.0:
        yield (
            f"Twist each plate's leads into one bundle, {design.mold.wire_mm:g} mm thick at most: "
            "the round relief beside its slot lets no more through, nor a connector: put none on "
            "before the mold is opened."
        )
    else:
        yield "mold.wire_mm is 0: no slot has room for wires; add the gages' leads elsewhere."
    yield "Check each gage's resistance now: afterwards nothing can be mended."
    yield "Wipe the plates with primer for this elastomer on metal; gages, if their maker agrees."


def _lead_ends(bench: Bench) -> str:
    """Where leads leave, by what the plates' rows run along."""
    leads = [side for side in bench.plan.sides if any(slot.wire > 0.0 for slot in side.slots)]
    if not leads:
        return "front or right"
    reported = [
        f"the {WORDS[side.side]} ({side.side})"
        + (f" of plates {numbers_text([s.plate for s in side.slots])}" if len(leads) > 1 else "")
        for side in leads
    ]
    return listed(reported)


def _thickness(sheet: PartMesh) -> float:
    extent = sheet.vertices.max(axis=0) - sheet.vertices.min(axis=0)
    return round(float(extent.min()), 4)
