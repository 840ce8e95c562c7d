"""
Many fingers from one: which radius, which rubber?
==================================================

A design is a value: change keys, and it is checked like a file. Here a plane is pressed on
twelve fingers. A rounder finger is softer and its contact is narrower. The width is the same in
each rubber, so its three lines coincide.
"""

from matplotlib import pyplot

from fingerdesign import analyse, parse_scene, with_values
from fingerdesign.checks.load import load_design

base = load_design("homogeneous")
scene = parse_scene("path.increments_mm = [[0.1, 0.0]]")
radii = (15.0, 25.0, 40.0, 60.0)

figure, (forces, widths) = pyplot.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
looks = {"dragon_skin_20": "#0b6fb0", "dragon_skin_30": "#d2560a", "sylgard_184": "#0a8f6b"}
for rubber, colour in looks.items():
    found = []
    for radius in radii:
        keys = {"body.arc_radius_mm": radius, "body.material": rubber}
        found.append(analyse(with_values(base, keys), scene, "plane-strain").increments[-1])
    name = rubber.replace("_", " ")
    forces.plot(radii, [each.normal_force_N for each in found], "o-", color=colour, label=name)
    widths.plot(radii, [each.contact_width_mm for each in found], "o-", color=colour)
forces.set_ylabel("force at 0.1 mm, N")
widths.set_ylabel("width of the contact, mm")
widths.set_ylim(bottom=0.0)
for axes in (forces, widths):
    axes.set_xlabel("radius of the arc, mm")
forces.legend()
pyplot.show()
