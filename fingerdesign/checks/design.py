"""Whether a design can exist, be meshed and be analysed as it asks.

One fault for one cause, with the worst value, the plates (numbered from 0, row by row) and a
computed remedy. Everything is in closed form; nothing here loads a CAD kernel.
"""

from collections.abc import Sequence

import numpy as np

from fingerdesign.checks.body import body_faults, sound_outline
from fingerdesign.checks.placing import placing_findings
from fingerdesign.checks.spacing import spacing_findings
from fingerdesign.design.faults import at_least, at_most
from fingerdesign.design.grip import Grip, lifting_tugs
from fingerdesign.design.mesh import mesh_file_faults
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design, Part
from fingerdesign.errors import Fault
from fingerdesign.layout.frames import (
    PlateRow,
    crest_height,
    plate_frames,
    plate_rows,
    surface_height,
)
from fingerdesign.layout.gaps import not_a_sheet
from fingerdesign.runtime.registry import MESHERS

# Faults between the keys of ``[grip]`` that say what is gripped, and with what hardware.

_LEAST_GAGES = 2
_FOLLOWED = 2.0  # time constants in which a press that lags is felt at its depth
_FELT_WITHIN = 1050  # samples that the bench's quick press is waited for (control/calibration.py)
_SWELLING = 0.02  # free strain: small strain is good to as much
_BENCH_SHEAR = 0.05  # of the preload: what the bench shears by (control/calibration.py)


def _drop_faults(grip: Grip) -> list[Fault]:
    """A length of slide that would be passed over: without inertia nothing slides."""
    if grip.inertia or grip.drop_mm == type(grip).model_fields["drop_mm"].default:
        return []
    remedy = "set grip.inertia = true, or leave it out: without inertia what slips has dropped"
    return [Fault("grip.drop_mm", grip.drop_mm, "left out where grip.inertia is false", remedy)]


def _lift_faults(grip: Grip) -> list[Fault]:
    events = [
        (f"grip.{table}[{k}]", each.step_after_lift)
        for table in ("tugs", "weight_changes")
        for k, each in enumerate(getattr(grip, table))
    ]
    if grip.plant != "lift":
        remedy = 'set grip.plant = "lift": there alone an object hangs from the fingers'
        faults = [Fault(key, "given", "left out", remedy) for key, _ in events]
        if grip.opposite != "mirror":
            faults.append(Fault("grip.opposite", grip.opposite, "'mirror'", remedy))
        if grip.hold_steps:
            faults.append(Fault("grip.hold_steps", grip.hold_steps, "0", remedy))
        if share := grip.relaxation_per_minute:
            faults.append(Fault("grip.relaxation_per_minute", share, "0", remedy))
        if grip.rubber_memory:
            faults.append(Fault("grip.rubber_memory", "given", "left out", remedy))
        if warmer := grip.warming_K:
            faults.append(Fault("grip.warming_K", warmer, "0", remedy))
        if grip.inertia:
            faults.append(Fault("grip.inertia", "true", "false", remedy))
        return faults
    bound, seen = f"at most grip.hold_steps = {grip.hold_steps}", set[int]()
    remedy = "hold the object on for longer, or begin sooner"
    late = [each for each in events if each[1] > grip.hold_steps]
    faults = [Fault(f"{key}.step_after_lift", step, bound, remedy) for key, step in late]
    if (share := grip.relaxation_per_minute) and grip.rubber_memory:
        both, one = "0 where grip.rubber_memory is given", "say either: both are the same rubber"
        faults.append(Fault("grip.relaxation_per_minute", share, both, one))
    for k, each in enumerate(grip.weight_changes):
        if (step := each.step_after_lift) in seen:
            key = f"grip.weight_changes[{k}].step_after_lift"
            faults.append(Fault(key, step, "a step of its own", "change the weight once"))
        seen.add(step)
    # Tugs that lift the object out of the fingers, wherever something else begins beside them.
    for k, least in lifting_tugs(grip.object_mass_g, grip.tugs, grip.weight_changes):
        force = grip.tugs[k].extra_force_N
        bound = f"no more upward than the weight allows, {-force + least:.3g} N"
        remedy = "tug less, or lift a heavier object"
        faults.append(Fault(f"grip.tugs[{k}].extra_force_N", force, bound, remedy))
    return faults


