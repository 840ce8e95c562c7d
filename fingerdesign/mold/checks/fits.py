"""Whether each part is sound, what is planned is there, and pins and keys fit.

Parts' triangles; the least slot, hole, pin, wall and web of the plan against what process and comb
hold; planned holes and plates in the triangles as they are made; gaps in the closed mold.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.layout.volume import plate_volume
from fingerdesign.mold.checks.assembly import (
    Assembly,
    areas,
    curved_area,
    heights,
    pairs,
    topology,
)
from fingerdesign.mold.part import BASE, Check, PartMesh, volume
from fingerdesign.mold.plan.plan import (
    Bolt,
    Key,
    Limits,
    MoldPlan,
    Pin,
    SidePlan,
    Slot,
    limits_of,
)
from fingerdesign.mold.plan.slots import least_slot, least_web, webs

# The kernel merges vertices closer than 1e-7 mm; anything flatter than this is rounding.
LEAST_HEIGHT_MM = 1e-6
VOLUME_SHARE = 1e-3
EXACT_SHARE = 1e-6  # of the kernel's own volumes
SINGLE = 2.0**-24


def part_checks(part: PartMesh, chord_mm: float) -> list[Check]:
    """Topology, triangles, volume and chord of one part. Rubber alone may enclose a core."""
    found, name = topology(part.triangles), part.name
    least = float(heights(part.vertices, part.triangles).min())
    flat = f"{name}: the flattest of {len(part.triangles)} triangles is {least:.2g} mm high"
    chord = f"{name}: triangles leave the exact surface by at most {part.chord:.4f} mm"
    one = found.shells == 1 or part.made == "silicone"

    def none_of(title: str, count: int, unit: str, what: str) -> Check:
        return Check.most(title, name, count, 0.0, unit, f"{name}: {count or 'no'} {what}")

    shells, whole = f"{name}: {found.shells} shells of triangles", least > LEAST_HEIGHT_MM
    return [
        none_of("watertight", found.open_edges, "edges", "edges that two triangles do not share"),
        none_of("winding", found.turned_edges, "edges", "edges that two triangles run alike"),
        none_of("manifold", found.extra_fans, "vertices", "vertices where shells merely touch"),
        Check("one shell", name, one, float(found.shells), 1.0, "shells", shells),
        Check("no degenerate triangles", name, whole, least, LEAST_HEIGHT_MM, "mm", flat),
        _written(part),
        _volume(part),
        Check.most("chord", name, part.chord, chord_mm, "mm", chord),
    ]


def _written(part: PartMesh) -> Check:
    """STL holds single precision: vertices that become one there would open or pinch the mesh."""
    used = np.unique(part.triangles)
    rounded = part.vertices[used].astype(np.float32)
    lost = len(used) - len(np.unique(rounded, axis=0))
    sentence = f"{part.name}: {lost} of {len(used)} vertices fall onto others in single precision"
    return Check.most("as written", part.name, lost, 0.0, "vertices", sentence)


def _volume(part: PartMesh) -> Check:
    """Triangles within a chord of a curved face enclose at most chord times its area more or less:
    holes, smaller as polygons, leave a wall heavier. Vertices are single."""
    found = volume(part.vertices, part.triangles)
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


AROUND = 12
ALONG = (0.25, 0.5, 0.75)
_REACH_MM = 50.0
_ROUND_MM = 0.05  # a round face may be this far off its radius in triangles


def fit_checks(assembly: Assembly) -> list[Check]:
    """The least gap of every pin and key against the clearance that was planned."""
    found = [
        check
        for number, pin in enumerate(assembly.plan.pins, 1)
        for check in _pin(assembly, number, pin)
    ]
    return found + [_key(assembly, key) for key in assembly.plan.keys]


def far(solid: Manifold, start: Array, way: Array) -> float:
    """How far along a ray a solid's surface is first met, mm; infinite: nowhere near."""
    hits = solid.ray_cast(tuple(start.tolist()), tuple((start + _REACH_MM * way).tolist()))
    return _REACH_MM * hits[0].distance if hits else float("inf")


def _pin(assembly: Assembly, number: int, pin: Pin) -> list[Check]:
    """A pin in its socket and in the combs that it passes; and in a jig's sheets, which rest on it:
    their holes are moved by the clearance, so that the pins hold the clamp."""
    solids = assembly.solids
    free = (pin.into, *(name for name in solids if name.startswith("comb_")))
    resting = tuple(name for name in solids if name.startswith("jig_"))
    what = f"pin {number} of {pin.on} in {pin.into}"
    found = [_fit(assembly, what, pin.into, _least_gap(assembly, pin, free), pin.clearance)]
    least = _least_gap(assembly, pin, resting) if resting else np.inf
    if np.isfinite(least):
        what = f"pin {number} of {pin.on} in the jig's sheets"
        found.append(_fit(assembly, what, pin.into, least, 0.0))
    return found


