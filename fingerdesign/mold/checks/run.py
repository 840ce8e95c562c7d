"""Checks of a built mold on its triangles: each with a measured number, a bound and a sentence."""

from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.volume import (
    core_volume,
    enclosed_volume,
    outline_volume,
    plate_volume,
)
from fingerdesign.mold.checks.assembly import (
    Assembly,
    areas,
    assemble,
    bounds,
    curved,
    curved_area,
    from_slot,
    inside,
    oriented,
    pairs,
    place_text,
    planned,
    seen_from,
    sound,
    surface_points,
)
from fingerdesign.mold.checks.venting import vent_check
from fingerdesign.mold.part import (
    BASE,
    BASE_FRAME,
    CORE,
    OUTER,
    RUBBER,
    Check,
    MoldMeshes,
    PartMesh,
    axis_name,
)
from fingerdesign.mold.plan.leg_room import EDGE_DEG
from fingerdesign.mold.plan.plan import MoldPlan, SidePlan, direction
from fingerdesign.mold.products.drawing import flat_patterns

SEED = 7


def run_checks(design: Design, plan: MoldPlan, meshes: MoldMeshes) -> tuple[Check, ...]:
    """Everything that is checked of a mold, its parts, one plate of each kind and its rubber.

    Parts whose triangles are not those of a solid cannot be cut with each other: then only their
    own checks are returned, and one that says so.
    """
    assembly, chord = assemble(design, plan, meshes), design.mold.chord_mm
    kinds = {f"plate_{pattern.plates[0]}" for pattern in flat_patterns(design, plan)}
    plates = (plate for plate in meshes.plates if plate.name in kinds)
    found = [
        check
        for part in (*meshes.parts, *plates, meshes.rubber)
        for check in part_checks(part, assembly.solids[part.name], chord)
    ]
    broken = [name for name, solid in assembly.solids.items() if not sound(solid)]
    right = f"all {len(assembly.solids)} meshes are solids that can be cut with each other"
    words = (
        f"no solid, so cavity, walls, draws and vents could not be checked: {', '.join(broken)} "
        "(first of them {0})"
    )
    found.append(Check.none("solids", "", broken, "parts", right, words))
    if broken:
        return tuple(found)
    rng = np.random.default_rng(SEED)
    found.append(finger_check(assembly))
    found.append(backing_check(assembly, rng))
    found += wall_checks(assembly, rng)
    found += demolding_checks(assembly)
    found.append(vent_check(assembly))
    return tuple(found)


VOLUME_SHARE = 1e-3
EXACT_SHARE = 1e-6  # of the kernel's own volumes
SINGLE = 2.0**-24


def part_checks(part: PartMesh, solid: Manifold, chord_mm: float) -> list[Check]:
    """One closed solid, its volume and its chord. Rubber alone may enclose a core."""
    name, pieces = part.name, len(solid.decompose()) if sound(solid) else 0
    one = pieces == 1 or (pieces > 1 and part.made == "silicone")
    closed = f"{name}: its triangles are {pieces or 'no'} closed shell{'s' if pieces > 1 else ''}"
    chord = f"{name}: triangles leave the exact surface by at most {part.chord:.4f} mm"
    return [
        Check("watertight", name, one, float(pieces), 1.0, "shells", closed),
        _volume(part),
        Check.most("chord", name, part.chord, chord_mm, "mm", chord),
    ]


def _volume(part: PartMesh) -> Check:
    """Triangles within a chord of a curved face enclose at most chord times its area more or less:
    holes, smaller as polygons, leave a wall heavier. Vertices are single."""
    found = enclosed_volume(part.vertices, part.triangles)
    error = abs(found - part.volume) / abs(part.volume)
    rounded = SINGLE * float(np.abs(part.vertices).max())
    slack = part.chord * curved_area(part.vertices, part.triangles)
    slack += rounded * float(areas(part.vertices, part.triangles).sum())
    bound = slack / abs(part.volume) + EXACT_SHARE
    if part.made == "metal":  # a bent plate's two faces err alike
        bound = min(VOLUME_SHARE, bound)
    sentence = (
        f"{part.name}: its triangles enclose {found:.4f} mm^3, the exact solid "
        f"{part.volume:.4f} mm^3 ({error:.1e} apart)"
    )
    return Check.most("volume", part.name, error, bound, "1", sentence)


