"""Things in pictures that are neither parts nor plates, by the names of the casting notes' views:
gages with leads, bolts, core pins, bands, clay, tape; mm."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.part import CELL, COUPON_COMB, PartMesh
from fingerdesign.mold.plan.mount import FLOOR_MM, INSERT_DEEP_MM, flange_holes
from fingerdesign.mold.plan.pieces import FLANKS, Bolt, Side, direction, in_space, slot_corners
from fingerdesign.mold.plan.plan import MoldPlan, spacer_height
from fingerdesign.mold.plan.slots import leg_bar, sides_of_plate
from fingerdesign.mold.products.casting import Casting
from fingerdesign.mold.profile import AROUND_MM, SPACER_MM

Aids = Mapping[str, tuple[PartMesh, ...]]
GAGES = "gages"  # with their leads: they go where the plates go
PATCH_MM, BAND_MM, TAPE_MM = 0.06, 1.5, 6.0  # thick; thick; wide
CUT_MM = 1.5  # outside the combs: what is left of legs while these are drawn
_QUADS = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
BOX = np.array([(a, *two) for a, b, c, d in _QUADS for two in ((b, c), (c, d))])  # its triangles
_Point = tuple[float, float, float]


def aids_of(casting: Casting) -> Aids:
    """Everything that a casting's pictures show besides its parts and plates, by name."""
    plan, meshes = casting.plan, casting.meshes
    gages = tuple(_bonded(plan))
    numbers = {f"plate_{frame.index}" for frame in casting.trial}
    found = {
        GAGES: gages,
        "one_plate": meshes.plates[:1],
        "one_gage": tuple(each for each in gages if each.name.endswith("_0")),
        "trial": tuple(plate for plate in meshes.plates if plate.name in numbers),
        "bands": tuple(_bands(plan)),
        "band_base": (_ring("z", -1.0, (plan.reach_x, -plan.base, plan.top), 2.0),),
        "band_packet": (
            _ring("y", 0.5 * plan.rim, (plan.block_x, -plan.corner, plan.corner), 2.0),
        ),
        "clay_windows": tuple(_windows(plan)),
        "clay_slots": tuple(_slots(plan)),
        "tape": tuple(_tape(plan)),
        "clay_cell": tuple(_cell_clay(casting)),
        "rubber_cell": tuple(_cell_rubber(casting)),
        "spacers": tuple(_spacers(plan)),
        "dowels": tuple(_dowels(plan)),
        "inserts": tuple(_inserts(plan)),
        "leg_ends": tuple(_legs(plan, True)),
        "leg_stubs": tuple(_legs(plan, False)),
    }
    for axis in "yz":
        found[f"bolts_{axis}"] = tuple(_bolt(bolt) for bolt in plan.bolts if bolt.axis == axis)
    for name, sides in (("back", ("-z",)), ("front", ("+z",)), ("sides", ("+x", "-x"))):
        found[f"core_pins_{name}"] = tuple(each for each in _pins(plan, sides))
    return found