def _warming_faults(design: Design) -> list[Fault]:
    """A finger that warms must be known to expand."""
    if not (warmer := design.grip.warming_K):
        return []
    key, faults, parts = "grip.warming_K", [], set[Part]({"body"})
    if design.plates.number:
        parts.add("plates")
        if design.plates.model != "solid":
            bound, remedy = "0 where plates are no solids", 'set plates.model = "solid"'
            faults.append(Fault(key, warmer, bound, remedy))
    if design.body.core is not None:
        parts.add("core")
    if unknown := sorted(part for part in parts if design.expansion_of(part) is None):
        bound = f"0 where the expansion of the {' and the '.join(unknown)} is not known"
        faults.append(Fault(key, warmer, bound, "give expansion_per_K of its material"))
    most = max(design.expansion_of(part) or 0.0 for part in parts)
    if most * abs(warmer) > _SWELLING:
        bound = f"within {_SWELLING / most:.3g} K, where a material expands by {_SWELLING:.0%}"
        faults.append(Fault(key, warmer, bound, "warm less: strains are taken as small"))
    return faults


def _dead_gage_faults(design: Design, name: str, before: Sequence[int] = ()) -> list[Fault]:
    """Of one list of gages that fail; ``before``: those that have failed already."""
    dead, plates = list(getattr(design.grip.hardware, name)), design.plates.number
    pairs = design.gages.grid == "double_axial"
    bridges = plates // 2 if pairs else plates
    key, most = f"grip.hardware.{name}", max(bridges - _LEAST_GAGES - len(set(before)), 0)
    if len(set(dead)) < len(dead):
        return [Fault(key, dead, "each once", "say a plate once")]
    if wrong := [plate for plate in dead if plate >= plates]:
        bound = f"plates 0 to {plates - 1}" if plates else "empty: the design has no plates"
        return [Fault(key, wrong, bound, "name plates that there are")]
    if seconds := [plate for plate in dead if pairs and plate % 2]:
        bound = "even: the bridge of two plates goes by the first"
        return [Fault(key, seconds, bound, "name the plate before")]
    if both := sorted(set(dead) & set(before)):
        return [Fault(key, both, "other than grip.hardware.dead_gages", "say a plate once")]
    if len(dead) > most:
        remedy = f"leave {_LEAST_GAGES} gages that answer: a rig is calibrated by them"
        bound = f"at most {most} of the design's {bridges}"
        return [Fault(key, dead, f"{bound}, dead ones counted" if before else bound, remedy)]
    return []


def _stage_faults(grip: Grip) -> list[Fault]:
    """A stage that the finger cannot be calibrated with: so coarse that some of the bench's moves
    would be no move at all, or so slow that its quick press is not felt in time."""
    hardware, faults = grip.hardware, []
    step = hardware.stage_step_mm
    least = min(0.5 * grip.approach_step_mm, _BENCH_SHEAR * grip.preload_mm)
    if step > least:
        half = f"half of grip.approach_step_mm, {_BENCH_SHEAR:g} grip.preload_mm"
        remedy = "take a finer stage, or longer moves"
        bound = f"at most {least:.4g}: {half}"
        faults.append(Fault("grip.hardware.stage_step_mm", step, bound, remedy))
    samples = (_FELT_WITHIN - hardware.delay_samples) / _FOLLOWED
    if hardware.actuator_lag_s * hardware.sample_rate_Hz > samples:
        most = samples / hardware.sample_rate_Hz
        bound = f"at most {most:.4g}, {samples:g} samples: the bench's press is felt by then"
        remedy = "take a faster stage, a lower sample_rate_Hz or a shorter delay"
        faults.append(Fault("grip.hardware.actuator_lag_s", hardware.actuator_lag_s, bound, remedy))
    return faults


# Whether a scene suits a design: motions that the body can take, readout points inside it.

# Small strain is long past where the object has moved by half of the finger's height, and so is
# finite strain: rubber folds there.
MOST_MOTION = 0.5
MOST_TWIST_DEG = 10.0  # cos 10 degrees is 0.985: turns are taken as small
_LESS = "move the object less: no model here follows a finger so far"
_TURN_LESS = "turn the object less: rotations are taken as small"


