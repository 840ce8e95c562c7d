"""Whether each part's triangles are those of one solid, and of the exact solid they stand for."""

from __future__ import annotations

import numpy as np

from fingerdesign.mold.checks.triangles import areas, curved_area, heights, topology, volume
from fingerdesign.mold.part import Check, PartMesh

# The kernel merges vertices closer than 1e-7 mm; anything flatter than this is rounding.
LEAST_HEIGHT_MM = 1e-6
VOLUME_SHARE = 1e-3
EXACT_SHARE = 1e-6  # of the kernel's own volumes
SINGLE = 2.0**-24


def part_checks(part: PartMesh, chord_mm: float) -> list[Check]:
    """Topology, triangles, volume and chord of one part. Rubber alone may enclose a core."""
    found = topology(part.triangles)
    least = float(heights(part.vertices, part.triangles).min())

    def none_of(name: str, count: int, unit: str, what: str) -> Check:
        sentence = f"{part.name}: {count} {what}" if count else f"{part.name}: no {what}"
        return Check(name, part.name, count == 0, float(count), 0.0, unit, sentence)

    return [
        none_of("watertight", found.open_edges, "edges", "edges that two triangles do not share"),
        none_of("winding", found.turned_edges, "edges", "edges that two triangles run alike"),
        none_of("manifold", found.extra_fans, "vertices", "vertices where shells merely touch"),
        Check(
            "one shell",
            part.name,
            found.shells == 1 or part.made == "silicone",
            float(found.shells),
            1.0,
            "shells",
            f"{part.name}: {found.shells} shells of triangles",
        ),
        Check(
            "no degenerate triangles",
            part.name,
            least > LEAST_HEIGHT_MM,
            least,
            LEAST_HEIGHT_MM,
            "mm",
            f"{part.name}: the flattest of {len(part.triangles)} triangles is {least:.2g} mm high",
        ),
        _written(part),
        _volume(part),
        Check(
            "chord",
            part.name,
            part.chord <= chord_mm,
            part.chord,
            chord_mm,
            "mm",
            f"{part.name}: triangles leave the exact surface by at most {part.chord:.4f} mm",
        ),
    ]


def _written(part: PartMesh) -> Check:
    """STL holds single precision: vertices that become one there would open or pinch the mesh."""
    used = np.unique(part.triangles)
    rounded = part.vertices[used].astype(np.float32)
    lost = len(used) - len(np.unique(rounded, axis=0))
    sentence = f"{part.name}: {lost} of {len(used)} vertices fall onto others in single precision"
    return Check("as written", part.name, lost == 0, float(lost), 0.0, "vertices", sentence)


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
    return Check("volume", part.name, bool(error <= bound), error, bound, "1", sentence)
