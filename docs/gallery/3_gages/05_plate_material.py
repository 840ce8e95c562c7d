"""
Plates of metal or of foil?
===========================

A stiff plate takes little of the strain of the rubber. Polyimide foil gives a far larger
response per newton than bronze. The response of bronze is about as large as the noise of an
amplifier.
"""

from matplotlib import pyplot

from fingerdesign import analyse, parse_scene, with_values
from fingerdesign.checks.load import load_design

base = load_design("sensitive")
scene = parse_scene("""
object.friction_coefficient = 0.8
path.increments_mm = [[0.1, 0.0], [0.1, 0.02]]
""")

materials = ("polyimide", "pla", "aluminium", "phosphor_bronze", "spring_steel")
strongest = []
for material in materials:
    design = with_values(base, {"plates.material": material})
    before, after = analyse(design, scene, "plane-strain").increments
    force = after.tangential_force_N - before.tangential_force_N
    pairs = zip(before.gages, after.gages, strict=True)
    strongest.append(max(abs(b.membrane - a.membrane) for a, b in pairs) / force)

figure, axes = pyplot.subplots(figsize=(7.2, 3.2), layout="constrained")
names = [name.replace("_", " ") for name in materials]
axes.barh(names[::-1], strongest[::-1], color="#0b6fb0", height=0.6)
axes.axvline(0.5, color="#d2560a", ls="--", label="noise of an amplifier, one sample")
for row, value in enumerate(strongest[::-1]):
    axes.text(1.1 * value, row, f"{value:.2g}", va="center")
axes.set_xscale("log")
axes.set_xlim(0.1, 3.0 * max(strongest))
axes.set_xlabel("strongest gage, microstrain per N of shear")
axes.grid(axis="y", visible=False)
axes.legend(loc="lower right")
pyplot.show()
