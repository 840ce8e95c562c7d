"""Things in pictures that are neither parts nor plates, by the names of the casting notes' views:
gages with leads, bolts, core pins, bands, clay, tape; mm."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.part import CELL, COUPON_COMB, PartMesh, Point, point
from fingerdesign.mold.plan.mount import FLOOR_MM, INSERT_DEEP_MM, flange_holes
from fingerdesign.mold.plan.pieces import FLANKS, Side, direction, in_space, slot_corners
from fingerdesign.mold.plan.plan import MoldPlan, spacer_height
from fingerdesign.mold.plan.slots import leg_bar, sides_of_plate
from fingerdesign.mold.products.casting import Casting
from fingerdesign.mold.profile import AROUND_MM, SPACER_MM

Aids = Mapping[str, tuple[PartMesh, ...]]
GAGES = "gages"  # with their leads: they go where the plates go
PATCH_MM, BAND_MM, TAPE_MM = 0.06, 1.5, 6.0  # thick; thick; wide
_DOWN = (0.0, -1.0, 0.0)
CUT_MM = 1.5  # outside the combs: what is left of legs while these are drawn
_QUADS = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
BOX = np.array([(a, *two) for a, b, c, d in _QUADS for two in ((b, c), (c, d))])  # its triangles


def aids_of(casting: Casting) -> Aids:
    """Everything that a casting's pictures show besides its parts and plates, by name."""
    plan, meshes = casting.plan, casting.meshes
    gages = tuple(_bonded(plan))
    numbers = {f"plate_{frame.index}" for frame in casting.trial}
    found: dict[str, Iterable[PartMesh]] = {
        GAGES: gages,
        "one_plate": meshes.plates[:1],
        "one_gage": (each for each in gages if each.name.endswith("_0")),
        "trial": (plate for plate in meshes.plates if plate.name in numbers),
        "bands": _bands(plan),
        "band_base": (_ring("z", -1.0, (plan.reach_x, -plan.base, plan.top), 2.0),),
        "band_packet": [_ring("y", 0.5 * plan.rim, (plan.block_x, -plan.corner, plan.corner), 2.0)],
        "clay_windows": _windows(plan),
        "clay_slots": _slots(plan),
        "tape": _tape(plan),
        "clay_cell": _cell_clay(casting),
        "rubber_cell": _cell_rubber(casting),
        "spacers": _spacers(plan),
        "dowels": _dowels(plan),
        "inserts": _inserts(plan),
        "leg_ends": _legs(plan, True),
        "leg_stubs": _legs(plan, False),
        "bolts_y": _bolts(plan, "y"),
        "bolts_z": _bolts(plan, "z"),
        "core_pins_back": _pins(plan, "-z"),
        "core_pins_front": _pins(plan, "+z"),
        "core_pins_sides": _pins(plan, *FLANKS),
    }
    return {name: tuple(things) for name, things in found.items()}


