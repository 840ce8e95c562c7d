"""Checks of a built mold on its triangles: each with a measured number, a bound and a sentence.

Each part is one closed solid with the volume and the chord that it should have; then the assembled
parts are checked.
"""

import numpy as np
from manifold3d import Manifold

from fingerdesign.layout.volume import enclosed_volume
from fingerdesign.mold.checks.assembly import assemble
from fingerdesign.mold.checks.cavity import backing_check, finger_check
from fingerdesign.mold.checks.demolding import demolding_checks
from fingerdesign.mold.checks.venting import vent_check
from fingerdesign.mold.checks.walls import clearance_checks, wall_checks
from fingerdesign.mold.part import Check, MoldMeshes, PartMesh
from fingerdesign.mold.plan.patterns import flat_patterns
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.solids import areas, curved_area, sound

SEED = 7
# Bound of a bent plate's error of volume, whose two faces err alike, as a fraction.
VOLUME_SHARE = 1e-3
EXACT_SHARE = 1e-6  # error of the kernel's own volumes, as a fraction
SINGLE = 2.0**-24  # rounding of single precision


def run_checks(plan: MoldPlan, meshes: MoldMeshes) -> tuple[Check, ...]:
    """Everything that is checked of a mold, its parts, one plate of each kind and its rubber.

    Parts whose triangles are not those of a solid cannot be cut with each other: then only their
    own checks are returned, and one that says so.
    """
    assembly, chord = assemble(plan, meshes), plan.design.mold.chord_mm
    kinds = {f"plate_{pattern.plates[0]}" for pattern in flat_patterns(plan)}
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
    rng = np.random.default_rng(SEED)  # the points of two checks are drawn from it, in this order
    return (
        *found,
        finger_check(assembly),
        backing_check(assembly, rng),
        *wall_checks(assembly, rng),
        *demolding_checks(assembly),
        vent_check(assembly),
        *clearance_checks(assembly),
    )


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
