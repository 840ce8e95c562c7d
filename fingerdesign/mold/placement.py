"""Effect of a plate off its place on its gage's reading: placement tolerance in terms of strain.

Plates among each other, which a fixture holds to within its tolerance: three changes, by the
tolerance along x, by it in height, turned by the angle that it allows over the leg's width; each
once of all plates alike and once of every second plate the other way. Alone, a plate's own change
is the mean of the two but for what farther plates do, so that it is at most the larger, which
counts. The whole row against the contact surface ("row" of the record): insert and walls are
placed by pins, to within their clearance and the process's tolerance.

The finger is pressed and sheared with the plates in their places, in plane strain (the section
z = 0) or in 3-D; changes are the derivatives of its readings times the tolerances, to first order.
They are relative to the largest reading of their row, and the three count together as the root of
the sum of their squares.
"""

import math
import time
from typing import Any

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import condense, in_wide_zone, make_mesh, zone_of
from fingerdesign.arrays import Array
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError, SolverError
from fingerdesign.fem.model import build_model
from fingerdesign.layout.bodies import crest_height, surface_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.plates import section_sizes
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mold.plan.fixture.outer import bow
from fingerdesign.mold.plan.limits import comb_tolerance
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.notes import effect_sentences, unknown_effect
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.model import meshed_for_grips
from fingerdesign.sensitivity.derive import Sensitivity, derivatives
from fingerdesign.sensitivity.variant import PLACES, differentiable, parameters_of

# Distance of a leg from the face of a slot that it is pushed against by hand, under a lens, until
# clay holds it. It is assumed: half a tenth of a millimetre is seen well at ten times.
_BY_HAND_MM = 0.05
CHANGES = ("along_x", "in_height", "turned")
_READS = 1e-6  # microstrain: a row whose largest reading is below it has none to be relative to
_DEEPEST = 0.1 / 8.22  # approach over the crest's height: that of the fundamental case on maeno2000
_ROWS = ((0.5, 0.0), (1.0, 0.0), (1.0, 0.4), (1.0, 0.8))  # approach, shear over the deepest
_FRICTION = 0.5
# A mesh twice as coarse as [mesh.section] says gives what finer ones do: turned plates change
# maeno2000's readings by 0.1366 (rms) at factors 2, 1 and 0.6, others by within 2 % of each other.
_COARSER, _GRADATION = 2.0, 0.3

Effect = dict[str, Any]


def placement_effect(
    design: Design,
    plan: MoldPlan,
    sizes: SectionMesh | None = None,
    fidelity: str = "plane-strain",
) -> Effect:
    """The effect of the fixture's tolerance on the gages, as plain values for the record.

    "reason": None, or a sentence why there are no numbers (and then nothing but it and the
    sentences). "changes": for each of CHANGES its size (``largest`` over the
    plates, ``unit``), ``rms`` and ``worst`` of what it does to readings, over gages and rows, as
    shares of a row's largest reading, with the ``worst_plate`` (``rms_alike``, ``rms_opposed``: of
    the two ways alone). "together": the same of all three. "row": "tolerance_mm", "changes"
    and "together" of the row as a whole. "std": of readings of fingers as made, any place within
    its tolerance being as likely, a share, RMS over gages and rows. "gages": a row a plate, the
    worst of its rows. sizes: of the section's mesh, instead of twice the design's; fidelity:
    "plane-strain" or "3d".
    """
    start = time.perf_counter()
    frames, reason = section_plates(design) if fidelity != "3d" else plates_in_space(design)
    if reason is None:
        try:
            found = _measured(design, plan, frames, sizes, fidelity)
        except FingerDesignError as error:
            reason = f"the finger could not be analysed: {error}"
    if reason is not None:
        return unknown_effect(reason)
    return {"reason": None, **found, "seconds": round(time.perf_counter() - start, 2)}


def section_plates(design: Design) -> tuple[tuple[PlateFrame, ...], str | None]:
    """The plates that the section z = 0 shows, or why there are none to be moved in it."""
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
    if design.gages.grid == "double_axial" and len(shown) < len(frames):
        return (), "the section z = 0 does not cut both plates of every pair"
    return shown, None


def plates_in_space(design: Design) -> tuple[tuple[PlateFrame, ...], str | None]:
    """All plates of a finger in 3-D, or why they are not moved there."""
    frames = plate_frames(design)
    if any(frame.along == "z" for frame in frames):
        return (), "plates in rows along z are not moved in 3-D"
    return frames, None if frames else "the finger has no plates"


