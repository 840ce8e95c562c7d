"""A test coupon: what a machine and a cutter hold, seen before a mold is made by them.

``coupon`` is a bar with a row a kind of feature, from fine to coarse along +x (its corner at the
fine end of the first row is cut off); ``coupon_pin`` goes into its sockets. ``coupon_cell`` is a
trough for two of the finger's own plates, held as in the mold: a casting of a few grams that shows
where they stay. Importing this module loads the CAD kernel.
"""

import cadquery as cq
import numpy as np

from fingerdesign.cad.kernel import box, one_solid
from fingerdesign.mold.cad.build import INSERT_ORDER, BuiltPart
from fingerdesign.mold.cad.features import cylinder, slot_tools
from fingerdesign.mold.cad.parting import prism_of, slab
from fingerdesign.mold.part import CELL, COUPON, COUPON_COMB, COUPON_PIN, SPACER, Point, point
from fingerdesign.mold.plan.pieces import WORDS, direction
from fingerdesign.mold.plan.plan import MoldPlan, spacer_height
from fingerdesign.mold.plan.slots import sides_of_plate
from fingerdesign.mold.profile import AROUND_MM, SPACER_MM, Ladder, cell_plates, ladders_of

DEEP_MM = 10.0  # of slots, holes and sockets: about a mold's wall
LOW_MM = 3.0  # height of the bar below its features
LONG_MM = 4.0  # of slots, walls and ribs, across the bar's length
GAP_MM = 2.0  # between features, and to the border
PIN_MM = 6.0  # length of a pin beyond the bar
CORNER_MM = 2.0  # that marks the fine end of the first row
_Z = np.array([0.0, 0.0, 1.0])
WALL_MM = 2.0  # of the cell, at least


def build_coupon(plan: MoldPlan) -> tuple[BuiltPart, ...]:
    """All pieces: bar, pin (none of machined parts: dowels are bought), cell and its combs (none
    where no two plates leave through the same sides). GeometryError where the kernel fails."""
    limits = plan.limits
    found = [_piece(COUPON, ladder_bar(ladders_of(limits), limits.pin_mm))]
    if not limits.dowels:
        head = box((0.0, 0.0, 0.0), (4.0 * limits.pin_mm, 4.0 * limits.pin_mm, LOW_MM))
        foot = (2.0 * limits.pin_mm, 2.0 * limits.pin_mm, 0.0)
        pin = cylinder(limits.pin_mm, foot, _Z, LOW_MM + PIN_MM)
        found.append(_piece(COUPON_PIN, one_solid(head.fuse(pin), COUPON_PIN)))
    if high := spacer_height(plan):
        found.append(_piece(SPACER, box((0.0, 0.0, 0.0), (SPACER_MM, SPACER_MM, high))))
    return (*found, *_cell(plan))


def _piece(name: str, solid: cq.Solid, draw: Point | None = None) -> BuiltPart:
    """A printed or milled piece; its outer face, as printed, lies on the side of its draw."""
    return BuiltPart(name, solid, draw, INSERT_ORDER, "process")


def ladder_bar(rows: tuple[Ladder, ...], pin: float) -> cq.Solid:
    """The bar: rows along x, following along -y; z is up. pin: diameter that sockets are for."""
    wide = {row.kind: [_width(row, size, pin) for size in row.sizes] for row in rows}
    pitch = max(max(each) for each in wide.values()) + GAP_MM
    length = pitch * max(len(row.sizes) for row in rows) + GAP_MM
    base: list[cq.Solid] = []
    cuts: list[cq.Solid] = []
    y = 0.0
    for row in rows:
        depth = GAP_MM + max(LONG_MM, *wide[row.kind])
        through = row.kind in ("slot", "hole", "socket")
        high = DEEP_MM if through else LOW_MM
        base.append(box((0.0, y - depth, 0.0), (length, y, high)))
        for k, size in enumerate(row.sizes):
            x, middle = GAP_MM + (k + 0.5) * pitch - 0.5 * GAP_MM, y - 0.5 * depth
            tool = _feature(row, size, pin, x, middle)
            (cuts if through else base).append(tool)
        y -= depth
    corner = np.array([[0.0, 0.0], [CORNER_MM, 0.0], [0.0, -CORNER_MM]])
    cuts.append(prism_of(np.column_stack([corner, np.zeros(3)]), DEEP_MM * _Z))
    whole = one_solid(base[0].fuse(*base[1:]).clean(), COUPON)
    return one_solid(whole.cut(*cuts).clean(), COUPON)


def _width(row: Ladder, size: float, pin: float) -> float:
    """Width of a feature along x."""
    return pin + 2.0 * size if row.kind == "socket" else size


def _feature(row: Ladder, size: float, pin: float, x: float, y: float) -> cq.Solid:
    """Make what is cut out of the bar, or added to it, about (x, y)."""
    if row.kind in ("hole", "socket"):
        return cylinder(_width(row, size, pin), (x, y, -1.0), _Z, DEEP_MM + 2.0)
    if row.kind == "pin":
        return cylinder(size, (x, y, 0.0), _Z, LOW_MM + PIN_MM)
    low = -1.0 if row.kind == "slot" else 0.0
    high = {"slot": DEEP_MM + 1.0, "wall": DEEP_MM, "rib": 2.0 * LOW_MM}[row.kind]
    half = 0.5 * LONG_MM
    return box((x - 0.5 * size, y - half, low), (x + 0.5 * size, y + half, high))


def _cell(plan: MoldPlan) -> tuple[BuiltPart, ...]:
    """The trough, open at its base as an open mold is, with a comb in a groove of each end that has
    one in the mold, and slots through its wall elsewhere."""
    plates = cell_plates(plan)
    if not plates:
        return ()
    limits, sheet = plan.limits, plan.design.mold.comb.sheet_mm
    numbers = {frame.index for frame in plates}
    held = [(side, slot) for side, slot, _ in plan.leg_slots if slot.plate in numbers]
    wall = max(WALL_MM, 1.5 * limits.wall_mm)
    points = np.vstack([frame.corners() for frame in plates])
    (left, low), (right, high) = points.min(axis=0) - AROUND_MM, points.max(axis=0) + AROUND_MM
    ends = sides_of_plate(plates[0])
    inside, beyond = plan.half(ends[0]), low - 1.0
    groove = inside + sheet + limits.clearance_mm
    outside, edge = groove + wall, AROUND_MM + wall
    cell = slab(ends[0], (left - edge, low, -outside), (right + edge, high + edge, outside))
    cuts = [slab(ends[0], (left, beyond, -inside), (right, high, inside))]
    combs = []
    for end in ends:
        tools = list(slot_tools(plan, end, [slot for side, slot in held if side.side == end]))
        if plan.by_side[end].holding != "comb" or not tools:
            cuts += tools
            continue
        room = AROUND_MM + limits.clearance_mm
        cuts.append(slab(end, (left - room, beyond, inside), (right + room, high + room, groove)))
        # Behind the comb, legs are free.
        cuts.append(slab(end, (left, beyond, inside), (right, high, outside + 1.0)))
        corner = (right + AROUND_MM, high + AROUND_MM, inside + sheet)
        comb = slab(end, (left - AROUND_MM, low, inside), corner)
        name = f"{COUPON_COMB}_{WORDS[end]}"
        solid = one_solid(comb.cut(*tools).clean(), name)
        combs.append(BuiltPart(name, solid, point(direction(end)), INSERT_ORDER, "sheet"))
    return _piece(CELL, one_solid(cell.cut(*cuts).clean(), CELL), (0.0, 1.0, 0.0)), *combs
