"""
Round objects have a smaller contact
====================================

The object of a scene may be a plane, a cylinder or a sphere. A rounder object has a narrower
contact and a higher pressure. The picture compares planes and cylinders along the finger at one
approach.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign import parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design
from fingerdesign.pipeline import run

design = load_design("homogeneous")
objects = {"a plane": 'shape = "plane"'}
for radius in (40, 15, 5):
    objects[f"a cylinder of R {radius}"] = f'shape = "cylinder"\nradius_mm = {radius}'

figure, axes = pyplot.subplots(figsize=(7.2, 3.8), layout="constrained")
colours = pyplot.colormaps["viridis"](np.linspace(0.05, 0.85, len(objects)))
for (name, text), colour in zip(objects.items(), colours, strict=True):
    scene = parse_scene(f"[object]\n{text}\n[path]\nincrements_mm = [[0.15, 0.0]]")
    found = run(Case(design, scene, "plane-strain"))
    order = found.contact.mid_line()  # by rising x
    x, pressure = found.contact.points[order, 0], found.contact.normal_traction[-1, order]
    axes.plot(x, pressure, color=colour)
    axes.fill_between(x, pressure, color=colour, alpha=0.12, lw=0.0)
    force = found.result.increments[-1].normal_force_N
    axes.plot([], [], color=colour, label=f"{name}: {force:.1f} N")
axes.set_xlim(-3.0, 3.0)
axes.set_xlabel("x, mm")
axes.set_ylabel("pressure, MPa")
axes.set_title("Each pressed by 0.15 mm")
axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
pyplot.show()
