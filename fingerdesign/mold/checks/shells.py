"""Check that each part is one closed solid with the volume and the chord it should have."""

import numpy as np
from manifold3d import Manifold

from fingerdesign.layout.volume import enclosed_volume
from fingerdesign.mold.part import Check, PartMesh
from fingerdesign.mold.solids import areas, curved_area, sound

# Bound of a bent plate's error of volume, whose two faces err alike, as a fraction.
VOLUME_SHARE = 1e-3
EXACT_SHARE = 1e-6  # error of the kernel's own volumes, as a fraction
SINGLE = 2.0**-24  # rounding of single precision


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
