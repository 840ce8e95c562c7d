"""What a mold's plan says, and whether it is in the parts as they are made: proofs of the planner
and of the CAD, not of one mold.

The least slot and web of a plan against what process and comb hold; planned openings, pins, lugs
and plates in the triangles.
"""

import numpy as np
from manifold3d import Manifold

from fingerdesign.layout.volume import plate_volume
from fingerdesign.mold.checks.assembly import assemble
from fingerdesign.mold.part import BASE, CORE, Check
from fingerdesign.mold.plan.pieces import direction, in_space
from fingerdesign.mold.plan.slots import least_slot, least_web, webs

ROUND = 64  # sides of a bar that is tried in a round hole
TIGHT_MM = 2e-3  # of a bar, all round: round holes are polygons within their circles
TOUCHING_MM3 = 1e-4
WHOLE = 0.98  # of a pin that stands on its part


def as_planned(plan, meshes):
    """All checks of a plan, and of the parts that were made by it."""
    return [*plan_checks(plan), *built_checks(assemble(plan, meshes))]


def built_checks(assembly):
    """What is planned is there: every opening is free, pins and lugs stand, plates are whole.

    A hole that was filled leaves every part sound and the block filled; only the plan knows of it.
    """
    solids = assembly.solids
    openings, standing = list(_openings(assembly)), list(_standing(assembly))
    blocked = [
        f"{what} in {name}"
        for what, bar, names in openings
        for name in names
        if (bar ^ solids[name]).volume() > TOUCHING_MM3
    ]
    missing = [
        f"{what} on {name}"
        for what, bar, (name,) in standing
        if (bar ^ solids[name]).volume() < WHOLE * bar.volume()
    ]
    return [
        Check.none(
            *("planned openings", "", blocked, "places"),
            f"each of {len(openings)} planned holes, sockets and grooves is open",
            f"{len(blocked)} planned openings are blocked: first {{0}}",
        ),
        Check.none(
            *("pins and lugs", "", missing, "places"),
            f"each of {len(standing)} planned pins and lugs stands on its part",
            f"{len(missing)} planned pins or lugs are missing: first {{0}}",
        ),
        _plates(assembly),
    ]


def _openings(assembly):
    """Each opening that is planned, what must fit into it, and the parts that it passes."""
    plan, tight = assembly.plan, assembly.chord + TIGHT_MM
    down, combs = np.array([0.0, -1.0, 0.0]), tuple(s.comb for s in plan.sides if s.comb)
    for hole in plan.base_holes:
        outer = hole.diameter if hole.kind == "wires" else hole.outer_diameter
        sizes = hole.diameter - 2.0 * tight, outer - 2.0 * tight
        if hole.pocket:
            back = np.array([hole.x, -plan.base, hole.z])
            wide = hole.outer_diameter - 2.0 * tight
            yield "a pocket", round_bar(back, -hole.pocket * down, wide, wide), (BASE,)
            out = np.array([0.0, 0.0, plan.mount_z - hole.z])
            back[1] += 0.5 * hole.pocket
            yield "a channel", round_bar(back, out, 0.9 * hole.pocket, 0.9 * hole.pocket), (BASE,)
        bar = round_bar(np.array([hole.x, 0.0, hole.z]), plan.base * down, *sizes)
        yield f"the {hole.kind} at ({hole.x:.2f}, {hole.z:.2f})", bar, (BASE,)
    for held, slot, _ in plan.leg_slots:
        ends = plan.half(slot.side), plan.reach(slot.side)
        bar = slot_bar(slot, ends, tight)
        yield f"the slot of plate {slot.plate}, side {slot.side},", bar, (held.holder,)
    for held in plan.sides:
        for slot in held.outer.slots if held.outer else ():
            ends = plan.reach(held.side), plan.reach(held.side) + held.sheet
            what = f"the outer slot of plate {slot.plate}, side {held.side},"
            yield what, slot_bar(slot, ends, tight), (str(held.outer_comb),)
    every = tuple(part.name for part in assembly.meshes.parts if part.name != BASE)
    for number, bolt in enumerate(plan.bolts, 1):
        way, size = bolt.at(bolt.high) - bolt.at(bolt.low), bolt.diameter - 2.0 * tight
        what = f"bolt {number} ({bolt.size} along {bolt.axis})"
        yield what, round_bar(bolt.at(bolt.low), way, size, size), every
    for number, pin in enumerate(plan.pins, 1):
        room = pin_bar(pin, pin.clearance - tight)
        yield f"pin {number} of {pin.on}", room, (pin.into, *combs)
    for core_pin in plan.core_pins:
        side, size = core_pin.side, core_pin.diameter
        foot = in_space(side, core_pin.place, core_pin.y, core_pin.tip)
        way = (plan.reach(side) - core_pin.tip) * direction(side)
        passed = tuple({plan.by_side[side].wall, plan.by_side[side].holder, CORE})
        yield "a core pin", round_bar(foot, way, size, size), passed


