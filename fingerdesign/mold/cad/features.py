"""Features of mold parts as solids: what is added to a blank, and what is cut out of it.

Pins and keys are added to one part and, larger by their clearance, cut out of the other; bolts,
slots, windows and the base's holes are cut. Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.cad.bodies import core_solid, plate_solid
from fingerdesign.cad.kernel import (
    Line,
    box,
    circle,
    extruded,
    flat_face,
    one_solid,
    polygon,
    revolved,
)
from fingerdesign.design.body import Body
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.cad.parting import AXIS, across, direction, prism_of
from fingerdesign.mold.part import BASE, CORE, INSERT, comb_names, wall_name
from fingerdesign.mold.plan.extent import extent_of, seam_height
from fingerdesign.mold.plan.plan import (
    SIDES,
    BaseHole,
    Bolt,
    CorePin,
    Key,
    Leg,
    MoldPlan,
    Pin,
    Side,
    SidePlan,
    Slot,
    limits_of,
)
from fingerdesign.mold.plan.slots import core_in_mold

# What is cast into the finger, as solids in mold space: plates with their legs, and the core.
#
# A flat plate with legs is one holed face drawn through its thickness. A bent plate's legs are
# pieces of the same bent sheet, joined to it. Importing this module loads the CAD kernel.

_NEAR = 1e-9


def cut_plate(frame: PlateFrame, legs: tuple[Leg, ...]) -> cq.Solid:
    """A plate as it is cut from sheet and lies in the mold: its span with its legs, one solid.

    GeometryError where the kernel fails, or where a leg does not touch its plate.
    """
    own = [leg for leg in legs if leg.plate == frame.index and leg.tip > leg.start + _NEAR]
    what = f"plate {frame.index} with its legs"
    if frame.bend_radius is None:
        return _flat(frame, own)
    if not own:
        return plate_solid(frame)
    pieces = [_bent_leg(frame, leg) for leg in own]
    return one_solid(plate_solid(frame).fuse(*pieces).clean(), what)


def cut_plates(plan: MoldPlan) -> tuple[cq.Solid, ...]:
    """Every plate with its legs, in the order of the plan's frames."""
    return tuple(cut_plate(frame, plan.legs) for frame in plan.frames)


def core_block(body: Body, scale: float) -> cq.Solid:
    """The core in mold space, before its holes; GeometryError for a body without one."""
    return core_solid(_body_in_mold(body, scale))


def core_room(body: Body, scale: float, half_depth: float) -> cq.Solid:
    """What the core takes from the rubber: itself, drawn out of the faces that it reaches."""
    moved = _body_in_mold(body, scale)
    bounds = core_solid(moved).BoundingBox()
    core = moved.core
    assert core is not None
    low = 0.0 if core.bottom_mm == 0.0 else core.bottom_mm
    floor = low - BEYOND_MM if low == 0.0 else low
    z = 0.5 * (core.depth_mm if core.depth_mm is not None else body.depth_mm)
    if z > half_depth - 1e-6:
        z += BEYOND_MM
    x = 0.5 * core.width_mm
    return box((-x, floor, -z), (x, min(low + core.height_mm, bounds.ymax + 1.0), z))


def _body_in_mold(body: Body, scale: float) -> Body:
    core = None if body.core is None else core_in_mold(body.core, scale)
    return body.model_copy(update={"core": core})


def _flat(frame: PlateFrame, legs: list[Leg]) -> cq.Solid:
    """The holed outline of plate and legs, drawn from the lower to the upper side."""
    outline = flat_outline(frame, legs)
    v = 0.5 * frame.thickness
    corners = [frame.to_space(frame.from_local(s, -v), w)[0] for s, w in outline]
    upward = frame.direction(frame.normal)
    across = np.eye(3)[2 if frame.along == "x" else 0]
    face_normal = np.cross(frame.direction(frame.axis), across)
    holes = [
        circle(frame.to_space(frame.from_local(h.s, -v), h.w)[0], -face_normal, h.radius)
        for h in frame.holes
    ]
    return extruded(flat_face(polygon(corners), holes), frame.thickness * upward)


