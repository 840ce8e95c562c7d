"""Effect of a plate off its place on its gage's reading: placement tolerance in terms of strain.

Plates among each other, which a fixture holds to within its tolerance: three one-sided changes, by
the tolerance along x, by it in height, turned by the angle that it allows over the leg's width;
each once of all plates alike and once of every second plate the other way. Alone, a plate's own
change is the mean of the two but for what farther plates do, so that it is at most the larger,
which counts. The whole row against the contact surface ("row" of the record): insert and walls are
placed by pins, to within their clearance and the process's tolerance.

The section z = 0 in plane strain is pressed and sheared with the plates in their places and after
each change. Changes of a reading are relative to the largest one of their row, and the three count
together as the root of the sum of their squares.
"""

import math
import time
from typing import Any

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.readings import readings_of
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import in_wide_zone, one_thread, zone_of
from fingerdesign.arrays import Array
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError, MeshError, SolverError
from fingerdesign.layout.bodies import crest_height, surface_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.moved import moved_frames, moved_mesh
from fingerdesign.mesh.section.plates import section_sizes
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import Mesh
from fingerdesign.mold.plan.fixture.outer import bow
from fingerdesign.mold.plan.limits import comb_tolerance
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.notes import effect_sentences, unknown_effect

# Distance of a leg from the face of a slot that it is pushed against by hand, under a lens, until
# clay holds it. It is assumed: half a tenth of a millimetre is seen well at ten times.
_BY_HAND_MM = 0.05
CHANGES = ("along_x", "in_height", "turned")
_READS = 1e-6  # microstrain: a row whose largest reading is below it has none to be relative to
_DEEPEST = 0.1 / 8.22  # approach over the crest's height: that of the fundamental case on maeno2000
_ROWS = ((0.5, 0.0), (1.0, 0.0), (1.0, 0.4), (1.0, 0.8))  # approach, shear over the deepest
_FRICTION = 0.5
_LEAST_SHARE = 0.1  # of a change that the mesh cannot follow whole
# A mesh twice as coarse as [mesh.section] says gives what finer ones do: turned plates change
# maeno2000's readings by 0.1366 (rms) at factors 2, 1 and 0.6, others by within 2 % of each other.
_COARSER, _GRADATION = 2.0, 0.3

Effect = dict[str, Any]


def readings(
    design: Design, mesh: Mesh, frames: tuple[PlateFrame, ...], zone: Zone, scene: Scene
) -> Array:
    """Compute what the gages of ``frames`` read (rows, frames), microstrain, along a scene's path.

    Raises SolverError where a row has no answer, ZoneExhausted where the candidates do not do.
    """
    from fingerdesign.fem.body import condense_body
    from fingerdesign.fem.model import body_of, candidate_facets
    from fingerdesign.fem.readout import gage_rows
    from fingerdesign.fem.reduction import reduced_model

    body = body_of(design, mesh, candidate_facets(mesh, zone.half_width))
    condensed = condense_body(body, [gage_rows(mesh, frames, design.gages, design.gage_weights)])
    centres = np.vstack([frame.to_space(frame.centre, frame.middle) for frame in frames])
    reduced = reduced_model(
        condensed,
        gage_readout=condensed.readouts[0],
        gage_positions=centres,
        depth=design.body.depth_mm,
    )
    problem = problem_at_touch(reduced, scene.object, design.body)
    with one_thread():
        return readings_of(follow_path(problem, scene, design), design.gages.face).reading


def placement_effect(design: Design, plan: MoldPlan, sizes: SectionMesh | None = None) -> Effect:
    """The effect of the fixture's tolerance on the gages, as plain values for the record.

    "reason": None, or a sentence why there are no numbers (and then nothing but it and the
    sentences). "changes": for each of CHANGES its size (``largest`` over the
    plates, ``unit``), ``rms`` and ``worst`` of what it does to readings, over gages and rows, as
    shares of a row's largest reading, with the ``worst_plate`` (``rms_alike``, ``rms_opposed``: of
    the two ways alone). "together": the same of all three. "row": "tolerance_mm", "changes"
    and "together" of the row as a whole. "gages": a row a plate, the worst of its rows. sizes: of
    the mesh, instead of twice the design's.
    """
    start = time.perf_counter()
    frames, reason = section_plates(design)
    if reason is None:
        try:
            found = _measured(design, plan, frames, sizes)
        except FingerDesignError as error:
            reason = f"the section could not be analysed: {error}"
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
    design: Design, plan: MoldPlan, frames: tuple[PlateFrame, ...], sizes: SectionMesh | None
) -> Effect:
    whole = design.plates.model_copy(update={"model": "solid"})  # they are cast, whatever the model
    design = design.model_copy(update={"plates": whole})
    scene = scene_for(design)
    zone = zone_of(Case(design, scene, grips=False, fields=False), scene)
    off = np.array([tolerances(plan, frame.index) for frame in frames])

    def work(zone: Zone) -> Effect:
        return _in_zone(design, plan, frames, off, zone, scene, sizes)

    return in_wide_zone(design, zone, work)


