"""Holes through the base plate: vents, gate, riser, locks, leads, and screws into a core; mm.

The mold is cast with its base up and tilted by ``TILT_DEG`` so that the corner of the first vent
is the highest: level plates and the core's face then let their bubbles go. All air gathers below
the base plate; each of its free regions gets a vent at its highest place, and one at the opposite
corner for the way back. The gate is away from the plates where it can, so that no poured thread
falls on one, and far from the first vent: where the tilted mold is lowest. Riser and locks are
placed where there is most room; all are shrunk to it down to the least hole, and wider outside:
cured, they hold the finger. An open mold is level, has no base plate while it is poured, and no
vents, gate and riser in it. The gages' leads leave through it, at the front.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.step import step_facts
from fingerdesign.mold.plan.limits import SPARE_MM
from fingerdesign.mold.plan.pieces import BaseHole, Box, HoleKind
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.refusals import Refusal

TILT_DEG = 5.0
VENT_MM = 1.0  # of vents that are not given
UNDERCUT = 1.3  # outer diameter of gate, riser and locks over that at y = 0
_ROUNDING_MM = 2e-6
_EDGE_MM = 0.1  # from a hole to the finger's edge and to the core
_GRID = 81  # places along each axis that are tried
_OPENINGS: list[HoleKind] = ["gate", "riser", "lock", "lock", "lock", "lock", "lock", "lock"]
_SHARES = (1.0, 0.8, 0.65, 0.5, 0.4, 0.3, 0.2)  # of the gate's diameter that are tried
_LEAST_GATE_MM = 1.5  # of a gate away from the plates: the tip of a small syringe goes in
_NEARLY = 0.8  # of the largest such gate: the farthest from the vent of all that are as wide
_FILLED = 0.5  # of a hole for leads: what bundles take of it
_POCKET = 2.0  # its diameter over that of the hole for leads: a knot stays in it
_LEAST_POCKET_MM = 0.3
# Clearance hole and pilot hole of a core's screws, mm (ISO 273, medium; drill for cut threads).
_SCREWS = ((2.4, 1.6), (1.8, 1.25))


@dataclass(frozen=True)
class _Base:
    """Places (n, 2) in the finger's base, how far each is from edge and core, (n,), what is full.

    region: the number (n,) of the connected region around the core that each lies in
    clear: distance (n,) of each from what lies below it of plates; infinite without any
    """

    places: Array
    room: Array
    region: IntArray
    web: float
    clear: Array

    def free(self, holes: list[BaseHole]) -> Array:
        """The greatest radius (n,) of a hole's outer end at each place, clear of ``holes``."""
        free = self.room.copy()
        for hole in holes:
            dx, dz = (self.places - [hole.x, hole.z]).T
            free = np.minimum(free, np.hypot(dx, dz) - hole.radius - self.web)
            if hole.pocket:  # the channel of its leads to the front
                away = np.hypot(dx, np.minimum(dz, 0.0)) - 0.5 * hole.diameter
                free = np.minimum(free, away - self.web)
        return free

    def lead_out(self, holes: list[BaseHole], wide: float) -> BoolArray:
        """True for places (n,) from which such a channel runs to the front clear of ``holes``."""
        free = np.ones(len(self.places), dtype=bool)
        for hole in holes:
            dx, dz = ([hole.x, hole.z] - self.places).T
            away = np.hypot(dx, np.minimum(dz, 0.0)) - hole.radius
            free &= away >= 0.5 * wide + self.web
        return free


def base_holes_of(plan: MoldPlan) -> tuple[tuple[BaseHole, ...], list[Refusal]]:
    """Place a closed mold's holes in its base, the highest vent first; refuse what has no room."""
    mold, limits = plan.design.mold, plan.limits
    base, box = _base(plan), core_below(plan)
    vent = max(VENT_MM, limits.hole_mm) if mold.vent_mm is None else mold.vent_mm
    screws = _screws(box)
    for corners in (3, 1):  # on a small base the gate comes before further vents
        vents = _vents(base, vent, limits.hole_mm, corners)
        wires = _wires(plan, base, [*vents, *screws])
        holes = [*vents, *screws, *(wires or ())]
        gate, lock = max(mold.gate_mm, limits.hole_mm), max(mold.lock_mm, limits.hole_mm)
        openings = _openings(base, holes, gate, lock, limits.hole_mm)
        if openings is not None and wires is not None:
            break
    of_core, found = "core, " if box is not None else "", list[Refusal]()
    numbers = {"limits": limits, "core": of_core}
    if len(vents) < 2:
        found.append(Refusal("no_hole", "mold.vent_mm", vent, {**numbers, "what": "two vents"}))
    if openings is None:
        of = {**numbers, "what": "gate and riser"}
        found.append(Refusal("no_hole", "mold.gate_mm", mold.gate_mm, of))
    if wires is None:
        found.append(_no_leads(plan, f"{of_core}vents and "))
    return (*holes, *(openings or ())), found


def core_below(plan: MoldPlan) -> Box | None:
    """Corners of a core that rests on the base; None: there is none."""
    return None if plan.core is None or plan.core[0][1] != 0.0 else plan.core


