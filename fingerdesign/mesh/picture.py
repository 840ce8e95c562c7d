"""A picture of a mesh: its outside with edges and, of a whole finger, its inside too (pyvista).

Plates are bronze, a core purple. VTK is native code that can crash where graphics drivers are odd:
it draws in a process of its own, ``python -m fingerdesign.mesh.picture IN.npz OUT.png``.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import Mesh
from fingerdesign.mesh.worker import run_module

TIME_LIMIT_S = 120.0  # drawing takes 1 to 2 s; a software renderer on a busy machine far longer
SIZE = (1600, 1120)
SILICONE, BRONZE, CORE, EDGES = "#cfd8e3", "#b87333", "#a487b5", "#33475b"

Array = NDArray[np.float64]


def placed(mesh: Mesh) -> Array:
    """Nodes (n, 3) as they are drawn: of a half model its mirror image z <= 0, the cut in front."""
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.dimension] = mesh.points
    if mesh.symmetric:
        points[:, 2] *= -1.0
    return points


def view(plotter: Any) -> None:
    """Look from the front, a little from above and the left."""
    plotter.view_vector((-0.3, 0.4, 1.0), viewup=(0.0, 1.0, 0.0))


def draw_mesh(mesh: Mesh, path: Path | str, time_limit_s: float = TIME_LIMIT_S) -> Path:
    """Write a PNG of a mesh: a section seen along -z, a half model with its mid-plane in front, a
    whole one beside itself cut open at z = 0.

    MeshError where nothing can be rendered (no off-screen graphics on this machine).
    """
    path = Path(path)
    cores = [number for number, name in mesh.region_names.items() if name == "core"]
    part = np.where(np.isin(mesh.regions, cores), 2, np.minimum(mesh.regions, 1))
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".picture-") as name:
        folder = Path(name)
        whole = mesh.dimension == 3 and not mesh.symmetric
        np.savez(folder / "in.npz", points=placed(mesh), cells=mesh.corners, part=part, whole=whole)
        try:
            run_module(__name__, ["in.npz", "out.png"], folder, time_limit_s)
        except MeshError as error:
            raise MeshError(f"the picture {path} could not be drawn: {error}") from error
        os.replace(folder / "out.png", path)
    return path


def main(source: str, target: str) -> None:
    """Draw what ``draw_mesh`` wrote; runs in its process."""
    import pyvista

    with np.load(source) as data:
        points, cells, part = data["points"], data["cells"], data["part"]
        whole = bool(data["whole"])
    width, height = SIZE
    plotter = pyvista.Plotter(
        off_screen=True,
        window_size=[2 * width, height] if whole else [width, height],
        shape=(1, 2) if whole else (1, 1),
        border=False,
    )
    kind = pyvista.CellType.TRIANGLE if cells.shape[1] == 3 else pyvista.CellType.TETRA
    behind = points[cells][..., 2].mean(axis=1) <= 1e-9
    for column, shown in enumerate([np.ones(len(cells), dtype=bool), behind][: 1 + whole]):
        plotter.subplot(0, column)
        plotter.set_background("white")
        for number, colour in enumerate((SILICONE, BRONZE, CORE)):
            rows = (shown | (part > 0)) & (part == number)  # plates and core stand out of the cut
            if rows.any():
                grid = pyvista.UnstructuredGrid({kind: cells[rows]}, points)
                plotter.add_mesh(grid, color=colour, show_edges=True, edge_color=EDGES, ambient=0.3)
        if cells.shape[1] == 3:
            plotter.view_xy()
        else:
            view(plotter)
        plotter.camera.zoom(1.15)
    plotter.screenshot(target)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
