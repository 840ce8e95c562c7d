"""Check that the parts come off, one after another, along their draws.

A part, moved by ever larger steps, must not overlap what is still there.
"""

from collections.abc import Iterable

import numpy as np
from manifold3d import Manifold

from fingerdesign.mold.checks.assembly import Assembly
from fingerdesign.mold.part import RUBBER, Check, PartMesh, axis_name
from fingerdesign.mold.solids import bounds, curved, inside, oriented

SLIDING = 0.3  # faces steeper to the draw part by more than a chord at the first step
# Undercuts bind at once, hooks later; a plate's leg is met while it is passed.
STEPS_MM = (0.05, 0.1, 0.2, 0.4, 0.8, 1.5, 3.0, 6.0, 12.0)
# Flat faces meet, and slide, within rounding: a micrometre's thousandth, over the area.
FLAT_MM = 1e-6


def demolding_checks(assembly: Assembly) -> list[Check]:
    """One check a part that is drawn: the greatest overlap on its way."""
    parts = sorted(assembly.meshes.parts, key=lambda each: each.order)
    return [_drawn(assembly, p, _still_there(assembly, p)) for p in parts if p.draw is not None]


def _still_there(assembly: Assembly, part: PartMesh) -> tuple[str, ...]:
    """Names of what is there when a part is drawn; those of its order and draw move with it."""
    drawn = [each for each in assembly.meshes.parts if each.draw is not None]
    fixed = [each for each in assembly.meshes.parts if each.draw is None]
    apart = [each for each in drawn if each.order == part.order and each.draw != part.draw]
    left = [each for each in drawn if each.order > part.order or each in apart]
    return (RUBBER, *(each.name for each in (*assembly.meshes.plates, *fixed, *left)))


def _shared(one: Manifold, other: Manifold) -> float:
    """Volume that two solids share, mm^3; boxes that do not meet are seen at once."""
    (low, high), (under, over) = bounds(one), bounds(other)
    near = np.all(under < high) and np.all(low < over)
    return float((one ^ other).volume()) if near else 0.0


def _drawn(assembly: Assembly, part: PartMesh, there: tuple[str, ...]) -> Check:
    solid, draw = assembly.solids[part.name], np.array(part.draw)
    way = axis_name(draw.tolist())
    obstacles = {name: assembly.solids[name] for name in there}
    # How far it must be drawn until its box has parted from all others.
    far = max(corner @ draw for each in obstacles.values() for corner in bounds(each))
    clear = max(0.0, float(far - min(corner @ draw for corner in bounds(solid)))) + 1.0
    bound = _sliding(part, obstacles.values(), assembly.chord)
    worst, where, what = 0.0, 0.0, ""
    for step in (step for step in STEPS_MM if step < clear):
        moved = solid.translate(tuple(step * draw))
        shares = {name: _shared(moved, each) for name, each in obstacles.items()}
        if sum(shares.values()) > worst:
            worst, where = sum(shares.values()), step
            what = max(shares, key=lambda each: shares[each])
    words = f"moved {clear:.1f} mm along {way} it passes everything that is still there"
    if worst > bound:
        words = f"{where:g} mm along {way} it overlaps {what} by {worst:.3g} mm^3"
    return Check.most("demolding", part.name, worst, bound, "mm^3", f"{part.name}: {words}")


def _sliding(part: PartMesh, obstacles: Iterable[Manifold], chord: float) -> float:
    """Overlap by triangles alone, mm^3: curved faces that slide along an obstacle lie up to two
    chords apart from where they should; flat ones meet within rounding."""
    units, sizes = oriented(part.vertices, part.triangles)
    sliding = curved(part.vertices, part.triangles)
    sliding &= np.abs(units @ np.array(part.draw)) < SLIDING
    rows = np.flatnonzero(sliding)
    near = part.vertices[part.triangles[rows]].mean(axis=1) + 3.0 * chord * units[rows]
    taken = np.any([inside(each, near) for each in obstacles], axis=0)
    return float(2.0 * chord * sizes[rows[taken]].sum() + FLAT_MM * sizes.sum())
