"""The size field and the background grid that carries it."""

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.errors import MeshError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.surface import ContactSurface
from fingerdesign.layout.volume import outline_volume
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.counting import elements_within, expected_elements
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.plates import extruded_sizes, section_sizes
from fingerdesign.mesh.sizing import END_GRADATION, LEAST_CONTACT_SIZE, MeshSizes, SizeField
from fingerdesign.mesh.tetra.background import GRID_POINTS, background_grid


def field_of(keys, stretch=1.0):
    design = parse_design(f'design.name = "t"\n{keys}')
    sizes = MeshSizes(contact=0.2, plate=0.3, far=2.0, gradation=0.5, stretch=stretch)
    frames = plate_frames(design)
    return SizeField(ContactSurface.of(design.body), frames, sizes, Zone(3.0))


def test_sizes_at_the_contact_beside_the_zone_and_far_away():
    field = field_of("plates.count = 0")
    crest = field.surface.crest
    at = np.array([[0.0, crest], [0.0, crest - 1.0], [2.9, field.surface.height(2.9)], [0.0, 0.0]])
    np.testing.assert_allclose(field(at), [0.2, 0.7, 0.2, 2.0], rtol=1e-9)
    beside = np.array([[5.0, float(field.surface.height(5.0))]])
    np.testing.assert_allclose(field(beside), 0.2 + 0.5 * 2.0)
    stretched = field_of("plates.count = 0", stretch=4.0)
    np.testing.assert_allclose(stretched(at[:1]), 0.1)  # across 0.1, along z 0.4: 0.2 on the mean
    # The circle continued below a half circle is no contact.
    round_top = field_of("plates.count = 0\nbody.arc_radius_mm = 10.0")
    np.testing.assert_allclose(round_top(np.array([[0.0, 0.0], [0.0, 20.0]])), [2.0, 0.2])
    for value in (0.0, -1.0, float("nan")):
        with pytest.raises(MeshError, match="plate"):
            MeshSizes(0.2, value, 2.0, 0.5)


@pytest.mark.parametrize(
    ("keys", "zone", "contact", "stretch"),
    [
        ("plates.count = 0", Zone(1.5), 0.3, 2.0),
        ("plates.count = 0", Zone(4.0, 1.0), 0.2, 1.4),
        ("plates.count = 0", Zone(0.1), 0.132, 2.0),
        ('body.shape = "dome"\nbody.dome_radius_mm = 15\nplates.count = 0', Zone(4.0), 0.4, 1.4),
        ('body.shape = "revolved"\nplates.count = 0', Zone(4.0, 4.0), 0.4, 1.0),
        ("plates.count = 3\nplates.rows = [{along = 'z', cover_mm = 6}]", Zone(4.0), 0.4, 1.0),
    ],
)
def test_sizes_of_a_design_follow_its_contact_and_its_slow_direction(keys, zone, contact, stretch):
    sizes = MeshSizes.of(parse_design(f'design.name = "t"\n{keys}'), zone)
    assert (sizes.contact, sizes.stretch) == (pytest.approx(contact), stretch)


def test_sizes_at_a_plate_and_at_its_ends():
    field = field_of("plates.count = 1\nplates.cover_mm = 5.0\nplates.length_mm = 4.0")
    (frame,) = field.frames
    centre, end = np.array([frame.x, frame.y]), 2.0 * frame.axis
    sizes = field(np.array([centre, centre + end, centre - end, centre + end + 0.1 * frame.axis]))
    np.testing.assert_allclose(sizes, [0.3, 0.05, 0.05, 0.05 + 0.1 * END_GRADATION], rtol=1e-9)


def test_the_field_grows_no_faster_than_its_gradation():
    field = field_of("plates.count = 5\nplates.span_mm = 6.0")
    rng = np.random.default_rng(1)
    first = rng.uniform([-10, 0, 0], [10, 12, 5], (4000, 3))
    second = first + rng.normal(0, 0.3, first.shape)
    growth = np.abs(field(first) - field(second)) / np.linalg.norm(first - second, axis=1)
    assert growth.max() <= END_GRADATION + 1e-9