def scene_faults(scene: Scene, design: Design) -> list[Fault]:
    """Every fault of a scene against a design; empty when it can be run.

    A body that cannot exist has its own fault: nothing is judged against it.
    """
    if body_faults(design.body):
        return []
    return _motion_faults(scene, design) + _point_faults(scene, design)


def _motion_faults(scene: Scene, design: Design) -> list[Fault]:
    if scene.path.control == "force":
        return _friction_faults(scene)
    limit = MOST_MOTION * crest_height(design.body)
    height = f"within {limit:.4g} mm, half of the finger's height"
    bounds = (
        (limit, f"an approach {height}", _LESS),
        (limit, f"a shear {height}", _LESS),
        (limit, f"a shear_z {height}", _LESS),
        (MOST_TWIST_DEG, f"a twist within {MOST_TWIST_DEG:g} degrees", _TURN_LESS),
    )
    faults: list[Fault] = []
    rows = np.array([[*row, 0.0, 0.0][:4] for row in scene.path.rows])
    for column, (most, bound, remedy) in enumerate(bounds):
        worst = int(np.argmax(np.abs(rows[:, column])))
        value = float(rows[worst, column])
        if abs(value) > most:
            faults.append(Fault(f"path.increments_mm[{worst}][{column}]", value, bound, remedy))
    return faults


def _friction_faults(scene: Scene) -> list[Fault]:
    """Forces that no friction carries on a plane: the worst row. Not of planes that slope along z,
    whose force may have a part there that is not prescribed."""
    across, down, along = scene.object.made().normal(np.zeros((1, 3)))[0]
    if not scene.object.flat or abs(along) > 1e-12:
        return []
    slope, angle = np.arctan2(across, -down), np.arctan(scene.object.friction_coefficient)
    low, high = (float(np.tan(slope + sign * angle)) for sign in (-1.0, 1.0))
    rows = np.array([row[:2] for row in scene.path.rows])
    over = np.maximum(rows[:, 1] - high * rows[:, 0], low * rows[:, 0] - rows[:, 1])
    worst = int(np.argmax(over))
    normal, tangential = (float(force) for force in rows[worst])
    if over[worst] <= 1e-6 * normal:
        return []
    bound = f"{low * normal:.4g} to {high * normal:.4g} N, what friction carries under {normal:g} N"
    remedy = "pull less, press harder, or prescribe the motion"
    return [Fault(f"{scene.path.key}[{worst}][1]", tangential, bound, remedy)]


def _point_faults(scene: Scene, design: Design) -> list[Fault]:
    points = np.array(scene.readout.points_mm).reshape(-1, 3)
    body = design.body
    across, along = 0.5 * body.width_mm, 0.5 * body.depth_mm
    x, y, z = points.T
    over = np.maximum(np.abs(x) - across, np.abs(z) - along)
    x, z = np.clip(x, -across, across), np.clip(z, -along, along)
    if body.kind.turned:
        radius = np.hypot(points[:, 0], points[:, 2])
        over = radius - across
        x, z = points[:, 0::2].T * np.minimum(1.0, across / np.maximum(radius, 1e-12))
    top = surface_height(body, x, z)
    beside = np.isnan(top)  # where a STEP body has no top
    top = np.where(beside, 0.0, top)
    over = np.maximum(np.maximum(over, np.where(beside, 1e-3, 0.0)), np.maximum(-y, y - top))
    outside = np.flatnonzero(over > 1e-9)
    if not len(outside):
        return []
    worst = int(np.argmax(over))
    others = [str(index) for index in outside if index != worst]
    also = f"; so are {', '.join(others[:8])}{' ...' if len(others) > 8 else ''}" if others else ""
    sides = f"|x| <= {across:g}, |z| <= {along:g}"
    if body.kind.turned:
        sides = f"x^2 + z^2 <= {across:g}^2"
    bound = f"inside the body: {sides}, 0 <= y <= {top[worst]:.4f} there"
    remedy = f"move it inside: it is {over[worst]:.4g} mm outside{also}"
    return [Fault(f"readout.points_mm[{worst}]", points[worst].tolist(), bound, remedy)]


# Whether plates can exist by themselves: slender, bent gently, perforated clear of their gage.

