"""
The gage area and the stick area
================================

The paper's claim: the length of plates whose response exceeds a threshold follows the length
that sticks, at any friction coefficient. In plane strain it does for this finger, if the effect
of the normal force is removed.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design
from fingerdesign.pipeline import run

found = run(Case(load_design("maeno2000"), fidelity="plane-strain", grips=False))

figure, axes = pyplot.subplots(figsize=(6.4, 4.2), layout="constrained")
colours = pyplot.colormaps["viridis"](np.linspace(0.05, 0.85, len(found.slip_studies)))
for study, colour in zip(found.slip_studies, colours, strict=True):
    label = (
        f"friction {study.friction_coefficient:g}: rank correlation {study.rank_correlation:.2f}"
    )
    axes.plot(study.stick_length_mm, study.gage_area_mm, "o-", color=colour, label=label, ms=4)
axes.set_xlabel("length that sticks, mm")
axes.set_ylabel("gage area, mm")
axes.legend(loc="upper left", fontsize=8)
pyplot.show()
