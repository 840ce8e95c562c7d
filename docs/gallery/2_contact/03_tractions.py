"""
Tractions on a finger with plates
=================================

Stiff plates below the surface cause ripples of the pressure. With more shear, the shear
traction reaches the dashed limit, friction times pressure, from the edges inward.
"""

from matplotlib import pyplot

from fingerdesign import parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design
from fingerdesign.pipeline import run

scene = parse_scene("""
object.friction_coefficient = 0.5
path.increments_mm = [[0.1, 0.0], [0.1, 0.04], [0.1, 0.08], [0.1, 0.12]]
""")
found = run(Case(load_design("maeno2000"), scene, "plane-strain"))
contact, steps = found.contact, found.result.increments
order = contact.mid_line()  # by rising x
x = contact.points[order, 0]

figure, rows = pyplot.subplots(
    len(steps), 1, figsize=(7.2, 6.0), sharex=True, sharey=True, layout="constrained"
)
for k, axes in enumerate(rows):
    normal = contact.normal_traction[k, order]
    shear = contact.tangential_traction[k, order, 0]
    axes.plot(x, normal, color="#0b6fb0", lw=1.2, label="pressure")
    axes.plot(x, 0.5 * normal, color="#6c6f73", lw=0.9, ls="--", label="friction times pressure")
    axes.fill_between(x, shear, color="#d2560a", alpha=0.35, lw=0.0, label="shear traction")
    axes.plot(x, shear, color="#d2560a", lw=1.0)
    shear_um, ratio = 1e3 * steps[k].shear_mm, steps[k].stick_ratio
    axes.set_title(f"sheared by {shear_um:.0f} µm: {ratio:.0%} sticks")
rows[0].legend(ncols=3, loc="upper right")
rows[0].set_ylim(top=1.45 * contact.normal_traction.max())
rows[-1].set_xlim(-2.8, 2.8)
rows[-1].set_xlabel("x, mm")
figure.supylabel("traction, MPa", fontsize=9)
pyplot.show()