LEAST_SLENDERNESS = 4.0  # length / thickness; a stubbier box is no plate and bends like no plate
LEAST_BEND = 4.0  # bend radius / thickness: below it the strain across the plate is no plate's
MOST_BEND_DEG = 90.0  # from end to end of a bent plate
LEAST_METAL_MM = 0.1  # beside a hole
_LEAST_SLOPE = 0.03  # product of sin(2 angle) of a pair: 5 degrees either way


def plate_faults(design: Design) -> list[Fault]:
    """Every fault of the plates' own shape, one a key."""
    faults: dict[str, Fault] = {}
    for row in plate_rows(design):
        for fault in (*_slender(row), *_bent(row), *_holes(design, row)):
            faults.setdefault(fault.key, fault)
    return list(faults.values())


def _slender(row: PlateRow) -> list[Fault]:
    length, thickness = row.table.length_mm, row.table.thickness_mm
    least = LEAST_SLENDERNESS * thickness
    if length >= least:
        return []
    bound = f"at least {LEAST_SLENDERNESS:g} x plates.thickness_mm = {least:g}"
    thinner = at_most(length / LEAST_SLENDERNESS)
    remedy = f"lengthen the plate or lower plates.thickness_mm to at most {thinner}"
    return [Fault(row.key("length_mm"), length, bound, remedy)]


def _bent(row: PlateRow) -> list[Fault]:
    """A bent plate lies along the surface, and is bent to a radius that a plate can take."""
    table = row.table
    if not table.layout.bends:
        return []
    if table.angle_deg != 0.0:
        bound = "0 where plates.follow = 'bent': a bent plate lies along the surface"
        remedy = "set it to 0, or plates.follow = 'turned'"
        return [Fault(row.key("angle_deg"), table.angle_deg, bound, remedy)]
    radii = [frame.bend_radius for frame in row.frames if frame.bend_radius is not None]
    if not radii:
        return []
    least = max(LEAST_BEND * table.thickness_mm, table.length_mm / np.radians(MOST_BEND_DEG))
    sharpest = min(radii)
    if sharpest >= least - 1e-9:
        return []
    key, cover = row.key("cover_mm"), table.cover_mm
    bound = (
        f"such that plates are bent to a radius of {least:.4g} mm at least "
        f"({LEAST_BEND:g} thicknesses, {MOST_BEND_DEG:g} degrees in all; now {sharpest:.4g})"
    )
    lowered = cover - (least - sharpest)
    remedy = f"lower it to at most {at_most(lowered)}" if lowered > 0.01 else "shorten the plates"
    return [Fault(key, cover, bound, remedy)]


def _holes(design: Design, row: PlateRow) -> list[Fault]:
    """Holes leave metal at the plate's long sides, between each other, and below the gage."""
    table, gages = row.table, design.gages
    diameter, pitch = table.hole_diameter_mm, table.hole_pitch_mm
    if diameter is None:
        return []
    if diameter > table.length_mm - 2.0 * LEAST_METAL_MM + 1e-9:
        most = table.length_mm - 2.0 * LEAST_METAL_MM
        bound = f"at most {row.key('length_mm')} less {2.0 * LEAST_METAL_MM:g} = {most:g}"
        remedy = f"metal is left on both sides of a hole; raise {row.key('length_mm')} or lower it"
        return [Fault("plates.hole_diameter_mm", diameter, bound, remedy)]
    if pitch < diameter + LEAST_METAL_MM - 1e-9:
        least = diameter + LEAST_METAL_MM
        bound = f"at least plates.hole_diameter_mm + {LEAST_METAL_MM:g} = {least:g}"
        return [Fault("plates.hole_pitch_mm", pitch, bound, "holes would run into each other")]
    frame = row.frames[0]
    if not frame.holes:
        widest = 2.0 * (0.5 * frame.span - 1.5 * diameter)
        bound = (
            f"such that holes fit into the span of {frame.span:g}: a hole's diameter from its ends"
        )
        remedy = "lower plates.hole_diameter_mm or leave it out"
        if widest >= diameter + LEAST_METAL_MM:
            remedy = f"lower it to at most {at_most(widest)}"
        return [Fault("plates.hole_pitch_mm", pitch, bound, remedy)]
    away = min(abs(hole.w - frame.middle - gages.z_mm) for hole in frame.holes)
    wanted = 0.5 * (diameter + gages.width_mm)
    if away >= wanted - 1e-9:
        return []
    bound = f"such that no hole lies under the gage (a hole {away:.4g} mm from its middle)"
    least = 2.0 * (wanted + abs(gages.z_mm))
    remedy = f"raise it to at least {at_least(least)} or narrow the gage"
    if least > frame.span - 3.0 * diameter or gages.z_mm:
        remedy = "narrow the gage, make the holes smaller, or set gages.z_mm = 0"
    return [Fault("plates.hole_pitch_mm", pitch, bound, remedy)]


