"""Features of mold parts as solids: what is added to a blank, and what is cut out of it.

Pins are added to one part and, larger by their clearance, cut out of the other; lugs are added;
bolts, slots, windows and the base's holes are cut. Importing this module loads the CAD kernel.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.cad.bodies import plate_solid
from fingerdesign.cad.kernel import box, one_solid
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.cad.parting import block, prism_of, slab
from fingerdesign.mold.part import BASE, BASE_FRAME, CORE, INSERT
from fingerdesign.mold.plan import pieces
from fingerdesign.mold.plan.extent import seam_height
from fingerdesign.mold.plan.fasteners.core_pins import CORE_CLEARANCE_MM
from fingerdesign.mold.plan.fixture.outer import ROOMS_MM
from fingerdesign.mold.plan.limits import SPARE_MM
from fingerdesign.mold.plan.pieces import Side, SidePlan, across, direction, in_space
from fingerdesign.mold.plan.plan import MoldPlan

BEYOND_MM = 1.0  # how far a tool reaches out of what it cuts
ROOT_MM = 0.2  # how deep a pin or lug reaches into its part
PILOT = 0.72  # of a clearance hole: the core hole of the same screw's thread
STEEP = 0.5  # fall of a wall's top, mm per mm, from which its edge at a window is cut level
UP = np.array([0.0, 1.0, 0.0])


def cut_plates(plan: MoldPlan) -> tuple[cq.Solid, ...]:
    """Every plate as it is cut from sheet and lies in the mold: its span with its legs, one solid.

    GeometryError where the kernel fails, or where a leg does not touch its plate.
    """
    found = []
    for frame in plan.frames:
        legs = [_leg(frame, leg) for leg in plan.legs_by_plate.get(frame.index, ())]
        whole = plate_solid(frame)
        whole = whole.fuse(*legs).clean() if legs else whole
        found.append(one_solid(whole, f"plate {frame.index} with its legs"))
    return tuple(found)


def _leg(frame: PlateFrame, leg: pieces.Leg) -> cq.Solid:
    """A leg: a strip of the same sheet, bent as the plate is, beyond the plate's end."""
    place, y = frame.from_local(leg.offset, 0.0)[0].tolist()
    low, high = (leg.start, leg.tip) if leg.side[0] == "+" else (-leg.tip, -leg.start)
    turn = 0.0 if frame.bend_radius is None else float(np.degrees(leg.offset / frame.bend_radius))
    strip = replace(frame, place=place, y=y, angle_deg=frame.angle_deg - turn, length=leg.width)
    return plate_solid(replace(strip, low=low, high=high, holes=()))


def slot_tools(plan: MoldPlan, side: Side, slots: Sequence[pieces.Slot]) -> Iterator[cq.Solid]:
    """Make what is cut for slots of a side: prisms outward from the mid-plane, and their mouths."""
    reach = plan.reach(side) + BEYOND_MM
    for slot in slots:
        along, upward = _axes(slot)
        s, v = 0.5 * slot.length * along, 0.5 * slot.width * upward
        centre = in_space(side, slot.place, slot.y)
        corners = [centre - s - v, centre + s - v, centre + s + v, centre - s + v]
        yield prism_of(corners, reach * direction(side))
        if slot.mouth:
            out, low = slot.mouth
            (left, start), (right, end) = slot.lower
            edge = [(left, start), (right, end), (right, low), (left, low)]
            yield prism_of([in_space(side, *corner) for corner in edge], out * direction(side))


def _axes(slot: pieces.Slot) -> tuple[Array, Array]:
    """Unit vectors along a slot and across it, toward the upper side of its plate."""
    angle, level = np.radians(slot.angle_deg), across(slot.side)
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * level + sine * UP, cosine * UP - sine * level


def window_tools(plan: MoldPlan, planned: SidePlan) -> Iterator[cq.Solid]:
    """The window in the wall behind sheets, open toward the insert and outward.

    Where the wall's top falls off steeply next to the window, it is cut level over somewhat more
    than a wall, so that no feather edge is left there.
    """
    if planned.window is None:
        return
    land = 1.2 * plan.limits.wall_mm

    def seam(place: float) -> float:
        flank = planned.side.endswith("x")
        x, z = (plan.half_width, place) if flank else (place, plan.half_depth)
        return seam_height(plan, x, z)

    low, high, bottom = planned.window
    most = plan.half_width if planned.side.endswith("z") else plan.half_depth
    yield _opening(plan, planned.side, low, high, bottom)
    for edge, sign in ((low, -1.0), (high, 1.0)):
        beyond = edge + sign * land
        # Where the finger has ended the top is level: a sliver of its end would stay.
        foot = seam(beyond) - (SPARE_MM if abs(beyond) >= most else 0.0)
        if seam(edge) - foot > STEEP * land and foot > bottom:
            ends = sorted((edge, edge + sign * land))
            yield _opening(plan, planned.side, ends[0], ends[1], foot)


