"""Whether parts and cavity fill the block, and whether the cavity is the finger, enlarged.

The exact solids' volumes say what the cavity is; the triangles, as they are made, that nothing
overlaps or gapes. Triangles of a curved face lie up to a chord c off it, on parts and outline
apart: along curved faces of area A parts overlap or gape by at most 2 c A.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from manifold3d import Manifold, OpType

from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.volume import core_volume, outline_volume, plate_volume
from fingerdesign.mold.checks.assembly import (
    OUTLINE,
    Assembly,
    areas,
    curved_area,
    filling,
    inside,
    place_text,
    planned,
    surface_points,
)
from fingerdesign.mold.part import Check

# The kernel's volumes are off by up to 1e-5 under edges that are neither lines nor circles.
FINGER_SHARE = 1e-4
# Flat faces meet within rounding: a micrometre's thousandth, over the area.
FLAT_MM = 1e-6


def fill_checks(assembly: Assembly) -> list[Check]:
    """Overlaps, voids, and the cavity's volume against the finger's."""
    low, high = (np.array(corner) for corner in (assembly.meshes.low, assembly.meshes.high))
    block = Manifold.cube(tuple(high - low)).translate(tuple(low))
    whole = Manifold.batch_boolean(list(assembly.blanks.values()), OpType.Add)
    cavity, voids = _cavity(block - whole, assembly.solids[OUTLINE])
    slack, block = _slack(assembly), float(np.prod(high - low))
    gape = voids + float((cavity - assembly.solids[OUTLINE]).volume())
    empty = f"between parts and the finger's outline {gape:.3g} mm^3 of the block are empty"
    return [
        _overlaps(assembly, whole, slack),
        Check.most("no voids", "", gape, slack, "mm^3", empty),
        _finger(assembly, block),
    ]


def _cavity(rest: Manifold, outline: Manifold) -> tuple[Manifold, float]:
    """The piece of what the parts leave in which the finger lies, and the volume of the others."""
    pieces = rest.decompose()
    if len(pieces) < 2:
        return rest, 0.0
    shared = [(piece ^ outline).volume() for piece in pieces]
    most = int(np.argmax(shared))
    return pieces[most], float(sum(p.volume() for i, p in enumerate(pieces) if i != most))


def _slack(assembly: Assembly) -> float:
    """Volume by which parts that meet along curved faces may overlap or gape, mm^3."""
    outline = assembly.meshes.outline
    meshes = [(outline.vertices, outline.triangles)]
    meshes += [(part.blank_vertices, part.blank_triangles) for part in filling(assembly.meshes)]
    curved = 0.5 * sum(curved_area(*mesh) for mesh in meshes)  # each face is of two
    return 2.0 * assembly.chord * curved + FLAT_MM * sum(
        float(areas(*mesh).sum()) for mesh in meshes
    )


def _overlaps(assembly: Assembly, whole: Manifold, slack: float) -> Check:
    blanks = {**assembly.blanks, OUTLINE: assembly.solids[OUTLINE]}
    joint = whole + assembly.solids[OUTLINE]
    total = sum(solid.volume() for solid in blanks.values()) - joint.volume()
    names = ""
    if total > slack:
        worst = max(
            combinations(blanks, 2), key=lambda two: (blanks[two[0]] ^ blanks[two[1]]).volume()
        )
        names = f", most of it between {worst[0]} and {worst[1]}"
    sentence = f"parts and cavity overlap each other by {total:.3g} mm^3{names}"
    return Check.most("no overlaps", "", total, slack, "mm^3", sentence)


def _finger(assembly: Assembly, block: float) -> Check:
    """Cavity / scale^3 less plates and core is the body: metal does not shrink, rubber does."""
    design, plan = assembly.design, assembly.plan
    inserts = sum(plate_volume(frame) for frame in plate_frames(design)) + core_volume(design)
    wanted = outline_volume(design.body) - inserts
    cavity = block - sum(part.blank_volume for part in filling(assembly.meshes))
    found = cavity / plan.scale**3 - inserts
    error = abs(found - wanted) / wanted
    sentence = (
        f"cavity less shrinkage, plates and core: {found:.4f} mm^3; the finger's body in closed "
        f"form: {wanted:.4f} mm^3"
    )
    return Check.most("cavity is the finger", "", error, FINGER_SHARE, "1", sentence)


POINTS = 10000  # 0.08 mm^2 each on a finger of 800 mm^2
# A sheet's slot is wider than planned by no more than its fillets; seams are closed.
SLACK_MM = 0.05


def backing_check(assembly: Assembly, rng: np.random.Generator) -> Check:
    """Points two chords outside the outline must lie in a part, a plate or a planned opening."""
    outline = assembly.meshes.outline
    points, normals = surface_points(outline.vertices, outline.triangles, POINTS, rng)
    points = points[:POINTS] + 2.0 * assembly.chord * normals[:POINTS]
    left = ~planned(assembly.plan, points, assembly.limits.clearance_mm, SLACK_MM)
    wanted = int(left.sum())
    for part in (*assembly.meshes.parts, *assembly.meshes.plates):
        rest = np.flatnonzero(left)
        left[rest[inside(assembly.solids[part.name], points[rest])]] = False
    bare = points[left]
    share = len(bare) / POINTS
    sentence = f"a part stands behind each of {wanted} points on the finger's surface"
    if len(bare):
        sentence = (
            f"{len(bare)} of {POINTS} points on the finger's surface have no part behind them, one "
            f"of them at {place_text(np.median(bare, axis=0))}"
        )
    return Check("surface backed by parts", "", not len(bare), share, 0.0, "1", sentence)
