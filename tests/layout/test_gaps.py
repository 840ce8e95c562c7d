"""Distances between plates in space against the distances of points all over them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fingerdesign.design.body import Core
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import core_gaps, least_gap, neighbour_gaps

QUICK = settings(max_examples=40, derandomize=True, deadline=None)
PLACE = st.floats(-2.0, 2.0)
ANGLE = st.floats(-180.0, 180.0)


def plate(index, place, y, angle, low, high, along="x", bend=None):
    return PlateFrame(index, place, y, angle, 2.0, 0.3, low, high, along, bend)


def filled(frame, count=25):
    """Points all over a plate, in space."""
    s, v, w = np.meshgrid(
        np.linspace(-0.5, 0.5, count) * frame.length,
        np.linspace(-0.5, 0.5, 5) * frame.thickness,
        np.linspace(frame.low, frame.high, count),
    )
    plane = frame.from_local(s.ravel(), v.ravel())
    return frame.to_space(plane, w.ravel())


def sampled(first, second):
    from scipy.spatial import KDTree

    return float(KDTree(first).query(second)[0].min())


@QUICK
@given(PLACE, PLACE, ANGLE, ANGLE, st.floats(-2, 2), st.sampled_from(["x", "z"]))
def test_gap_is_that_of_the_plates_points(place, y, one, two, low, along):
    first = plate(0, 0.0, 0.0, one, -1.0, 1.0)
    second = plate(1, place, y, two, low, low + 1.5, along)
    gap = least_gap((first, second))
    brute = sampled(filled(first), filled(second))
    assert gap.distance <= brute + 1e-9
    assert brute - gap.distance < 0.09  # the sampling's spacing
    assert least_gap((second,), (first,)).distance == pytest.approx(gap.distance, abs=1e-12)


@QUICK
@given(PLACE, st.floats(0.5, 3.0), ANGLE, st.floats(1.0, 5.0), st.sampled_from(["x", "z"]))
def test_bent_plates_gap_is_that_of_their_points(place, y, angle, radius, along):
    first = plate(0, 0.0, 0.0, 0.0, -1.0, 1.0, bend=radius)
    second = plate(1, place, y, angle, -0.5, 0.5, along)
    gap = least_gap((first, second)).distance
    brute = sampled(filled(first), filled(second))
    assert abs(brute - gap) < 0.09
    assert gap <= brute + 2e-3  # chords of a bent plate


def test_plates_that_miss_each_other_across_are_apart():
    first, second = plate(0, 0.0, 0.0, 0.0, -3.0, -1.0), plate(1, 0.5, 0.0, 0.0, -0.6, 1.0)
    assert least_gap((first, second)).distance == pytest.approx(0.4)


def test_a_plate_along_z_passes_below_one_along_x():
    above, below = plate(0, 0.0, 1.0, 0.0, -2.0, 2.0), plate(1, 0.0, 0.0, 0.0, -2.0, 2.0, "z")
    assert least_gap((above, below)).distance == pytest.approx(1.0 - 0.3)
    crossing = plate(1, 0.0, 0.9, 0.0, -2.0, 2.0, "z")
    assert least_gap((above, crossing)).distance == 0.0


def test_neighbours_are_reported_one_by_one():
    frames = tuple(plate(k, x, 0.0, 90.0, -1.0, 1.0) for k, x in enumerate((0.0, 1.0, 1.9, 3.0)))
    assert np.allclose(neighbour_gaps(frames), [0.7, 0.6, 0.8])
    bent = tuple(plate(k, 3.0 * k, 0.0, 0.0, -1.0, 1.0, bend=50.0) for k in range(3))
    assert np.allclose(neighbour_gaps(bent), 1.0, atol=0.01)


def test_a_plate_of_no_place_is_in_no_pair():
    lost = plate(1, np.nan, np.nan, 0.0, -1.0, 1.0)
    assert least_gap((plate(0, 0.0, 0.0, 0.0, -1.0, 1.0), lost)) is None


@pytest.mark.parametrize("along", ["x", "z"])
@QUICK
@given(PLACE, st.floats(-1.0, 3.0), ANGLE, st.floats(-3.0, 2.0))
def test_gap_to_the_core_is_that_of_their_points(along, place, y, angle, low):
    core = Core(width_mm=2.0, height_mm=1.0, bottom_mm=0.0)
    frame = plate(0, place, y, angle, low, low + 1.0, along)
    gap = core_gaps(core, 3.0, (frame,))[0]
    x, h, z = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(0, 1, 11), np.linspace(-1.5, 1.5, 31))
    brute = sampled(np.column_stack([x.ravel(), h.ravel(), z.ravel()]), filled(frame))
    assert gap <= brute + 1e-9
    assert brute - gap < 0.1