def tolerances(plan: MoldPlan, plate: int) -> tuple[float, float]:
    """Distance (mm) and angle (degrees) by which a plate may be off, by the slots that hold it.

    A slot's place is off by the tolerance of the sheet (comb) or of the process (slots). One end of
    it may be off against the other by as much: an angle. Where a second comb pushes the leg against
    a face of its slot, that is all, and the bow of its middle. Else the plate is off by half of the
    larger play, across the slot or along it, and turns by the play over the leg's width; in the
    wide slots of a wall, where a hand pushes it against a face and an end, by what that leaves. Of
    a plate's two ends the worse one counts.
    """
    comb, process = comb_tolerance(plan.design.mold), plan.limits.tolerance_mm
    places, angles = [0.0], [0.0]
    for side, slot, width in plan.leg_slots:
        if slot.plate == plate:
            tolerance = comb if side.holding == "comb" else process
            if side.outer:
                places.append(tolerance + bow(plan, side))
                angles.append(math.degrees(math.atan(tolerance / width)))
                continue
            left = math.inf if side.holding == "comb" else _BY_HAND_MM
            play = min(max(slot.width - plan.thickness[plate], 0.0), left)
            places.append(tolerance + 0.5 * max(play, min(slot.length - width, left)))
            angles.append(math.degrees(math.atan(tolerance / slot.length + play / width)))
    return max(places), max(angles)


def row_tolerances(plan: MoldPlan) -> tuple[float, float]:
    """Distance by which the whole row may be off against the contact surface, along x and in
    height, mm.

    Where base plate and insert lie on the combs, these, cut with their slots in one go, are as high
    as the finger and have its profile: their tolerance counts, and in height the form of the
    insert's face that they stand on; along x, too, on a flat top, which only its rounded ends hold.
    A tilt of the surface against the base is not the row's. Else insert and walls are placed by
    pins: their clearance and the process's tolerance.
    """
    limits, cut = plan.limits, comb_tolerance(plan.design.mold)
    if plan.seam > 0.0:
        seated = cut + limits.form_mm
        return (seated if plan.design.body.kind.flat else cut), seated
    return (limits.clearance_mm + limits.tolerance_mm,) * 2


def scene_for(design: Design) -> Scene:
    """A plane pressed onto the finger, then sheared: the fundamental case in four rows, its motions
    in proportion to the finger's height."""
    deepest = _DEEPEST * crest_height(design.body)
    rows = [[deepest * approach, deepest * shear] for approach, shear in _ROWS]
    return Scene.model_validate(
        {"object": {"friction_coefficient": _FRICTION}, "path": {"increments_mm": rows}}
    )


def _measured(
    design: Design,
    plan: MoldPlan,
    frames: tuple[PlateFrame, ...],
    sizes: SectionMesh | None,
    fidelity: str,
) -> Effect:
    design = differentiable(design)  # plates are cast whole, whatever the design's model
    if fidelity == "3d":
        design = meshed_for_grips(design, fidelity)
    case = Case(design, scene_for(design), fidelity, grips=False, fields=False)

    def work(zone: Zone) -> Sensitivity:
        return place_slopes(case, frames, zone, sizes)

    found = in_wide_zone(design, zone_of(case, case.path_scene), work)
    return _effect(case, plan, frames, found)


def place_slopes(
    case: Case, frames: tuple[PlateFrame, ...], zone: Zone, sizes: SectionMesh | None
) -> Sensitivity:
    """Derivatives of the readings with the places of all ``frames``, axis by axis."""
    design, scene = case.design, case.path_scene
    if case.fidelity == "3d":
        model = condense(design, make_mesh(design, "3d", zone, case.symmetric), zone, scene)
    else:
        sizes = _coarser(design, zone) if sizes is None else sizes
        mesh = mesh_section(design, zone.half_width, sizes, frames)
        model = build_model(design, mesh, zone.half_width, frames=frames)
    problem = problem_at_touch(model.reduced, scene.object, design.body)
    names = tuple(f"placement[{k}].{axis}" for axis in PLACES for k in range(len(frames)))
    with one_thread():
        steps = follow_path(problem, scene, design)
    places = parameters_of(design, scene, names, frames)
    return derivatives(design, scene, model, problem, steps, places, stick=False)


