"""
Comparison with Cattaneo and Mindlin
====================================

A round body that is pressed and then sheared slips at its edges first: the classical solution
of Cattaneo (1938) and Mindlin (1949). An arc of plain rubber is no half-space, but gives nearly
the same. Lines are closed forms for the computed forces; points are the model.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.pipeline import run

MU = 0.5
design = parse_design('design.name = "arc"\nplates.count = 0\nbody.base_height_mm = 20.0')
scene = parse_scene(f"""
object.friction_coefficient = {MU}
path.increments_mm = [[0.1, 0.0], [0.1, 0.05], [0.1, 0.1], [0.1, 0.15], [0.1, 0.18]]
""")
found = run(Case(design, scene, "plane-strain"))
x, contact, last = found.contact.points[:, 0], found.contact, found.result.increments[-1]

half = 0.5 * last.contact_width_mm
stuck = half * np.sqrt(1.0 - last.tangential_force_N / (MU * last.normal_force_N))
peak = 2.0 * last.normal_force_N / (np.pi * half * design.body.depth_mm)
line = np.linspace(-1.05 * half, 1.05 * half, 400)
pressure = peak * np.sqrt(np.clip(1.0 - (line / half) ** 2, 0.0, None))
held = peak * np.sqrt(np.clip(stuck**2 - line**2, 0.0, None)) / half

figure, axes = pyplot.subplots(figsize=(7.2, 3.8), layout="constrained")
axes.axvspan(-stuck, stuck, color="#e6e8eb", label="sticks, by the closed form")
axes.plot(line, pressure, color="#0b6fb0", label="pressure: closed form, model")
axes.plot(line, MU * (pressure - held), color="#d2560a", label="shear: closed form, model")
axes.plot(x, contact.normal_traction[-1], "o", color="#0b6fb0", ms=3.5)
axes.plot(x, contact.tangential_traction[-1, :, 0], "s", color="#d2560a", ms=3.5)
axes.set_xlim(line[0], line[-1])
axes.set_xlabel("x, mm")
axes.set_ylabel("traction, MPa")
axes.set_title(f"{last.normal_force_N:.1f} N pressed, {last.tangential_force_N:.1f} N sheared")
axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
pyplot.show()