def _opening(plan: MoldPlan, side: Side, low: float, high: float, bottom: float) -> cq.Solid:
    """The box above ``bottom`` between two places, from the finger's face out of the block: what
    forms the finger's other sides stays."""
    far = (high, plan.top + BEYOND_MM, plan.reach(side) + BEYOND_MM)
    return slab(side, (low, bottom, plan.half(side)), far)


@dataclass(frozen=True)
class Features:
    """Solids to be added to the parts and then to be cut out of them, by part name."""

    added: defaultdict[str, list[cq.Solid]] = field(default_factory=lambda: defaultdict(list))
    cut: defaultdict[str, list[cq.Solid]] = field(default_factory=lambda: defaultdict(list))

    def take(self, solid: cq.Solid, *names: str) -> None:
        """``solid`` is cut out of the parts ``names``."""
        for name in names:
            self.cut[name].append(solid)


def features_of(plan: MoldPlan) -> Features:
    """Make every feature of a plan: fasteners, the base's holes, slots, windows, core holes."""
    found = Features()
    _fasten(found, plan)
    core = plan.design.body.core
    for hole in plan.base_holes:
        wires = hole.kind == "wires"
        for tool in _wire_way(hole, plan) if wires else [_base_hole(hole, plan.base)]:
            found.take(tool, BASE)
        if hole.kind == "screw" and core is not None:
            found.take(_pilot(hole, core.height_mm), CORE)
    for core_pin in plan.core_pins:
        names = {plan.by_side[core_pin.side].wall, plan.by_side[core_pin.side].holder}
        found.take(_core_pin(plan, core_pin, core_pin.clearance), *names)
        found.take(_core_pin(plan, core_pin, CORE_CLEARANCE_MM), CORE)
    _hold(found, plan)
    for planned in plan.sides:
        _open_side(found, plan, planned)
        for opening in window_tools(plan, planned):
            found.take(opening, planned.wall)
    return found


def _fasten(found: Features, plan: MoldPlan) -> None:
    """Add bolts' holes, pins with their sockets, and lugs."""
    combs = [side.comb for side in plan.sides if side.comb]
    for bolt in plan.bolts:
        way = UP if bolt.axis == "y" else direction("+z")
        long = bolt.high - bolt.low + 2.0 * BEYOND_MM
        bar = cylinder(bolt.diameter, bolt.at(bolt.low - BEYOND_MM), way, long)
        found.take(bar, INSERT, *plan.walls, *combs, BASE_FRAME)
    for pin in plan.pins:
        if pin.dowel:
            whole = _along(pin, -0.5 * pin.length, pin.diameter, BEYOND_MM, pin.diameter)
            found.take(whole, pin.on)
        else:
            found.added[pin.on].append(_pin(pin))
        found.take(_socket(pin), pin.into, *combs)
    for lug in plan.lugs:
        found.added[lug.on].append(_lug(lug, plan.seam + ROOT_MM))


def _hold(found: Features, plan: MoldPlan) -> None:
    """Cut the mount's grooves, and the insert's notches to pry it off and relief under combs."""
    if plan.groove is not None:
        depth, low, high = plan.groove
        x, beyond, far = plan.mount_x - depth, plan.mount_x + BEYOND_MM, plan.mount_z + BEYOND_MM
        for sign in (-1.0, 1.0):
            found.take(block((sign * x, low, -far), (sign * beyond, high, far)), BASE)
    if plan.pry:
        deep, high, half = pieces.PRY_MM
        reach, foot = plan.reach_x, seam_height(plan, plan.reach_x, 0.0)
        for sign in (-1.0, 1.0):
            inner = (sign * (reach - deep), foot - BEYOND_MM, -half)
            found.take(block(inner, (sign * (reach + BEYOND_MM), foot + high, half)), INSERT)
    for side in plan.sides:
        if side.outer is not None:
            wide, top = plan.reach_x + BEYOND_MM, side.outer.high + BEYOND_MM
            near = plan.reach_z - pieces.RELIEF_MM
            tool = slab(side.side, (-wide, 0.0, near), (wide, top, plan.reach_z + BEYOND_MM))
            found.take(tool, INSERT)


def _open_side(found: Features, plan: MoldPlan, planned: SidePlan) -> None:
    """Cut a side's slots, its outer comb's with room to slide on bolts, a half frame's seam."""
    side = planned.side
    for tool in slot_tools(plan, side, planned.slots):
        found.take(tool, planned.holder)
    if planned.outer and planned.outer_comb:
        for tool in slot_tools(plan, side, planned.outer.slots):
            found.take(tool, planned.outer_comb)
        for bolt in plan.bolts:
            wide, reach = bolt.diameter + 2.0 * ROOMS_MM[0], bolt.high + BEYOND_MM
            found.take(cylinder(wide, bolt.at(0.0), direction(side), reach), planned.outer_comb)
    if planned.framed and plan.seam > 0.0:
        low = (-plan.reach_x - BEYOND_MM, -BEYOND_MM, 0.0)
        high = (plan.reach_x + BEYOND_MM, plan.seam, plan.reach_z + BEYOND_MM)
        lugs = [_lug(lug, plan.seam) for lug in plan.lugs if lug.on == planned.wall]
        short = slab(side, low, high).cut(*lugs)
        found.take(one_solid(short, planned.wall), planned.wall)


