"""Plates as sheets in tetrahedra: a mesh cut along the plates' mid-surfaces, opened to slots.

fTetWild keeps closed surfaces, so each plate is meshed as one face, its mid-surface, of a box of
rubber, the *carrier*, thicker than the plate by far. Then the mesh is cut along that face
(slot_cut.py), the two sides are moved t/2 apart, and what opens beyond the plate's
square ends is filled with tetrahedra. So the rubber has its true shape, and the plate is the slot,
which structural elements fill (fem/sheet.py), or prisms for a solid plate (finish.py).
No element of the plate's thickness is asked of fTetWild, and across it the mesh is regular.
Measured on maeno2000 against a fine extruded mesh: plates cut in, readings within 1.2 to 1.8 % on
130k to 190k dofs; resolved by fTetWild itself, 10 to 14 % on 230k.
"""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.layers import not_a_sheet
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.sizing import distances_to_plate
from fingerdesign.mesh.tetra.carriers import Carriers, core_faces, outer_faces
from fingerdesign.mesh.tetra.slot_cut import Cut, plan_cut, sheet_facets_of
from fingerdesign.mesh.tetra.snap import improve
from fingerdesign.mesh.types import TETRA_FACETS, Stars, boundary_facets, pieces, same_keys
from fingerdesign.shapes.faces import Carrier

# Carriers: the boxes of rubber that are meshed so that plates as sheets have their mid-surface.

_WIDEST = 0.22  # of the plate's length or span: on maeno2000 0.2 mm did better than 0.3
_WANTED, _LEAST = 1.5, 0.6  # times the plate's thickness: half of it is the slot's
_ENOUGH = 0.6  # of what is wanted: then the box lies on the upper side
# What stays between a box and whatever is near: of its thickness, and of the plate's.
_FREE, _FREE_LEAST = 0.5, 0.2
_ENDS = 0.6  # of a plate's thickness: the elements at a sheet's ends
_FLUSH = 1e-6  # mm
_STEPS = 0.9 ** np.arange(32)


def carrier_frames(frames: tuple[PlateFrame, ...], design: Design) -> tuple[PlateFrame, ...]:
    """The boxes to mesh instead of the plates ``frames``: one face of each is the mid-surface.

    Each box has its plate's length and span, and lies on the side with more room, the upper one
    where both have enough. MeshError where a plate has too little, or cannot be a sheet.
    """
    for frame in frames:
        why = not_a_sheet(frame)
        if why is not None:
            raise MeshError(f"plate {frame.index} cannot be a sheet: {why}")
    boxes = list(frames)
    for k, frame in enumerate(frames):
        least = _LEAST * frame.thickness
        wanted = min(design.mesh.plate_size_mm, _WIDEST * min(frame.length, frame.span))
        most = max(wanted, _WANTED * frame.thickness)
        near = _near(frame, [*boxes[:k], *frames[:k], *frames[k + 1 :]], 3.0 * most)
        upper, lower = (_thickest(frame, side * most, near, design) for side in (1.0, -1.0))
        thickness = lower if abs(lower) > max(abs(upper), _ENOUGH * most) else upper
        if abs(thickness) < least:
            raise MeshError(
                f"plate {frame.index} has {abs(thickness):.3g} mm of room beside it: to be meshed "
                f"as a sheet it needs {least:.3g} mm; set plates.model = 'solid'"
            )
        boxes[k] = _box(frame, thickness)
    return tuple(boxes)


def sized_frames(frames: tuple[PlateFrame, ...]) -> tuple[PlateFrame, ...]:
    """Boxes around the mid-surfaces of plates as sheets, for a mesh's size field.

    It asks for elements of half a box's thickness at its ends: _ENDS of the plate's. On maeno2000,
    fifteen plates 0.1 mm thick, worst error of membrane strain over five increments up to complete
    slip against a fine extruded model: 0.5: 1.2 % (192k dofs), 0.7: 1.8 % (128k), 1: 3.8 % (94k).
    """
    return tuple(replace(frame, thickness=2.0 * _ENDS * frame.thickness) for frame in frames)


def _box(frame: PlateFrame, thickness: float) -> PlateFrame:
    """The box from a plate's mid-surface to ``thickness`` (mm; < 0: on the lower side)."""
    place, y = frame.from_local(0.0, 0.5 * thickness)[0]
    return replace(frame, place=float(place), y=float(y), thickness=abs(thickness))


