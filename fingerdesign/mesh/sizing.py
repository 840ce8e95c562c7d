"""Target sizes of elements, point by point.

fTetWild reads its size field where the vertices of a first, coarse mesh happen to lie, by linear
interpolation in a background tetrahedral grid. A grid coarser than the field blurs it upward, so
the grid is fine where the field is steep.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.surface import Surface
from fingerdesign.layout.zone import Zone

# Measured on a finger with three plates against a fine extruded mesh (errors of membrane strain out
# of 39, of bending out of 286): sizes alone, 25k dofs: 2.8 and 33; with fine plate ends, 40k dofs:
# 1.1 and 25; with fine ends and stretched elements, 35k dofs: 0.4 and 11. The answer varies slowly
# along z. A dome's contact is round, and its elements nearly so.
STRETCH_STRAIGHT, STRETCH_ROUND = 2.0, 1.4
# Least number of contact facets over half the contact's width: with mesh.contact_size_mm alone, a
# small contact on a large finger would be a few facets. But no finer than a third of that key.
FACETS_ACROSS, LEAST_CONTACT_SIZE = 5.0, 0.33
# Factors on the size: facets that the scene's own path reaches, and those that only grips reach. On
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
    size: float, zone_half_width: float, zone_half_depth: float | None = None
) -> float:
    """Edge length at the contact, mm, for the target ``size`` and a contact zone.

    No coarser than FACETS_ACROSS facets over the zone's half-width (or half-depth) need, but no
    finer than LEAST_CONTACT_SIZE of ``size``.
    """
    least = min(zone_half_width, zone_half_depth or np.inf) / FACETS_ACROSS
    return min(size, max(least, LEAST_CONTACT_SIZE * size))


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
        """The sizes of a design's ``[mesh]`` table, no coarser than its contact needs.

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
        contact, plate, far = (factor * each for each in (self.contact, self.plate, self.far))
        return replace(self, contact=contact, plate=plate, far=far)


@dataclass(frozen=True)
class SizeField:
    """Target edge length in the section: fine at the contact zone, at plates and at their ends.

    The square ends of the plates are stress singularities, and what strains a gage comes in through
    them: there the size is half the thickness (but no less than a tenth of ``sizes.plate``) and
    grows by END_GRADATION.
    """

    surface: Surface
    frames: tuple[PlateFrame, ...]
    sizes: MeshSizes
    zone: Zone

    def __call__(self, points: Array) -> Array:
        """Target edge length (n,), mm, at points (n, 2) or (n, 3)."""
        target, sizes = self.at_contact(points), self.sizes
        for frame in self.frames:
            plate, ends = distances_to_plate(frame, points, sizes.stretch)
            target = np.minimum(target, sizes.plate + sizes.gradation * plate)
            target = np.minimum(target, self.end_size(frame) + END_GRADATION * ends)
            for hole in frame.holes:
                target = np.minimum(target, hole.radius + END_GRADATION * ends)
        return np.asarray(target)

    def box(self, body: Body, half: bool) -> tuple[Array, Array]:
        """Lowest and highest corners (3,) of the body's, or its half z >= 0's, box."""
        high = np.array([0.5 * body.width_mm, self.surface.crest, 0.5 * body.depth_mm])
        return high * [-1.0, 0.0, -1.0 + half], high

    def at_contact(self, points: Array) -> Array:
        """Edge length (n,) by the contact alone, mm, at points (n, 2) or (n, 3)."""
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
        """Target edge length at a plate's ends, mm."""
        return min(self.sizes.plate, max(0.5 * frame.thickness, 0.1 * self.sizes.plate))


def distances_to_plate(
    frame: PlateFrame, points: Array, stretch: float = 1.0
) -> tuple[Array, Array]:
    """Distances (n,), mm, from points (n, 2) or (n, 3) to a plate's box and to its two end faces.
    Distances across the section plane count 1 / ``stretch``."""
    u, v = np.abs(frame.local(points)).T
    sideways = np.maximum(v - 0.5 * frame.thickness, 0.0)
    if points.shape[1] == 3:
        w = frame.across(points)
        past = np.maximum(np.maximum(frame.low - w, w - frame.high), 0.0)
        sideways = np.hypot(sideways, past / stretch)
    along = u - 0.5 * frame.length
    return np.hypot(np.maximum(along, 0.0), sideways), np.hypot(along, sideways)