def flat_outline(frame: PlateFrame, legs: list[Leg]) -> list[tuple[float, float]]:
    """Corners (s along the plate, w across the row) of plate and legs, anticlockwise, without
    those that lie on a straight line."""
    half = 0.5 * frame.length
    ways = {leg.side[0]: leg for leg in legs}
    corners = [(-half, frame.low)]
    if "-" in ways:
        corners += _leg_corners(ways["-"], frame.low, -1.0)
    corners += [(half, frame.low), (half, frame.high)]
    if "+" in ways:
        corners += _leg_corners(ways["+"], frame.high, 1.0)
    corners.append((-half, frame.high))
    return _without_idle(corners)


def _leg_corners(leg: Leg, end: float, sign: float) -> list[tuple[float, float]]:
    """Four corners of a leg, going from -s to +s at the low end, from +s to -s at the high one."""
    near, far = leg.offset + 0.5 * sign * leg.width, leg.offset - 0.5 * sign * leg.width
    tip = sign * leg.tip
    return [(near, end), (near, tip), (far, tip), (far, end)]


def _without_idle(corners: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """A closed polygon without double corners and those between neighbours in one line."""
    kept = list(corners)
    while True:
        for k, here in enumerate(kept):
            before, after = kept[k - 1], kept[(k + 1) % len(kept)]
            one = (here[0] - before[0], here[1] - before[1])
            two = (after[0] - here[0], after[1] - here[1])
            if abs(one[0] * two[1] - one[1] * two[0]) < _NEAR:
                del kept[k]
                break
        else:
            return kept


def _bent_leg(frame: PlateFrame, leg: Leg) -> cq.Solid:
    """A leg of a bent plate: a strip of the same bent sheet beyond the plate's end."""
    radius = float(frame.bend_radius or 0.0)
    place, y = frame.from_local(leg.offset, 0.0)[0]
    ends = sorted((leg.start, leg.tip)) if leg.side[0] == "+" else sorted((-leg.tip, -leg.start))
    strip = replace(
        frame,
        place=float(place),
        y=float(y),
        angle_deg=frame.angle_deg - float(np.degrees(leg.offset / radius)),
        length=leg.width,
        low=ends[0],
        high=ends[1],
        holes=(),
    )
    return plate_solid(strip)


# Openings for plates' legs as solids: slots in combs, jigs and walls, windows behind sheets.
#
# Importing this module loads the CAD kernel.

STEEP = 0.5  # fall of a wall's top, mm per mm, from which its edge at a window is cut level
_UP = np.array([0.0, 1.0, 0.0])


def slot_tools(plan: MoldPlan, planned: SidePlan) -> Iterator[tuple[str, cq.Solid]]:
    """What is cut for the slots of a side: names of parts, and a tool for each.

    The slots of a jig's inner sheet lie toward the plates' upper side by its shift, those of the
    outer one toward the lower: so, level with each other, the sheets clamp the plates.
    """
    side = planned.side
    sheets = comb_names(side, planned.holding)
    reach = (plan.reach_x if side.endswith("x") else plan.reach_z) + BEYOND_MM
    for slot in planned.slots:
        if not sheets:
            yield from ((wall_name(side), tool) for tool in _opening_tools(slot, 0.0, reach))
        for k, name in enumerate(sheets):
            shift = planned.shift * (1.0 - 2.0 * k) if len(sheets) > 1 else 0.0
            yield from ((name, tool) for tool in _opening_tools(slot, shift, reach))


def jig_moves(plan: MoldPlan, clearance: float) -> Iterator[tuple[str, Array]]:
    """How the pins' holes in the sheets of jigs are moved: (sheet, vector).

    By the pins' clearance, against the sheet's own shift: the pins then bear on the holes' sides
    and keep the sheets from slipping back, however loose they are.
    """
    for planned in plan.sides:
        if planned.holding == "jig" and planned.slots:
            upward = upper_side(planned.slots[0])
            for k, name in enumerate(comb_names(planned.side, planned.holding)):
                yield name, -clearance * (1.0 - 2.0 * k) * upward


def _opening_tools(slot: Slot, shift: float, reach: float) -> Iterator[cq.Solid]:
    """A slot's rectangle, and the round relief for the leads at its end."""
    yield slot_solid(slot, shift, reach)
    if slot.relief:
        away = direction(slot.side)
        place, y = slot.relief_centre
        foot = place * across(slot.side) + y * _UP + shift * upper_side(slot)
        yield cq.Solid.makeCylinder(0.5 * slot.relief, reach, cq.Vector(*foot), cq.Vector(*away))


def upper_side(slot: Slot) -> Array:
    """Unit vector across a slot, toward the upper side of its plate."""
    angle = np.radians(slot.angle_deg)
    return np.asarray(-np.sin(angle) * across(slot.side) + np.cos(angle) * _UP)


def slot_solid(slot: Slot, shift: float, reach: float) -> cq.Solid:
    """A slot's rectangle, moved by ``shift`` toward the upper side, drawn out from the mid-plane:
    it is cut out of one part alone."""
    away, level = direction(slot.side), across(slot.side)
    angle = np.radians(slot.angle_deg)
    along = np.cos(angle) * level + np.sin(angle) * _UP
    upward = upper_side(slot)
    centre = slot.place * level + slot.y * _UP + shift * upward
    s, v = 0.5 * slot.length * along, 0.5 * slot.width * upward
    corners = [centre - s - v, centre + s - v, centre + s + v, centre - s + v]
    return prism_of(corners, reach * away)


def window_tools(
    plan: MoldPlan, planned: SidePlan, seam: Callable[[float], float], land: float
) -> Iterator[cq.Solid]:
    """The window in the wall behind sheets, open toward the insert and outward.

    Where the wall's top, of height ``seam(place)``, falls off steeply beside the window, it is cut
    level over ``land`` mm, so that no feather edge is left there.
    """
    if planned.window is None:
        return
    low, high, bottom = planned.window
    yield _opening(plan, planned.side, low, high, bottom)
    for edge, sign in ((low, -1.0), (high, 1.0)):
        foot = seam(edge + sign * land)
        if seam(edge) - foot > STEEP * land and foot > bottom:
            ends = sorted((edge, edge + sign * land))
            yield _opening(plan, planned.side, ends[0], ends[1], foot)


def _opening(plan: MoldPlan, side: Side, low: float, high: float, bottom: float) -> cq.Solid:
    """The box above ``bottom`` between two places, from the mid-plane out of the block."""
    reach = plan.reach_x if side.endswith("x") else plan.reach_z
    one = low * across(side) + bottom * _UP
    other = (
        (reach + BEYOND_MM) * direction(side) + high * across(side) + (plan.top + BEYOND_MM) * _UP
    )
    return box(np.minimum(one, other).tolist(), np.maximum(one, other).tolist())


BEYOND_MM = 1.0  # how far a tool reaches out of what it cuts
ROOT_MM = 0.2  # how deep a pin or key reaches into what it stands on
PILOT = 0.72  # of a clearance hole: the core hole of the same screw's thread


@dataclass(frozen=True)
class Features:
    """Solids to be added to the parts and then to be cut out of them, by part name."""

    added: dict[str, list[cq.Solid]] = field(default_factory=dict)
    cut: dict[str, list[cq.Solid]] = field(default_factory=dict)

    def add(self, name: str, solid: cq.Solid) -> None:
        """``solid`` becomes part of ``name``."""
        self.added.setdefault(name, []).append(solid)

    def take(self, solid: cq.Solid, *names: str) -> None:
        """``solid`` is cut out of the parts ``names``."""
        for name in names:
            self.cut.setdefault(name, []).append(solid)


def features_of(design: Design, plan: MoldPlan) -> Features:
    """Every feature of a plan: pins, keys, bolts, the base's holes, slots, windows, core holes."""
    found = Features()
    walls = [wall_name(side) for side in SIDES]
    sheets = [name for side in SIDES for name in _sheets(plan, side)]
    for bolt in plan.bolts:
        found.take(_bolt(bolt), INSERT, *walls, *sheets, BASE)
    for pin in plan.pins:
        if pin.dowel:
            found.take(_dowel_hole(pin), pin.on)
        else:
            found.add(pin.on, _pin(pin))
        found.take(_socket(pin), pin.into, *_combs(plan, sheets))
        for name, move in jig_moves(plan, pin.clearance):
            found.take(_socket(pin).translate(cq.Vector(*move)), name)
    for key in plan.keys:
        found.add(BASE, rib(key, _side_of(key.into)))
        found.take(groove(key, _side_of(key.into)), key.into, *sheets)
    core = design.body.core
    for hole in plan.base_holes:
        found.take(_base_hole(hole, plan.base), BASE)
        if hole.kind == "screw" and core is not None:
            found.take(_pilot(hole, core.height_mm), CORE)
    limits = limits_of(design.mold)
    clearance, land = limits.clearance_mm, 1.2 * limits.wall_mm
    for core_pin in plan.core_pins:
        names = (wall_name(core_pin.side), *_sheets(plan, core_pin.side), CORE)
        found.take(_core_pin(plan, core_pin, clearance), *names)
    for planned in plan.sides:
        for name, tool in slot_tools(plan, planned):
            found.take(tool, name)
        for opening in window_tools(plan, planned, _seam(design, plan, planned.side), land):
            found.take(opening, wall_name(planned.side))
    return found


def _seam(design: Design, plan: MoldPlan, side: Side) -> Callable[[float], float]:
    """Height of a wall's top over places along its side."""
    extent = extent_of(design, plan.scale)

    def height(place: float) -> float:
        x, z = (plan.half_width, place) if side.endswith("x") else (place, plan.half_depth)
        return seam_height(design, extent, plan.scale, x, z)

    return height


def _sheets(plan: MoldPlan, side: Side) -> tuple[str, ...]:
    return comb_names(side, plan.side(side).holding)


def _combs(plan: MoldPlan, sheets: list[str]) -> list[str]:
    """The sheets whose pins stand in the middle of their holes: not those of a jig."""
    jigs = [name for name, _ in jig_moves(plan, 0.0)]
    return [name for name in sheets if name not in jigs]


def _side_of(wall: str) -> Side:
    return next(side for side in SIDES if wall_name(side) == wall)


def _bolt(bolt: Bolt) -> cq.Solid:
    if bolt.axis == "y":
        start, way = np.array([bolt.first, bolt.low - BEYOND_MM, bolt.second]), _UP
    else:
        start, way = np.array([bolt.first, bolt.second, bolt.low - BEYOND_MM]), direction("+z")
    return _cylinder(bolt.diameter, start, way, bolt.high - bolt.low + 2.0 * BEYOND_MM)


def _pin(pin: Pin) -> cq.Solid:
    """A pin with a piece of its root inside of the part that it stands on."""
    slope = (pin.tip_diameter - pin.diameter) / pin.length
    root = pin.diameter - ROOT_MM * slope
    return _cone(pin, -ROOT_MM, root, pin.length, pin.tip_diameter)


def _socket(pin: Pin) -> cq.Solid:
    """The room of a pin, or of a dowel's outer half, with the clearance all round."""
    if pin.dowel:
        wide = pin.diameter + 2.0 * pin.clearance
        return _cone(pin, -BEYOND_MM, wide, 0.5 * pin.length + pin.clearance, wide)
    slope = (pin.tip_diameter - pin.diameter) / pin.length
    more = 2.0 * pin.clearance * float(np.hypot(1.0, 0.5 * slope))  # across the leaning side
    first = pin.diameter + more - BEYOND_MM * slope
    last = pin.tip_diameter + more
    return _cone(pin, -BEYOND_MM, first, pin.length + pin.clearance, last)


def _dowel_hole(pin: Pin) -> cq.Solid:
    return _cone(pin, -0.5 * pin.length, pin.diameter, BEYOND_MM, pin.diameter)


def _cone(pin: Pin, start: float, first: float, end: float, last: float) -> cq.Solid:
    """A round bar along a pin between distances from its root, with its diameters there."""
    way = np.array(pin.direction) / np.linalg.norm(pin.direction)
    foot = np.array(pin.root) + start * way
    return cone(foot, way, first, last, end - start)


def cone(foot: Array, way: Array, first: float, last: float, length: float) -> cq.Solid:
    """The cone (or cylinder) of diameters ``first`` at ``foot`` and ``last`` at its other end."""
    if abs(first - last) < 1e-9:
        return _cylinder(first, foot, way, length)
    across = np.cross(way, np.eye(3)[int(np.argmin(np.abs(way)))])
    across /= np.linalg.norm(across)
    tip = foot + length * way
    corners = [foot, foot + 0.5 * first * across, tip + 0.5 * last * across, tip]
    lines: list[Line] = [
        Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    return revolved(flat_face(lines), foot, way, 360.0)


def _cylinder(diameter: float, foot: Array, way: Array, length: float) -> cq.Solid:
    return cq.Solid.makeCylinder(0.5 * diameter, length, cq.Vector(*foot), cq.Vector(*way))


def rib(key: Key, side: Side) -> cq.Solid:
    """A key: a rib along the side's direction, its long sides leaning by its draft."""
    return _between(key, side, 0.0, -ROOT_MM, key.high[1], *_ends(key, side))


def groove(key: Key, side: Side) -> cq.Solid:
    """A key's groove: the rib with the clearance, and open inward, so that the wall can slide off
    along its draw."""
    end = _ends(key, side)[1] + key.clearance
    return _between(key, side, key.clearance, -BEYOND_MM, key.high[1] + key.clearance, 0.0, end)


def _ends(key: Key, side: Side) -> list[float]:
    """Distances outward at which a key begins and ends."""
    return sorted(float(np.array(corner) @ direction(side)) for corner in (key.low, key.high))


def _between(
    key: Key, side: Side, more: float, bottom: float, top: float, start: float, end: float
) -> cq.Solid:
    """The key's section, ``more`` wider all round, drawn from ``start`` to ``end`` outward."""
    away, axis = direction(side), 2 - AXIS[side[1]]
    lean = np.tan(np.radians(key.draft_deg))
    wider = more * float(np.hypot(1.0, lean))  # across the leaning side
    left, right = key.low[axis] - wider, key.high[axis] + wider
    corners = [
        start * away + place * across(side) + height * _UP
        for place, height in (
            (left + lean * bottom, bottom),
            (right - lean * bottom, bottom),
            (right - lean * top, top),
            (left + lean * top, top),
        )
    ]
    return prism_of(corners, (end - start) * away)


def _base_hole(hole: BaseHole, base: float) -> cq.Solid:
    """A hole through the base plate, as wide as planned at its two faces."""
    slope = (hole.outer_diameter - hole.diameter) / base
    first = hole.diameter - BEYOND_MM * slope
    if first <= 0.1 * hole.diameter:  # it would end in a point before it is out
        slope, first = 0.0, hole.diameter
    return cone(
        np.array([hole.x, BEYOND_MM, hole.z]),
        -_UP,
        first,
        hole.diameter + (base + BEYOND_MM) * slope,
        base + 2.0 * BEYOND_MM,
    )


def _pilot(hole: BaseHole, height: float) -> cq.Solid:
    """A screw's pilot hole in the core, from the base up, as deep as its thread holds."""
    depth = min(2.5 * hole.diameter, max(height - 1.5, 0.5 * height))
    foot = np.array([hole.x, -BEYOND_MM, hole.z])
    return _cylinder(PILOT * hole.diameter, foot, _UP, depth + BEYOND_MM)


def _core_pin(plan: MoldPlan, pin: CorePin, clearance: float) -> cq.Solid:
    """The hole of a core pin, from its tip out of the block, with the clearance all round."""
    away = direction(pin.side)
    reach = plan.reach_x if pin.side.endswith("x") else plan.reach_z
    start = pin.tip - clearance
    foot = start * away + pin.place * across(pin.side) + pin.y * _UP
    diameter = pin.diameter + 2.0 * clearance
    return _cylinder(diameter, foot, away, reach + BEYOND_MM - start)
