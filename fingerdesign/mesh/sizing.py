"""How large elements should be, point by point, and the background grid that carries it.

fTetWild reads its size field where the vertices of a first, coarse mesh happen to lie, by linear
interpolation in a background tetrahedral grid. A grid coarser than the field blurs it upward, so
the grid is fine where the field is steep.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import permutations, product
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import MeshError
from fingerdesign.layout.clearance import plate_points
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.surface import Surface
from fingerdesign.layout.zone import Zone

GRID_POINTS = 200_000
# Measured on a finger with three plates against a fine extruded mesh (errors of membrane strain out
# of 39, of bending out of 286): sizes alone, 25k dofs: 2.8 and 33; with fine plate ends, 40k dofs:
# 1.1 and 25; with fine ends and stretched elements, 35k dofs: 0.4 and 11. The answer varies slowly
# along z. A dome's contact is round, and its elements nearly so.
STRETCH_STRAIGHT, STRETCH_ROUND = 2.0, 1.4
# Contact facets over half the contact's width at the least, whatever mesh.contact_size_mm says: a
# small contact on a large finger would be a few facets. But no finer than a third of what is said.
FACETS_ACROSS, LEAST_CONTACT_SIZE = 5.0, 0.33
# Times what is said: facets that the scene's own path reaches, and those that only grips reach. On
# the reference finger 790 nodes in place of 700, and pressures within 4 to 6 % of the peak of those
# on facets of 0.1 mm (alike all over: 7 to 9; 0.65 and 1.2: 1000 nodes, 4; 1.0 and 1.4: 8 to 12).
INNER_SIZE, OUTER_SIZE = 0.8, 1.2
# Away from a plate's end, a singularity, elements may grow faster than elsewhere. Against a fine
# swept mesh, the root mean square of the gages' errors in per cent of the largest reading, in two
# or three meshes each: 1.8 with mesh.gradation 0.7 gives 1.3 to 1.4 on the reference finger with
# 170k equations and 0.6 to 0.9 on the sensitive one; 1.2 with 0.5 gave 1.2 to 1.5 with 245k and
# 0.8; 2.4 gives 2.5.
END_GRADATION = 1.8


def contact_size(
    said: float, zone_half_width: float, zone_half_depth: float | None = None
) -> float:
    """Edge length at the contact, mm, where ``said`` is asked for and the contact zone is so large.

    No coarser than FACETS_ACROSS facets over the zone's half-width (or half-depth) need, but no
    finer than LEAST_CONTACT_SIZE of what is said.
    """
    least = min(zone_half_width, zone_half_depth or np.inf) / FACETS_ACROSS
    return min(said, max(least, LEAST_CONTACT_SIZE * said))


@dataclass(frozen=True)
class MeshSizes:
    """Edge lengths in mm.

    contact    mean edge of the contact facets that the scene's path reaches
    plate, far along the plates, and largest anywhere: in the section (x, y)
    gradation  growth of the size, mm per mm away from where it is set
    stretch    elements are this many times longer along z than in the section
    """

    contact: float
    plate: float
    far: float
    gradation: float
    stretch: float = STRETCH_STRAIGHT

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0.0):
                raise MeshError(f"mesh size {name} = {value} must be a finite number above 0")

    @classmethod
    def of(cls, design: Design, zone: Zone) -> Self:
        """The sizes a design asks for in its ``[mesh]`` table, no coarser than its contact needs.

        ``zone``: of the contact that its scene will produce.
        """
        mesh, body = design.mesh, design.body
        round_contact = zone.half_depth is not None or body.dome_radius_mm is not None
        stretch = STRETCH_ROUND if round_contact else STRETCH_STRAIGHT
        across = [plates.along == "z" for plates in design.plates.all_rows]
        if body.kind.turned or body.step is not None or (design.plates.number and any(across)):
            stretch = 1.0  # no direction is the slow one
        contact = contact_size(mesh.contact_size_mm, zone.half_width, zone.half_depth)
        return cls(contact, mesh.plate_size_mm, mesh.far_size_mm, mesh.gradation, stretch)

    def scaled(self, factor: float) -> Self:
        """The same field with every length multiplied by ``factor``."""
        return replace(
            self,
            contact=self.contact * factor,
            plate=self.plate * factor,
            far=self.far * factor,
        )


@dataclass(frozen=True)
class SizeField:
    """Wanted edge length in the section: fine at the contact zone, at plates and at their ends.

    The square ends of the plates are stress singularities, and what strains a gage comes in through
    them: there the size is half the thickness (but no less than a tenth of ``sizes.plate``) and
    grows by END_GRADATION.
    """

    surface: Surface
    frames: tuple[PlateFrame, ...]
    sizes: MeshSizes
    zone: Zone

    def __call__(self, points: Array) -> Array:
        """Wanted edge length (n,), mm, at points (n, 2) or (n, 3)."""
        wanted, sizes = self.at_contact(points), self.sizes
        for frame in self.frames:
            plate, ends = distances_to_plate(frame, points, sizes.stretch)
            wanted = np.minimum(wanted, sizes.plate + sizes.gradation * plate)
            wanted = np.minimum(wanted, self.end_size(frame) + END_GRADATION * ends)
            for hole in frame.holes:
                wanted = np.minimum(wanted, hole.radius + END_GRADATION * ends)
        return np.asarray(wanted)

    def box(self, body: Body, half: bool) -> tuple[Array, Array]:
        """Lowest and highest corners (3,) of the body's, or its half z >= 0's, box."""
        high = np.array([0.5 * body.width_mm, self.surface.crest, 0.5 * body.depth_mm])
        return high * [-1.0, 0.0, -1.0 + half], high

    def at_contact(self, points: Array) -> Array:
        """What the contact alone asks for, (n,), mm, at points (n, 2) or (n, 3)."""
        sizes = self.sizes
        from_middle = np.abs(points[:, 0])
        sideways = np.maximum(from_middle - self.zone.half_width, 0.0)
        # The surface continued below its lowest point is no contact surface.
        below = self.surface.lowest - points[:, 1]
        if self.zone.half_depth is not None and points.shape[1] == 3:
            past = np.maximum(np.abs(points[:, 2]) - self.zone.half_depth, 0.0)
            sideways = np.hypot(sideways, past / sizes.stretch)
        away = np.hypot(sideways, np.maximum(np.abs(self.surface.distance(points)), below))
        least = sizes.contact / np.sqrt(sizes.stretch)  # across; along z longer, on the mean so
        contact: float | Array = least
        if self.zone.inner is not None:
            beyond = np.maximum(from_middle - self.zone.inner, 0.0)
            inner = INNER_SIZE * least
            contact = np.minimum(OUTER_SIZE * least, inner + sizes.gradation * beyond)
        return np.asarray(np.minimum(sizes.far, contact + sizes.gradation * away))

    def end_size(self, frame: PlateFrame) -> float:
        """Wanted edge length at a plate's ends, mm."""
        return min(self.sizes.plate, max(0.5 * frame.thickness, 0.1 * self.sizes.plate))


