"""The section's triangles and their extrusion: areas, names, orientation, the exact arc."""

import numpy as np
import pytest

from fingerdesign import parse_design, with_values
from fingerdesign.errors import MeshError
from fingerdesign.fem.elements import physical_gradients
from fingerdesign.layout.frames import crest_height, plate_frames
from fingerdesign.layout.volume import outline_volume
from fingerdesign.mesh.section.extrude import extrude, layer_heights
from fingerdesign.mesh.section.section import mesh_section

DESIGN = parse_design(
    """
    design.name = "sectioned"
    body.width_mm = 12.0
    body.base_height_mm = 5.0
    body.arc_radius_mm = 10.0
    body.depth_mm = 6.0
    plates.count = 5
    mesh.layers = 3
    mesh.contact_size_mm = 0.6
    """
)


def measure(mesh):
    """Volume (area) by region."""
    _, weights = physical_gradients(mesh.points, mesh.cells, 4)
    return np.bincount(mesh.regions, weights.sum(axis=1))


@pytest.mark.parametrize("kind", ["section", "half", "whole"])
def test_regions_fill_the_body(kind):
    mesh = mesh_section(DESIGN, 2.0) if kind == "section" else extrude(DESIGN, 2.0, kind == "half")
    depth = {"section": 1.0, "half": 3.0, "whole": 6.0}[kind]
    sizes = measure(mesh)
    plates = plate_frames(DESIGN)
    assert len(sizes) == len(plates) + 1
    assert np.allclose(sizes[1:], 2.0 * 0.1 * depth, rtol=1e-9)
    # Quadratic edges on the exact arc: the area is good to the fourth order of the edge.
    assert np.isclose(sizes.sum(), outline_volume(DESIGN.body) / 6.0 * depth, rtol=1e-6)


def test_contact_nodes_lie_on_the_arc():
    for mesh in (mesh_section(DESIGN, 2.0), extrude(DESIGN, 2.0)):
        nodes = mesh.points[np.unique(mesh.facets["contact"])]
        centre = np.array([0.0, crest_height(DESIGN.body) - 10.0])
        assert np.abs(np.linalg.norm(nodes[:, :2] - centre, axis=1) - 10.0).max() < 1e-12


def test_named_facets_cover_the_boundary():
    mesh = extrude(DESIGN, 2.0)
    assert set(mesh.facets) == {"base", "side", "end", "symmetry", "contact"}
    assert np.abs(mesh.points[np.unique(mesh.facets["base"]), 1]).max() == 0.0
    assert np.abs(mesh.points[np.unique(mesh.facets["symmetry"]), 2]).max() == 0.0
    assert np.allclose(mesh.points[np.unique(mesh.facets["end"]), 2], 3.0)
    assert np.allclose(np.abs(mesh.points[np.unique(mesh.facets["side"]), 0]), 6.0)


def test_the_same_mesh_every_time():
    one, two = mesh_section(DESIGN, 2.0), mesh_section(DESIGN, 2.0)
    assert np.array_equal(one.points, two.points)
    assert np.array_equal(one.cells, two.cells)


def test_fine_where_the_contact_is():
    mesh = mesh_section(DESIGN, 2.0)
    facets = mesh.facets["contact"][:, :2]
    ends = mesh.points[facets]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    inside = np.abs(ends[:, :, 0]).max(axis=1) <= 2.0
    assert length[inside].max() <= 1.2 * DESIGN.mesh.section.contact_size_mm


def test_gage_ends_are_nodes():
    mesh = mesh_section(DESIGN, 2.0)
    frame = plate_frames(DESIGN)[2]
    for side in (-0.5, 0.5):
        for end in (-0.5, 0.5):
            place = np.array([frame.x, frame.y]) + end * 1.0 * frame.axis
            place = place + side * frame.thickness * frame.normal
            assert np.linalg.norm(mesh.points - place, axis=1).min() < 1e-9


def test_left_out_plates_leave_rubber():
    mesh = mesh_section(with_values(DESIGN, {"plates.model": "none"}), 2.0)
    assert set(mesh.regions.tolist()) == {0}


def test_layers_thin_toward_the_free_end():
    heights = layer_heights(5.0, 6)
    steps = np.diff(heights)
    assert heights[0] == 0.0
    assert heights[-1] == pytest.approx(5.0)
    assert (np.diff(steps) < 0).all()


def test_a_body_that_changes_along_z_cannot_be_extruded():
    dome = with_values(DESIGN, {"body.shape": "dome", "body.dome_radius_mm": 20.0})
    with pytest.raises(MeshError, match=r"body\.shape = 'dome'.*tetwild"):
        extrude(dome, 2.0)


def test_a_mesh_that_lost_its_plates_is_not_called_good():
    from dataclasses import replace

    from fingerdesign.mesh.quality import assess

    mesh = extrude(DESIGN, 2.0)
    assert assess(mesh, DESIGN).worst_plate_volume_error < 1e-6
    lost = replace(mesh, regions=np.zeros_like(mesh.regions))
    assert assess(lost, DESIGN).worst_plate_volume_error == pytest.approx(1.0)


def test_sizes_that_netgen_cannot_do_in_time_end_with_a_reason():
    fine = with_values(
        DESIGN,
        {
            "mesh.section.contact_size_mm": 0.001,
            "mesh.section.far_size_mm": 0.01,
            "mesh.time_limit_s": 1.0,
        },
    )
    with pytest.raises(MeshError, match="did not finish in 1 s"):
        mesh_section(fine, 2.0)