def _standing(assembly):
    """Each pin and lug that a part has."""
    for number, pin in enumerate(assembly.plan.pins, 1):
        if not pin.dowel:
            yield f"pin {number}", pin_bar(pin, 0.0), (pin.on,)
    for lug in assembly.plan.lugs:
        low, high = np.array(lug.low), np.array(lug.high)
        yield f"a lug of {lug.on}", Manifold.cube(high - low).translate(low), (lug.on,)


def round_bar(foot, way, first, last):
    """A round bar from ``foot`` over ``way`` (3,), its diameters at both ends."""
    long = float(np.linalg.norm(way))
    axis = way / long
    side = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    side /= np.linalg.norm(side)
    bar = Manifold.cylinder(long, 0.5 * first, 0.5 * last, ROUND)
    return bar.transform(np.column_stack([side, np.cross(axis, side), axis, foot]))


def slot_bar(slot, ends, less):
    """A bar that fills a slot between two distances from the mid-plane, ``less`` smaller all
    round."""
    angle, middle = np.radians(slot.angle_deg), in_space(slot.side, slot.place, slot.y)
    along = in_space(slot.side, float(np.cos(angle)), float(np.sin(angle)))
    out = direction(slot.side)
    low, high = ends
    size = (slot.length - 2.0 * less, slot.width - 2.0 * less, high - low)
    bar = Manifold.cube(size, True)
    over = np.cross(out, along)
    return bar.transform(np.column_stack([along, over, out, middle + 0.5 * (low + high) * out]))


def pin_bar(pin, more):
    """A pin, or a dowel's outer half, ``more`` larger all round."""
    first, last = pin.diameter + 2.0 * more, pin.tip_diameter + 2.0 * more
    long = (0.5 * pin.length if pin.dowel else pin.length) + more
    return round_bar(np.array(pin.root), long * np.array(pin.direction), first, last)


def _plates(assembly):
    """Every plate of the plan is in the mold, no other, and each is no less than its span."""
    plan = assembly.plan
    made = {plate.name: plate.volume for plate in assembly.meshes.plates}
    wanted = {f"plate_{frame.index}": plate_volume(frame) for frame in plan.frames}
    wrong = sorted(set(made) ^ set(wanted))
    wrong += [name for name in wanted if name in made and made[name] < 0.999 * wanted[name]]
    right = f"all {len(wanted)} plates of the plan are in the mold"
    words = f"{len(wrong)} plates are missing, too many or too small: first {{0}}"
    return Check.none("plates", "", wrong, "plates", right, words)


_ROUNDING_MM = 1e-9
ROOM_MM = 0.005  # next to a plate, or it cannot be pushed in


def plan_checks(plan):
    """The least slot, web and room of a plate on every side that holds plates.

    What else is planned (walls, holes, pins, clearances) is refused before where it is too small.
    """
    return [c for side in plan.sides if side.slots for c in _side(plan, side)]


def _side(plan, side):
    least = least_slot(plan.design, side.holding, plan.limits)
    web = least_web(plan.design, side.holding, plan.limits)
    room = [slot.width - plan.thickness[slot.plate] for slot in side.slots]
    where, between = f"side {side.side}", webs(side.slots)[2]
    return [
        _least(
            "planned slots",
            where,
            [min(s.width, s.length) for s in side.slots],
            least,
            f"slot of {where}",
        ),
        _least("room of plates", where, room, ROOM_MM, f"room next to a plate, {where}"),
        _least("planned webs", where, between.tolist(), web, f"web of {where}"),
        *_outer(side, where, web),
    ]


def _outer(side, where, web):
    """The webs of a second comb."""
    if side.outer is None:
        return []
    between = webs(side.outer.slots)[2].tolist()
    what = f"web of the outer comb of {where}"
    return [_least("planned outer webs", where, between, web, what)]


def _least(name, where, sizes, bound, what):
    """Of nothing, nothing is too small."""
    title = f"{name}, {where}"
    least = min(sizes, default=np.inf)
    if not np.isfinite(least):
        return Check(title, "", True, None, bound, "mm", f"there is no {what}")
    sentence = f"the least {what} is {least:.3f} mm, {bound:g} mm are needed"
    return Check.least(title, "", least, bound, sentence, _ROUNDING_MM)
