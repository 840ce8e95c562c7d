"""
Materials with a name
=====================

Each material has a Young's modulus and a Poisson's ratio with their source; a design may define
its own. Moduli range over five powers of ten from rubber to steel. A polyimide plate gives a
far larger signal than a bronze one.
"""

from matplotlib import pyplot

from fingerdesign.materials import MATERIALS

names = sorted(MATERIALS, key=lambda name: MATERIALS[name].youngs_modulus_MPa)
moduli = [MATERIALS[name].youngs_modulus_MPa for name in names]
rubber = [MATERIALS[name].poissons_ratio > 0.45 for name in names]

figure, axes = pyplot.subplots(figsize=(7.2, 4.6), layout="constrained")
colours = ["#0b6fb0" if soft else "#d2560a" for soft in rubber]
axes.barh([name.replace("_", " ") for name in names], moduli, color=colours, height=0.65)
for row, modulus in enumerate(moduli):
    label = f"{modulus:,.0f} MPa" if modulus > 10.0 else f"{modulus:.3g} MPa"
    axes.text(1.15 * modulus, row, label, va="center", fontsize=8)
axes.set_xscale("log")
axes.set_xlim(right=2e7)
axes.set_xlabel("Young's modulus, MPa (blue: elastomers, orange: plates and cores)")
axes.grid(axis="y", visible=False)
axes.set_title("Known materials")
pyplot.show()

print(MATERIALS["dragon_skin_30"].source)
