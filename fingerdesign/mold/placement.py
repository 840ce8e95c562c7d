"""What a plate off its place does to its gage's reading: placement tolerance in terms of strain.

    effect = placement_effect(design, plan)
    effect["sentences"]   # "A plate 0.04 mm off along x changes its reading by up to 3 % ..."

A fixture holds a plate to within its tolerance. Three changes, one-sided and each of all plates at
once: by the tolerance along x, by it in height, turned by the angle that it allows over the leg's
width. The section z = 0 in plane strain is pressed and sheared with the plates in their places and
after each change; changes of a reading are relative to the largest one of their row, and count
together as the root of the sum of their squares.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.errors import FingerDesignError, MeshError, SolverError

if TYPE_CHECKING:
    from fingerdesign.design.contact_zone import Zone
    from fingerdesign.design.layout import PlateFrame
    from fingerdesign.design.meshing import SectionMesh
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.mesh.types import Mesh
    from fingerdesign.mold.moved_section import Move
    from fingerdesign.mold.plan import MoldPlan, Slot

Array = NDArray[np.float64]
Effect = dict[str, Any]

CHANGES = ("along_x", "in_height", "turned")
_DEEPEST = 0.1 / 8.22  # approach over the crest's height: that of the fundamental case on maeno2000
_ROWS = ((0.5, 0.0), (1.0, 0.0), (1.0, 0.4), (1.0, 0.8))  # approach, shear over the deepest
_FRICTION = 0.5
_LEAST_SHARE = 0.1  # of a change that the mesh cannot follow whole
_WIDEN = 1.4  # a candidate zone that the contact has outgrown
_READS = 1e-6  # microstrain: a row whose largest reading is below it has none to be relative to


def placement_effect(design: Design, plan: MoldPlan, sizes: SectionMesh | None = None) -> Effect:
    """The effect of the fixture's tolerance on the gages, as plain values for the record.

    "reason": None, or a sentence why there are no numbers (and then nothing but it and the
    sentences). "changes": for each of CHANGES its size (``largest`` over the plates, ``unit``), and
    ``rms`` and ``worst`` of the changed readings over gages and rows, shares of a row's largest
    reading, with the ``worst_plate``; "together": the same of all three. "gages": a row a plate,
    the worst of its rows. sizes: of the mesh, other than the design's.
    """
    start = time.perf_counter()
    frames, reason = section_plates(design)
    if reason is None:
        try:
            found = _measured(design, plan, frames, sizes)
        except FingerDesignError as error:
            reason = f"the section could not be analysed: {error}"
    if reason is not None:
        sentence = f"What the plates' tolerance does to the gages is not known: {reason}."
        return {"reason": reason, "sentences": [sentence]}
    return {"reason": None, **found, "seconds": round(time.perf_counter() - start, 2)}


def section_plates(design: Design) -> tuple[tuple[PlateFrame, ...], str | None]:
    """The plates that the section z = 0 shows, or why there are none to be moved in it."""
    from fingerdesign.design.layout import plate_frames

    frames = plate_frames(design)
    if not frames:
        return (), "the finger has no plates"
    if design.body.shape == "step":
        return (), "a STEP body has no section in closed form, and plane strain needs one"
    if all(frame.along == "z" for frame in frames):
        return (), "all plates stand in rows along z, which the section z = 0 does not show"
    shown = tuple(f for f in frames if f.along == "x" and f.low < 0.0 < f.high)
    if not shown:
        return (), "the section z = 0 cuts no plate"
    return shown, None


def tolerances(design: Design, plan: MoldPlan, plate: int) -> tuple[float, float]:
    """How far (mm) and by what angle (degrees) a plate may be off, by the slots that hold it.

    In a comb it has its sheet's tolerance and the clearance; a jig clamps it and shims fill a slot,
    so that there the process's tolerance alone counts. Over half of its leg's width in a comb, over
    the length of a slot otherwise, that is an angle. Of its two ends the worse one counts.
    """
    from fingerdesign.mold.profiles import limits_of

    comb, process = design.mold.comb, limits_of(design.mold).tolerance_mm
    places, angles = [0.0], [0.0]
    for side in plan.sides:
        for slot in side.slots:
            if slot.plate != plate:
                continue
            if side.holding == "comb":
                off = comb.tolerance_mm + comb.clearance_mm
                reach = 0.5 * _leg_width(plan, slot)
            else:
                off, reach = process, slot.length
            places.append(off)
            angles.append(math.degrees(math.atan(off / reach)))
    return max(places), max(angles)


def _leg_width(plan: MoldPlan, slot: Slot) -> float:
    for leg in plan.legs:
        if (leg.plate, leg.side) == (slot.plate, slot.side):
            return leg.width
    return slot.length - slot.wire


def scene_for(design: Design) -> Scene:
    """A plane pressed onto the finger, then sheared: the fundamental case in four rows, its motions
    in proportion to the finger's height."""
    from fingerdesign.design.layout import crest_height
    from fingerdesign.design.scene import Scene

    deepest = _DEEPEST * crest_height(design.body)
    rows = [[deepest * approach, deepest * shear] for approach, shear in _ROWS]
    return Scene.model_validate(
        {"object": {"friction_coefficient": _FRICTION}, "path": {"increments_mm": rows}}
    )


