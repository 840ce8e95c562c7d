"""A picture of a mesh: its outside with edges, plates in bronze, off-screen (pyvista).

VTK is native code that can crash where graphics drivers are odd: it draws in a process of its own,
``python -m fingerdesign.mesh.picture IN.npz OUT.png``.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import Mesh
from fingerdesign.mesh.worker import run_module

TIME_LIMIT_S = 120.0  # drawing takes 1 to 2 s; a software renderer on a busy machine far longer
SIZE = (1600, 1120)
SILICONE, BRONZE, EDGES = "#cfd8e3", "#b87333", "#33475b"


def draw_mesh(mesh: Mesh, path: Path | str, time_limit_s: float = TIME_LIMIT_S) -> Path:
    """Write a PNG of a mesh: a section seen along -z, a half model with its mid-plane in front.

    MeshError where nothing can be rendered (no off-screen graphics on this machine).
    """
    path = Path(path)
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.dimension] = mesh.points
    if mesh.symmetric:  # the half z <= 0, which mirrors it, turns the cut to the viewer
        points[:, 2] *= -1.0
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".picture-") as name:
        folder = Path(name)
        plates = mesh.regions > 0
        np.savez(folder / "in.npz", points=points, cells=mesh.corners, plates=plates)
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
        points, cells, plates = data["points"], data["cells"], data["plates"]
    plotter = pyvista.Plotter(off_screen=True, window_size=list(SIZE))
    plotter.set_background("white")
    kind = pyvista.CellType.TRIANGLE if cells.shape[1] == 3 else pyvista.CellType.TETRA
    for rows, colour in ((~plates, SILICONE), (plates, BRONZE)):
        if rows.any():
            grid = pyvista.UnstructuredGrid({kind: cells[rows]}, points)
            plotter.add_mesh(grid, color=colour, show_edges=True, edge_color=EDGES, ambient=0.3)
    if cells.shape[1] == 3:
        plotter.view_xy()
    else:
        plotter.view_vector((-0.3, 0.4, 1.0), viewup=(0.0, 1.0, 0.0))
    plotter.camera.zoom(1.2)
    plotter.screenshot(target)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