# Whether the cavity is the finger, enlarged: the exact solids' volumes say so. Parts that overlap
# or gape have another sum, unless both do by as much; those that overlap do not come off, either.

# The kernel's volumes are off by up to 1e-5 under edges that are neither lines nor circles.
FINGER_SHARE = 1e-4
# Flat faces meet, and slide, within rounding: a micrometre's thousandth, over the area.
FLAT_MM = 1e-6


def finger_check(assembly: Assembly) -> Check:
    """Cavity / scale^3 less plates and core is the body: metal does not shrink, rubber does."""
    design, plan, meshes = assembly.design, assembly.plan, assembly.meshes
    beside = (BASE, BASE_FRAME, CORE)  # these do not fill the block, nor do sheets outside of it
    filling = [p for p in meshes.parts if p.name not in beside and not p.name.endswith(OUTER)]
    inserts = sum(plate_volume(frame) for frame in plate_frames(design)) + core_volume(design)
    wanted = outline_volume(design.body) - inserts
    block = float(np.prod(np.array(meshes.high) - np.array(meshes.low)))
    cavity = block - sum(part.blank_volume for part in filling)
    found = cavity / plan.scale**3 - inserts
    error = abs(found - wanted) / wanted
    sentence = (
        f"cavity less shrinkage, plates and core: {found:.4f} mm^3; the finger's body in closed "
        f"form: {wanted:.4f} mm^3"
    )
    return Check.most("cavity is the finger", "", error, FINGER_SHARE, "1", sentence)


BACKED = 10000  # 0.08 mm^2 each on a finger of 800 mm^2
# A sheet's slot is wider than planned by no more than its fillets; seams are closed.
SLACK_MM = 0.05


def backing_check(assembly: Assembly, rng: np.random.Generator) -> Check:
    """Points two chords outside the outline must lie in a part, a plate or a planned opening."""
    outline = assembly.meshes.outline
    points, normals = surface_points(outline.vertices, outline.triangles, BACKED, rng)
    points = points[:BACKED] + 2.0 * assembly.chord * normals[:BACKED]
    left = ~planned(assembly.plan, points, assembly.limits.clearance_mm, SLACK_MM)
    wanted = int(left.sum())
    left[left] = ~_backed(assembly, points[left])
    # Triangles of two parts that meet along a curve leave slivers as thin as their chords.
    for way in 2.0 * assembly.chord * np.eye(3):
        left[left] = ~np.all([_backed(assembly, points[left] + s * way) for s in (-1, 1)], axis=0)
    bare = points[left]
    share = len(bare) / BACKED
    sentence = f"a part stands behind each of {wanted} points on the finger's surface"
    if len(bare):
        sentence = (
            f"{len(bare)} of {BACKED} points on the finger's surface have no part behind them, one "
            f"of them at {place_text(np.median(bare, axis=0))}"
        )
    return Check("surface backed by parts", "", not len(bare), share, 0.0, "1", sentence)


def _backed(assembly: Assembly, points: Array) -> BoolArray:
    """Whether points (n, 3) lie in a part or a plate, (n,)."""
    left = np.ones(len(points), dtype=bool)
    for part in (*assembly.meshes.parts, *assembly.meshes.plates):
        rest = np.flatnonzero(left)
        left[rest[inside(assembly.solids[part.name], points[rest])]] = False
    return ~left


# Whether the parts come off, one after another, along their draws.
#
# The part, moved by ever larger steps, must not overlap what is still there.

SLIDING = 0.3  # faces steeper to the draw part by more than a chord at the first step
# Undercuts bind at once, hooks later; a plate's leg is met while it is passed.
STEPS_MM = (0.05, 0.1, 0.2, 0.4, 0.8, 1.5, 3.0, 6.0, 12.0)