def gage_faults(design: Design) -> list[Fault]:
    """Gages longer or wider than the plates that carry them."""
    gages, rows = design.gages, plate_rows(design)
    faults = []
    row = min(rows, key=lambda each: each.table.length_mm)
    key, length = row.key("length_mm"), row.table.length_mm
    if gages.length_mm > length:
        remedy = f"shorten the gage or raise {key} to at least {gages.length_mm:g}"
        bound = f"at most {key} = {length:g}"
        faults.append(Fault("gages.length_mm", gages.length_mm, bound, remedy))
    row = min(rows, key=lambda each: each.frames[0].span)
    span, key = row.frames[0].span, row.key("span_mm")
    across = "z" if row.table.along == "x" else "x"
    if gages.width_mm > span:
        bound = f"at most the plate's span along {across}, {span:g}"
        remedy = f"narrow the gage or raise {key} to at least {gages.width_mm:g}"
        faults.append(Fault("gages.width_mm", gages.width_mm, bound, remedy))
    elif abs(gages.z_mm) + 0.5 * gages.width_mm > 0.5 * span + 1e-9:
        reach = 0.5 * (span - gages.width_mm)
        bound = f"within -{reach:g} ... {reach:g}, so that the gage lies on the plate"
        remedy = f"move it toward 0, narrow the gage or raise {key}"
        faults.append(Fault("gages.z_mm", gages.z_mm, bound, remedy))
    return faults + _bridge_faults(design) + _pair_faults(design)


def _bridge_faults(design: Design) -> list[Fault]:
    """A bridge that the grids cannot make."""
    gages = design.gages
    found = list(gages.bridges(design.material_of("plates").poissons_ratio))
    if gages.bridge is None or gages.bridge in found:
        return []
    faces = "both faces" if gages.faces == 2 else "one face"
    bound = f"{' or '.join(map(repr, found))} for {gages.grid} grids on {faces}"
    remedy = f"leave it out for '{found[-1]}'"
    if gages.faces == 1 and gages.bridge != "quarter":
        remedy += ", or set gages.face = 'both'"
    return [Fault("gages.bridge", gages.bridge, bound, remedy)]


def _pair_faults(design: Design) -> list[Fault]:
    """Two plates of one bridge lie at opposite angles, side by side in one row."""
    if design.gages.grid != "double_axial":
        return []
    for row in plate_rows(design):
        first, last = row.frames[0].index, row.frames[-1].index
        if len(row.frames) % 2:
            bound = f"'axial' or 'tee' for a row of {len(row.frames)} plates ({first} to {last})"
            remedy = f"give the row an even number of plates ({row.key('count')})"
            return [Fault("gages.grid", "double_axial", bound, remedy)]
        for one, two in zip(row.frames[::2], row.frames[1::2], strict=True):
            slopes = np.sin(np.radians([2.0 * one.angle_deg, 2.0 * two.angle_deg]))
            if slopes[0] * slopes[1] > -_LEAST_SLOPE:
                angles = f"{one.angle_deg:.4g} and {two.angle_deg:.4g} degrees"
                bound = f"'axial' or 'tee' for plates {one.index} and {two.index} at {angles}"
                remedy = "give a pair opposite angles: plates.alternate = true, or plates.placement"
                return [Fault("gages.grid", "double_axial", bound, remedy)]
    return []


MOST_MOVES = 5000  # a grip takes about 50


