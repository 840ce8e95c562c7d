"""Sections that mirror in x have meshes that do, and mirror images the mirrored mesh; so have what
is swept from them, and the answers to mirrored scenes."""

import numpy as np
import pytest

from fingerdesign import analyse, parse_design, parse_scene, with_values
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.measures import aspects
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.mirror import half_of
from fingerdesign.mesh.section.plates import section_outline
from fingerdesign.mesh.section.section import mesh_section

DESIGN = parse_design(
    """
    design.name = "mirror"
    body.width_mm = 12.0
    body.base_height_mm = 5.0
    body.arc_radius_mm = 10.0
    body.depth_mm = 6.0
    plates.count = 3
    plates.pitch_mm = 2.5
    plates.length_mm = 2.0
    mesh.mesher = "sweep"
    mesh.layers = 2
    mesh.contact_size_mm = 0.8
    mesh.plate_size_mm = 0.8
    mesh.far_size_mm = 2.0
    [mesh.section]
    plate_size_mm = 0.4
    plate_end_size_mm = 0.1
    contact_size_mm = 0.2
    """
)
CORE = {"body.core": {"width_mm": 6.0, "height_mm": 1.0, "bottom_mm": 0.5}}
SHEETS = {"plates.model": "sheet"}
EVEN = {"plates.count": 4, "plates.alternate": True, "plates.angle_deg": 30.0}
OWN_IMAGES = {
    "bare": {"plates.count": 0},
    "core": {"plates.count": 0} | CORE,
    "level": {"plates.angle_deg": 0.0} | CORE,
    "upright": {"plates.angle_deg": 90.0},
    "bent": {"plates.angle_deg": 0.0, "plates.follow": "bent", "plates.pitch_mm": 3.2},
    "pairs": EVEN,
    "level sheets": {"plates.angle_deg": 0.0} | SHEETS,
    "upright sheets": {"plates.angle_deg": 90.0, "plates.count": 4} | SHEETS,
    "pairs of sheets that end inside": EVEN | SHEETS | {"plates.span_mm": 3.0},
}
TWO_IMAGES = {"solid": {}, "sheets": SHEETS, "turned": {"plates.follow": "turned"}}


def mirror_image(design):
    return with_values(design, {"plates.angle_deg": -design.plates.angle_deg})


def assert_mirrored(one, other):
    """The same elements of mirrored nodes; regions of plates are numbered the other way."""
    image = other.points.copy()
    image[:, 0] *= -1.0
    order, theirs = (np.lexsort(np.round(points, 7).T) for points in (one.points, image))
    np.testing.assert_allclose(one.points[order], image[theirs], atol=1e-12)
    number = np.empty(len(order), dtype=int)
    number[theirs] = order
    ours = np.unique(np.sort(one.corners, axis=1), axis=0)
    assert np.array_equal(ours, np.unique(np.sort(number[other.corners], axis=1), axis=0))


@pytest.mark.parametrize("name", OWN_IMAGES)
def test_what_mirrors_has_a_mesh_that_does(name):
    design = with_values(DESIGN, OWN_IMAGES[name])
    for mesh in (mesh_section(design, 2.0), extrude(design, Zone(2.0))):
        assert_mirrored(mesh, mesh)


@pytest.mark.parametrize("name", TWO_IMAGES)
def test_two_mirror_images_have_mirrored_meshes(name):
    one = with_values(DESIGN, TWO_IMAGES[name])
    other = mirror_image(one)
    assert_mirrored(mesh_section(one, 2.0), mesh_section(other, 2.0))
    assert_mirrored(extrude(one, Zone(2.0)), extrude(other, Zone(2.0)))


def test_a_half_is_closed_along_the_axis():
    design = with_values(DESIGN, OWN_IMAGES["core"])
    whole = section_outline(design, 2.0, design.mesh.section, ())
    half = half_of(whole)
    assert min(x for x, *_ in half.points) == 0.0
    assert half.domains == whole.domains
    lines = [[half.points[number][:2] for number in points] for points, *_ in half.curves]
    axis = [line for line in lines if all(x == 0.0 for x, _ in line)]
    heights = sorted((high, low) for (_, high), (_, low) in axis)
    assert [high for high, _ in heights[:-1]] == [low for _, low in heights[1:]]
    assert heights[0][1] == 0.0
    assert heights[-1][0] == crest_height(design.body)
    assert {0.5, 1.5} <= {high for high, _ in heights}


def test_the_axis_is_as_fine_as_what_is_around_it():
    """A contact 240 times finer than the far size: netgen would lay needles down to the axis."""
    text = """
    design.name = "deep"
    plates.count = 0
    body = { width_mm = 120, base_height_mm = 60, arc_radius_mm = 100, depth_mm = 1 }
    mesh.section = { contact_size_mm = 0.025, far_size_mm = 6 }
    """
    mesh = mesh_section(parse_design(text), 1.7)
    assert aspects(mesh.points, mesh.cells[:, :3]).max() < 5.0
    below = np.sort(mesh.points[mesh.points[:, 0] == 0.0, 1])[::-1]
    steps = -np.diff(below)
    assert steps[0] < 0.025
    assert steps.max() < 6.0
    assert (steps[1:] < 1.6 * steps[:-1]).all()


def answer(design, sign, fidelity):
    """Forces, stick ratios and gages from left to right under a scene or its mirror image."""
    rows = [[0.1, 0.01], [0.2, 0.05], [0.2, -0.02], [0.15, -0.08]]
    rows = [[deep, sign * along] for deep, along in rows]
    scene = parse_scene(f"object.tilt_deg = {3.0 * sign}\npath.increments_mm = {rows}")
    found = analyse(design, scene, fidelity).increments
    forces = np.array([[i.normal_force_N, sign * i.tangential_force_N] for i in found])
    membrane = np.array([[gage.membrane for gage in i.gages] for i in found])
    return forces, np.array([i.stick_ratio for i in found]), membrane[:, :: int(sign)]


@pytest.mark.parametrize(
    ("name", "fidelity"),
    [
        ("bare", "plane-strain"),
        ("level", "plane-strain"),
        ("upright", "plane-strain"),
        ("pairs", "plane-strain"),
        ("solid", "plane-strain"),
        *(
            pytest.param(name, "3d", marks=pytest.mark.slow)
            for name in ("sheets", "level sheets", "upright sheets", "upright", "solid")
        ),
    ],
)
def test_a_mirrored_scene_has_the_mirrored_answer(name, fidelity):
    """To what solvers leave (1e-9 of the force): the two systems are the same but for rounding."""
    one = with_values(DESIGN, (OWN_IMAGES | TWO_IMAGES)[name])
    other = one if name in OWN_IMAGES else mirror_image(one)
    (force, stick, gages), image = answer(one, 1.0, fidelity), answer(other, -1.0, fidelity)
    np.testing.assert_allclose(force, image[0], atol=1e-8 * np.abs(force).max())
    np.testing.assert_allclose(stick, image[1], atol=1e-8)
    np.testing.assert_allclose(gages, image[2], atol=1e-7 * np.abs(gages).max(initial=1e-9))