def _least_gap(assembly: Assembly, pin: Pin, names: tuple[str, ...]) -> float:
    """The least gap, mm, of a pin to parts beside it; infinite where there is none."""
    root, axis = np.array(pin.root), np.array(pin.direction)
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(axis, helper) / np.linalg.norm(np.cross(axis, helper))
    second = np.cross(axis, first)
    reach = 0.5 * pin.length if pin.dowel else pin.length
    lean = np.arctan2(0.5 * (pin.diameter - pin.tip_diameter), pin.length)
    gaps = []
    for share in ALONG:
        start, radius = root + share * reach * axis, 0.5 * pin.diameter
        radius += 0.5 * share * (pin.tip_diameter - pin.diameter)
        for a, b in _ring(1.0)[:-1]:
            way = a * first + b * second
            # Beyond the skin it still is within the part that it stands on.
            skin = radius if pin.dowel else far(assembly.solids[pin.on], start, way)
            if skin < radius + _ROUND_MM:
                beside = min(far(assembly.solids[name], start, way) for name in names)
                gaps.append((beside - skin) * np.cos(lean))
    return float(min(gaps, default=np.inf))


def _key(assembly: Assembly, key: Key) -> Check:
    low, high = np.array(key.low), np.array(key.high)
    along = 2 if high[2] - low[2] > high[0] - low[0] else 0
    side = np.eye(3)[2 - along]
    lean = np.cos(np.radians(key.draft_deg))
    gaps = [np.inf]
    for share in ALONG:
        start = 0.5 * (low + high)
        start[along] = low[along] + share * (high[along] - low[along])
        for way, slope in ((side, lean), (-side, lean), (np.array([0.0, 1.0, 0.0]), 1.0)):
            out = far(assembly.solids[key.into], start, way)
            if np.isfinite(out):
                gaps.append(slope * (out - far(assembly.solids[BASE], start, way)))
    return _fit(assembly, f"key of {BASE} in {key.into}", key.into, min(gaps), key.clearance)


def _fit(assembly: Assembly, what: str, part: str, least: float, planned: float) -> Check:
    """A socket's chords lie inside its circle, by at most a chord."""
    bound = planned - assembly.chord - 1e-6
    if not np.isfinite(least):
        return Check("clearance", part, False, None, planned, "mm", f"{what}: there is none")
    sentence = f"{what}: least gap {least:.3f} mm, {planned:g} mm planned"
    return Check.least("clearance", part, least, bound, sentence)


# A hole that was filled leaves every part sound and the block filled; only the plan knows of it.
INSET = 0.9  # of a hole's radius: where rays pass that must meet nothing
SLACK_MM = 0.02  # of a measured diameter, chords of round holes apart
_BEYOND_MM = 0.5
_NEAR_FACE = 0.05  # of the plate's thickness, from its faces


def hole_checks(assembly: Assembly) -> list[Check]:
    """The base plate's holes are open and as wide as planned, bolts pass, plates are all there."""
    return [_open(assembly), _widths(assembly), _bolts(assembly), _plates(assembly)]


def _ring(radius: float) -> Array:
    """Places (n, 2) around a hole's axis, and on it."""
    turns = 2.0 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
    ring = radius * np.column_stack([np.cos(turns), np.sin(turns)])
    return np.vstack([ring, np.zeros((1, 2))])


def _passes(solid: Manifold, hole: Bolt) -> bool:
    """Whether nothing of a solid stands in a round hole."""
    at = _ring(0.5 * INSET * hole.diameter) + np.array([hole.first, hole.second])
    starts, ends = (
        np.insert(at, 1 if hole.axis == "y" else 2, level, axis=1)
        for level in (hole.low - _BEYOND_MM, hole.high + _BEYOND_MM)
    )
    return not any(solid.ray_cast(start, end) for start, end in pairs(starts, ends))


def _open(assembly: Assembly) -> Check:
    plan, closed = assembly.plan, []
    for hole in plan.base_holes:
        bar = Bolt("y", hole.x, hole.z, -plan.base, 0.0, "", hole.diameter)
        if not _passes(assembly.solids[BASE], bar):
            closed.append(f"{hole.kind} at ({hole.x:.2f}, {hole.z:.2f})")
    right = f"{BASE}: each of {len(plan.base_holes)} planned holes is open"
    words = f"{BASE}: {len(closed)} planned holes are closed, first of them the {{0}}"
    return Check.none("open holes", BASE, closed, "holes", right, words)


def _widths(assembly: Assembly) -> Check:
    """The greatest error of any diameter at both faces: the undercut of locks, too."""
    plan, worst, words = assembly.plan, 0.0, f"{BASE}: has no holes"
    solid = assembly.solids[BASE]
    for hole in plan.base_holes:
        for share in (_NEAR_FACE, 1.0 - _NEAR_FACE):
            planned = hole.diameter + share * (hole.outer_diameter - hole.diameter)
            start = np.array([hole.x, -share * plan.base, hole.z])
            ways = np.insert(_ring(1.0)[:-1], 1, 0.0, axis=1)
            reach = planned + 1.0
            found = []
            for a, b in pairs(np.tile(start, (AROUND, 1)), start + reach * ways):
                hits = solid.ray_cast(a, b)
                found.append(2.0 * reach * hits[0].distance if hits else np.inf)
            off = float(np.abs(np.array(found) - planned).max())
            if off >= worst:
                worst = off
                words = (
                    f"{BASE}: diameters of holes are within {off:.3f} mm of the plan; the worst, "
                    f"the {hole.kind} at ({hole.x:.2f}, {hole.z:.2f}), is planned {planned:.3f}"
                )
    bound = SLACK_MM + 2.0 * assembly.chord
    if not np.isfinite(worst):
        return Check("widths of holes", BASE, False, None, bound, "mm", words)
    return Check.most("widths of holes", BASE, worst, bound, "mm", words)


