"""Air that stays while the mold is filled: high points of the rubber with no opening near.

The base is up: height grows along -y. An open mold is level and its base is its opening: air stays
only below what overhangs. In a closed one a level face holds air everywhere, so the mold is tilted
by a few degrees, one opening highest; air then runs along every face to the local high points of
the rubber, tilted as the casting notes say.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.mesh.cells import pieces
from fingerdesign.mold.checks.assembly import Assembly, from_pin, from_slot, place_text
from fingerdesign.mold.part import BASE, CORE, RUBBER, Check
from fingerdesign.mold.plan.base import TILT_DEG
from fingerdesign.mold.plan.pieces import Side, direction
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.solids import inside

# Beyond an opening's edge, at that tilt, air that stays is no higher than 0.26 mm.
REACH_MM = 3.0
_LEVEL_MM = 1e-7
_STEP_MM = 0.02  # a fifth of the thinnest plates: from a vertex into what is next to it
AIRING = ("gate", "riser", "vent", "lock")


@dataclass(frozen=True)
class HighPoint:
    """A local high place (of several vertices on one level the farthest from any opening), and how
    far beyond the nearest opening's edge it lies, mm."""

    place: Array
    beyond: float


def vent_check(assembly: Assembly) -> Check:
    """High points on the mold's own surface may hold no air; those under plates and core are
    reported (what frees them, bubbles' buoyancy or a vacuum, is a warning of the notes)."""
    poured = pour_turn(assembly.plan)
    found = [(p, p.beyond > REACH_MM and _under_metal(assembly, p)) for p in high_points(assembly)]
    under = sum(metal for _, metal in found)
    farthest = max((p for p, metal in found if not metal), key=lambda p: p.beyond, default=None)
    beyond = 0.0 if farthest is None else max(0.0, farthest.beyond)
    x, z = (float(np.round(value, 2)) + 0.0 for value in (np.cos(poured), np.sin(poured)))
    words = f"tilted by {TILT_DEG:g} degrees toward x, z = {x:g}, {z:g}, "
    if assembly.plan.pour == "open":
        words = "filled level, its base open, "
    if farthest is None or beyond <= REACH_MM:
        words += f"each high point has an opening within {beyond:.1f} mm"
    else:
        words += f"air stays at {place_text(farthest.place)}, {beyond:.1f} mm from any opening"
    words += f"; {under} high points lie under plates or core" if under else ""
    return Check.most("vents", BASE, beyond, REACH_MM, "mm", words)


def pour_turn(plan: MoldPlan) -> float:
    """Direction toward which the mold is tilted while it is filled: its first vent's corner, or +x
    +z without a vent; radians from +x toward +z."""
    vents = ((hole.x, hole.z) for hole in plan.holes["vent"])
    x, z = next(vents, (1.0, 1.0))
    return float(np.arctan2(np.sign(z) or 1.0, np.sign(x) or 1.0))


def high_points(assembly: Assembly) -> list[HighPoint]:
    """Local high places of the rubber, tilted as it is poured."""
    mesh, up = assembly.meshes.rubber, np.array([0.0, -1.0, 0.0])
    if assembly.plan.pour == "closed":
        up = upward(pour_turn(assembly.plan))
    found = []
    for group in _summits(mesh.vertices @ up, mesh.triangles):
        points = mesh.vertices[group]
        if inside(assembly.solids[RUBBER], points[:1] + _STEP_MM * up)[0]:
            continue  # the top of something that the rubber flows over
        beyond = beyond_openings(assembly.plan, points)
        worst = int(np.argmax(beyond))
        found.append(HighPoint(points[worst], float(beyond[worst])))
    return found


def upward(turn: float) -> Array:
    """Unit vector against gravity in the mold's axes, tilted toward ``turn``."""
    tilt = np.radians(TILT_DEG)
    level = np.array([np.cos(turn), 0.0, np.sin(turn)])
    return np.asarray(np.sin(tilt) * level - np.array([0.0, np.cos(tilt), 0.0]))


def beyond_openings(plan: MoldPlan, points: Array) -> Array:
    """Distance of points (n, 3) from the edge of the nearest opening that air leaves by, mm.

    A slot lets air out next to its plate, and a core pin's hole next to its pin: rubber is far
    slower in gaps of some hundredths of a millimetre.
    """
    found = np.full(len(points), np.inf)
    if plan.pour == "open":
        found = np.asarray(points[:, 1])
    for hole in (hole for hole in plan.base_holes if hole.kind in AIRING):
        level = np.hypot(points[:, 0] - hole.x, points[:, 2] - hole.z) - 0.5 * hole.diameter
        found = np.fmin(found, np.hypot(np.maximum(level, 0.0), points[:, 1]))
    beyond: list[tuple[Side, Array]]
    beyond = [(s.side, from_slot(slot, points)) for s in plan.sides for slot in s.slots]
    beyond += [(pin.side, from_pin(pin, points)) for pin in plan.core_pins]
    for side, far in beyond:
        out = plan.half(side) - points @ direction(side)
        found = np.fmin(found, np.hypot(np.maximum(far, 0.0), out))
    return found


def _summits(height: Array, triangles: IntArray) -> list[IntArray]:
    """Groups of vertices, level and joined by edges, that no neighbour of theirs is above."""
    first, second = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    level = np.abs(height[first] - height[second]) <= _LEVEL_MM
    count, labels = pieces(first[level], second[level], len(height))
    lower = np.zeros(count, dtype=bool)
    lower[labels[first[height[second] > height[first] + _LEVEL_MM]]] = True
    lower[labels[second[height[first] > height[second] + _LEVEL_MM]]] = True
    used = np.zeros(count, dtype=bool)
    used[labels[first]] = True
    return [np.flatnonzero(labels == label) for label in np.flatnonzero(used & ~lower)]


def _under_metal(assembly: Assembly, point: HighPoint) -> bool:
    """True where a plate or the core is right next to a high point."""
    steps = np.array(np.meshgrid(*[(-1.0, 0.0, 1.0)] * 3)).reshape(3, -1).T
    around = point.place + _STEP_MM * steps
    names = [CORE, *(plate.name for plate in assembly.meshes.plates)]
    solids = (assembly.solids[name] for name in names if name in assembly.solids)
    return any(bool(inside(solid, around).any()) for solid in solids)