def _solid(name: str, corners: Array, draw: Array | None) -> PartMesh:
    """Boxes of corners (8 k, 3), each eight in BOX's order, as one thing."""
    triangles = np.vstack([BOX + 8 * k for k in range(len(corners) // 8)])
    way = None if draw is None else (float(draw[0]), float(draw[1]), float(draw[2]))
    return PartMesh(name, corners, triangles, way, 9, "metal", 0.0, 0.0, 0.0)


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
    """A thin box on a plate's face (side 0: around the plate), +-``half`` about its middle, between
    two places across."""
    near, far = 0.5 * frame.thickness, 0.5 * frame.thickness + PATCH_MM
    near, side = (-far, 1.0) if side == 0.0 else (near, side)
    section = np.array([[-half, near], [half, near], [half, far], [-half, far]])
    points = [frame.from_local(s, side * v) for s, v in section]
    return _solid(
        name, np.vstack([frame.to_space(np.atleast_2d(p), w) for w in ends for p in points]), None
    )


def _bolt(bolt: Bolt) -> PartMesh:
    """A bolt as a bar along its axis."""
    along = np.array([0.0, 1.0, 0.0] if bolt.axis == "y" else [0.0, 0.0, 1.0])
    half = 0.45 * bolt.diameter * (1.0 - along)
    ends = bolt.at(bolt.low - bolt.diameter), bolt.at(bolt.high + bolt.diameter)
    return _solid(f"bolts_{bolt.axis}", _block(ends[0] - half, ends[1] + half), along)


def _pins(plan: MoldPlan, sides: Sequence[str]) -> Iterator[PartMesh]:
    """Core pins of some sides, as bars that reach out of the walls by a centimetre."""
    for pin in plan.core_pins:
        if pin.side in sides:
            half, out = 0.5 * pin.diameter, plan.reach(pin.side) + 10.0
            low = in_space(pin.side, pin.place - half, pin.y - half, pin.tip)
            high = in_space(pin.side, pin.place + half, pin.y + half, out)
            yield _solid("pins", _block(low, high), direction(pin.side))


def _spacers(plan: MoldPlan) -> Iterator[PartMesh]:
    """The two spacers under the ends of the frame that is laid down first."""
    high, far, out = spacer_height(plan), plan.reach_x, plan.reach("-z")
    for near in (-far, far - SPACER_MM) if high else ():
        low, top = (near, 0.0, -out - high), (near + SPACER_MM, SPACER_MM, -out)
        yield _solid("spacer", _block(low, top), np.array([0.0, 0.0, -1.0]))


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
        ends = np.array([x, back, z]), np.array([x, back + INSERT_DEEP_MM, z])
        yield _solid("pins", _block(ends[0] - half, ends[1] + half), np.array([0.0, -1.0, 0.0]))


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
        yield replace(piece, draw=tuple(direction(leg.side).tolist()))


def _ring(axis: str, place: float, sizes: _Point, wide: float) -> PartMesh:
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
    draw = np.array([0.0, 0.0, 1.0 if place > -0.5 else -1.0])
    return _solid("band", np.vstack(corners), draw if axis == "z" else np.array([0.0, 1.0, 0.0]))


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
            near, far = plan.half(side.side) + side.sheet, plan.reach(side.side)
            low = in_space(side.side, left, bottom, near)
            high = in_space(side.side, right, plan.rim, far)
            yield _solid("clay", _block(low, high), direction(side.side))


def _slots(plan: MoldPlan) -> Iterator[PartMesh]:
    """Clay around legs where they leave the slots of walls."""
    for side in plan.sides:
        if side.holding == "slots":
            for corners in slot_corners(side.slots):
                yield _lump(side.side, plan.reach(side.side), corners)


def _lump(side: Side, out: float, corners: Array, thick: float = 1.0) -> PartMesh:
    """Clay on a face at ``out``, half a millimetre around places (n, 2) on it."""
    low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
    block = _block(
        in_space(side, low[0], low[1], out), in_space(side, high[0], high[1], out + thick)
    )
    return _solid("clay", block, direction(side))


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
            low = in_space(flank, z - 0.5 * TAPE_MM, 0.0, out)
            high = in_space(flank, z + 0.5 * TAPE_MM, plan.rim, out + 0.3)
            yield _solid("tape", _block(low, high), direction(flank))
        low = in_space(flank, -plan.reach_z, plan.rim - 0.5 * TAPE_MM, out)
        high = in_space(flank, plan.reach_z, plan.rim + 0.5 * TAPE_MM, out + 0.3)
        yield _solid("tape", _block(low, high), direction(flank))


def _cell_rubber(casting: Casting) -> Iterator[PartMesh]:
    """The casting in the coupon's cell."""
    if casting.trial:
        points = np.vstack([frame.corners() for frame in casting.trial])
        (left, low), (right, high) = points.min(axis=0) - AROUND_MM, points.max(axis=0) + AROUND_MM
        side = sides_of_plate(casting.trial[0])[0]
        out = casting.plan.half(side)
        ends = in_space(side, left, low, -out), in_space(side, right, high, out)
        yield _solid("rubber", _block(*ends), np.array([0.0, -1.0, 0.0]))


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
            yield _solid("clay", _block(low, high), np.array([0.0, -1.0, 0.0]))
