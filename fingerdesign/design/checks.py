"""Whether a design can exist, be meshed and be analysed as it asks.

One fault for one cause, with the worst value, the plates (numbered from 0, row by row) and a
computed remedy. Everything is in closed form; nothing here loads a CAD kernel.
"""

from __future__ import annotations

from collections.abc import Set

from fingerdesign.design.body_checks import body_faults, sound_outline
from fingerdesign.design.faults import involves
from fingerdesign.design.grip_checks import plant_faults
from fingerdesign.design.layers import lies_over, not_sweepable
from fingerdesign.design.layout import plate_frames
from fingerdesign.design.meshing import mesh_file_faults
from fingerdesign.design.placing import placing_findings
from fingerdesign.design.plate_checks import gage_faults, plate_faults
from fingerdesign.design.plate_rows import plate_rows, surface_keys
from fingerdesign.design.remedies import Finding
from fingerdesign.design.schema import Design
from fingerdesign.design.sheet_limits import not_a_sheet
from fingerdesign.design.spacing import spacing_findings
from fingerdesign.errors import Fault

Doubt = Set[str]  # dotted keys whose values are not the user's

MOST_MOVES = 5000  # a grip takes about 50
FLATTEST_MM = 1e4  # the largest body.arc_radius_mm


def design_faults(design: Design, doubtful: Doubt = frozenset()) -> list[Fault]:
    """Every fault of the geometry of a design whose keys are sound; empty when it can be built.

    ``doubtful``: keys that were faulty and have their default here; no fault that involves one of
    them is told.
    """
    faults = body_faults(design.body, doubtful) + _mesh_faults(design, doubtful)
    unsound = {fault.key for fault in faults if fault.key.startswith("body.")}
    faults += _grip_faults(design, doubtful)
    faults += [] if involves(doubtful, "mesh.file") else mesh_file_faults(design.mesh)
    many = ("plates.count", "plates.placement", "plates.rows")
    if not any(key in doubtful or "plates" in doubtful for key in many) and design.plates.number:
        faults += _plates_faults(design, doubtful, frozenset(unsound))
    return faults


def _plates_faults(design: Design, doubtful: Doubt, unsound: Doubt) -> list[Fault]:
    """The faults of the plates, below a sound body or one that stands in for it."""
    doubtful = doubtful | unsound
    whole = not involves(doubtful, "body.arc_radius_mm")
    if whole and sound_outline(design.body) and not involves(doubtful, "body.dome_radius_mm"):
        own = plate_faults(design, doubtful) + gage_faults(design, doubtful)
        told = {fault.key for fault in own}
        return own + [f for f in placing_faults(design, doubtful) if f.key not in told]
    # What is told must hold whatever the sound body: below the roundest arc and the flattest one.
    body = design.body.model_copy(update={"edge_radius_mm": None})
    if body.dome_radius_mm is not None:
        # The middle section of every sound dome is the arc's.
        body = body.model_copy(update={"shape": "arc", "dome_radius_mm": None})
        doubtful = doubtful | {"body.shape"}
    if body.shape not in ("arc", "revolved"):
        return []
    if involves(doubtful, "body.width_mm") and body.arc_radius_mm < 0.5 * body.width_mm:
        body = body.model_copy(update={"width_mm": 2.0 * body.arc_radius_mm})
    radii = (body.arc_radius_mm,) if whole else (0.5 * body.width_mm, FLATTEST_MM)
    found = []
    for radius in radii:
        stand_in = body.model_copy(update={"arc_radius_mm": radius})
        trial = design.model_copy(update={"body": stand_in})
        judged = doubtful if whole else doubtful - {"body.arc_radius_mm", "body"}
        own = plate_faults(trial, doubtful) + gage_faults(trial, doubtful)
        found.append(own + placing_faults(trial, judged, whole))
    both = {fault.key for fault in found[0]}
    return [fault for fault in found[-1] if fault.key in both]


def placing_faults(
    design: Design, doubtful: Doubt = frozenset(), whole: bool = True
) -> list[Fault]:
    """Every fault of where the plates lie that involves no ``doubtful`` key; the body is sound.

    Not ``whole``: those that are the same below any surface.
    """

    def findings(trial: Design) -> list[Finding]:
        return placing_findings(trial, doubtful, whole) + spacing_findings(trial, doubtful)

    def keys(trial: Design) -> set[str]:
        wrong = body_faults(trial.body, doubtful)
        if wrong or not sound_outline(trial.body):
            return {fault.key for fault in wrong} | {"body"}
        own = plate_faults(trial, doubtful) + gage_faults(trial, doubtful)
        return {found.key for found in findings(trial)} | {fault.key for fault in own}

    every = findings(design)
    before = {found.key for found in every}
    return [found.fault(design, before, keys) for found in every]


def is_sound(design: Design) -> bool:
    """Whether :func:`design_faults` finds nothing; faster where it does, for it seeks no remedy."""
    if body_faults(design.body, frozenset()) or _mesh_faults(design, frozenset()):
        return False
    if _grip_faults(design, frozenset()):
        return False
    if not design.plates.number:
        return True
    if plate_faults(design, frozenset()) or gage_faults(design, frozenset()):
        return False
    return not (placing_findings(design, frozenset()) or spacing_findings(design, frozenset()))


