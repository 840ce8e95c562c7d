"""Fields as .vtu files, one an increment, that ParaView and pyvista open as a series."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.fem.elements import tabulate
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.arrays import FieldHistory

STRAINS = ("xx", "yy", "zz", "xy", "xz", "yz")
_CELL_NAMES = {2: "triangle6", 3: "tetra10"}  # their mid-edge nodes stand in our order


def write_fields(folder: Path, mesh: Mesh, fields: FieldHistory | None) -> list[Path]:
    """Write fields_NN.vtu (NN: increment, from 1) into an existing folder; returns the files.

    Point data: displacement_mm (three components). Cell data: region (0 elastomer, k + 1 plate k,
    a core's after the last plate's) and strain_xx_microstrain and so on, at the centroid, for xx,
    yy, zz, xy, xz, yz (engineering shear). Without fields one file, fields_mesh.vtu, holds the
    mesh and its regions. Quadratic cells; a half model is written as the half z >= 0 that it is
    (ParaView: Reflect).
    """
    if fields is None:
        return [_write(folder / "fields_mesh.vtu", mesh, None)]
    n = len(mesh.points)
    if fields.displacement.shape[1:] != (n, mesh.dimension):
        raise ValueError(
            f"displacement of shape {fields.displacement.shape} is not of the mesh's {n} nodes"
        )
    digits = max(2, len(str(max(fields.increments, default=0) + 1)))
    return [
        _write(folder / f"fields_{number + 1:0{digits}d}.vtu", mesh, displacement)
        for number, displacement in zip(fields.increments, fields.displacement, strict=True)
    ]


def centroid_strain(mesh: Mesh, displacement: Array) -> Array:
    """Strain at each cell's centroid, microstrain, (c, 6): xx, yy, zz, xy, xz, yz.

    displacement (n, dim), mm. xy, xz, yz: engineering shear; zz = xz = yz = 0 in 2-D.
    The geometry is isoparametric: du/dx = (du/dxi) (dx/dxi)^-1 with the quadratic shape functions.
    """
    dimension = mesh.dimension
    slopes = tabulate(dimension, np.full((dimension, 1), 1.0 / (dimension + 1))).gradient[..., 0]
    jacobian = np.einsum("cai,ak->cik", mesh.points[mesh.cells], slopes)
    local = np.einsum("cai,ak->cik", displacement[mesh.cells], slopes)
    gradient = local @ np.linalg.inv(jacobian)
    strain = np.zeros((len(mesh.cells), 6))
    for axis in range(dimension):
        strain[:, axis] = gradient[:, axis, axis]
    pairs = ((0, 1),) if dimension == 2 else ((0, 1), (0, 2), (1, 2))
    for column, (i, j) in enumerate(pairs, start=3):
        strain[:, column] = gradient[:, i, j] + gradient[:, j, i]
    return 1e6 * strain


def _write(path: Path, mesh: Mesh, displacement: Array | None) -> Path:
    import meshio

    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.dimension] = mesh.points
    point_data, cell_data = {}, {"region": [mesh.regions.astype(np.int32)]}
    if displacement is not None:
        moved = np.zeros((len(points), 3), dtype=np.float32)
        moved[:, : mesh.dimension] = displacement
        point_data["displacement_mm"] = moved
        strain = centroid_strain(mesh, displacement).astype(np.float32)
        for part, values in zip(STRAINS, strain.T, strict=True):
            cell_data[f"strain_{part}_microstrain"] = [np.ascontiguousarray(values)]
    grid = meshio.Mesh(
        points,
        [(_CELL_NAMES[mesh.dimension], mesh.cells)],
        point_data=point_data,
        cell_data=cell_data,
    )
    grid.write(path, file_format="vtu", binary=True)
    return path