def _no_leads(plan: MoldPlan, holes: str) -> Refusal:
    numbers = {"limits": plan.limits, "bundles": len(plan.frames), "holes": holes}
    return Refusal("no_leads", "mold.wire_mm", plan.design.mold.wire_mm, numbers)


def open_holes_of(plan: MoldPlan) -> tuple[BaseHole, ...] | Refusal:
    """Place the holes of an open mold's base plate: for leads, and locks, as many as have room; or
    refuse leads that have none."""
    base, least = _base(plan), plan.limits.hole_mm
    holes = _wires(plan, base, [])
    if holes is None:
        return _no_leads(plan, "")
    for _ in range(_OPENINGS.count("lock")):
        hole = _largest(base, holes, "lock", max(plan.design.mold.lock_mm, least), least)
        holes += [] if hole is None else [hole]
    return tuple(holes)


def _wires(plan: MoldPlan, base: _Base, holes: list[BaseHole]) -> list[BaseHole] | None:
    """Holes for all bundles of leads, as near to the front as they can be, in the middle of it:
    one, or several smaller ones where that has no room, or without pockets where these have none.
    None: there is no room."""
    bundles, wire, limits = len(plan.frames), plan.design.mold.wire_mm, plan.limits
    if not bundles or wire <= 0.0 or plan.design.mold.leads == "leg":
        return []
    deep = plan.base - limits.wall_mm - _EDGE_MM
    counts = range(1, min(bundles, 4) + 1)
    pockets = (True, False) if deep >= _LEAST_POCKET_MM else (False,)
    for with_pocket, count in product(pockets, counts):
        each = math.ceil(bundles / count)
        wide = max(limits.hole_mm, wire * (math.sqrt(each / _FILLED) if each > 1 else 1.2))
        pocket = min(deep, wide) if with_pocket else 0.0
        outer = _POCKET * wide if pocket else wide
        found: list[BaseHole] = []
        for _ in range(count):
            others = [*holes, *found]
            fits = base.free(others) >= 0.5 * outer
            if pocket:
                fits &= base.lead_out(others, wide)
            if not fits.any():
                break
            x, z = base.places[fits].T
            best = np.lexsort((np.abs(x), -z))[0]
            found.append(BaseHole("wires", float(x[best]), float(z[best]), wide, outer, pocket))
        if len(found) == count:
            return found
    return None


def _openings(
    base: _Base, holes: list[BaseHole], gate: float, lock: float, least: float
) -> list[BaseHole] | None:
    """Gate, riser and locks; the gate is shrunk until a riser half as wide and two locks fit.

    None where there is no room for both gate and riser.
    """
    tried = (_as_many(base, holes, max(share * gate, least), lock, least) for share in _SHARES)
    possible = []
    for found in (each for each in tried if len(each) >= 2):
        if len(found) >= 4 and found[1].diameter >= 0.5 * found[0].diameter:
            return found
        possible.append(found)
    return max(possible, key=lambda each: (len(each), each[1].diameter), default=None)


def _as_many(
    base: _Base, holes: list[BaseHole], gate: float, lock: float, least: float
) -> list[BaseHole]:
    """Gate, riser and locks, as many as have room; no more rises in the riser than is poured."""
    found: list[BaseHole] = []
    for kind in _OPENINGS:
        diameter = lock if kind == "lock" else gate
        if kind == "riser":
            diameter = min(diameter, found[0].diameter)
        hole = _gate(base, holes, diameter, least) if kind == "gate" else None
        hole = hole or _largest(base, [*holes, *found], kind, diameter, least)
        if hole is None:
            break
        found.append(hole)
    return found


def _base(plan: MoldPlan) -> _Base:
    from scipy.ndimage import label

    web, box = plan.limits.wall_mm, core_below(plan)
    x, z = np.meshgrid(
        np.linspace(-plan.half_width, plan.half_width, _GRID),
        np.linspace(-plan.half_depth, plan.half_depth, _GRID),
        indexing="ij",
    )
    places = np.column_stack([x.ravel(), z.ravel()])
    room = _inside(plan, places)
    if box is not None:
        room = np.minimum(room, _outside(places, box[1][[0, 2]]))
    region = label(room.reshape(x.shape) > 0.0)[0].ravel().astype(np.int64)
    edge = (np.array([plan.mount_x, plan.mount_z]) - np.abs(places)).min(axis=1)  # of the plate
    room = np.minimum(room - _EDGE_MM, edge - web - SPARE_MM)
    return _Base(places, room, region, web, _from_plates(plan, places))


def _outside(places: Array, halves: Array) -> Array:
    """Distance (n,) of places (n, 2) from a rectangle about the middle; negative within it."""
    away = np.abs(places) - halves
    return np.asarray(
        np.linalg.norm(np.maximum(away, 0.0), axis=1) + np.minimum(away.max(axis=1), 0.0)
    )