def _grip_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    """Faults of the stage's motions against each other and against the body."""
    grip = design.grip
    unsure = involves(doubtful, "grip", "plates.count", "plates.placement", "plates.rows")
    faults = [] if unsure else plant_faults(design)
    if involves(doubtful, "grip.max_approach_mm", "grip.preload_mm", "grip.approach_step_mm"):
        return faults
    most = design.body.base_height_mm
    if grip.max_approach_mm > most and not involves(doubtful, "body.base_height_mm"):
        bound = f"at most body.base_height_mm = {most:g}"
        remedy = "shorten the stage's travel: the model is of small strains"
        faults.append(Fault("grip.max_approach_mm", grip.max_approach_mm, bound, remedy))
    travel = f"at most grip.max_approach_mm = {grip.max_approach_mm:g}"
    for key in ("preload_mm", "approach_step_mm"):
        value = getattr(grip, key)
        if value > grip.max_approach_mm:
            faults.append(Fault(f"grip.{key}", value, travel, "the stage could not move so far"))
    if grip.preload_mm == grip.max_approach_mm:
        bound = f"below grip.max_approach_mm = {grip.max_approach_mm:g}"
        faults.append(Fault("grip.preload_mm", grip.preload_mm, bound, "leave travel to grip with"))
    least = grip.max_approach_mm / MOST_MOVES
    if grip.approach_step_mm < least:
        bound = f"at least grip.max_approach_mm / {MOST_MOVES} = {least:g}"
        remedy = "the travel would take too many moves"
        faults.append(Fault("grip.approach_step_mm", grip.approach_step_mm, bound, remedy))
    return faults


_SWEEP_KEYS = (
    "body.shape",
    "plates.along",
    "plates.hole_diameter_mm",
    "plates.count",
    "plates.placement",
    "plates.rows",
)
_PLACE_KEYS = (
    "body.depth_mm",
    "body.base_height_mm",
    "body.core",
    *(f"plates.{name}_mm" for name in ("span", "span_offset", "stagger", "length", "thickness")),
    *(f"plates.{name}" for name in ("pitch_mm", "cover_mm", "offset_mm", "angle_deg", "follow")),
)


def _mesh_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    faults = []
    mesh = design.mesh
    why = None
    if mesh.mesher == "extrude" and not involves(doubtful, "mesh.mesher", *_SWEEP_KEYS):
        why = not_sweepable(design)
        placed = not involves(doubtful, *_PLACE_KEYS, *surface_keys(design.body))
        if why is None and placed and sound_outline(design.body):
            why = lies_over(design)
    if why is not None:
        bound = f"'tetwild' for a finger that cannot be swept through layers ({why})"
        remedy = "set mesh.mesher = 'tetwild'"
        faults.append(Fault("mesh.mesher", mesh.mesher, bound, remedy))
    faults += _sheet_faults(design, doubtful)
    for prefix, sizes in (("mesh", mesh), ("mesh.section", mesh.section)):
        keys = (f"{prefix}.contact_size_mm", f"{prefix}.far_size_mm")
        if sizes.contact_size_mm > sizes.far_size_mm and not involves(doubtful, *keys):
            bound = f"at most {prefix}.far_size_mm = {sizes.far_size_mm:g}"
            remedy = "lower it: far_size_mm is the largest size anywhere"
            faults.append(Fault(keys[0], sizes.contact_size_mm, bound, remedy))
    return faults


def _sheet_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    """Plates as sheets: flat, whole, of elements that bend."""
    plates = design.plates
    if plates.model != "sheet" or not plates.number or involves(doubtful, "plates.model"):
        return []
    faults = []
    if design.mesh.element == "P1" and not involves(doubtful, "mesh.element"):
        bound = "'auto', 'P2' or 'mixed' for plates as sheets"
        remedy = "linear elements do not bend; leave mesh.element out"
        faults.append(Fault("mesh.element", "P1", bound, remedy))
    shape = ("plates.follow", "plates.hole_diameter_mm", "plates.rows", *surface_keys(design.body))
    if involves(doubtful, *shape) or not sound_outline(design.body):
        return faults
    for frame in plate_frames(design):
        why = not_a_sheet(frame)
        if why is not None:
            bound = f"'solid' or 'none' for plate {frame.index}: {why}"
            faults.append(Fault("plates.model", "sheet", bound, "set plates.model = 'solid'"))
            break
    return faults


def tetwild_faults(design: Design, symmetric: bool) -> list[Fault]:
    """What tetwild cannot mesh of a sound design, or (``symmetric``) of its half z >= 0: a sheet
    that stands in the symmetry plane."""
    if design.plates.model != "sheet":
        return []
    for frame in plate_frames(design):
        why = not_a_sheet(frame, half=symmetric)
        if why is not None:
            bound = f"'solid' or 'none' for plate {frame.index}: {why}"
            return [Fault("plates.model", "sheet", bound, "set plates.model = 'solid'")]
    return []


def plane_strain_faults(design: Design) -> list[Fault]:
    """What one section cannot show of a sound design: a step body, plates that it does not cut.

    A core that is not of full depth, domes, pins and plates of finite span are taken as they are
    in the section z = 0, and drawn straight.
    """
    if design.body.shape == "step":
        bound = "a parametric shape for --fidelity plane-strain: a STEP body's section is not taken"
        return [Fault("body.shape", "step", bound, "take --fidelity 3d")]
    faults: dict[str, Fault] = {}
    for row in plate_rows(design):
        if row.table.along == "z":
            bound = "'x' for --fidelity plane-strain: the section z = 0 shows no plate along z"
            key = row.key("along")
            faults.setdefault(key, Fault(key, "z", bound, "take --fidelity 3d"))
            continue
        missed = [frame.index for frame in row.frames if not frame.low < 0.0 < frame.high]
        if missed:
            name = "stagger_mm" if row.table.stagger_mm else "span_offset_mm"
            key, value = row.key(name), row.value(name)
            bound = "such that the section z = 0 cuts every plate, for --fidelity plane-strain"
            told = f"{bound} (it misses plate {missed[0]})"
            faults.setdefault(key, Fault(key, value, told, "take --fidelity 3d"))
    return list(faults.values())