def _in_zone(
    design: Design,
    plan: MoldPlan,
    frames: tuple[PlateFrame, ...],
    off: Array,
    zone: Zone,
    scene: Scene,
    sizes: SectionMesh | None,
) -> Effect:
    sizes = _coarser(design, zone) if sizes is None else sizes
    mesh = mesh_section(design, zone.half_width, sizes, frames)
    right = readings(design, mesh, frames, zone, scene)
    most = np.abs(right).max(axis=1)
    sampled = most > _READS
    if not sampled.any():
        raise SolverError("no gage reads anything in the section")

    def changed(moves: list[Array]) -> tuple[Array, Array]:
        """Shares (moves, rows, gages) of a row's largest reading; of each move what was solved."""
        changes, solved = [], []
        for move in moves:
            moved, share = _moved(mesh, frames, move)
            after = moved_frames(frames, share * move)
            changes.append((readings(design, moved, after, zone, scene) - right) / share)
            solved.append(share)
        return np.abs(np.array(changes)[:, sampled]) / most[sampled][:, None], np.array(solved)

    ways, solved = changed(_moves(frames, off))
    ways = ways.reshape(-1, 3, *ways.shape[1:])
    solved = solved.reshape(-1, 3).min(axis=0)
    share = ways.max(axis=0)
    sizes_off = [round(float(off[:, k].max()), 6) for k in (0, 0, 1)]
    changes = [
        _change(k, sizes_off[k], share[k], solved[k], frames)
        | {"rms_alike": _rms(ways[0, k]), "rms_opposed": _rms(ways[-1, k])}
        for k in range(3)
    ]
    row_off = row_tolerances(plan)
    rows, part = changed([np.tile(way, (len(frames), 1)) for way in np.diag([*row_off, 0.0])[:2]])
    together = np.sqrt((share**2).sum(axis=0))
    found: Effect = {
        "tolerance_mm": sizes_off[0],
        "angle_deg": sizes_off[2],
        "changes": changes,
        "together": _summary(together, frames),
        "gages": _gages(design, frames, share, together),
        "friction_coefficient": scene.object.friction_coefficient,
        "increments_mm": [[round(value, 5) for value in row[:2]] for row in scene.path.rows],
        "largest_reading_microstrain": [float(value) for value in most],
    }
    row: Effect = {
        "tolerance_mm": round(max(row_off), 6),
        "seated": plan.seam > 0.0,
        "changes": [_change(k, round(row_off[k], 6), rows[k], part[k], frames) for k in range(2)],
        "together": _summary(np.sqrt((rows**2).sum(axis=0)), frames),
    }
    return found | {"sentences": effect_sentences(design, found, row), "row": row}


def _change(
    k: int, largest: float, share: Array, solved: float, frames: tuple[PlateFrame, ...]
) -> Effect:
    """One of CHANGES, up to ``largest``, and its shares (rows, gages) of the readings; how much of
    it was ``solved``."""
    head = {"name": CHANGES[k], "largest": largest, "unit": "mm" if k < 2 else "degrees"}
    return head | _summary(share, frames) | {"share_solved": float(solved)}


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


def _moves(frames: tuple[PlateFrame, ...], off: Array) -> list[Array]:
    """The three changes of plates that may be off by ``off`` (k, 2), mm and degrees: of all alike,
    then of every second one the other way."""
    order = np.argsort(np.argsort([frame.place for frame in frames]))
    second = np.where(order % 2, -1.0, 1.0)
    signs = (np.ones(len(frames)), second) if len(frames) > 1 else (second,)
    return [row * (sign[:, None] * off)[:, [0, 0, 1]] for sign in signs for row in np.eye(3)]


def _moved(mesh: Mesh, frames: tuple[PlateFrame, ...], move: Array) -> tuple[Mesh, float]:
    """The mesh after a change, or after the largest share of it that the mesh can follow."""
    share = 1.0
    while True:
        try:
            return moved_mesh(mesh, frames, share * move), share
        except MeshError:
            share *= 0.5
            if share < _LEAST_SHARE:
                raise