def _solid(name: str, corners: Array, draw: Iterable[float] | None) -> PartMesh:
    """Boxes of corners (8 k, 3), each eight in BOX's order, as one thing."""
    triangles = np.vstack([BOX + 8 * k for k in range(len(corners) // 8)])
    way = None if draw is None else point(draw)
    return PartMesh(name, corners, triangles, way, 9, "metal", 0.0, 0.0, 0.0)


def _on_side(name: str, side: Side, near: Point, far: Point) -> PartMesh:
    """The box between two corners (place along a side, height, distance outward), drawn outward."""
    return _solid(name, _block(in_space(side, *near), in_space(side, *far)), direction(side))


def _block(low: Sequence[float] | Array, high: Sequence[float] | Array) -> Array:
    """Corners (8, 3) of the box between two points."""
    (a, b, c), (d, e, f) = np.minimum(low, high), np.maximum(low, high)
    return np.array([(x, y, z) for z in (c, f) for x, y in ((a, b), (d, b), (d, e), (a, e))])


def _bonded(plan: MoldPlan) -> Iterator[PartMesh]:
    """Gages on their plates' faces, and their leads to the plates' front ends, or out on the front
    legs, as thin plates: drawn larger than they are thick."""
    gages, leg = plan.design.gages, plan.design.mold.leads == "leg"
    for frame in plan.frames:
        tips = [each.tip for each in plan.legs_by_plate.get(frame.index, ()) if each.side[0] == "+"]
        end = max(tips) if leg and tips else frame.high
        edge = frame.middle + gages.z_mm + 0.5 * gages.width_mm
        wide = 0.25 * min(gages.length_mm, frame.length)
        for side in gages.sides:
            ends = edge - gages.width_mm, edge
            yield _patch(frame, f"gage_{frame.index}", side, 2.0 * wide, ends)
            yield _patch(frame, f"lead_{frame.index}", side, 0.5 * wide, (edge, end))


def _patch(
    frame: PlateFrame, name: str, side: float, half: float, ends: tuple[float, float]
) -> PartMesh:
    """A thin box on a plate's face (side 0: around it), +-``half`` about its middle."""
    near, far = 0.5 * frame.thickness, 0.5 * frame.thickness + PATCH_MM
    near, side = (-far, 1.0) if side == 0.0 else (near, side)
    section = np.array([[-half, near], [half, near], [half, far], [-half, far]])
    points = [frame.from_local(s, side * v) for s, v in section]
    return _solid(
        name, np.vstack([frame.to_space(np.atleast_2d(p), w) for w in ends for p in points]), None
    )


def _bolts(plan: MoldPlan, axis: str) -> Iterator[PartMesh]:
    """Bolts as bars along their axis."""
    along = np.eye(3)["xyz".index(axis)]
    for bolt in (bolt for bolt in plan.bolts if bolt.axis == axis):
        half = 0.45 * bolt.diameter * (1.0 - along)
        low, high = bolt.at(bolt.low - bolt.diameter), bolt.at(bolt.high + bolt.diameter)
        yield _solid(f"bolts_{axis}", _block(low - half, high + half), along)


def _pins(plan: MoldPlan, *sides: Side) -> Iterator[PartMesh]:
    """Core pins of some sides, as bars that reach out of the walls by a centimetre."""
    for pin in plan.core_pins:
        if pin.side in sides:
            half, out = 0.5 * pin.diameter, plan.reach(pin.side) + 10.0
            near, far = (
                (pin.place - half, pin.y - half, pin.tip),
                (pin.place + half, pin.y + half, out),
            )
            yield _on_side("pins", pin.side, near, far)


def _spacers(plan: MoldPlan) -> Iterator[PartMesh]:
    """The two spacers under the ends of the frame that is laid down first."""
    high, far, out = spacer_height(plan), plan.reach_x, plan.reach("-z")
    for near in (-far, far - SPACER_MM) if high else ():
        end = (near + SPACER_MM, SPACER_MM, out + high)
        yield _on_side("spacer", "-z", (near, 0.0, out), end)


def _dowels(plan: MoldPlan) -> Iterator[PartMesh]:
    """Steel pins, half of each in the part that it is pressed into."""
    for pin in plan.pins:
        if pin.dowel:
            way, root = np.array(pin.direction), np.array(pin.root)
            half = 0.5 * pin.diameter * (1.0 - np.abs(way)) + 0.5 * pin.length * np.abs(way)
            yield _solid("pins", _block(root - half, root + half), way)


def _inserts(plan: MoldPlan) -> Iterator[PartMesh]:
    """Threaded inserts in the receiver's back."""
    back = -plan.base - plan.limits.clearance_mm - FLOOR_MM
    for x, z, wide in flange_holes(plan):
        half = np.array([0.5 * wide, 0.0, 0.5 * wide])
        low, high = np.array([x, back, z]) - half, np.array([x, back + INSERT_DEEP_MM, z]) + half
        yield _solid("pins", _block(low, high), _DOWN)


def _legs(plan: MoldPlan, ends: bool) -> Iterator[PartMesh]:
    """Pieces that are cut off the legs: the ends beyond CUT_MM outside the combs, or the stubs that
    then remain; front legs with traces are not cut."""
    frames = {frame.index: frame for frame in plan.frames}
    for leg in plan.legs:
        if leg.side[0] == "+" and plan.design.mold.leads == "leg":
            continue
        sign, bar = (1.0 if leg.side[0] == "+" else -1.0), leg_bar(frames[leg.plate], leg)
        cut = min(leg.exit + plan.by_side[leg.side].sheet + CUT_MM, leg.tip)
        out = (cut, leg.tip) if ends else (leg.exit, cut)
        piece = _patch(bar, "plate", 0.0, 0.5 * bar.length, (sign * out[0], sign * out[1]))
        yield replace(piece, draw=point(direction(leg.side)))


def _ring(axis: str, place: float, sizes: Point, wide: float) -> PartMesh:
    """An elastic band about an axis at a place on it, ``wide`` along it, around a rectangle: half
    its size along x, then from low to high along the other axis."""
    x, low, high = sizes
    thick, half = BAND_MM, 0.5 * wide
    corners = []
    for a, b, c, d in (
        (-x - thick, low - thick, -x, high + thick),
        (x, low - thick, x + thick, high + thick),
        (-x, low - thick, x, low),
        (-x, high, x, high + thick),
    ):
        near, far = (a, b, place - half), (c, d, place + half)
        if axis == "y":
            near, far = (near[0], near[2], near[1]), (far[0], far[2], far[1])
        corners.append(_block(near, far))
    outward = (0.0, 0.0, 1.0 if place > -0.5 else -1.0)
    return _solid("band", np.vstack(corners), outward if axis == "z" else (0.0, 1.0, 0.0))


def _bands(plan: MoldPlan) -> Iterator[PartMesh]:
    """Bands of an open mold around insert and frames, at both ends, clear of the base plate; of a
    closed one around its four walls."""
    if plan.pour == "closed":
        yield _ring("y", 0.5 * plan.rim, (plan.reach_x, -plan.reach_z, plan.reach_z), 3.0)
        return
    far = max((abs(z) for lug in plan.lugs for z in (lug.low[2], lug.high[2])), default=0.0)
    for way in (1.0, -1.0):
        place = way * 0.5 * (max(far, plan.mount_z) + plan.reach_z)
        yield _ring("z", place, (plan.reach_x, 0.0, plan.top), 2.0)


def _windows(plan: MoldPlan) -> Iterator[PartMesh]:
    """Clay in the windows behind combs."""
    for side in plan.sides:
        if side.window is not None:
            left, right, bottom = side.window
            near = (left, bottom, plan.half(side.side) + side.sheet)
            yield _on_side("clay", side.side, near, (right, plan.rim, plan.reach(side.side)))


def _slots(plan: MoldPlan) -> Iterator[PartMesh]:
    """Clay around legs where they leave the slots of walls."""
    for side in plan.sides:
        if side.holding == "slots":
            for corners in slot_corners(side.slots):
                yield _lump(side.side, plan.reach(side.side), corners)


def _lump(side: Side, out: float, corners: Array) -> PartMesh:
    """Clay on a face at ``out``, half a millimetre around places (n, 2) on it."""
    low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
    return _on_side("clay", side, point([*low, out]), point([*high, out + 1.0]))


def _tape(plan: MoldPlan) -> Iterator[PartMesh]:
    """Tape over the seams of the flanks, clay on the slots of outer combs."""
    for side in plan.sides:
        if side.outer is not None:
            out = plan.reach(side.side) + side.sheet
            yield _lump(side.side, out, slot_corners(side.outer.slots).reshape(-1, 2))
    seams = (0.0,) if plan.pour == "open" else (-plan.corner, plan.corner)
    out = plan.reach_x if plan.pour == "open" else plan.block_x
    for flank in FLANKS:
        for z in seams:
            far = (z + 0.5 * TAPE_MM, plan.rim, out + 0.3)
            yield _on_side("tape", flank, (z - 0.5 * TAPE_MM, 0.0, out), far)
        far = (plan.reach_z, plan.rim + 0.5 * TAPE_MM, out + 0.3)
        yield _on_side("tape", flank, (-plan.reach_z, plan.rim - 0.5 * TAPE_MM, out), far)


def _cell_rubber(casting: Casting) -> Iterator[PartMesh]:
    """The casting in the coupon's cell."""
    if casting.trial:
        points = np.vstack([frame.corners() for frame in casting.trial])
        (left, low), (right, high) = points.min(axis=0) - AROUND_MM, points.max(axis=0) + AROUND_MM
        side = sides_of_plate(casting.trial[0])[0]
        out = casting.plan.half(side)
        ends = in_space(side, left, low, -out), in_space(side, right, high, out)
        yield _solid("rubber", _block(*ends), _DOWN)


def _cell_clay(casting: Casting) -> Iterator[PartMesh]:
    """Clay behind the coupon's combs, out to the cell's ends."""
    pieces = {piece.name: piece.vertices for piece in casting.meshes.coupon}
    cell = pieces.get(CELL)
    for name, points in pieces.items():
        if name.startswith(COUPON_COMB) and cell is not None:
            low, high = points.min(axis=0), points.max(axis=0)
            axis = int(np.argmin(high - low))
            out = float(np.sign(low[axis]))
            low, high = low + AROUND_MM * (np.arange(3) == 2 - axis), high - AROUND_MM
            low[axis] = np.abs(points[:, axis]).max() * out
            high[axis] = np.abs(cell[:, axis]).max() * out
            yield _solid("clay", _block(low, high), _DOWN)