def _measured(
    design: Design, plan: MoldPlan, frames: tuple[PlateFrame, ...], sizes: SectionMesh | None
) -> Effect:
    from fingerdesign.case import Case
    from fingerdesign.contact.increment import ZoneExhausted
    from fingerdesign.pipeline import zone_of

    whole = design.plates.model_copy(update={"model": "solid"})  # they are cast, whatever the model
    design = design.model_copy(update={"plates": whole})
    scene = scene_for(design)
    zone = zone_of(Case(design, scene, grips=False, fields=False), scene)
    off = np.array([tolerances(design, plan, frame.index) for frame in frames])
    while True:
        try:
            return _in_zone(design, frames, off, zone, scene, sizes)
        except ZoneExhausted:
            if zone.fills(design):
                raise
            zone = zone.widened(_WIDEN, design)


def _in_zone(
    design: Design,
    frames: tuple[PlateFrame, ...],
    off: Array,
    zone: Zone,
    scene: Scene,
    sizes: SectionMesh | None,
) -> Effect:
    from fingerdesign.mesh.section import mesh_section
    from fingerdesign.mold.moved_section import readings

    mesh = mesh_section(design, zone.half_width, sizes, frames)
    right = readings(design, mesh, frames, zone, scene)
    apart, shares = [], []
    for move in _moves(off):
        moved, share, after = _moved(mesh, frames, move)
        apart.append((readings(design, moved, after, zone, scene) - right) / share)
        shares.append(share)
    return _effect(design, frames, off, right, np.array(apart), shares, scene)


def _moves(off: Array) -> list[Move]:
    """The three changes of plates that may be off by ``off`` (k, 2): mm and degrees."""
    from fingerdesign.mold.moved_section import Move

    none = np.zeros(len(off))
    far, turned = off.T
    return [Move(far, none, none), Move(none, far, none), Move(none, none, turned)]


def _moved(
    mesh: Mesh, frames: tuple[PlateFrame, ...], move: Move
) -> tuple[Mesh, float, tuple[PlateFrame, ...]]:
    """The mesh after a change, or after the largest share of it that the mesh can follow."""
    from fingerdesign.mold.moved_section import moved_mesh

    share = 1.0
    while True:
        part = move.scaled(share)
        try:
            return moved_mesh(mesh, frames, part), share, part.of(frames)
        except MeshError:
            share *= 0.5
            if share < _LEAST_SHARE:
                raise


