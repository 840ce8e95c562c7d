"""
Pressure and slip on a dome, in 3-D
===================================

A dome touches in a spot. The mesh is coarse here, so it takes seconds. At the end of the shear
the middle of the spot still sticks, as in a section.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign import parse_scene, with_values
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design
from fingerdesign.pipeline import run

coarse = {"plates.count": 0, "plates.span_mm": None, "mesh.contact_size_mm": 0.35}
design = with_values(load_design("domed"), coarse)
scene = parse_scene("""
object.friction_coefficient = 0.5
path.increments_mm = [[0.1, 0.0], [0.2, 0.0], [0.3, 0.0], [0.3, 0.06], [0.3, 0.12]]
""")
contact = run(Case(design, scene, "3d")).contact
touched = contact.facets[(contact.status[-1] > 0)[contact.facets].any(axis=1)]

figure, panels = pyplot.subplots(1, 3, figsize=(10.0, 3.7), sharey=True, layout="constrained")
shear = np.linalg.norm(contact.tangential_traction[-1], axis=1)
shown = {"pressure, MPa": contact.normal_traction[-1], "shear traction, MPa": shear}
shown["slip, µm"] = 1e3 * np.linalg.norm(contact.slip[-1], axis=1)
for axes, (title, values) in zip(panels, shown.items(), strict=True):
    for side in (1.0, -1.0) if contact.symmetric else (1.0,):
        x, z = contact.points[:, 0], side * contact.points[:, 2]
        drawn = axes.tripcolor(x, z, touched, values, shading="gouraud", cmap="viridis", vmin=0.0)
    figure.colorbar(drawn, ax=axes, shrink=0.8)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlim(-3.2, 3.2)
    axes.set_ylim(-3.4, 3.4)
    axes.set_title(title)
    axes.set_xlabel("x, mm")
panels[0].set_ylabel("z, mm")
pyplot.show()
