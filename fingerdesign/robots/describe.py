"""A finger as MJCF or URDF: meshes, mass and inertia, a site or frame at each gage.

The finger's base is fixed at y = 0 of its body's frame, which has the finger's axes: x tangential,
y normal, z along the plates. Descriptions are in metres; the STL files in mm, scaled there.
Simulators take the convex hull of a collision mesh, so the hull is what is written.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.cad.export import write_triangles
from fingerdesign.cad.solid_process import write_finger_cad
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.solids import hull_of
from fingerdesign.records.folder import RecordFolder
from fingerdesign.report.page import macros
from fingerdesign.robots.flex import Flex, flex_of
from fingerdesign.robots.rigid import RigidBody, densities, rigid_body, triangles_of

COLLISION = "collision"
FLEX_MM = (0.2, 20.0)  # At 0.2 a finger has a quarter of a million tetrahedra, and loads in 3 s.
_TEMPLATE = Path(__file__).parent / "templates" / "finger.xml.j2"
FOLDERS = {
    "xml": RecordFolder("MuJoCo model", "finger.xml", ("finger.xml", "*.stl")),
    "urdf": RecordFolder("robot description", "finger.urdf", ("finger.urdf", "*.stl")),
}


@dataclass(frozen=True)
class GageSite:
    """A gage's name, centre (3,) in m, and axes (3, 3): columns along the plate, normal to its
    upper face, across."""

    name: str
    centre: Array
    axes: Array


@dataclass(frozen=True)
class Description:
    """A finger as a robot's description has it. meshes: STL file by part; crest: of y, m.

    flex: the rubber, where it is not rigid; ``rigid`` is then the rest, None without any.
    """

    name: str
    rigid: RigidBody | None
    meshes: Mapping[str, Path]
    sites: tuple[GageSite, ...]
    crest: float
    flex: Flex | None = None

    @property
    def mass(self) -> float:
        """The sum over all parts, kg."""
        return sum(each.mass for each in (self.rigid, self.flex) if each is not None)


def describe(
    design: Design,
    folder: Path,
    given: Mapping[str, float] | None = None,
    flex_mm: float | None = None,
) -> Description:
    """Write the meshes of a finger into ``folder``; given: densities, g/cm^3, by material.

    flex_mm: the size of tetrahedra that replace the rubber's mesh and hull; None: it is rigid.
    Raises DesignError for a material without density and for a number that is no density or size,
    GeometryError where it cannot be built.
    """
    by_part = densities(design, given or {})
    least, most = FLEX_MM
    if flex_mm is not None and not least <= flex_mm <= most:
        raise DesignError([Fault("--flex", flex_mm, f"{least:g} to {most:g} mm", "correct it")])
    files = write_finger_cad(design, folder)
    hull = _write_hull(files["finger.stl"], folder / f"{COLLISION}.stl")
    for name in ("finger.step", "finger.stl"):
        files[name].unlink()
    meshes = {part: folder / f"{part}.stl" for part in by_part}
    solids = {part: (triangles_of(meshes[part]), rho) for part, rho in by_part.items()}
    meshes[COLLISION], flex = hull, None
    if flex_mm is not None:
        flex = flex_of(design, flex_mm, rigid_body([solids.pop("body")]).mass)
        for part in ("body", COLLISION):
            meshes.pop(part).unlink()
    rigid = rigid_body(solids.values()) if solids else None
    frames = plate_frames(design) if design.plates.model != "none" else ()
    sites = tuple(_site(frame, design.gages.z_mm) for frame in frames)
    crest = 1e-3 * crest_height(design.body)
    return Description(design.design.name, rigid, meshes, sites, crest, flex)


def _write_hull(outside: Path, path: Path) -> Path:
    """Write the convex hull of an STL."""
    hull = hull_of(triangles_of(outside).reshape(-1, 3))
    mesh, volume = hull.to_mesh64(), hull.volume()
    return write_triangles(mesh.vert_properties, mesh.tri_verts, path, volume, 1e-6 * volume)


def _site(frame: PlateFrame, across: float) -> GageSite:
    centre = frame.to_space(frame.centre[None], frame.middle + across)[0]
    axis, normal = frame.direction(frame.axis), frame.direction(frame.normal)
    axes = np.column_stack([axis, normal, np.cross(axis, normal)])
    # From 1, as traces, mock-up units and data sets count gages.
    return GageSite(f"gage_{frame.index + 1}", 1e-3 * centre, axes)


def mjcf(finger: Description) -> str:
    """Write the finger as a MuJoCo model: a body without joints, to be attached to a hand's."""
    return str(macros(_TEMPLATE).mjcf(finger, _numbers))


def urdf(finger: Description) -> str:
    """Write the finger as a URDF robot: one link, and a fixed frame at each gage."""
    assert finger.rigid is not None  # it has no flex: URDF knows none
    return str(macros(_TEMPLATE).urdf(finger, _numbers, _roll_pitch_yaw))


def _roll_pitch_yaw(axes: Array) -> Array:
    """Angles (3,) of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch = np.arctan2(-axes[2, 0], np.hypot(axes[0, 0], axes[1, 0]))
    if abs(np.cos(pitch)) < 1e-9:  # Only the difference of roll and yaw counts.
        return np.array([np.arctan2(-axes[1, 2], axes[1, 1]), pitch, 0.0])
    roll, yaw = np.arctan2(axes[2, 1], axes[2, 2]), np.arctan2(axes[1, 0], axes[0, 0])
    return np.array([roll, pitch, yaw])


def _numbers(values: Array | IntArray | list[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)