def distances_to_plate(
    frame: PlateFrame, points: Array, stretch: float = 1.0
) -> tuple[Array, Array]:
    """Distances (n,), mm, from points (n, 2) or (n, 3) to a plate's box and to its two end faces.

    Distances across the section plane count 1 / ``stretch``.
    """
    u, v = np.abs(frame.local(points)).T
    beside = np.maximum(v - 0.5 * frame.thickness, 0.0)
    if points.shape[1] == 3:
        w = frame.across(points)
        past = np.maximum(np.maximum(frame.low - w, w - frame.high), 0.0)
        beside = np.hypot(beside, past / stretch)
    along = u - 0.5 * frame.length
    return np.hypot(np.maximum(along, 0.0), beside), np.hypot(along, beside)


_CELL = 0.7  # largest cell of the integral over the size at its middle
_DEEPEST = 12
_FIRST = 6  # cells across the body's shortest extent to begin with
# Cells of one level: of more, some stand for all, so that an astronomic mesh is predicted at once.
_MOST_CELLS = 25_000


def expected_elements(field: SizeField, low: Array, high: Array) -> float:
    """How many tetrahedra the field asks for within the body between low and high (3,).

    By the volume of a regular tetrahedron, h^3 / (6 sqrt 2), stretched.
    """
    sizes = field.sizes
    stretch = np.array([1.0, 1.0, sizes.stretch])
    extent = (high - low) / stretch
    return elements_within(
        field,
        (low, high),
        np.maximum(np.round(_FIRST * extent / extent.min()), 1),
        lambda cells, _: field.surface.encloses(cells).astype(float),
        lambda size: sizes.stretch * size**3 / (6.0 * np.sqrt(2.0)),
        (_CELL, _DEEPEST, _MOST_CELLS),
        stretch,
    )


def elements_within(
    field: Callable[[Array], Array],
    box: tuple[Array, Array],
    count: Array,
    inside: Callable[[Array, Array], Array],
    element: Callable[[Array], Array],
    bounds: tuple[float, int, int],
    stretch: Array | float = 1.0,
) -> float:
    """Elements of the field's size within a box: two corners (d,), ``count`` (d,) cells at first.

    The cells are cut up until they suit the size at their middles, ``stretch`` times as long by
    direction. inside(middles, edges): the share of each cell that counts; element(size): the volume
    or area of one. bounds: the largest cell over the size, the deepest level, the most cells kept
    of a level; of more, some stand for all.
    """
    (low, high), (most, deepest, kept) = box, bounds
    step = (high - low) / count
    axes = [low[k] + step[k] * (np.arange(int(count[k])) + 0.5) for k in range(len(count))]
    cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(count))
    corners = np.array(list(product((-1, 1), repeat=len(count))))
    total, stands_for = 0.0, 1.0
    for level in range(deepest + 1):
        wanted = field(cells)
        good = ((step / stretch).max() <= most * wanted) | (level == deepest)
        if good.any():
            share = inside(cells[good], step) / element(wanted[good])
            total += stands_for * float(share.sum() * step.prod())
        cells, share_kept = some_of(cells[~good], kept)
        if not len(cells):
            break
        stands_for /= share_kept
        step = 0.5 * step
        cells = (cells[:, None] + 0.5 * step * corners).reshape(-1, len(step))
    return total