def _lug(lug: pieces.Lug, root: float) -> cq.Solid:
    """A lug, up to ``root`` above the base plate's face."""
    x, y, z = lug.high
    return box(lug.low, (x, y + root, z))


def _pin(pin: pieces.Pin) -> cq.Solid:
    """A pin with a piece of its root inside of its part."""
    slope = (pin.tip_diameter - pin.diameter) / pin.length
    root = pin.diameter - ROOT_MM * slope
    return _along(pin, -ROOT_MM, root, pin.length, pin.tip_diameter)


def _socket(pin: pieces.Pin) -> cq.Solid:
    """The room of a pin, or of a dowel's outer half, with the clearance all round."""
    if pin.dowel:
        wide = pin.diameter + 2.0 * pin.clearance
        return _along(pin, -BEYOND_MM, wide, 0.5 * pin.length + pin.clearance, wide)
    slope = (pin.tip_diameter - pin.diameter) / pin.length
    more = 2.0 * pin.clearance * float(np.hypot(1.0, 0.5 * slope))  # across the leaning side
    first = pin.diameter + more - BEYOND_MM * slope
    return _along(pin, -BEYOND_MM, first, pin.length + pin.clearance, pin.tip_diameter + more)


def _along(pin: pieces.Pin, start: float, first: float, end: float, last: float) -> cq.Solid:
    """A round bar along a pin between distances from its root, with its diameters there."""
    way = np.array(pin.direction)
    return _cone(np.array(pin.root) + start * way, way, first, last, end - start)


def _cone(foot: Array, way: Array, first: float, last: float, length: float) -> cq.Solid:
    """The cone (or cylinder) of diameters ``first`` at ``foot`` and ``last`` at its other end."""
    if abs(first - last) < 1e-9:
        return cylinder(first, foot, way, length)
    return cq.Solid.makeCone(0.5 * first, 0.5 * last, length, cq.Vector(*foot), cq.Vector(*way))


def cylinder(diameter: float, foot: Iterable[float], way: Array, length: float) -> cq.Solid:
    """The cylinder of a diameter and a length along a unit vector from ``foot``, (3,)."""
    return cq.Solid.makeCylinder(0.5 * diameter, length, cq.Vector(*foot), cq.Vector(*way))


def _base_hole(hole: pieces.BaseHole, base: float) -> cq.Solid:
    """A hole through the base plate, as wide as planned at its two faces."""
    slope = (hole.outer_diameter - hole.diameter) / base
    first = hole.diameter - BEYOND_MM * slope
    if first <= 0.1 * hole.diameter:  # it would end in a point before it is out
        slope, first = 0.0, hole.diameter
    last = hole.diameter + (base + BEYOND_MM) * slope
    foot = np.array([hole.x, BEYOND_MM, hole.z])
    return _cone(foot, -UP, first, last, base + 2.0 * BEYOND_MM)


def _wire_way(hole: pieces.BaseHole, plan: MoldPlan) -> Iterator[cq.Solid]:
    """The way of leads through the base plate: hole, pocket on the back, channel to the front."""
    foot = (hole.x, BEYOND_MM, hole.z)
    yield cylinder(hole.diameter, foot, -UP, plan.base + 2.0 * BEYOND_MM)
    if hole.pocket > 0.0:
        floor, back = hole.pocket - plan.base, -plan.base - BEYOND_MM
        yield cylinder(hole.outer_diameter, (hole.x, back, hole.z), UP, floor - back)
        half = 0.5 * hole.diameter
        far = (hole.x + half, floor, plan.mount_z + BEYOND_MM)
        yield box((hole.x - half, back, hole.z), far)


def _pilot(hole: pieces.BaseHole, height: float) -> cq.Solid:
    """A screw's pilot hole in the core, from the base up, as deep as its thread holds."""
    depth = min(2.5 * hole.diameter, max(height - 1.5, 0.5 * height))
    foot = (hole.x, -BEYOND_MM, hole.z)
    return cylinder(PILOT * hole.diameter, foot, UP, depth + BEYOND_MM)


def _core_pin(plan: MoldPlan, pin: pieces.CorePin, clearance: float) -> cq.Solid:
    """The hole of a core pin, from its tip out of the block, with the clearance all round."""
    start = pin.tip - clearance
    foot = in_space(pin.side, pin.place, pin.y, start)
    long = plan.reach(pin.side) + BEYOND_MM - start
    return cylinder(pin.diameter + 2.0 * clearance, foot, direction(pin.side), long)
