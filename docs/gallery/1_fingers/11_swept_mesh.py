"""
A swept mesh in 3-D
===================

A straight finger can be swept: the mesh of the section goes through graded layers along z. This
is fast and gives the same mesh every time. Other bodies are meshed by fTetWild. The picture
omits half of the elements to show the plates.
"""

import numpy as np
import pyvista

from fingerdesign import with_values
from fingerdesign.checks.load import load_design
from fingerdesign.design.scene import SceneObject
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.mesh.make import mesh_finger

coarse = {"mesh.mesher": "sweep", "mesh.contact_size_mm": 0.8, "mesh.layers": 3}
design = with_values(load_design("maeno2000"), coarse)
mesh = mesh_finger(design, candidate_zone(design, SceneObject(), 0.1), symmetric=False)

middle = mesh.points[mesh.corners].mean(axis=1)
rubber, plates = mesh.parts["elastomer"], mesh.parts["plates"]
plotter = pyvista.Plotter(window_size=(1100, 720))
for chosen, colour in ((rubber & (middle[:, 2] < 0.0), "#b9d3e6"), (plates, "#d2560a")):
    cells = {pyvista.CellType.TETRA: mesh.corners[chosen]}
    grid = pyvista.UnstructuredGrid(cells, mesh.points)
    surface = grid.extract_surface(algorithm="dataset_surface")
    plotter.add_mesh(surface, color=colour, show_edges=True, line_width=0.5, ambient=0.4)
plotter.camera_position = [(-18.0, 24.0, 34.0), (0.0, 3.6, 0.0), (0.0, 1.0, 0.0)]
plotter.enable_anti_aliasing("ssaa")
plotter.show()

print(f"{np.count_nonzero(rubber):,} tetrahedra of rubber, {np.count_nonzero(plates):,} of plates")