def some_of(cells: Array, most: int) -> tuple[Array, float]:
    """No more than ``most`` of the cells, by chance but always the same ones, and their share."""
    if len(cells) <= most:
        return cells, 1.0
    chosen = np.random.default_rng(0).choice(len(cells), most, replace=False)
    return cells[chosen], most / len(cells)


def background_grid(
    field: SizeField, low: Array, high: Array
) -> tuple[Array, NDArray[np.int32], Array]:
    """A rectilinear grid of tetrahedra over a box with the field's value at each of its points.

    low, high (3,): the box to cover (a margin is added). The grid is fine where the field is steep;
    where that would take more than about GRID_POINTS points, all of it is coarser. Returns points
    (n, 3), positively oriented tetrahedra (t, 4), values (n,).
    """
    axes = _grid_axes(field, low, high)
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = tuple(len(axis) for axis in axes)
    numbers = np.arange(len(points)).reshape(shape)

    def corner(step: Array) -> IntArray:
        i, j, k = (int(s) for s in step)
        nx, ny, nz = shape
        return numbers[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].reshape(-1)

    tets = []
    for order in permutations(range(3)):  # Kuhn's six tetrahedra of a brick
        path = [np.zeros(3)]
        for axis in order:
            path.append(path[-1] + np.eye(3)[axis])
        tet = np.stack([corner(step) for step in path], axis=1)
        even = np.linalg.det(np.diff(np.array(path), axis=0)) > 0
        tets.append(tet if even else tet[:, [0, 2, 1, 3]])
    return points, np.vstack(tets).astype(np.int32), field(points)


def _grid_axes(field: SizeField, low: Array, high: Array) -> list[Array]:
    """Grid coordinates along x, y and z: fine around plates and the contact surface's heights."""
    sizes, extent = field.sizes, high - low
    coarse = np.minimum(np.array([0.5, 0.5, 1.0]) * sizes.far, 0.25 * extent)
    fine = np.minimum(np.array([2.0, 0.7, 2.0]) * sizes.contact, coarse)
    first, last = low.copy(), high.copy()
    first[1] = _zone_floor(field, high) - 2.0 * sizes.contact
    half_depth = field.zone.half_depth
    round_zone = half_depth is not None or field.surface.curvatures[1] > 0.0
    steep_in_z = round_zone
    if field.frames:
        end = min(field.end_size(frame) for frame in field.frames)
        corners = np.vstack([plate_points(frame) for frame in field.frames])
        least, most = corners.min(axis=0), corners.max(axis=0)
        across = 2 if all(frame.along == "x" for frame in field.frames) else 1
        fine[:across] = np.minimum(fine[:across], [2.0 * end, end][:across])
        first[1] = min(first[1], least[1] - 2.0 * end)
        first[0], last[0] = least[0] - 2.0 * end, most[0] + 2.0 * end
        if across == 1:
            fine[1:] = np.minimum(fine[1:], [end, 2.0 * end])
            first[2], last[2] = least[2] - 2.0 * end, most[2] + 2.0 * end
        steep_in_z |= across == 1 or least[2] > low[2] + 1e-6 or most[2] < high[2] - 1e-6
    elif half_depth is not None:
        reach = 1.5 * half_depth
        first[2], last[2] = max(low[2], -reach), min(high[2], reach)
    if not steep_in_z:
        fine[2] = coarse[2] = 0.5 * extent[2]
    factor = 1.0
    while True:
        axes = [
            _graded_axis(low[i], high[i], first[i], last[i], factor * fine[i], factor * coarse[i])
            for i in range(3)
        ]
        if np.prod([float(len(axis)) for axis in axes]) <= GRID_POINTS:
            return axes
        factor *= 1.1


def _graded_axis(
    low: float, high: float, first: float, last: float, fine: float, coarse: float
) -> Array:
    """Coordinates from below ``low`` to above ``high``, spaced ``fine`` from first to last."""
    margin = 0.05 * (high - low) + 1e-6
    start, stop = low - margin, high + margin
    first, last = max(first, start), min(last, stop)
    pieces = [(start, first, coarse), (first, last, fine), (last, stop, coarse)]
    found = [np.array([start])]
    for begin, end, step in pieces:
        if end - begin > 1e-9 * (stop - start):
            count = int(np.ceil((end - begin) / step))
            found.append(np.linspace(begin, end, count + 1)[1:])
    return np.concatenate(found)


def _zone_floor(field: SizeField, high: Array) -> float:
    """Least height of the contact surface over the zone, mm."""
    x = np.linspace(0.0, min(field.zone.half_width, float(high[0])), 9)
    deep = field.zone.half_depth if field.zone.half_depth is not None else float(high[2])
    z = np.linspace(0.0, deep, 9)
    heights = field.surface.height(*(axis.reshape(-1) for axis in np.meshgrid(x, z)))
    known = heights[np.isfinite(heights)]
    return float(known.min()) if len(known) else field.surface.lowest
