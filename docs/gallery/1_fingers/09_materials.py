"""
Materials that are known by name
================================

Each has a Young's modulus and a Poisson's ratio with their source; a design may bring its own. From
the softest rubber to steel there are five powers of ten: a plate is a stiff thing in a soft one,
and a plate of polyimide answers fifty times more than one of bronze.
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
    said = f"{modulus:,.0f} MPa" if modulus > 10.0 else f"{modulus:.3g} MPa"
    axes.text(1.15 * modulus, row, said, va="center", fontsize=8)
axes.set_xscale("log")
axes.set_xlim(right=2e7)
axes.set_xlabel("Young's modulus, MPa (blue: elastomers, orange: plates and cores)")
axes.grid(axis="y", visible=False)
axes.set_title("Known materials")
pyplot.show()

print(MATERIALS["dragon_skin_30"].source)