def _near(frame: PlateFrame, others: list[PlateFrame], reach: float) -> list[PlateFrame]:
    """Those of the others that may come within ``reach`` of a plate."""

    def size(one: PlateFrame) -> float:
        return 0.5 * float(np.linalg.norm([one.length, one.thickness, one.span]))

    def centre(one: PlateFrame) -> Array:
        return np.asarray(one.to_space(one.centre, one.middle)[0])

    return [
        one
        for one in others
        if np.linalg.norm(centre(one) - centre(frame)) < size(one) + size(frame) + reach
    ]


def _thickest(frame: PlateFrame, most: float, near: list[PlateFrame], design: Design) -> float:
    """Thickness (mm, with the sign of ``most``) of a box with room around it; 0: there is none."""
    faces = _room_faces(frame, design)
    core = [] if design.body.core is None else core_faces(design.body)
    for step in _STEPS:
        box = _box(frame, float(step * most))
        mine = _samples(box)
        gaps = [distances_to_plate(one, mine)[0].min() for one in near]
        gaps += [distances_to_plate(box, _samples(one))[0].min() for one in near]
        gaps += [np.abs(face.misfit(mine)).min() for face in faces]
        if core:
            gaps.append(np.max([face.distance(mine) for face in core], axis=0).min())
        if min(gaps, default=np.inf) >= max(_FREE * box.thickness, _FREE_LEAST * frame.thickness):
            return float(step * most)
    return 0.0


def _room_faces(frame: PlateFrame, design: Design) -> list[Carrier]:
    """The body's outer faces but those that the plate ends in."""
    ends = frame.from_local(np.array([-0.5, 0.5]) * frame.length, 0.0)
    edges = [frame.to_space(ends, across) for across in (frame.low, frame.high)]
    both = np.array([frame.low, frame.high])
    edges += [frame.to_space(np.tile(end, (2, 1)), both) for end in ends]
    outer = outer_faces(design.body, symmetric=False)
    return [face for face in outer if not any(np.abs(face.misfit(e)).max() < _FLUSH for e in edges)]


def _samples(frame: PlateFrame) -> Array:
    """Points (n, 3) in a box, its corners and edges among them."""
    s, v, w = (
        axis.ravel()
        for axis in np.meshgrid(
            np.linspace(-0.5, 0.5, 9) * frame.length,
            np.linspace(-0.5, 0.5, 3) * frame.thickness,
            np.linspace(frame.low, frame.high, 9),
        )
    )
    return frame.to_space(frame.from_local(s, v), w)


# Moving the two sides of cut plates apart, and the nodes around so that all make room.
#
# The displacement is harmonic: zero on what must stay, half the thickness on the slots' faces, and
# between as small elements ask for (they move as if stiffer), so nothing is turned over where the
# room suffices.

_ALIGNED = 1e-9
_STIFFEST = 200.0  # of an element's stiffness times its edges' length squared; an even one has 6
_FLAT = 1e-18  # of the mesh's extent cubed: the least volume reckoned with
_NO_AREA = 1e-300
_CLOSE = 1e-3  # of the load: where nodes come to lie need not be exact
_MOST = 2000
_MENDABLE = 20  # tetrahedra turned over that moving single nodes may still mend