def _effect(
    case: Case, plan: MoldPlan, frames: tuple[PlateFrame, ...], found: Sensitivity
) -> Effect:
    design, scene = case.design, case.path_scene
    most = np.abs(found.readings.reading).max(axis=1)
    sampled = most > _READS
    if not sampled.any():
        raise SolverError("no gage reads anything")
    slopes = found.reading[sampled] / most[sampled][:, None, None]
    slopes = np.moveaxis(slopes.reshape(*slopes.shape[:2], 3, len(frames)), 2, 0)
    off = np.array([tolerances(plan, frame.index) for frame in frames])[:, [0, 0, 1]]
    ways = np.abs(
        [np.einsum("argk,ka->arg", slopes, sign[:, None] * off) for sign in _signs(frames)]
    )
    share, sizes_off = ways.max(axis=0), [round(size, 6) for size in off.max(axis=0).tolist()]
    changes = [
        _change(k, sizes_off[k], share[k], frames)
        | {"rms_alike": _rms(ways[0, k]), "rms_opposed": _rms(ways[-1, k])}
        for k in range(3)
    ]
    row_off = row_tolerances(plan)
    rows = np.abs(slopes[:2].sum(axis=-1) * np.array(row_off)[:, None, None])
    together = np.sqrt((share**2).sum(axis=0))
    alone = ((slopes * off.T[:, None, None]) ** 2).sum(axis=(0, -1)) + (rows**2).sum(axis=0)
    effect: Effect = {
        "fidelity": case.fidelity,
        "tolerance_mm": sizes_off[0],
        "angle_deg": sizes_off[2],
        "changes": changes,
        "together": _summary(together, frames),
        "std": float(np.sqrt(alone.mean() / 3.0)),  # Of a uniform draw: the tolerance over root 3.
        "gages": _gages(design, frames, share, together),
        "friction_coefficient": scene.object.friction_coefficient,
        "increments_mm": [[round(value, 5) for value in row[:2]] for row in scene.path.rows],
        "largest_reading_microstrain": [float(value) for value in most],
    }
    row: Effect = {
        "tolerance_mm": round(max(row_off), 6),
        "seated": plan.seam > 0.0,
        "changes": [_change(k, round(row_off[k], 6), rows[k], frames) for k in range(2)],
        "together": _summary(np.sqrt((rows**2).sum(axis=0)), frames),
    }
    return effect | {"sentences": effect_sentences(design, effect, row), "row": row}


def _change(k: int, largest: float, share: Array, frames: tuple[PlateFrame, ...]) -> Effect:
    """One of CHANGES, up to ``largest``, and its shares (rows, gages) of the readings."""
    head = {"name": CHANGES[k], "largest": largest, "unit": "mm" if k < 2 else "degrees"}
    return head | _summary(share, frames)


def _summary(share: Array, frames: tuple[PlateFrame, ...]) -> Effect:
    """RMS and worst of shares (rows, gages), and whose the worst is."""
    worst = int(share.max(axis=0).argmax())
    return {"rms": _rms(share), "worst": float(share.max()), "worst_plate": frames[worst].index}


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def _gages(
    design: Design, frames: tuple[PlateFrame, ...], share: Array, together: Array
) -> list[Effect]:
    """A row a plate: the worst of its shares, alone (changes, rows, gages) and together."""
    surface = surface_height(design.body, np.array([frame.place for frame in frames]))
    worst = np.vstack([share.max(axis=1), together.max(axis=0)]).T.tolist()
    return [
        {
            "plate": frame.index,
            "x_mm": round(frame.place, 4),
            "surface_mm": round(float(height) - frame.y, 4),
            **dict(zip((*CHANGES, "together"), row, strict=True)),
        }
        for frame, height, row in zip(frames, surface, worst, strict=True)
    ]


def _coarser(design: Design, zone: Zone) -> SectionMesh:
    own = section_sizes(design, zone.half_width)
    names = ("contact_size_mm", "plate_size_mm", "plate_end_size_mm", "far_size_mm")
    wider = {name: _COARSER * getattr(own, name) for name in names}
    return own.model_copy(update=wider | {"gradation": max(own.gradation, _GRADATION)})


def _signs(frames: tuple[PlateFrame, ...]) -> list[Array]:
    """Signs (k,) of the plates' changes: all alike, then every second one the other way."""
    order = np.argsort(np.argsort([frame.place for frame in frames]))
    second = np.where(order % 2, -1.0, 1.0)
    return [np.ones(len(frames)), second] if len(frames) > 1 else [second]