def demolding_checks(assembly: Assembly) -> list[Check]:
    """One check a part that is drawn: the greatest overlap on its way."""
    drawn = [part for part in assembly.meshes.parts if part.draw is not None]
    fixed = [part for part in assembly.meshes.parts if part.draw is None]
    staying = (RUBBER, *(each.name for each in (*assembly.meshes.plates, *fixed)))
    found = []
    for part in sorted(drawn, key=lambda each: each.order):
        # Those of one order that are drawn one way move together.
        apart = [p for p in drawn if p.order == part.order and p.draw != part.draw]
        left = [p.name for p in drawn if p.order > part.order or p in apart]
        found.append(_drawn(assembly, part, (*staying, *left)))
    return found


@dataclass(frozen=True)
class Obstacle:
    """What is still there while a part is drawn, with the corners of its box."""

    name: str
    solid: Manifold
    low: Array
    high: Array

    def shared(self, moved: Manifold) -> float:
        """Volume that it shares with a part whose box it reaches, mm^3."""
        low, high = bounds(moved)
        near = np.all(self.low < high) and np.all(low < self.high)
        return float((moved ^ self.solid).volume()) if near else 0.0


def _drawn(assembly: Assembly, part: PartMesh, there: tuple[str, ...]) -> Check:
    solid, draw = assembly.solids[part.name], np.array(part.draw)
    way = axis_name(draw.tolist())
    solids = [(name, assembly.solids[name]) for name in there]
    obstacles = [Obstacle(name, each, *bounds(each)) for name, each in solids]
    # How far it must be drawn until its box has parted from all others.
    far = max(max(each.low @ draw, each.high @ draw) for each in obstacles)
    clear = max(0.0, float(far - min(corner @ draw for corner in bounds(solid)))) + 1.0
    bound = _sliding(part, obstacles, assembly.chord)
    worst, where, name = 0.0, 0.0, ""
    for step in (step for step in STEPS_MM if step < clear):
        moved = solid.translate(tuple(step * draw))
        shares = {each.name: each.shared(moved) for each in obstacles}
        if sum(shares.values()) > worst:
            worst, where = sum(shares.values()), step
            name = max(shares, key=lambda each: shares[each])
    words = f"moved {clear:.1f} mm along {way} it passes everything that is still there"
    if worst > bound:
        words = f"{where:g} mm along {way} it overlaps {name} by {worst:.3g} mm^3"
    return Check.most("demolding", part.name, worst, bound, "mm^3", f"{part.name}: {words}")


def _sliding(part: PartMesh, obstacles: list[Obstacle], chord: float) -> float:
    """Overlap by triangles alone, mm^3: curved faces that slide along an obstacle lie up to two
    chords apart from where they should; flat ones meet within rounding."""
    units, sizes = oriented(part.vertices, part.triangles)
    sliding = curved(part.vertices, part.triangles)
    sliding &= np.abs(units @ np.array(part.draw)) < SLIDING
    rows = np.flatnonzero(sliding)
    beside = part.vertices[part.triangles[rows]].mean(axis=1) + 3.0 * chord * units[rows]
    taken = np.any([inside(each.solid, beside) for each in obstacles], axis=0)
    return float(2.0 * chord * sizes[rows[taken]].sum() + FLAT_MM * sizes.sum())


# How thin the parts are: rays inward from seeded points of their surfaces.
#
# A ray that ends on a face which looks the other way within 30 degrees has crossed a wall; one that
# ends on another face has crossed an edge, which making it blunts. Sharper edges count as thin
# walls.

WALL_POINTS = 2500  # and as many centroids: on 2500 mm^2 two in a square millimetre
OPPOSITE = np.cos(np.radians(EDGE_DEG))
_START_MM = 1e-6  # off the surface that the ray starts from
_NEAR_SLOT_MM = 0.05
_NEAR_PIN_MM = 0.02


