"""
One result in a notebook: figures and arrays
============================================

The result of ``analyse`` has Plotly figures of the finger, the forces, the tractions and the
gages. It also gives its stick maps as numpy arrays for any other picture. ``report`` writes the
page of the analysis.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign import analyse

result = analyse("maeno2000", "pull", "plane-strain")
finger = result.plot_finger()
tractions = result.plot_contact(increment=-1)

maps = result.arrays()
x = maps["contact_points_mm"][:, 0]
order = np.argsort(x)
use = maps["shear_traction_MPa"][..., 0] / np.where(
    maps["pressure_MPa"] > 0, maps["pressure_MPa"], np.nan
)

figure, axes = pyplot.subplots(layout="constrained")
shades = axes.pcolormesh(x[order], np.arange(1, len(use) + 1), use[:, order], cmap="cividis")
axes.set(xlabel="x (mm)", ylabel="increment", title="Shear traction over pressure", xlim=(-4, 4))
figure.colorbar(shades, label="at most the friction coefficient, 0.5")
pyplot.show()

print(result)
