"""How large elements should be, point by point, and the background grid that carries it.

fTetWild reads its size field where the vertices of a first, coarse mesh happen to lie, by linear
interpolation in a background tetrahedral grid. A grid coarser than the field blurs it upward, so
the grid is fine in y, across the contact surface and the plates, where the field is steep.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame
from fingerdesign.errors import MeshError
from fingerdesign.geometry.surface import ContactSurface

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


GRID_POINTS = 200_000  # of the background grid; 26 000 serve a finger of 20 x 13 x 5 mm


@dataclass(frozen=True)
class MeshSizes:
    """Edge lengths in mm; sizes grow by ``gradation`` mm per mm away from where they are set."""

    contact: float
    plate: float
    far: float
    gradation: float

    def __post_init__(self) -> None:
        for name in ("contact", "plate", "far", "gradation"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise MeshError(f"mesh size {name} = {value} must be a finite number above 0")

    @classmethod
    def of(cls, design: Design) -> MeshSizes:
        """The sizes a design asks for in its ``[mesh]`` table."""
        mesh = design.mesh
        return cls(
            mesh.contact_size_mm, mesh.plate_size_mm, mesh.far_size_mm, float(mesh.gradation)
        )

    def scaled(self, factor: float) -> MeshSizes:
        """The same field with every length multiplied by ``factor``."""
        return MeshSizes(
            self.contact * factor, self.plate * factor, self.far * factor, self.gradation
        )


@dataclass(frozen=True)
class SizeField:
    """Wanted edge length over a finger: fine at the contact zone |x| <= half width and at plates.

    Under ``zone_half_width`` the whole depth along z counts as contact zone.
    """

    surface: ContactSurface
    frames: tuple[PlateFrame, ...]
    sizes: MeshSizes
    zone_half_width: float

    def __call__(self, points: Array) -> Array:
        """Wanted edge length (n,), mm, at points (n, 2) or (n, 3)."""
        sizes = self.sizes
        sideways = np.maximum(np.abs(points[:, 0]) - self.zone_half_width, 0.0)
        away = np.hypot(sideways, self.surface.distance(points))
        wanted = np.minimum(sizes.far, sizes.contact + sizes.gradation * away)
        for frame in self.frames:
            away = distance_to_plate(frame, points)
            wanted = np.minimum(wanted, sizes.plate + sizes.gradation * away)
        return np.asarray(wanted)


def distance_to_plate(frame: PlateFrame, points: Array) -> Array:
    """Distance (n,), mm, from points (n, 2) or (n, 3) to a plate's box; 0 inside."""
    local = np.abs(frame.local(points)) - 0.5 * np.array([frame.length, frame.thickness])
    away = np.hypot(*np.maximum(local, 0.0).T)
    if points.shape[1] == 3:
        z = points[:, 2]
        away = np.hypot(away, np.maximum(np.maximum(frame.z_min - z, z - frame.z_max), 0.0))
    return np.asarray(away)


def background_grid(
    field: SizeField, low: Array, high: Array, spacing: tuple[float, float, float]
) -> tuple[Array, NDArray[np.int32], Array]:
    """A regular grid of tetrahedra over a box with the field's value at each of its points.

    low, high (3,): the box to cover (a margin is added); spacing: grid steps wanted, mm, all made
    longer where there would be more than GRID_POINTS points. Returns points (n, 3), positively
    oriented tetrahedra (t, 4), values (n,).
    """
    steps = np.array(spacing)
    margin = np.maximum(steps, 0.05 * (high - low))
    start, extent = low - margin, high - low + 2.0 * margin
    steps = steps * max(1.0, float(np.prod(extent / steps) / GRID_POINTS) ** (1.0 / 3.0))
    axes = [
        np.linspace(
            start[axis], start[axis] + extent[axis], int(np.ceil(extent[axis] / steps[axis])) + 1
        )
        for axis in range(3)
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = tuple(len(axis) for axis in axes)
    numbers = np.arange(len(points)).reshape(shape)

    def corner(step: Array) -> IntArray:
        i, j, k = (int(s) for s in step)
        nx, ny, nz = shape
        return numbers[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].reshape(-1)

    tets = []
    for order in permutations(range(3)):  # Kuhn's six tetrahedra of a brick
        path = [np.zeros(3)]
        for axis in order:
            path.append(path[-1] + np.eye(3)[axis])
        tet = np.stack([corner(step) for step in path], axis=1)
        even = np.linalg.det(np.diff(np.array(path), axis=0)) > 0
        tets.append(tet if even else tet[:, [0, 2, 1, 3]])
    return points, np.vstack(tets).astype(np.int32), field(points)