def _effect(
    design: Design,
    frames: tuple[PlateFrame, ...],
    off: Array,
    right: Array,
    apart: Array,
    shares: list[float],
    scene: Scene,
) -> Effect:
    """The record of readings ``right`` (rows, gages) and of changes ``apart`` (3, rows, gages)."""
    most = np.abs(right).max(axis=1)
    heard = most > _READS
    if not heard.any():
        raise SolverError("no gage reads anything in the section")
    share = np.abs(apart[:, heard]) / most[heard][:, None]
    together = np.sqrt((share**2).sum(axis=0))
    sizes = [float(off[:, 0].max()), float(off[:, 0].max()), float(off[:, 1].max())]
    changes = [
        {"name": name, "largest": sizes[k], "unit": "mm" if k < 2 else "degrees"}
        | _summary(share[k], frames)
        | {"share_solved": shares[k]}
        for k, name in enumerate(CHANGES)
    ]
    cover = _covers(design, frames)
    gages = [
        {"plate": frame.index, "x_mm": round(frame.place, 4), "surface_mm": round(cover[k], 4)}
        | {name: float(share[j, :, k].max()) for j, name in enumerate(CHANGES)}
        | {"together": float(together[:, k].max())}
        for k, frame in enumerate(frames)
    ]
    found: Effect = {
        "tolerance_mm": sizes[0],
        "angle_deg": sizes[2],
        "changes": changes,
        "together": _summary(together, frames),
        "gages": gages,
        "friction_coefficient": _FRICTION,
        "increments_mm": [[round(value, 5) for value in row[:2]] for row in scene.path.rows],
        "largest_reading_microstrain": [float(value) for value in most],
    }
    return found | {"sentences": _sentences(design, found)}


def _summary(share: Array, frames: tuple[PlateFrame, ...]) -> Effect:
    """RMS and worst of shares (rows, gages), and whose the worst is."""
    worst = int(share.max(axis=0).argmax())
    return {
        "rms": float(np.sqrt((share**2).mean())),
        "worst": float(share.max()),
        "worst_plate": frames[worst].index,
    }


def _covers(design: Design, frames: tuple[PlateFrame, ...]) -> list[float]:
    """Height of the surface above each plate's centre, mm."""
    from fingerdesign.design.layout import surface_height

    places = np.array([frame.place for frame in frames])
    heights = surface_height(design.body, places)
    return [float(h - frame.y) for h, frame in zip(heights, frames, strict=True)]


def _sentences(design: Design, found: Effect) -> list[str]:
    """What the numbers say, for the report."""
    from fingerdesign.design.layout import plate_frames

    x, y, turned = found["changes"]
    both = found["together"]
    said = [
        f"A plate {x['largest']:.2g} mm off along x changes its reading by up to "
        f"{_percent(x['worst'])} of the largest, {y['largest']:.2g} mm off in height by up to "
        f"{_percent(y['worst'])}, turned by {turned['largest']:.2g} degrees by up to "
        f"{_percent(turned['worst'])}; together by up to {_percent(both['worst'])}, "
        f"{_percent(both['rms'])} root mean square."
    ]
    worst = max(found["gages"], key=lambda each: float(each["in_height"]))
    said.append(
        f"Height counts most for plate {worst['plate']} at x = {worst['x_mm']:g} mm, "
        f"{worst['surface_mm']:.3g} mm below the surface."
    )
    partial = [each["name"] for each in found["changes"] if each["share_solved"] < 1.0]
    if partial:
        said.append(
            f"Plates lie too close for the whole change ({', '.join(partial).replace('_', ' ')}): "
            "a part was solved and enlarged in proportion."
        )
    if design.body.shape not in ("arc", "block") or not design.extruded:
        said.append("In plane strain, of a finger that is not its mid-section throughout: a guide.")
    if any(frame.span < design.body.depth_mm - 1e-9 for frame in plate_frames(design)):
        said.append("Legs of embedded plates stay in the rubber; the section does not show them.")
    else:
        said.append("Legs are trimmed flush with the rubber, which moves no plate.")
    return said


def _percent(share: float) -> str:
    """A share in percent, two digits.

    >>> _percent(0.0312), _percent(1.234)
    ('3.1 %', '120 %')
    """
    value = 100.0 * share
    if value >= 10.0:
        value = round(value, 1 - math.floor(math.log10(value)))
        return f"{value:.0f} %"
    return f"{value:.2g} %"
