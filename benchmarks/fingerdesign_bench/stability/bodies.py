"""The bodies of the stability map: small models that make contact hard in different ways."""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.checks.load import parse_design
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.fem.model import build_model
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import TRIANGLE_EDGES
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import Mesh
from fingerdesign.reduced import ReducedModel

_SIZES = """
mesh.section.contact_size_mm = 0.15
mesh.section.plate_size_mm = 0.25
mesh.section.plate_end_size_mm = 0.1
mesh.section.far_size_mm = 1.5
mesh.section.gradation = 0.4
"""
_COARSE = _SIZES.replace("contact_size_mm = 0.15", "contact_size_mm = 0.8")
_BARE = "plates.count = 0\n"
# The least rubber over a plate that a design may have is 0.1 mm.
_SHALLOW = "plates.count = 5\nplates.pitch_mm = 1.0\nplates.cover_mm = 0.93\n"
_LYING = "plates.count = 3\nplates.pitch_mm = 2.5\nplates.angle_deg = 0.0\nplates.cover_mm = 0.31\n"
_STIFF = """
plates.material = "stiff"
materials.silicone.youngs_modulus_MPa = 1.0
materials.stiff.youngs_modulus_MPa = 1e6
materials.stiff.poissons_ratio = 0.3
"""
# Nearly flat: touched over its whole width, its edges are stress singularities.
_FLAT = "body.width_mm = 6.0\nbody.base_height_mm = 4.0\nbody.arc_radius_mm = 1e4\n"
_SOLID = """
mesh.mesher = "sweep"
mesh.contact_size_mm = 0.5
mesh.far_size_mm = 3.0
mesh.layers = 4
body.width_mm = 10.0
body.base_height_mm = 5.0
body.depth_mm = 5.0
"""


@dataclass(frozen=True)
class HardBody:
    """A finger to be condensed: ``design`` text without the silicone's Poisson's ratio.

    group: the row of the map that it belongs to; zone: half-width of the candidates, mm;
    press: approach, mm, of an ordinary grip; load: normal force, N, of another; solid: 3-D,
    ``symmetric`` its half z >= 0; objects: also under a tilted plane, a cylinder, a sphere; radius
    of its arc, mm; distortion: largest random displacement of interior corners as a part of their
    shortest edge, drawn from ``seed``.
    """

    name: str
    group: str
    poissons_ratio: float
    design: str
    zone: float
    press: float
    load: float = 5.0
    solid: bool = False
    symmetric: bool = True
    objects: bool = False
    radius: float = 20.0
    distortion: float = 0.0
    seed: int = 0

    def of(self, poissons_ratio: float) -> "HardBody":
        """The same body of a rubber of this Poisson's ratio."""
        name = f"{self.name}, nu {poissons_ratio}"
        return replace(self, name=name, poissons_ratio=poissons_ratio)

    def parsed(self) -> Design:
        text = f'design.name = "hard"\n{self.design}'
        if "materials.silicone.youngs_modulus_MPa" not in text:
            text += "materials.silicone.youngs_modulus_MPa = 4.96\n"
        return parse_design(text + f"materials.silicone.poissons_ratio = {self.poissons_ratio}\n")

    def build(self) -> tuple[ReducedModel, float]:
        """The reduced model and the height of its crest, mm."""
        design = self.parsed()
        if self.solid:
            mesh = extrude(design, Zone(self.zone), self.symmetric)
        else:
            mesh = mesh_section(design, self.zone)
        if self.distortion:
            mesh = distorted(mesh, self.distortion, self.seed)
        return build_model(design, mesh, self.zone).reduced, crest_height(design.body)


def hard_bodies() -> tuple[HardBody, ...]:
    """All bodies, the plain ones first."""
    flat = HardBody("flat", "flat end", 0.0, _BARE + _FLAT + _SIZES, 3.0, 0.05, radius=1e4)
    solid = HardBody("3-D", "3-D", 0.0, _BARE + _SOLID, 3.2, 0.1, load=1.0, solid=True)
    arc = HardBody("arc", "arc finger", 0.0, _BARE + _SIZES, 5.0, 0.3)
    coarse = HardBody("coarse", "coarse mesh", 0.0, _BARE + _COARSE, 5.0, 0.3)
    plates = HardBody("15 plates", "15 plates", 0.0, _SIZES, 5.0, 0.3)
    surface = "plates at the surface"
    return (
        *(replace(arc.of(nu), objects=nu != 0.49) for nu in (0.0, 0.3, 0.49, 0.4999)),
        *(plates.of(nu) for nu in (0.3, 0.4999)),
        HardBody("shallow plates", surface, 0.49, _SHALLOW + _SIZES, 5.0, 0.3),
        HardBody("lying plates", surface, 0.3, _LYING + _SIZES, 5.0, 0.3),
        HardBody(
            *("contrast 1e6", "stiffness contrast 1e6", 0.49),
            *(_SHALLOW + _STIFF + _SIZES, 5.0, 0.3),
        ),
        *(flat.of(nu) for nu in (0.0, 0.49)),
        *(coarse.of(nu) for nu in (0.3, 0.4999)),
        *(
            HardBody(
                *(f"distorted, seed {seed}", "distorted mesh", nu, _BARE + _SIZES, 5.0, 0.3),
                distortion=0.35,
                seed=seed,
            )
            for seed, nu in enumerate((0.3, 0.49, 0.4999))
        ),
        *(replace(solid.of(nu), symmetric=nu != 0.3, objects=nu != 0.0) for nu in (0.0, 0.3, 0.49)),
    )


def distorted(mesh: Mesh, share: float, seed: int) -> Mesh:
    """The section's mesh with interior corners moved at random, by up to ``share`` of an edge.

    The body's outline and its plates stay. Moves that would turn a triangle over are halved until
    none does. Raises MeshError for a 3-D mesh.
    """
    if mesh.dimension != 2:
        raise MeshError("only cross-section meshes are distorted")
    corners = mesh.corners
    used, cells = np.unique(corners, return_inverse=True)
    cells = cells.reshape(corners.shape)
    points = mesh.points[used]
    held = np.isin(used, np.concatenate([f[:, :2] for f in mesh.facets.values()]))
    held[cells[mesh.regions > 0]] = True
    ends = np.concatenate([cells[:, pair] for pair in TRIANGLE_EDGES])
    length = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    shortest = np.full(len(points), np.inf)
    for side in (0, 1):
        np.minimum.at(shortest, ends[:, side], length)
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, 2.0 * np.pi, len(points))
    reach = share * shortest * np.where(held, 0.0, 1.0)
    step = reach[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    before = cell_volumes(points, cells)
    for _ in range(40):
        turned = cell_volumes(points + step, cells) < 0.05 * before
        if not turned.any():
            break
        step[np.unique(cells[turned])] *= 0.5
    else:
        raise MeshError("the distorted mesh keeps turning triangles over")
    moved = mesh.points.copy()
    moved[used] = points + step
    for middle, (one, other) in enumerate(TRIANGLE_EDGES, start=3):
        both = moved[mesh.cells[:, [one, other]]]
        moved[mesh.cells[:, middle]] = both.mean(axis=1)
    outline = np.unique(np.concatenate(list(mesh.facets.values())))
    moved[outline] = mesh.points[outline]  # its mid-nodes lie on the exact arc
    return replace(mesh, points=moved)
