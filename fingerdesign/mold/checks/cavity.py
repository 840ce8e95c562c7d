"""Check that the cavity is the finger, enlarged, and that parts stand behind all of its surface.

The exact solids' volumes show the first. Parts that overlap or gape have another sum, unless both
do by as much; those that overlap do not come off, either.
"""

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import core_volume, outline_volume, plate_volume
from fingerdesign.mold.checks.assembly import Assembly, place_text, planned
from fingerdesign.mold.part import BASE, BASE_FRAME, CORE, OUTER, Check
from fingerdesign.mold.solids import inside, surface_points

# The kernel's volumes are off by up to 1e-5 under edges that are neither lines nor circles.
FINGER_SHARE = 1e-4
BACKED = 10000  # points: 0.08 mm^2 each on a finger of 800 mm^2
# A sheet's slot is wider than planned by no more than its fillets; seams are closed.
SLACK_MM = 0.05


def finger_check(assembly: Assembly) -> Check:
    """Cavity / scale^3 less plates and core is the body: metal does not shrink, rubber does."""
    plan, meshes = assembly.plan, assembly.meshes
    outside = (BASE, BASE_FRAME, CORE)  # these do not fill the block, nor do sheets outside of it
    filling = [p for p in meshes.parts if p.name not in outside and not p.name.endswith(OUTER)]
    design = plan.design
    inserts = sum(plate_volume(frame) for frame in plate_frames(design)) + core_volume(design)
    expected = outline_volume(design.body) - inserts
    block = float(np.prod(np.array(meshes.high) - np.array(meshes.low)))
    cavity = block - sum(part.blank_volume for part in filling)
    found = cavity / plan.scale**3 - inserts
    error = abs(found - expected) / expected
    sentence = (
        f"cavity less shrinkage, plates and core: {found:.4f} mm^3; the finger's body in closed "
        f"form: {expected:.4f} mm^3"
    )
    return Check.most("cavity is the finger", "", error, FINGER_SHARE, "1", sentence)


def backing_check(assembly: Assembly, rng: np.random.Generator) -> Check:
    """Points two chords outside the outline must lie in a part, a plate or a planned opening."""
    outline = assembly.meshes.outline
    points, normals = surface_points(outline.vertices, outline.triangles, BACKED, rng)
    points = points[:BACKED] + 2.0 * assembly.chord * normals[:BACKED]
    left = ~planned(assembly.plan, points, SLACK_MM)
    solid = int(left.sum())
    left[left] = ~_backed(assembly, points[left])
    # Triangles of two parts that meet along a curve leave slivers as thin as their chords.
    for way in 2.0 * assembly.chord * np.eye(3):
        left[left] = ~np.all([_backed(assembly, points[left] + s * way) for s in (-1, 1)], axis=0)
    bare = points[left]
    share = len(bare) / BACKED
    sentence = f"a part stands behind each of {solid} points on the finger's surface"
    if len(bare):
        sentence = (
            f"{len(bare)} of {BACKED} points on the finger's surface have no part behind them, one "
            f"of them at {place_text(np.median(bare, axis=0))}"
        )
    return Check("surface backed by parts", "", not len(bare), share, 0.0, "1", sentence)


def _backed(assembly: Assembly, points: Array) -> BoolArray:
    """True for points (n, 3) that lie in a part or a plate, (n,)."""
    left = np.ones(len(points), dtype=bool)
    for part in (*assembly.meshes.parts, *assembly.meshes.plates):
        rest = np.flatnonzero(left)
        left[rest[inside(assembly.solids[part.name], points[rest])]] = False
    return ~left
