"""How parts lie on a printer's bed: a flat face down, side by side. Lengths in mm, bed z = 0."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.mold.part import PartMesh

GAP_MM = 5.0  # between neighbours on the bed
FLAT = 1e-6  # mm; how far from its plane a face may lie
OUTSIDE = 1.5  # how much more a face that is drawn away from the finger counts: its other side
# forms the finger, and prints best when it looks up


@dataclass(frozen=True)
class Posed:
    """A part turned for printing: vertices (n, 3) from its own corner (0, 0, 0), and its place.

    place: where that corner lies on the bed. flat_area: of the face it lies on, mm^2. down: that
    face's outward normal in mold space.
    """

    name: str
    vertices: Array
    triangles: IntArray
    place: tuple[float, float]
    flat_area: float
    down: tuple[float, float, float]

    @property
    def size(self) -> tuple[float, float, float]:
        """Extent along x, y, z of the bed."""
        x, y, z = np.ptp(self.vertices, axis=0).tolist()
        return x, y, z


def laid_out(parts: tuple[PartMesh, ...]) -> tuple[Posed, ...]:
    """Each part with its largest flat outer face down, in rows that make about a square.

    Outer: nothing of the part reaches beyond the face's plane. A face that looks away from the
    finger counts half as much again, so that the side that forms it looks up.
    """
    posed = [_posed(part) for part in parts]
    posed.sort(key=lambda each: (-each.size[1], each.name))
    area = sum((each.size[0] + GAP_MM) * (each.size[1] + GAP_MM) for each in posed)
    widest = max((each.size[0] for each in posed), default=0.0)
    limit = max(widest, 1.2 * float(np.sqrt(area)))
    placed, x, y, row = [], 0.0, 0.0, 0.0
    for each in posed:
        wide, deep, _ = each.size
        if x > 0.0 and x + wide > limit:
            x, y, row = 0.0, y + row + GAP_MM, 0.0
        placed.append(_at(each, x, y))
        x, row = x + wide + GAP_MM, max(row, deep)
    return tuple(placed)


def flat_faces(part: PartMesh, most: int = 60) -> list[tuple[float, Array]]:
    """(area, outward normal) of the flat faces that a part can lie on, largest first."""
    corners = part.vertices[part.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(across, axis=1)
    sound = double > 0.0
    normals, areas = across[sound] / double[sound, None], 0.5 * double[sound]
    corners = corners[sound]
    _, kinds = np.unique(np.round(normals, 4) + 0.0, axis=0, return_inverse=True)
    kinds = kinds.reshape(-1)
    sums = np.bincount(kinds, areas)
    found = []
    for kind in np.argsort(-sums)[:most]:
        members = kinds == kind
        normal = areas[members] @ normals[members]
        normal /= np.linalg.norm(normal)
        reach = float((part.vertices @ normal).max())
        on = np.abs(corners[members] @ normal - reach).max(axis=1) < FLAT
        if on.any():
            found.append((float(areas[members][on].sum()), normal))
    return sorted(found, key=lambda each: -each[0])


def _posed(part: PartMesh) -> Posed:
    faces = flat_faces(part)
    outward = np.array(part.draw if part.draw is not None else (0.0, -1.0, 0.0))
    if faces:
        area, down = max(faces, key=lambda f: f[0] * (OUTSIDE if f[1] @ outward > 0.999 else 1.0))
    else:  # no flat face: as it stands in the mold
        area, down = 0.0, np.array([0.0, -1.0, 0.0])
    turned = part.vertices @ _turn_down(down).T
    if np.ptp(turned[:, 1]) > np.ptp(turned[:, 0]):
        turned = turned[:, [1, 0, 2]] * np.array([-1.0, 1.0, 1.0])
    turned = turned - turned.min(axis=0)
    x, y, z = down.tolist()
    return Posed(part.name, turned, part.triangles, (0.0, 0.0), area, (x, y, z))


def _turn_down(normal: Array) -> Array:
    """The rotation (3, 3) that takes a unit vector to -z."""
    target = np.array([0.0, 0.0, -1.0])
    axis, cosine = np.cross(normal, target), float(normal @ target)
    if cosine < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + skew + skew @ skew / (1.0 + cosine))


def _at(posed: Posed, x: float, y: float) -> Posed:
    return Posed(posed.name, posed.vertices, posed.triangles, (x, y), posed.flat_area, posed.down)
