"""Plates as sheets: a section's mesh that follows the plates' mid-lines, opened to their thickness.

The mesh is made with each plate as a line, which needs no element of the plate's thickness. Then
every line is cut into an upper and a lower face, the faces are moved t/2 apart, and the triangles
around are squeezed to make room: beyond a reach R from the mid-line nothing moves. The plate's
square ends open along a short line beyond each end, which is cut too and filled with triangles. So
the rubber has its true shape, and the plate is the slot, which structural elements fill
(fem/sheet.py).
"""

from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Body
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.outline import chain_misfit
from fingerdesign.layout.profile import profile_of
from fingerdesign.mesh.cells import facet_kind, outer_facets
from fingerdesign.mesh.measures import cell_volumes, edge_lengths, flat_areas

FACES = ("upper", "lower", "end")
CAP = "cap"  # Where a plate in layers of prisms ends inside the body, along z.
_ON = 1e-9  # mm: the mesher's vertices lie on their lines to rounding
_FILLED = 1e-8  # relative: what is missing is a facet or nothing
_SHARE = 0.98  # of the room around a mid-line
_LEAST_REACH = 1.2  # times t/2: triangles next to the plate keep a sixth of their height
_MOST_REACH = 8.0  # times t/2; triangles there keep seven eighths


def open_sheets(
    points: Array, triangles: IntArray, frames: tuple[PlateFrame, ...], body: Body, end_size: float
) -> tuple[Array, IntArray]:
    """Cut a linear mesh along the plates' mid-lines and open each slot to the plate's thickness.

    ``end_size``: the triangles' at the plates' ends, mm. The vertices of lower faces are added at
    the end, in the order of those above. Raises MeshError where a line is missing from the mesh or
    has too little room, and where a triangle would be turned over.
    """
    moved, cells = points.copy(), [triangles.copy()]
    extra: list[Array] = []
    count = len(points)
    for frame in frames:
        room = room_around(frame, frames, body)
        beyond = line_beyond(frame, room, end_size)
        reach = min(_SHARE * room, max(_MOST_REACH * 0.5 * frame.thickness, 1.2 * beyond))
        shift = _opening(frame, points, reach, beyond)
        chain = _on_axis(frame, points, beyond)
        cut = np.sort(chain[1:-1])  # as numbered above, so below: swept, both faces are cut alike
        moved += shift * np.sign(frame.local(points)[:, 1:]) * frame.normal
        moved[cut] = points[cut] + shift[cut] * frame.normal
        extra.append(points[cut] - shift[cut] * frame.normal)
        lower = np.arange(len(points))
        lower[cut] = count + np.arange(len(cut))
        below = frame.local(points)[:, 1][triangles].sum(axis=1) < 0.0
        below &= np.isin(triangles, cut).any(axis=1)
        split = np.isin(triangles, cut) & below[:, None]
        cells[0][split] = lower[triangles[split]]
        cells.append(_ends_filled(frame, points, chain, lower))
        count += len(cut)
    opened, whole = np.vstack([moved, *extra]), np.vstack(cells)
    turned = int((cell_volumes(opened, whole) <= 0.0).sum())
    if turned:
        raise MeshError(
            f"{turned} triangles were turned over where plates were opened to their thickness: "
            "make the sizes in [mesh.section] (in 3-D [mesh]) smaller, or plates.model = 'solid'"
        )
    return opened, whole


def line_beyond(frame: PlateFrame, room: float, end_size: float) -> float:
    """Length (mm) of the line beyond each end of a plate's mid-line, on which the slot closes."""
    return min(max(end_size, 0.5 * frame.thickness), 0.8 * room)


def _on_axis(frame: PlateFrame, points: Array, beyond: float) -> IntArray:
    """Vertices on a plate's mid-line and on the lines beyond its ends, from end to end."""
    along, off = frame.local(points).T
    half = 0.5 * frame.length
    axis = np.flatnonzero((np.abs(off) < _ON) & (np.abs(along) < half + beyond + _ON))
    axis = axis[np.argsort(along[axis])]
    for place in (-half - beyond, -half, half, half + beyond):
        if len(axis) == 0 or np.abs(along[axis] - place).min() > _ON:
            raise MeshError(f"the mesh does not follow plate {frame.index} to its ends")
    return axis


def _ends_filled(frame: PlateFrame, points: Array, chain: IntArray, lower: IntArray) -> IntArray:
    """Triangles of what opens beyond a plate's square ends, anticlockwise."""
    along = frame.local(points)[:, 0]
    made = []
    for a, b in pairwise(chain):
        if max(abs(along[a]), abs(along[b])) < 0.5 * frame.length + _ON:
            continue  # the plate itself
        if lower[a] != a:
            made.append([lower[a], b, a])
        if lower[b] != b:
            made.append([lower[a], lower[b], b])
    return np.array(made, dtype=np.int64)


def _opening(frame: PlateFrame, points: Array, reach: float, beyond: float) -> Array:
    """Distance (n, 1) that points next to a plate move to make room, mm."""
    past = np.abs(frame.local(points)[:, 0]) - 0.5 * frame.length
    fading = np.clip(1.0 - np.maximum(past, 0.0) / beyond, 0.0, 1.0)
    fading *= np.clip(1.0 - _distance(frame, points) / reach, 0.0, 1.0)
    return np.asarray(0.5 * frame.thickness * fading[:, None])


