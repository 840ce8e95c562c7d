"""Plates as sheets in the mesh: slots of the plate's shape, faces that mirror, rubber around."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign import parse_design, with_values
from fingerdesign.errors import MeshError
from fingerdesign.fem.elements import physical_gradients
from fingerdesign.fem.sheet import sheet_of
from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.volume import outline_volume, section_area
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.sheets import open_sheets, room_around

TEXT = """
    design.name = "sheets"
    body.width_mm = 12.0
    body.base_height_mm = 5.0
    body.arc_radius_mm = 10.0
    body.depth_mm = 6.0
    plates.count = 3
    plates.model = "sheet"
    mesh.layers = 3
    mesh.contact_size_mm = 0.6
    mesh.section.contact_size_mm = 0.2
    mesh.section.plate_size_mm = 0.2
"""
DESIGN = parse_design(TEXT)


@pytest.fixture(scope="module", params=["section", "half", "whole"])
def mesh(request):
    if request.param == "section":
        return mesh_section(DESIGN, 2.0)
    return extrude(DESIGN, Zone(2.0), request.param == "half")


def rubber(mesh):
    return float(physical_gradients(mesh.points, mesh.cells, 4)[1].sum())


def shares(mesh):
    """Depth of the modelled part, mm (1 in the section)."""
    return 1.0 if mesh.dimension == 2 else (3.0 if mesh.symmetric else 6.0)


def test_the_rubber_is_the_body_without_the_plates(mesh):
    wanted = (section_area(DESIGN.body) - 3 * 2.0 * 0.1) * shares(mesh)
    assert rubber(mesh) == pytest.approx(wanted, rel=1e-5)
    assert outline_volume(DESIGN.body) / 6.0 * shares(mesh) - rubber(mesh) > 0.5
    assert set(mesh.regions.tolist()) == {0}
    report = assess(mesh, DESIGN)
    assert report.worst_face_area_error < 1e-4
    away = report.surface_distance_mm
    assert max(away.values()) < 1e-9
    faces = {f"plate_{k}_{face}" for k in range(3) for face in ("upper", "lower", "end")}
    bare = with_values(DESIGN, {"plates.model": "none"})
    flat = mesh.dimension == 2
    other = mesh_section(bare, 2.0) if flat else extrude(bare, Zone(2.0), mesh.symmetric)
    assert set(away) == set(mesh.facets) == faces | set(other.facets)
    for frame in plate_frames(DESIGN):
        sheet_of(mesh, frame)  # its faces mirror node by node


def test_gage_ends_are_nodes_on_both_faces():
    mesh = mesh_section(DESIGN, 2.0)
    frame = plate_frames(DESIGN)[1]
    for face, side in (("upper", 0.05), ("lower", -0.05)):
        nodes = mesh.points[np.unique(mesh.facets[f"plate_1_{face}"])]
        for end in (-0.5, 0.5):
            place = np.array([frame.x, frame.y]) + end * frame.axis + side * frame.normal
            assert np.linalg.norm(nodes - place, axis=1).min() < 1e-9


def test_crossing_angles_and_thick_plates():
    rows = [[-2.2, 5.2, 10.0], [0.5, 5.0, -60.0], [2.6, 4.5, 90.0]]
    design = with_values(DESIGN, {"plates.placement": rows, "plates.thickness_mm": 0.3})
    mesh = mesh_section(design, 2.0)
    assert rubber(mesh) == pytest.approx(section_area(design.body) - 3 * 2.0 * 0.3, rel=1e-5)
    assert assess(mesh, design).min_dihedral_deg > 10.0


@pytest.mark.parametrize("thickness", [0.03, 0.4])
def test_thin_and_thick_plates_open_without_turning_triangles_over(thickness):
    """Thick ones once did: the mesher cuts the lines beyond their ends into several."""
    design = parse_design(
        f"""
        design.name = "many"
        plates.count = 8
        plates.thickness_mm = {thickness}
        plates.length_mm = 2.2
        plates.angle_deg = 61.0
        plates.pitch_mm = 1.53
        plates.cover_mm = 1.9
        plates.model = "sheet"
        """
    )
    mesh = mesh_section(design, 2.0)
    wanted = section_area(design.body) - 8 * 2.2 * thickness
    assert rubber(mesh) == pytest.approx(wanted, rel=1e-6)
    assert assess(mesh, design).min_dihedral_deg > 3.0


def test_too_little_room_is_refused_by_name():
    frames = plate_frames(DESIGN)
    near = replace(frames[1], place=frames[0].place + 0.16)
    with pytest.raises(MeshError, match=r"plate 0 has 0\.0388 mm .* plates\.model = 'solid'"):
        room_around(frames[0], (frames[0], near), DESIGN.body)
    high = replace(frames[1], y=6.25)
    with pytest.raises(MeshError, match=r"plate 1 has 0\.0\d+ mm around its mid-line"):
        room_around(high, (high,), DESIGN.body)


def test_a_mesh_that_misses_a_line_is_refused():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    with pytest.raises(MeshError, match="does not follow plate 0"):
        open_sheets(points, np.array([[0, 1, 2]]), plate_frames(DESIGN)[:1], DESIGN.body, 0.1)