@pytest.mark.parametrize(
    "keys",
    [
        "plates.count = 0",
        "plates.count = 15",
        "plates.count = 2\nplates.span_mm = 6.0",
        'body.shape = "dome"\nbody.dome_radius_mm = 15.0\nplates.count = 3',
    ],
)
def test_the_background_grid_fills_its_box_and_carries_the_field(keys):
    field = field_of(keys)
    low, high = np.array([-10.0, 0.0, 0.0]), np.array([10.0, field.surface.crest, 5.0])
    points, tets, values = background_grid(field, low, high)
    volumes = cell_volumes(points, tets.astype(np.int64))
    assert volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(np.prod(np.ptp(points, axis=0)))
    assert np.all(points.min(axis=0) < low)
    assert np.all(points.max(axis=0) > high)
    assert len(points) <= GRID_POINTS
    np.testing.assert_array_equal(values, field(points))
    if keys == "plates.count = 15":
        assert len(background_grid(field, np.zeros(3), np.full(3, 500.0))[0]) <= GRID_POINTS
    # Near the crest, where it is finest, linear interpolation blurs the field by little.
    near = np.abs(points[tets].mean(axis=1) - [0.0, field.surface.crest, 0.0]).max(axis=1) < 0.3
    blurred = values[tets[near]].mean(axis=1)
    assert np.all(blurred < 1.35 * field(points[tets[near]].mean(axis=1)))


def test_the_expected_elements_of_an_even_field_fill_the_body():
    design = parse_design('design.name = "t"\nplates.count = 0')
    low, high = np.array([-10.0, 0.0, 0.0]), np.array([10.0, 12.7, 5.0])
    for stretch in (1.0, 3.0):
        sizes = MeshSizes(
            contact=1.0 * np.sqrt(stretch), plate=1.0, far=1.0, gradation=0.5, stretch=stretch
        )
        field = SizeField(ContactSurface.of(design.body), (), sizes, Zone(3.0))
        wanted = outline_volume(design.body, half=True) * 6.0 * np.sqrt(2.0) / stretch
        assert expected_elements(field, low, high) == pytest.approx(wanted, rel=0.05)


@pytest.mark.parametrize(("deepest", "many"), [(12, 10_000), (12, 20), (0, 10_000)])
def test_elements_of_an_even_size_are_area_over_theirs_also_where_some_cells_stand_for_all(
    deepest, many
):
    """Squares of 0.1 in a rectangle of 2 by 1, of which a quarter counts."""
    found = elements_within(
        lambda cells: np.full(len(cells), 0.1),
        (np.array([-1.0, 2.0]), np.array([1.0, 3.0])),
        np.array([2, 1]),
        lambda cells, edges: np.full(len(cells), 0.25),
        lambda size: size**2,
        (1.0, deepest, many),
    )
    assert found == pytest.approx(0.25 * 2.0 / 0.1**2)


def test_sections_too_are_as_fine_as_a_small_contact_needs():
    keys = "[mesh]\ncontact_size_mm = 0.4\n[mesh.section]\ncontact_size_mm = 0.4"
    design = parse_design(f'design.name = "t"\n{keys}')
    assert section_sizes(design, 1.0).contact_size_mm == pytest.approx(0.2)
    assert section_sizes(design, 0.3).contact_size_mm == pytest.approx(LEAST_CONTACT_SIZE * 0.4)
    assert section_sizes(design, 4.0) == design.mesh.section
    assert extruded_sizes(design, 1.0).contact_size_mm == MeshSizes.of(design, Zone(1.0)).contact
    assert extruded_sizes(design, 4.0).contact_size_mm == 0.4


def test_facets_are_finest_where_the_path_reaches():
    """Swept: 0.3 of what is said over the path's zone, the said size beyond; fTetWild: 0.8
    and 1.2 of it."""
    design = parse_design('design.name = "t"\nplates.count = 0\n[mesh]\nlayers = 2\n')
    zone = Zone(6.0, inner=2.5)
    mesh = extrude(design, zone)
    corners = mesh.points[mesh.facets["contact"][:, :3]]
    across, middle = np.ptp(corners[..., 0], axis=1), np.abs(corners[..., 0]).mean(axis=1)
    said = design.mesh.contact_size_mm
    assert across[middle < 2.3].mean() == pytest.approx(0.3 * said, rel=0.1)
    assert across[(middle > 3.5) & (middle < 5.5)].mean() == pytest.approx(said, rel=0.2)
    field = SizeField(ContactSurface.of(design.body), (), MeshSizes.of(design, zone), zone)
    x = np.array([0.0, 2.4, 4.0, 5.9])
    top = np.column_stack([x, field.surface.height(x, 0.0 * x)])
    assert field(top) * np.sqrt(2.0) / said == pytest.approx([0.8, 0.8, 1.2, 1.2], rel=1e-3)
