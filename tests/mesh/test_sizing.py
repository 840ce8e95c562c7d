"""The size field and the background grid that carries it."""

from __future__ import annotations

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.errors import MeshError
from fingerdesign.geometry.surface import ContactSurface
from fingerdesign.mesh.sizing import (
    GRID_POINTS,
    MeshSizes,
    SizeField,
    background_grid,
    distance_to_plate,
)
from fingerdesign.mesh.snap import tet_volumes


def field_of(keys: str) -> SizeField:
    design = parse_design(f'design.name = "t"\n{keys}')
    sizes = MeshSizes(contact=0.2, plate=0.3, far=2.0, gradation=0.5)
    frames = plate_frames(design)
    return SizeField(ContactSurface.of(design.body), frames, sizes, 3.0)


def test_sizes_at_the_contact_beside_the_zone_and_far_away() -> None:
    field = field_of("plates.count = 0")
    crest = field.surface.crest
    at = np.array([[0.0, crest], [0.0, crest - 1.0], [2.9, field.surface.height(2.9)], [0.0, 0.0]])
    np.testing.assert_allclose(field(at), [0.2, 0.7, 0.2, 2.0], rtol=1e-9)
    beside = np.array([[5.0, float(field.surface.height(5.0))]])
    np.testing.assert_allclose(field(beside), 0.2 + 0.5 * 2.0)


def test_the_field_grows_no_faster_than_its_gradation() -> None:
    field = field_of("plates.count = 5\nplates.span_mm = 6.0")
    rng = np.random.default_rng(1)
    first = rng.uniform([-10, 0, 0], [10, 12, 5], (4000, 3))
    second = first + rng.normal(0, 0.3, first.shape)
    growth = np.abs(field(first) - field(second)) / np.linalg.norm(first - second, axis=1)
    assert growth.max() <= 0.5 + 1e-9


def test_distance_to_a_plate_is_that_of_its_box() -> None:
    frame = PlateFrame(0, 0.0, 0.0, 90.0, 2.0, 0.2, -1.0, 1.0)
    points = np.array([[0.0, 0.9, 0.0], [0.4, 0.0, 0.0], [0.1, 1.3, 1.4], [0.0, 0.0, -3.0]])
    np.testing.assert_allclose(distance_to_plate(frame, points), [0.0, 0.3, 0.5, 2.0], atol=1e-12)


def test_the_background_grid_fills_its_box_with_positive_tetrahedra() -> None:
    field = field_of("plates.count = 1")
    low, high = np.array([-10.0, 0.0, 0.0]), np.array([10.0, 12.7, 5.0])
    points, tets, values = background_grid(field, low, high, (1.0, 0.5, 1.0))
    volumes = tet_volumes(points, tets.astype(np.int64))
    assert volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(np.prod(np.ptp(points, axis=0)))
    assert np.all(points.min(axis=0) < low)
    assert np.all(points.max(axis=0) > high)
    np.testing.assert_array_equal(values, field(points))


def test_the_background_grid_of_a_large_finger_stays_bounded() -> None:
    field = field_of("plates.count = 0")
    low, high = np.zeros(3), np.full(3, 500.0)
    points, _, _ = background_grid(field, low, high, (0.5, 0.2, 0.8))
    assert 0.5 * GRID_POINTS < len(points) < 1.5 * GRID_POINTS


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_sizes_must_be_positive(value: float) -> None:
    with pytest.raises(MeshError, match="plate"):
        MeshSizes(0.2, value, 2.0, 0.5)