def room_around(frame: PlateFrame, frames: tuple[PlateFrame, ...], body: Body) -> float:
    """Room of a plate around its mid-line, mm: to body and core, and half way to others. Raises
    MeshError where that is too little for the faces to be moved apart."""
    own = float(_to_faces(body, _mid_line(frame)).min())
    for other in frames:
        if other is not frame:
            own = min(own, 0.5 * float(_distance(frame, _mid_line(other)).min()))
    least = _LEAST_REACH * 0.5 * frame.thickness
    if own * _SHARE < least:
        raise MeshError(
            f"plate {frame.index} has {own:.3g} mm around its mid-line to itself: as a sheet of "
            f"this thickness it needs {least / _SHARE:.3g} mm; set plates.model = 'solid'"
        )
    return own


def _mid_line(frame: PlateFrame) -> Array:
    """Points (65, 2) of a plate's mid-line."""
    return frame.from_local(np.linspace(-0.5, 0.5, 65) * frame.length, 0.0)


def _to_faces(body: Body, points: Array) -> Array:
    """Distance (n,) of section points (n, 2) to the body's outline and to its core; < 0: beyond."""
    profile = profile_of(body)
    x, y = np.abs(points[:, 0]), points[:, 1]
    room = np.minimum(y, profile.half_width - x)
    top = chain_misfit(profile.pieces, points)
    room = np.minimum(room, np.where(y < profile.height(x), top, -top))
    if body.core is not None:
        bottom, half = body.core.bottom_mm, 0.5 * body.core.width_mm
        up = np.maximum(bottom - y, y - bottom - body.core.height_mm)
        past = np.hypot(np.maximum(x - half, 0.0), np.maximum(up, 0.0))
        room = np.minimum(room, np.where(past > 0.0, past, np.maximum(x - half, up)))
    return np.asarray(room)


def _distance(frame: PlateFrame, points: Array) -> Array:
    """Distance of points (n, 2) to a plate's mid-line."""
    along, off = frame.local(points).T
    past = np.maximum(np.abs(along) - 0.5 * frame.length, 0.0)
    return np.asarray(np.hypot(past, off))


def sheet_facets(
    points: Array, cells: IntArray, frames: tuple[PlateFrame, ...]
) -> dict[str, IntArray]:
    """Boundary facets "plate_k_upper", "_lower", "_end" and "_cap" of the slot of each plate.

    points (n, dim) and quadratic cells of an opened mesh -> (f, nodes): corners, then mid-nodes.
    Prisms have triangles for caps, tetrahedra have them among the ends. Raises MeshError where they
    do not fill the plate's faces.
    """
    kinds = outer_facets(cells)
    found = {}
    for frame in frames:
        named: dict[str, list[IntArray]] = {name: [] for name in FACES}
        for facets in kinds:
            for name, chosen in _faces_of(frame, points, facets).items():
                named[name].append(facets[chosen])
        for name, parts in named.items():
            _check_filled(points, parts, frame, name)
            full = [part for part in parts if len(part)]
            labels = (name,) if len(full) == 1 else (CAP, name)
            for label, part in zip(labels, full, strict=True):
                found[f"plate_{frame.index}_{label}"] = part
    return found


def _faces_of(frame: PlateFrame, points: Array, facets: IntArray) -> dict[str, BoolArray]:
    """Masks (f,) of the facets that lie on each face of a plate's slot."""
    dimension = points.shape[1]
    corners = points[facets[:, : facet_kind(facets).corners]]
    half = 0.5 * np.array([frame.length, frame.thickness])
    local = frame.local(corners.reshape(-1, dimension)).reshape(*corners.shape[:2], 2)
    inside = (np.abs(local) < half + _ON).all(axis=(1, 2))
    on = {
        "upper": (np.abs(local[..., 1] - half[1]) < _ON).all(axis=1),
        "lower": (np.abs(local[..., 1] + half[1]) < _ON).all(axis=1),
        "end": (np.abs(np.abs(local[..., 0]) - half[0]) < _ON).all(axis=1),
    }
    if dimension == 3:  # and where the plate ends inside the body
        across = frame.across(corners.reshape(-1, 3)).reshape(corners.shape[:2])
        for end in (frame.low, frame.high):
            on["end"] |= (np.abs(across - end) < _ON).all(axis=1)
    return {name: inside & mask for name, mask in on.items()}


def _check_filled(points: Array, parts: list[IntArray], frame: PlateFrame, name: str) -> None:
    dimension = points.shape[1]
    requested = 2.0 * frame.thickness if name == "end" else frame.length
    if dimension == 2:
        filled = sum(float(edge_lengths(points, facets[:, :2]).sum()) for facets in parts)
    else:
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        requested *= min(frame.high, high) - max(frame.low, low)
        if name == "end":
            inside = (frame.low > low + _ON) + (frame.high < high - _ON)
            requested += inside * frame.length * frame.thickness
        filled = sum(
            float(flat_areas(points, facets[:, : facet_kind(facets).corners]).sum())
            for facets in parts
        )
    if not abs(filled / requested - 1.0) < _FILLED:
        unit = "mm" if dimension == 2 else "mm^2"
        raise MeshError(
            f"the mesh follows {filled:.6g} of {requested:.6g} {unit} of a face of plate "
            f"{frame.index}"
        )