def wall_checks(assembly: Assembly, rng: np.random.Generator) -> list[Check]:
    """Least wall of every part that is made, least web between the slots of those that hold."""
    found: list[Check] = []
    sides = {side.holder: side for side in assembly.plan.sides if side.slots}
    sides |= {side.outer_comb: side for side in assembly.plan.sides if side.outer_comb}
    for part in assembly.meshes.parts:
        if part.made not in ("process", "sheet"):
            continue
        points, normals = surface_points(part.vertices, part.triangles, WALL_POINTS, rng)
        found += _of_part(assembly, part, sides.get(part.name), points, normals)
    return found


def thicknesses(solid: Manifold, points: Array, normals: Array) -> Array:
    """Thickness (n,) mm of a solid at points (n, 3) of its surface, inward along outward normals;
    infinite where none is met."""
    low, high = bounds(solid)
    reach = float(np.linalg.norm(high - low))
    starts, ends = points - _START_MM * normals, points - reach * normals
    found = np.full(len(points), np.inf)
    for row, (start, end) in enumerate(pairs(starts, ends)):
        for hit in solid.ray_cast(start, end):
            distance = hit.distance * (reach - _START_MM)
            if distance > _START_MM:
                if float(np.dot(hit.normal, normals[row])) < -OPPOSITE:
                    found[row] = distance + _START_MM
                break
    return found


def _of_part(
    assembly: Assembly, part: PartMesh, side: SidePlan | None, points: Array, normals: Array
) -> list[Check]:
    """Walls, webs and sheets at points that lie on no pin; then these."""
    thick = thicknesses(assembly.solids[part.name], points, normals)
    limits, pins = assembly.limits, _on_pins(assembly.plan, part.name, points)
    if side is None:
        kinds = [("wall", ~pins, limits.wall_mm)]
    elif part.made == "sheet":
        flat = np.abs(normals @ direction(side.side)) > OPPOSITE
        kinds = [("sheet", flat, side.sheet), ("web", ~flat, assembly.design.mold.comb.web_mm)]
    else:
        slotted = _at_slots(side, points, normals, thick)
        kinds = [("wall", ~pins & ~slotted, limits.wall_mm)]
        kinds += [("web", ~pins & slotted, limits.feature_mm)]
    if pins.any():
        kinds.append(("pin", pins, limits.feature_mm))
    slack, found = 2.0 * part.chord + 1e-3, []  # a round hole's chords, and rounding
    for kind, where, bound in kinds:
        name = f"least {kind}"
        row = int(np.argmin(np.where(where, thick, np.inf)))
        least = thick[row]
        if not (where[row] and np.isfinite(least)):
            said = f"{part.name}: has no {kind}"
            found.append(Check(name, part.name, True, None, bound, "mm", said))
            continue
        said = f"{part.name}: {name} {least:.3f} mm, at {place_text(points[row])}; "
        said += f"{bound:g} mm can be made"
        found.append(Check.least(name, part.name, least, bound, said, slack))
    return found


def _on_pins(plan: MoldPlan, name: str, points: Array) -> BoolArray:
    """Points on the planned pins that stand on a part: their tips may be as thin as a feature."""
    found = np.zeros(len(points), dtype=bool)
    for pin in plan.pins:
        if pin.on != name or pin.dowel:
            continue
        away = points - np.array(pin.root)
        along = away @ np.array(pin.direction)
        radius = np.linalg.norm(away - along[:, None] * np.array(pin.direction), axis=1)
        near = (along > _START_MM) & (along < pin.length + _NEAR_PIN_MM)
        found |= near & (radius < 0.5 * pin.diameter + _NEAR_PIN_MM)
    return found


def _at_slots(side: SidePlan, points: Array, normals: Array, thick: Array) -> BoolArray:
    """Points with a slot's face at one end of their rays: between it and the other lies a web."""
    ends = points - np.where(np.isfinite(thick), thick, 0.0)[:, None] * normals
    found = np.zeros(len(points), dtype=bool)
    for slot in side.slots:
        for each in (points, ends):
            found |= np.abs(from_slot(slot, each)) < _NEAR_SLOT_MM
    place, _ = seen_from(side.side, normals)
    return np.asarray(found & (np.hypot(place, normals[:, 1]) > OPPOSITE))