def _from_plates(plan: MoldPlan, places: Array) -> Array:
    """Distance (n,) of places (x, z) from the shadow of every plate; negative within one."""
    found = np.full(len(places), np.inf)
    for frame in plan.frames:
        angle = np.radians(frame.angle_deg)
        half = 0.5 * (frame.length * abs(np.cos(angle)) + frame.thickness * abs(np.sin(angle)))
        middle, halves = np.array([frame.place, frame.middle]), np.array([half, 0.5 * frame.span])
        if frame.along == "z":
            middle, halves = middle[::-1], halves[::-1]
        found = np.minimum(found, _outside(places - middle, halves))
    return found


def _gate(base: _Base, holes: list[BaseHole], diameter: float, least: float) -> BaseHole | None:
    """A gate away from the plates, far from the first vent; None: there is no room for one."""
    free = 2.0 * np.minimum(base.free(holes) / UNDERCUT, base.clear)
    size, low = np.minimum(diameter, free), min(max(least, _LEAST_GATE_MM), diameter)
    if not len(size) or size.max() < low - 1e-9:
        return None
    good = np.flatnonzero(size >= max(low, _NEARLY * size.max()) - 1e-9)
    vent = next(((hole.x, hole.z) for hole in holes if hole.kind == "vent"), (0.0, 0.0))
    away = np.linalg.norm(base.places[good] - vent, axis=1)
    return _best(base, "gate", good, away, size)


def _best(base: _Base, kind: HoleKind, good: IntArray, score: Array, size: Array) -> BaseHole:
    """The hole at the best of ``good`` places by their ``score``; size: (n,), of every place."""
    best = good[int(np.argmax(np.round(score, 6)))]
    wide = float(np.floor(1000.0 * (size[best] + _ROUNDING_MM)) / 1000.0)
    x, z = base.places[best].tolist()
    return BaseHole(kind, x, z, wide, UNDERCUT * wide)


def _inside(plan: MoldPlan, places: Array) -> Array:
    """Distance (n,) by which places of y = 0 lie inside the finger's base; negative outside."""
    body = plan.design.body
    if body.kind.turned:
        return np.asarray(plan.half_width - np.hypot(*places.T))
    half = np.array([plan.half_width, plan.half_depth])
    within = (half - np.abs(places)).min(axis=1)
    if body.step is None:
        return np.asarray(within)
    points = np.column_stack([places[:, 0], np.zeros(len(places)), places[:, 1]])
    faces = [face for face in step_facts(body.step).faces if face.name == "base"]
    outside = np.min([face.border.beyond(points / plan.scale) for face in faces], axis=0) > 0.0
    border = np.min([face.border.distance(points / plan.scale) for face in faces], axis=0)
    return np.asarray(np.minimum(within, plan.scale * np.where(outside, -border, border)))


def _vents(base: _Base, diameter: float, least: float, corners: int) -> list[BaseHole]:
    """Place vents at the highest place of each region, then at further ``corners`` with room."""
    found: list[BaseHole] = []
    ways = [np.array(way) for way in ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))]
    targets = [(ways[0], number) for number in range(1, int(base.region.max(initial=0)) + 1)]
    # The highest of all regions first: the mold is tilted toward it.
    height = base.places @ ways[0]
    targets.sort(key=lambda w: -float(height[base.region == w[1]].max()))
    targets += [(way, 0) for way in ways[1 : 1 + corners]]
    sizes = [diameter] if diameter <= least else [diameter, 0.5 * (diameter + least), least]
    for way, number in targets:
        for size in sizes:
            fits = base.free(found) >= 0.5 * size
            fits &= (base.region == number) if number else (base.places * way > 0.0).all(axis=1)
            if fits.any():
                best = np.flatnonzero(fits)[np.argmax(base.places[fits] @ way)]
                x, z = base.places[best].tolist()
                found.append(BaseHole("vent", x, z, size, size))
                break
    return found


def _largest(
    base: _Base, holes: list[BaseHole], kind: HoleKind, diameter: float, least: float
) -> BaseHole | None:
    """A hole where it is largest, up to ``diameter``; among those the farthest from its kind."""
    free = base.free(holes)
    size = np.minimum(diameter, 2.0 * free / UNDERCUT)
    if not len(size) or not size.max() >= least - 1e-9:
        return None
    good = np.flatnonzero(size >= size.max() - 1e-6)
    others = [(hole.x, hole.z) for hole in holes if hole.kind in ("gate", "riser", "lock")]
    away = [np.linalg.norm(base.places[good] - at, axis=1) for at in others or [(0.0, 0.0)]]
    score = np.min(away, axis=0) if others else -away[0]
    return _best(base, kind, good, score, size)


def _screws(box: Box | None) -> list[BaseHole]:
    """One or two holes for screws into a core that rests on the base."""
    wide, deep = (0.0, 0.0) if box is None else (float(box[1][0]), float(box[1][2]))
    # Half a diameter of core is left at each side of the pilot hole.
    for hole, pilot in (each for each in _SCREWS if min(wide, deep) >= each[1]):
        most = max(wide, deep) - 1.5 * pilot
        places = (-0.9 * most, 0.9 * most) if 1.8 * most >= hole + 1.0 else (0.0,)
        at = [(place, 0.0) if wide >= deep else (0.0, place) for place in places]
        return [BaseHole("screw", x, z, hole, hole) for x, z in at]
    return []