def _bolts(assembly: Assembly) -> Check:
    closed = [
        f"bolt {number} ({bolt.size} along {bolt.axis}) in {part.name}"
        for number, bolt in enumerate(assembly.plan.bolts, 1)
        for part in assembly.meshes.parts
        if not _passes(assembly.solids[part.name], bolt)
    ]
    right = f"each of {len(assembly.plan.bolts)} bolts passes all parts on its way"
    words = f"{len(closed)} times a bolt meets a part: first {{0}}"
    return Check.none("bolts pass", "", closed, "places", right, words)


def _plates(assembly: Assembly) -> Check:
    """Every plate of the plan is in the mold, no other, and each is no less than its span."""
    plan = assembly.plan
    made = {plate.name: plate.volume for plate in assembly.meshes.plates}
    wanted = {f"plate_{frame.index}": plate_volume(frame) for frame in plan.frames}
    wrong = sorted(set(made) ^ set(wanted))
    wrong += [name for name in wanted if name in made and made[name] < 0.999 * wanted[name]]
    right = f"all {len(wanted)} plates of the plan are in the mold"
    words = f"{len(wrong)} plates are missing, too many or too small: first {{0}}"
    return Check.none("plates", "", wrong, "plates", right, words)


_ROUNDING_MM = 1e-9
ROOM_MM = 0.005  # beside a plate and its shim, or they cannot be pushed in


def plan_checks(design: Design, plan: MoldPlan) -> list[Check]:
    """One check a kind of feature: its least size against its limit."""
    limits = limits_of(design.mold)
    walls = [plan.wall_x, plan.wall_z, plan.top - plan.crest, plan.base]
    holes = [d for hole in plan.base_holes for d in (hole.diameter, hole.outer_diameter)]
    holes += [bolt.diameter for bolt in plan.bolts]
    holes += [pin.diameter for pin in plan.core_pins]
    clearances = [pin.clearance for pin in plan.pins] + [key.clearance for key in plan.keys]
    found = [
        _least("planned walls", "", walls, limits.wall_mm, "wall, insert or base plate"),
        _least("planned holes", "", holes, limits.hole_mm, "round hole"),
        _least("planned pins", "", [p.diameter for p in plan.pins], limits.pin_mm, "pin"),
        _least("planned clearances", "", clearances, limits.clearance_mm, "clearance"),
    ]
    for side in plan.sides:
        if side.slots:
            found += _side(design, plan, side, limits)
    return found


def _side(design: Design, plan: MoldPlan, side: SidePlan, limits: Limits) -> list[Check]:
    least = least_slot(design, side.holding, limits)
    web = least_web(design, side.holding, limits)
    room = [slot.width - slot.shim - plan.thickness[slot.plate] for slot in side.slots]
    leads = [_for_leads(side, slot) for slot in side.slots if slot.wire > 0.0]
    wire = max((slot.wire for slot in side.slots), default=0.0)
    where, between = f"side {side.side}", webs(side.slots)[2]
    return [
        _least("planned slots", where, [s.width for s in side.slots], least, f"slot of {where}"),
        _least(
            "room of plates", where, room, ROOM_MM, f"room beside a plate and its shim, {where}"
        ),
        _least("leads pass", where, leads, wire, f"hole for a plate's leads, {where},"),
        _least("planned webs", where, between.tolist(), web, f"web of {where}"),
    ]


def _for_leads(side: SidePlan, slot: Slot) -> float:
    """Diameter that is free for leads beside a leg anywhere in its slot, mm.

    A jig's two holes are shifted against each other; a leg's end may stand in the hole's edge.
    """
    centre = np.hypot(slot.relief_centre[0] - slot.place, slot.relief_centre[1] - slot.y)
    reaches = 0.5 * slot.length - (centre - 0.5 * slot.relief)  # into the slot
    return float(slot.relief - max(reaches, 0.0) - 2.0 * side.shift)


def _least(name: str, where: str, sizes: Sequence[float], bound: float, what: str) -> Check:
    """Of nothing, nothing is too small."""
    title = f"{name}, {where}" if where else name
    least = min(sizes, default=np.inf)
    if not np.isfinite(least):
        return Check(title, "", True, None, bound, "mm", f"there is no {what}")
    sentence = f"the least {what} is {least:.3f} mm, {bound:g} mm are needed"
    return Check.least(title, "", least, bound, sentence, _ROUNDING_MM)
