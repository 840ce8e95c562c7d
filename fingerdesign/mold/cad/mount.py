"""The mount: a receiver that the base plate slides into along its flanks' grooves, and its flange.

The base plate stays on the finger. A groove along z in each of its flanks (``MoldPlan.groove``)
takes the receiver's lips: slid in from the front until it stops, held by a screw through the floor
from behind. The receiver goes onto a hand by two threaded inserts in its back, or by the hole
pattern of ISO 9409-1-50-4-M6. In front of the base plate a trough takes legs that carry traces and
their connector. Importing this module loads the CAD kernel.
"""

from fingerdesign.cad.kernel import box, one_solid
from fingerdesign.mold.cad.build import INSERT_ORDER, BuiltPart
from fingerdesign.mold.cad.features import UP, cylinder
from fingerdesign.mold.part import MOUNT
from fingerdesign.mold.plan import mount as sizes
from fingerdesign.mold.plan.plan import MoldPlan


def build_mount(plan: MoldPlan) -> tuple[BuiltPart, ...]:
    """The receiver in its place on the closed mold's base plate; none where the plate is too thin
    for grooves. GeometryError where the kernel fails."""
    if plan.groove is None:
        return ()
    depth, low, high = plan.groove
    x, z, play = plan.mount_x, plan.mount_z, plan.limits.clearance_mm
    back, front = -z - sizes.SIDE_MM - play, z + sizes.TROUGH_MM[0] + 1.0 + sizes.SIDE_MM
    floor = -plan.base - play
    outer = x + play + sizes.SIDE_MM
    whole = box((-outer, floor - sizes.FLOOR_MM, back), (outer, high - play, front))
    if plan.design.mold.mount == "iso9409":
        disc = cylinder(sizes.ISO_DISC_MM, (0.0, floor - sizes.FLOOR_MM, 0.0), UP, sizes.FLOOR_MM)
        whole = one_solid(whole.fuse(disc).clean(), MOUNT)
    lip = x - depth + play
    cuts = [
        box((-x - play, floor, -z - play), (x + play, low + play, front + 1.0)),
        box((-lip, floor, -z - play), (lip, high + 1.0, front + 1.0)),
    ]
    trough = z + 0.5, z + 0.5 + sizes.TROUGH_MM[0]
    cuts.append(box((-x, floor - sizes.TROUGH_MM[1], trough[0]), (x, floor + 1.0, trough[1])))
    below, inserts = floor - sizes.FLOOR_MM - 1.0, plan.design.mold.mount == "inserts"
    for at, across, wide in sizes.flange_holes(plan):
        deep = sizes.INSERT_DEEP_MM if inserts else sizes.FLOOR_MM + 20.0
        cuts.append(cylinder(wide, (at, below, across), UP, deep + 1.0))
        if not inserts:  # the screw's head, on the floor
            cuts.append(cylinder(sizes.HEAD_MM + 2.0 * play, (at, floor, across), UP, 20.0))
    cuts.append(cylinder(sizes.STOP_SCREW_MM, (0.0, below, -0.5 * z), UP, sizes.FLOOR_MM + 2.0))
    solid = one_solid(whole.cut(*cuts).clean(), MOUNT)
    return (BuiltPart(MOUNT, solid, None, INSERT_ORDER, "process"),)
