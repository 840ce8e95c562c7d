"""Fingers swept through layers whose plates and core end inside the body."""

import numpy as np
import pytest

from fingerdesign import parse_design, with_values
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.layout.gaps import lies_over, not_layered
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.section.extrude import distinct, extrude, graded_heights, layer_heights

DESIGN = parse_design(
    """
    design.name = "short"
    body.width_mm = 12.0
    body.base_height_mm = 5.0
    body.arc_radius_mm = 10.0
    body.depth_mm = 6.0
    plates.count = 3
    plates.length_mm = 1.5
    plates.span_mm = 3.0
    mesh.layers = 3
    mesh.contact_size_mm = 0.8
    mesh.plate_size_mm = 0.5
    """
)
CORE = {"width_mm": 6.0, "height_mm": 1.0, "bottom_mm": 0.5, "depth_mm": 3.0}
BENT = {
    "plates.follow": "bent",
    "plates.angle_deg": 0.0,
    "plates.pitch_mm": 3.0,
    "plates.cover_mm": 1.0,
}
KINDS = {
    "common span": {},
    "off the middle": {"plates.span_offset_mm": 0.5},
    "staggered": {"plates.stagger_mm": 1.0},
    "placed": {"plates.placement": [[-2.0, 4.0, 45.0, 0.4], [0, 4, 45], [2, 4, 45, -0.6]]},
    "core": {"body.core": CORE},
    "bent": BENT,
    "sheets": {"plates.model": "sheet"},
    "staggered sheets": {"plates.model": "sheet", "plates.stagger_mm": 1.0},
    "sheets and core": {"plates.model": "sheet", "body.core": CORE},
    "left out, core": {"plates.model": "none", "body.core": CORE},
}


@pytest.mark.parametrize("name", KINDS)
def test_parts_end_where_the_design_says(name):
    """Regions' volumes, plates' faces and the outside's areas are the closed form's."""
    design = with_values(DESIGN, KINDS[name])
    mesh = extrude(design, Zone(2.0), mirrors_in_z(design))
    assert mesh.symmetric == (name not in ("off the middle", "placed") and "stag" not in name)
    report = assess(mesh, design)
    assert report.body_volume_error < 1e-6
    assert report.worst_plate_volume_error < 1e-6
    assert report.worst_face_area_error < 1e-6
    assert max(report.surface_distance_mm.values()) < 1e-9
    assert report.inverted_elements == 0
    assert report.min_dihedral_deg > 1.0
    solid = design.plates.model == "solid"
    regions = 1 + (3 if solid else 0) + (design.body.core is not None)
    assert len(np.unique(mesh.regions)) == regions


@pytest.mark.parametrize("model", ["solid", "sheet"])
def test_half_and_whole_are_the_same_finger(model):
    design = with_values(DESIGN, {"plates.model": model})
    half, whole = extrude(design, Zone(2.0)), extrude(design, Zone(2.0), symmetric=False)
    assert len(whole.cells) == 2 * len(half.cells)
    assert assess(whole, design).body_volume_error < 1e-6
    assert set(whole.facets) == set(half.facets) - {"symmetry"}


def test_full_plates_give_the_mesh_that_they_gave():
    """A plate as long as the body needs no border, and changes no layer."""
    full = extrude(with_values(DESIGN, {"plates.span_mm": 6.0}), Zone(2.0))
    heights = np.unique(np.round(full.points[np.unique(full.corners), 2], 9))
    assert heights == pytest.approx(layer_heights(3.0, 3, 1.15))


def test_layers_are_thin_where_plates_end():
    heights = graded_heights(np.array([0.0, 2.5, 5.0]), np.array([-2.5, 2.5, 5.0]), 0.3, 1.15)
    steps, middle = np.diff(heights), 0.5 * (heights[1:] + heights[:-1])
    assert {0.0, 2.5, 5.0} <= set(heights)
    assert (steps > 0.0).all()
    near = np.abs(middle[:, None] - [2.5, 5.0]).min(axis=1)
    assert (np.abs(steps - 0.3 - 0.15 * near) < 0.1).all()
    assert (
        np.diff(graded_heights(np.array([0.0, 5.0]), np.array([5.0]), 0.3, 1.15, 0.4)).max() <= 0.4
    )


def test_what_cannot_be_layered_is_refused_by_name():
    near = with_values(DESIGN, {"plates.placement": [[-2, 4, 45, 0.0], [2, 4, 45, 0.004]]})
    with pytest.raises(MeshError, match=r"end at z = -1\.5 and -1\.496 mm"):
        extrude(near, Zone(2.0), symmetric=False)
    with pytest.raises(MeshError, match="do not mirror"):
        extrude(with_values(DESIGN, {"plates.span_offset_mm": 0.5}), Zone(2.0))
    assert distinct(np.array([1.0, -1.0, 1.0 + 1e-13, 0.5])).tolist() == [-1.0, 0.5, 1.0]


def test_parts_over_one_another_are_refused_by_name():
    """Apart in space, but drawn into one section."""
    crossing = {"plates.span_mm": 2.0, "plates.placement": [[0, 4, 45, -1.5], [0, 4, -45, 1.5]]}
    assert not_layered(with_values(DESIGN, crossing)) == (
        "plates 0 and 1 lie over one another, seen along z"
    )
    core = {"body.core": CORE | {"depth_mm": 2.0}, "plates.span_mm": 1.5}
    beyond = with_values(DESIGN, core | {"plates.placement": [[0, 1.2, 0, 2.0], [0, 4, 0, -2.0]]})
    assert lies_over(beyond) == "plate 0 and the core lie over one another, seen along z"
