"""Casting notes before the mold is closed: parts, cleanliness, plates and gages."""

from __future__ import annotations

from collections.abc import Iterator

from fingerdesign.mold.casting_bench import Bench, listed, numbers_text, words
from fingerdesign.mold.part import PartMesh


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
    for sheet in (p for p in bench.parts if p.made == "sheet"):
        thick = _thickness(sheet)
        yield f"Cut or etch {words(sheet.name)} from {thick:g} mm sheet by {sheet.name}.dxf."
    yield from _insertfinishing(bench)
    if bench.core and bench.design.body.core is not None:
        material = words(bench.design.body.core.material)
        yield f"Make the core of {material} by core.step, with its holes; roughen it."


def _insertfinishing(bench: Bench) -> Iterator[str]:
    if bench.design.body.shape == "block":
        yield (
            "The finger's contact surface is flat: polish the contact insert, or bond a piece of "
            "glass over its face and make the insert thinner by the glass (mold.insert_mm)."
        )
        return
    steps = {
        "sla": "wet-sand the contact insert's face from 400 to 2000 grit and polish it",
        "fdm": "fill and sand the contact insert's face until no layer line can be felt",
        "machined": "polish the contact insert's face from 600 grit to a mirror",
    }
    step = steps[bench.design.mold.process]
    yield (
        f"The contact surface copies every scratch: {step}. Stay off its rim, where the seam lies."
    )


def preparing(bench: Bench) -> Iterator[str]:
    """What must not be in the rubber, and a dry run."""
    mold = bench.design.mold
    if mold.process == "sla":
        yield "Wash the prints twice in fresh isopropanol, 5 min each, and let them dry for 30 min."
        yield "Cure them under ultraviolet light as the resin's maker says, both sides."
    if bench.polyurethane:
        yield "Dry parts, tools and plates at 60 degrees C for an hour: moisture makes it foam."
    elif mold.process == "sla" and mold.cure == "platinum":
        yield (
            "Bake the cured prints for 2 h at 80 degrees C (or what the resin stands): that drives "
            "out what would stop a platinum cure. Then spray a thin barrier coat (acrylic or "
            "polyvinyl alcohol) onto every face that meets silicone."
        )
        yield (
            "Inhibition test: cure a drop of mixed silicone on a print's back. Go on only if it "
            "does not stay tacky against the resin; else bake and coat again."
        )
    elif mold.cure == "platinum":
        yield (
            "Inhibition test: cure a drop of mixed silicone on one part and on the tape you will "
            "use. Sulfur, tin and amines stop a platinum cure: no latex gloves, no sulfur clay."
        )
    yield "Close the mold dry, without plates: every part slides into its place without force."
    yield "Degrease every face with isopropanol; from now on wear nitrile gloves."


def plates_and_gages(bench: Bench) -> Iterator[str]:
    """Plates cut, gages bonded, wires led."""
    design = bench.design
    if not bench.patterns:
        return
    material = words(design.plates.material)
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
    yield (
        f"Bond the gages at the marks of layer GAGES on {faces[design.gages.face]}, with a film as "
        "thin as it gets, and solder the leads at the gage's end toward a leg."
    )
    if design.mold.wire_mm > 0.0:
        yield (
            f"Lead the wires along the leg: its slot has {design.mold.wire_mm:g} mm more length "
            "for them. Seal the joints with a thin coat of lacquer."
        )
    else:
        yield "mold.wire_mm is 0: no slot has room for wires; add the gages' leads elsewhere."
    yield "Check each gage's resistance now: afterwards nothing can be mended."
    yield "Wipe the plates with primer for this elastomer on metal; gages, if their maker agrees."


def _thickness(sheet: PartMesh) -> float:
    extent = sheet.vertices.max(axis=0) - sheet.vertices.min(axis=0)
    return round(float(extent.min()), 4)
