"""
The mesh of a section
=====================

In plane strain a finger is its section. Triangles are small at the contact and at the plates,
and grow away from them. Their sides follow every plate.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.mesh.section.section import mesh_section

design = load_design("maeno2000")
mesh = mesh_section(design, 3.0)  # fine for a contact 3 mm to either side

figure, (whole, near) = pyplot.subplots(
    1, 2, figsize=(9.0, 3.4), width_ratios=(1.5, 1.0), layout="constrained"
)
for axes, line in ((whole, 0.08), (near, 0.4)):
    axes.tripcolor(
        *mesh.points.T,
        mesh.corners,
        facecolors=np.minimum(mesh.regions, 1).astype(float),
        cmap=pyplot.matplotlib.colors.ListedColormap(["#dce8f1", "#d2560a"]),
        edgecolors="#46657d",
        linewidth=line,
    )
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlabel("x, mm")
whole.set_ylabel("y, mm")
whole.set_title(f"{len(mesh.cells):,} triangles")
near.set_xlim(-1.6, 1.6)
near.set_ylim(6.2, 8.3)
near.set_title("the middle plates")
pyplot.show()