def widened(
    points: Array,
    tets: IntArray,
    fill: IntArray,
    regions: IntArray,
    outer: IntArray,
    targets: list[tuple[IntArray, Array]],
) -> Array:
    """Points with the slots' nodes at their targets and the others out of the way.

    tets (t, 4): the mesh that is cut, closed; fill (g, 4): what fills the slots' ends; regions
    (t,); outer (o, 3): facets on the body's outside, where nodes stay on it; targets: nodes (k,)
    and where they go (k, 3). MeshError where a tetrahedron is turned over.
    """
    goal = points.copy()
    placed = np.zeros(len(points), dtype=bool)
    for nodes, where in targets:
        goal[nodes], placed[nodes] = where, True
    held = placed[:, None] | held_on_faces(points, tets, regions, outer)
    shift = _harmonic(points, tets, goal - points, held)
    moved = points + shift
    moved[placed] = goal[placed]
    whole = np.vstack([tets, fill])
    _refuse_turned(moved, whole, max(_MENDABLE, len(fill) // 20))
    fixed = np.repeat(held.any(axis=1, keepdims=True), 3, axis=1)  # as by three faces, at a corner
    moved = improve(moved, whole, fixed, Carriers((), (), {}))
    _refuse_turned(moved, whole, 0)
    return moved


def _refuse_turned(points: Array, tets: IntArray, most: int) -> None:
    """MeshError where more than ``most`` tetrahedra are turned over."""
    turned = int((cell_volumes(points, tets) <= 0.0).sum())
    if turned > most:
        raise MeshError(
            f"{turned} tetrahedra were turned over where plates were opened to their thickness: "
            "make mesh.plate_size_mm smaller, or plates.model = 'solid'"
        )


def held_on_faces(points: Array, tets: IntArray, regions: IntArray, outer: IntArray) -> BoolArray:
    """Which coordinates (n, 3) of nodes must stay: on the outside and between regions.

    On flat faces across a coordinate axis only that coordinate is held; a facet without area, as
    fTetWild may leave, tells no direction and holds all.
    """
    a, b, c = (points[outer[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal = np.abs(normal) / np.maximum(np.linalg.norm(normal, axis=1), _NO_AREA)[:, None]
    across = normal > 1.0 - _ALIGNED
    across[~across.any(axis=1)] = True
    held = np.zeros((len(points), 3), dtype=bool)
    for corner in range(3):
        np.logical_or.at(held, outer[:, corner], across)
    for region in np.unique(regions[regions != 0]):
        inside = np.zeros(len(points), dtype=bool)
        inside[tets[regions == region]] = True
        held[inside] = True
    return held


def _harmonic(points: Array, tets: IntArray, wanted: Array, held: BoolArray) -> Array:
    """Displacements (n, 3), as wanted where ``held``, that even out between."""
    from scipy.sparse import coo_matrix, diags_array
    from scipy.sparse.linalg import cg

    corners = points[tets]
    edges = corners[:, 1:] - corners[:, :1]
    volume = np.maximum(np.abs(np.linalg.det(edges)) / 6.0, _FLAT * np.ptp(points) ** 3)
    a, b, c = (edges[:, k] for k in range(3))
    slopes = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    slopes /= 6.0 * volume[:, None, None]
    slopes = np.concatenate([-slopes.sum(axis=1, keepdims=True), slopes], axis=1)
    block = np.einsum("tia,tja->tij", slopes, slopes)
    # A flat tetrahedron on a face of a carrier is free to be mended from now on: it must not bind.
    most = _STIFFEST / (edges**2).sum(axis=2).mean(axis=1)
    block *= np.minimum(1.0, most / np.einsum("tii->t", block))[:, None, None]
    rows, columns = np.repeat(tets, 4, axis=1).ravel(), np.tile(tets, (1, 4)).ravel()
    size = len(points)
    matrix = coo_matrix((block.ravel(), (rows, columns)), shape=(size, size)).tocsr()
    shift = np.where(held, wanted, 0.0)
    for axis in range(3):
        if not shift[:, axis].any():
            continue
        free = np.flatnonzero(~held[:, axis])
        inner = matrix[free][:, free]
        load = -(matrix[free] @ shift[:, axis])
        scale = diags_array(1.0 / inner.diagonal())
        found, failed = cg(inner, load, rtol=_CLOSE, maxiter=_MOST, M=scale)
        if failed:
            raise MeshError("the nodes around the plates could not be moved out of their way")
        shift[free, axis] = found
    return shift


@dataclass(frozen=True)
class Slots:
    """A linear mesh with a slot for each plate.

    points (n, 3) mm; tets (t, 4), positively oriented: those given, then those that fill the
    slots' ends; regions (t,): carriers have become elastomer, 0; facets: name -> corners (f, 3) of
    "plate_k_upper", "plate_k_lower" and "plate_k_end"; origin (n,): the node given that each node
    was, or that it was split from.
    """

    points: Array
    tets: IntArray
    regions: IntArray
    facets: dict[str, IntArray]
    origin: IntArray


def open_slots(
    points: Array, tets: IntArray, regions: IntArray, frames: tuple[PlateFrame, ...]
) -> Slots:
    """Cut a snapped mesh along the mid-surfaces of ``frames`` and open it to their thickness.

    points (n, 3), tets (t, 4) positively oriented; regions (t,): k + 1 where plate k's carrier is;
    others are kept. MeshError where a mid-surface is not filled by facets, where its rim leaves no
    way for the cut, and where tetrahedra would be turned over.
    """
    stars, outer = Stars.of(tets, len(points)), boundary_facets(tets, 3)
    sheets = [
        sheet_facets_of(points, tets, regions == number, frame)
        for number, frame in enumerate(frames, start=1)
    ]
    taken = np.zeros(len(points), dtype=bool)
    for sheet, frame in zip(sheets, frames, strict=True):
        if taken[sheet].any():
            raise MeshError(f"plate {frame.index}'s mid-surface touches another plate's")
        taken[sheet] = True
    opened, count = tets.copy(), len(points)
    origin, fills = [np.arange(count)], []
    targets: list[tuple[IntArray, Array]] = []
    facets: dict[str, IntArray] = {}
    for sheet, frame in zip(sheets, frames, strict=True):
        cut = plan_cut(points, stars, sheet, outer, frame, taken)
        nodes = cut.nodes
        lower = np.arange(len(points))
        lower[nodes] = count + np.arange(len(nodes))
        below, up = sides(points, stars, cut, frame)
        part = opened[below]
        opened[below] = np.where(
            np.isin(part, nodes), lower[np.minimum(part, len(points) - 1)], part
        )
        made, ends = _filled(points, cut, lower, up)
        fills.append(made)
        name = f"plate_{frame.index}"
        facets |= {f"{name}_upper": sheet, f"{name}_lower": lower[sheet], f"{name}_end": ends}
        place = frame.local(points[nodes])[:, 0], frame.across(points[nodes])
        for copies, side in ((nodes, 0.5), (lower[nodes], -0.5)):
            plane = frame.from_local(place[0], side * frame.thickness)
            targets.append((copies, frame.to_space(plane, place[1])))
        origin.append(nodes)
        count += len(nodes)
    source = np.concatenate(origin)
    fill = np.vstack([np.empty((0, 4), dtype=np.int64), *fills])
    kept = np.where((regions >= 1) & (regions <= len(frames)), 0, regions)
    moved = widened(points[source], opened, fill, kept, outer, targets)
    regions = np.concatenate([kept, np.zeros(len(fill), dtype=kept.dtype)])
    return Slots(moved, np.vstack([opened, fill]), regions, facets, source)


def sides(points: Array, stars: Stars, cut: Cut, frame: PlateFrame) -> tuple[IntArray, IntArray]:
    """The tetrahedra around a cut that lie below it, and the apex (f,) above each of its facets.

    MeshError where the cut does not part the tetrahedra around it in two.
    """
    around = np.unique(np.concatenate([stars.around(int(n)) for n in cut.nodes]))
    cells = stars.cells[around]
    local = np.array(TETRA_FACETS)
    facets = np.sort(cells[:, local].reshape(-1, 3), axis=1)
    apex = cells[:, [6 - sum(facet) for facet in TETRA_FACETS]].ravel()
    owner = np.repeat(np.arange(len(cells)), 4)
    at_cut = np.isin(facets, cut.nodes).any(axis=1)
    facets, apex, owner = facets[at_cut], apex[at_cut], owner[at_cut]
    barrier = np.sort(cut.facets, axis=1)
    unique, label = np.unique(np.vstack([barrier, facets]), axis=0, return_inverse=True)
    label = label.ravel()
    walls, label = label[: len(barrier)], label[len(barrier) :]
    one, two = same_keys(label)
    joined = ~np.isin(label[one], walls)
    _, part = pieces(owner[one[joined]], owner[two[joined]], len(cells))
    first = np.full(len(unique), -1)
    second = np.full(len(unique), -1)
    first[label[one]], second[label[one]] = one, two
    a, b = first[walls], second[walls]
    if (a < 0).any():
        raise MeshError(f"the cut of plate {frame.index} leaves the mesh")
    normal = frame.direction(frame.normal)
    start = points[cut.sheet[:, 0]]
    first_up = (points[apex[a[: len(start)]]] - start) @ normal > 0.0
    above = np.unique(part[owner[np.where(first_up, a[: len(start)], b[: len(start)])]])
    under = np.unique(part[owner[np.where(first_up, b[: len(start)], a[: len(start)])]])
    both = np.concatenate([above, under])
    if len(np.unique(both)) != len(both) or len(both) != part.max() + 1:
        raise MeshError(f"the cut of plate {frame.index} does not part its two sides")
    a_above = np.isin(part[owner[a]], above)
    if (a_above == np.isin(part[owner[b]], above)).any():
        raise MeshError(f"the cut of plate {frame.index} does not part its two sides")
    return around[np.isin(part, under)], np.where(a_above, apex[a], apex[b])


def _filled(points: Array, cut: Cut, lower: IntArray, up: IntArray) -> tuple[IntArray, IntArray]:
    """Tetrahedra (t, 4) of what opens beyond the rim, and the facets (f, 3) of the square ends.

    A flap (r, x, y) opens to the tetrahedron (r below, x, y, r above), a wing (a, b, c) to a
    pyramid over the end's facets (a, b below, b, a above), which is two tetrahedra.
    """
    beyond = cut.facets[len(cut.sheet) :]
    apex = points[up[len(cut.sheet) :]]
    p, q, r = (points[beyond[:, k]] for k in range(3))
    turned = np.einsum("ij,ij->i", np.cross(q - p, r - p), apex - p) < 0.0
    count = len(cut.wings)
    wings, flaps = beyond[:count].copy(), beyond[count:].copy()
    wings[turned[:count]] = wings[turned[:count]][:, [1, 0, 2]]
    flaps[turned[count:]] = flaps[turned[count:]][:, [0, 2, 1]]
    (a, b, c), (n, x, y) = wings.T, flaps.T
    # The ends' diagonals start above at the node of lower number, as those of the prisms do.
    first = (a < b)[:, None]
    la, lb = lower[a], lower[b]
    one = np.where(first, np.column_stack([la, lb, c, a]), np.column_stack([la, lb, c, b]))
    two = np.where(first, np.column_stack([a, lb, c, b]), np.column_stack([la, b, c, a]))
    tets = [one, two, np.column_stack([lower[n], x, y, n])]
    ends = [
        np.where(first, np.column_stack([a, la, lb]), np.column_stack([la, lb, b])),
        np.where(first, np.column_stack([a, lb, b]), np.column_stack([a, la, b])),
    ]
    return np.vstack(tets), np.vstack(ends)


# Plates are left out, cut in as above, or resolved by fTetWild itself.

# Plates thicker than this share of mesh.plate_size_mm are resolved first: it costs nothing.
THICK = 0.6


@dataclass(frozen=True)
class PlateWay:
    """The boxes that fTetWild meshes for the plates, those that the sizes go by, what happens next.

    cut: ``meshed`` are carriers, to be cut open at the plates' mid-surfaces; filled: the slots are
    filled as solid plates.
    """

    meshed: tuple[PlateFrame, ...]
    sized: tuple[PlateFrame, ...]
    cut: bool = False
    filled: bool = False

    @property
    def name(self) -> str:
        """For notes and complaints."""
        if not self.meshed:
            return "no plates"
        return "plates cut in" if self.cut else "plates resolved"


def plate_ways(design: Design, symmetric: bool) -> tuple[PlateWay, ...]:
    """The ways to try, the best first. MeshError where plates as sheets have none."""
    frames = plate_frames(design) if design.plates.model != "none" else ()
    resolved = PlateWay(frames, frames)
    if not frames:
        return (resolved,)
    if design.plates.model == "sheet":
        return (_cut(design, frames, filled=False),)
    if any(not_a_sheet(frame, symmetric) for frame in frames):
        return (resolved,)
    try:
        cut = _cut(design, frames, filled=True)
    except MeshError:  # too little room for a carrier: plates lie close
        return (resolved,)
    thick = design.plates.thickness_mm > THICK * design.mesh.plate_size_mm
    return (resolved, cut) if thick else (cut, resolved)


def _cut(design: Design, frames: tuple[PlateFrame, ...], filled: bool) -> PlateWay:
    return PlateWay(carrier_frames(frames, design), sized_frames(frames), True, filled)