def design_faults(design: Design) -> list[Fault]:
    """Every fault of the geometry of a design whose keys are sound; empty when it can be built.

    Where plates lie is judged in a body that can exist, beside a core that fits into it; of any
    other, what plates and gages are by themselves.
    """
    body = body_faults(design.body)
    faults = body + _mesh_faults(design) + _grip_faults(design) + mesh_file_faults(design.mesh)
    if not design.plates.number:
        return faults
    shaped = all(fault.key.startswith("body.core.") for fault in body)
    left_out: dict[str, object] = {"core": None} if body else {}
    if not shaped:  # below a flat top
        left_out |= {"shape": "block", "edge_radius_mm": None, "dome_radius_mm": None}
    rest = design.model_copy(update={"body": design.body.model_copy(update=left_out)})
    own = plate_faults(rest) + gage_faults(rest)
    blamed = {fault.key for fault in own}
    placed = placing_faults(rest) if shaped else []
    return faults + own + [fault for fault in placed if fault.key not in blamed]


def placing_faults(design: Design) -> list[Fault]:
    """Every fault of where the plates lie in a sound body, with remedies that have been tried."""

    def keys(trial: Design) -> set[str]:
        wrong = body_faults(trial.body)
        if wrong or not sound_outline(trial.body):
            return {fault.key for fault in wrong} | {"body"}
        own = plate_faults(trial) + gage_faults(trial)
        found = placing_findings(trial) + spacing_findings(trial)
        return {each.key for each in found} | {fault.key for fault in own}

    every = placing_findings(design) + spacing_findings(design)
    before = {found.key for found in every}
    return [found.fault(design, before, keys) for found in every]


def is_sound(design: Design) -> bool:
    """Whether :func:`design_faults` finds nothing; faster where it does, for it seeks no remedy."""
    if body_faults(design.body) or _mesh_faults(design) or _grip_faults(design):
        return False
    among = (plate_faults, gage_faults, placing_findings, spacing_findings)
    return not (design.plates.number and any(found(design) for found in among))


def _grip_faults(design: Design) -> list[Fault]:
    """Faults of what is gripped and with what, of the stage's motions against each other and
    against the body."""
    grip = design.grip
    dead = grip.hardware.dead_gages
    faults = [
        *_lift_faults(grip),
        *_warming_faults(design),
        *_drop_faults(grip),
        *_dead_gage_faults(design, "dead_gages"),
        *_dead_gage_faults(design, "dying_gages", dead),
        *_stage_faults(grip),
    ]
    if grip.opposite == "bare" and design.mesh.mesher == "file":
        remedy = "the mesh's file holds the plates: take the mirror image"
        faults.append(Fault("grip.opposite", "bare", "'mirror' with mesh.mesher = 'file'", remedy))
    most = design.body.base_height_mm
    if grip.max_approach_mm > most:
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


def _mesh_faults(design: Design) -> list[Fault]:
    faults = []
    mesh = design.mesh
    why = MESHERS.find(mesh.mesher, "mesh.mesher").made.why_not(design)
    if why is not None:
        bound = f"'tetwild' for a finger that cannot be {why}"
        remedy = "set mesh.mesher = 'tetwild'"
        faults.append(Fault("mesh.mesher", mesh.mesher, bound, remedy))
    faults += _sheet_faults(design)
    for prefix, sizes in (("mesh", mesh), ("mesh.section", mesh.section)):
        if sizes.contact_size_mm > sizes.far_size_mm:
            bound = f"at most {prefix}.far_size_mm = {sizes.far_size_mm:g}"
            remedy = "lower it: far_size_mm is the largest size anywhere"
            key = f"{prefix}.contact_size_mm"
            faults.append(Fault(key, sizes.contact_size_mm, bound, remedy))
    return faults


def _sheet_faults(design: Design) -> list[Fault]:
    """Plates as sheets: flat, whole, of elements that bend."""
    plates = design.plates
    if plates.model != "sheet" or not plates.number:
        return []
    faults = []
    if design.mesh.element == "P1":
        bound = "'auto', 'P2' or 'mixed' for plates as sheets"
        remedy = "linear elements do not bend; leave mesh.element out"
        faults.append(Fault("mesh.element", "P1", bound, remedy))
    return faults + (tetwild_faults(design, False) if sound_outline(design.body) else [])


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
            reported = f"{bound} (it misses plate {missed[0]})"
            faults.setdefault(key, Fault(key, value, reported, "take --fidelity 3d"))
    return list(faults.values())
