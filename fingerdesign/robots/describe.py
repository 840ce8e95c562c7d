"""A finger as MJCF or URDF: meshes, mass and inertia, a site or frame at each gage.

The finger's base is fixed at y = 0 of its body's frame, which has the finger's axes: x tangential,
y normal, z along the plates. Descriptions are in metres; the STL files in mm, scaled there.
Simulators take the convex hull of a collision mesh, so the hull is what is written.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as xml

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
from fingerdesign.robots.flex import PINNED, Flex, flex_of
from fingerdesign.robots.rigid import RigidBody, densities, rigid_body, triangles_of

COLLISION = "collision"
COLOURS = {"body": "0.80 0.84 0.88 1", "plates": "0.72 0.45 0.20 1", "core": "0.93 0.90 0.80 1"}
FLEX_MM = (0.2, 20.0)  # At 0.2 a finger has a quarter of a million tetrahedra, and loads in 3 s.
_SITE_M = 0.0002
_MOMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # places of an inertia's numbers
_DAMPING_s = 0.0005  # Of the flex, Rayleigh's: it damps a swing of 100 Hz by a sixth.
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
    root = xml.Element("mujoco", model=finger.name)
    xml.SubElement(root, "compiler", angle="radian")
    if finger.flex is not None:
        xml.SubElement(root, "option", integrator="discrete")
    asset = xml.SubElement(root, "asset")
    body = xml.SubElement(xml.SubElement(root, "worldbody"), "body", name=finger.name)
    if (rigid := finger.rigid) is not None:
        full = _numbers([rigid.inertia[place] for place in _MOMENTS])
        about = {"pos": _numbers(rigid.centre), "mass": f"{rigid.mass:.9g}", "fullinertia": full}
        xml.SubElement(body, "inertial", about)
    if finger.flex is not None:
        _add_flex(body, finger.name, finger.flex)
    for part, path in finger.meshes.items():
        name = f"{finger.name}_{part}"
        scaled = {"name": name, "file": path.name, "scale": "0.001 0.001 0.001"}
        xml.SubElement(asset, "mesh", scaled)
        geom = {"name": name, "type": "mesh", "mesh": name, "mass": "0"}
        if part == COLLISION:
            geom |= {"group": "3", "condim": "4"}
        else:
            geom |= {"group": "2", "rgba": COLOURS[part], "contype": "0", "conaffinity": "0"}
        xml.SubElement(body, "geom", geom)
    xml.SubElement(body, "site", name=f"{finger.name}_pad", size=f"{_SITE_M}")
    crest = {"name": f"{finger.name}_crest", "pos": f"0 {finger.crest:.9g} 0"}
    xml.SubElement(body, "site", crest, size=f"{_SITE_M}")
    for site in finger.sites:
        place = {"pos": _numbers(site.centre), "xyaxes": _numbers(site.axes.T[:2].ravel())}
        name = f"{finger.name}_{site.name}"
        xml.SubElement(body, "site", {"name": name, **place}, size=f"{_SITE_M}", group="4")
    return _text(root)


def _add_flex(body: xml.Element, name: str, flex: Flex) -> None:
    sizes = {"radius": f"{_SITE_M}", "mass": f"{flex.mass:.9g}"}
    about = {"name": f"{name}_rubber", "type": "direct", "dim": "3", "dof": "quadratic"}
    points = {"point": _numbers(flex.points.ravel()), "element": _numbers(flex.cells.ravel())}
    comp = xml.SubElement(body, "flexcomp", {**about, "rgba": COLOURS["body"], **sizes, **points})
    xml.SubElement(comp, "contact", selfcollide="none", condim="4")
    modulus = {"young": f"{flex.youngs_modulus:.9g}", "poisson": f"{flex.poissons_ratio:.9g}"}
    xml.SubElement(comp, "elasticity", {**modulus, "damping": f"{_DAMPING_s}"})
    xml.SubElement(comp, "pin", id=PINNED)


def urdf(finger: Description) -> str:
    """Write the finger as a URDF robot: one link, and a fixed frame at each gage."""
    root = xml.Element("robot", name=finger.name)
    link = xml.SubElement(root, "link", name=finger.name)
    inertial = xml.SubElement(link, "inertial")
    rigid = finger.rigid
    assert rigid is not None  # it has no flex: URDF knows none
    xml.SubElement(inertial, "origin", xyz=_numbers(rigid.centre), rpy="0 0 0")
    xml.SubElement(inertial, "mass", value=f"{rigid.mass:.9g}")
    inertia = {f"i{'xyz'[j]}{'xyz'[k]}": f"{rigid.inertia[j, k]:.9g}" for j, k in _MOMENTS}
    xml.SubElement(inertial, "inertia", inertia)
    for part, path in finger.meshes.items():
        role = xml.SubElement(link, "collision" if part == COLLISION else "visual", name=part)
        geometry = xml.SubElement(role, "geometry")
        xml.SubElement(geometry, "mesh", filename=path.name, scale="0.001 0.001 0.001")
        if part != COLLISION:
            material = xml.SubElement(role, "material", name=part)
            xml.SubElement(material, "color", rgba=COLOURS[part])
    for site in finger.sites:
        name = f"{finger.name}_{site.name}"
        xml.SubElement(root, "link", name=name)
        joint = xml.SubElement(root, "joint", name=f"{name}_joint", type="fixed")
        xml.SubElement(joint, "parent", link=finger.name)
        xml.SubElement(joint, "child", link=name)
        turned = _roll_pitch_yaw(site.axes)
        xml.SubElement(joint, "origin", xyz=_numbers(site.centre), rpy=_numbers(turned))
    return _text(root)


def _roll_pitch_yaw(axes: Array) -> Array:
    """Angles (3,) of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch = np.arctan2(-axes[2, 0], np.hypot(axes[0, 0], axes[1, 0]))
    if abs(np.cos(pitch)) < 1e-9:  # Only the difference of roll and yaw counts.
        return np.array([np.arctan2(-axes[1, 2], axes[1, 1]), pitch, 0.0])
    roll, yaw = np.arctan2(axes[2, 1], axes[2, 2]), np.arctan2(axes[1, 0], axes[0, 0])
    return np.array([roll, pitch, yaw])


def _numbers(values: Array | IntArray | list[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def _text(root: xml.Element) -> str:
    xml.indent(root)
    return f'<?xml version="1.0"?>\n{xml.tostring(root, encoding="unicode")}\n'
