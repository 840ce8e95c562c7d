"""Distances of plates to each other, core and surface against those of points all over them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from fingerdesign.design.body import Body, Core
from fingerdesign.design.plates import Plates
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height, surface_height
from fingerdesign.layout.clearance import cover_clearances, least_dome_radius
from fingerdesign.layout.frames import Hole, PlateFrame
from fingerdesign.layout.gaps import core_gaps, least_gap
from fingerdesign.layout.rows import holes_of, plate_frames

QUICK = settings(max_examples=40, derandomize=True, deadline=None)
LONGER = settings(QUICK, max_examples=50)
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
    return float(KDTree(first).query(second)[0].min())


@QUICK
@given(PLACE, PLACE, ANGLE, st.none() | st.floats(1.0, 5.0), st.sampled_from(["x", "z"]))
def test_a_plates_own_coordinates_lead_back_to_the_point(place, y, angle, radius, along):
    """Along the arc of a bent plate, not along its chord; radians times radius from the centre."""
    frame = plate(0, place, y, angle, -1.0, 1.0, along, radius)
    s, v = np.meshgrid(np.linspace(-1.0, 1.0, 5), np.linspace(-0.15, 0.15, 3))
    points = frame.to_space(frame.from_local(s.ravel(), v.ravel()), 0.4)
    back = frame.local(points)
    np.testing.assert_allclose(back, np.column_stack([s.ravel(), v.ravel()]), atol=1e-12)
    np.testing.assert_allclose(frame.across(points), 0.4)
    middle = points.reshape(3, 5, 3)[1]  # points of the mid-surface, a quarter of it apart
    chord = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    arc = chord if radius is None else 2.0 * radius * np.arcsin(chord / (2.0 * radius))
    np.testing.assert_allclose(arc, 0.5, atol=1e-12)


@pytest.mark.parametrize("radius", [None, 1.5])
def test_a_plates_outline_goes_once_around_it_anticlockwise(radius):
    """Its area, positive, is length times thickness; a bent one in 256 chords."""
    x, y = plate(0, 0.3, -0.2, 30.0, -1.0, 1.0, bend=radius).outline(256).T
    area = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert area == pytest.approx(2.0 * 0.3, rel=1e-4)


@pytest.mark.parametrize("radius", [None, 1.5])
def test_a_plate_holds_the_points_of_its_metal_alone(radius):
    """2 mm long, 0.3 thick, from -1 to 3 across, a hole of 0.2 mm radius at (0.5, 1)."""
    frame = replace(plate(0, 0.3, -0.2, 30.0, -1.0, 3.0, bend=radius), holes=(Hole(0.5, 1.0, 0.2),))
    metal = [(0.0, 0.0, 1.0), (0.99, 0.14, 2.99), (-0.99, -0.14, -0.99), (0.71, 0.0, 1.0)]
    metal += [(0.5, 0.0, 0.79)]
    none = [(1.01, 0.0, 0.0), (-1.01, 0.0, 0.0), (0.0, 0.16, 0.0), (0.0, -0.16, 0.0)]
    none += [(0.0, 0.0, 3.01), (0.0, 0.0, -1.01), (0.69, 0.0, 1.0), (0.5, 0.14, 0.81)]
    s, v, w = np.array(metal + none).T
    held = frame.holds(frame.to_space(frame.from_local(s, v), w))
    assert held.tolist() == [True] * len(metal) + [False] * len(none)


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


@pytest.mark.parametrize(
    ("first", "second", "gap"),
    [
        # They miss each other across; one along z passes below one along x, or crosses it.
        (plate(0, 0.0, 0.0, 0.0, -3.0, -1.0), plate(1, 0.5, 0.0, 0.0, -0.6, 1.0), 0.4),
        (plate(0, 0.0, 1.0, 0.0, -2.0, 2.0), plate(1, 0.0, 0.0, 0.0, -2.0, 2.0, "z"), 0.7),
        (plate(0, 0.0, 1.0, 0.0, -2.0, 2.0), plate(1, 0.0, 0.9, 0.0, -2.0, 2.0, "z"), 0.0),
        # One of no place is in no pair.
        (plate(0, 0.0, 0.0, 0.0, -1.0, 1.0), plate(1, np.nan, np.nan, 0.0, -1.0, 1.0), None),
    ],
)
def test_known_gaps(first, second, gap):
    found = least_gap((first, second))
    assert found is None if gap is None else found.distance == pytest.approx(gap)


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


# Covers, and the layout that they rest on.


@LONGER
@given(st.floats(-6, 6), st.floats(9, 11), st.floats(-90, 90), st.floats(0.5, 6), st.booleans())
def test_cover_is_the_distance_to_the_surface(x, y, angle, half_span, dome):
    body = Body(shape="dome", dome_radius_mm=25.0, depth_mm=14.0) if dome else Body(depth_mm=14.0)
    tilted = plate(0, x, y, angle, -half_span, half_span)
    clearance = cover_clearances(body, (tilted,))[0]
    u = np.linspace(-10, 10, 401)
    w = np.linspace(-7, 7, 281)
    grid = np.meshgrid(u, w, indexing="ij")
    surface = np.stack([grid[0], surface_height(body, *grid), grid[1]], axis=-1).reshape(-1, 3)
    ends = [np.append(corner, half_span) for corner in tilted.corners()]
    below = all(end[1] < surface_height(body, end[0], end[2]) for end in ends)
    if below:
        sampled = min(np.linalg.norm(surface - end, axis=1).min() for end in ends)
        assert clearance <= sampled + 1e-9
        assert sampled - clearance < 0.03 or abs(x) > 4  # near the sides the arc is cut off
    else:
        assert clearance < 1e-9


@LONGER
@given(st.floats(0.5, 30), st.floats(0.5, 40), st.floats(1, 20))
def test_least_dome_radius_leaves_the_corners_that_high(base, depth, sagitta_scale):
    body = Body(base_height_mm=base, depth_mm=depth, arc_radius_mm=10.0 * sagitta_scale)
    least = least_dome_radius(body, 0.1)

    def corner(dome_radius):
        dome = body.model_copy(update={"shape": "dome", "dome_radius_mm": dome_radius})
        with np.errstate(invalid="ignore"):
            return float(surface_height(dome, 10.0, 0.5 * depth))

    assert corner(least * (1 + 1e-9)) >= 0.1 - 1e-6
    lower = corner(least * (1 - 1e-6))
    assert np.isnan(lower) or lower < 0.1 + 1e-6


def test_holes_lie_a_pitch_apart_about_the_middle_and_leave_a_diameter_at_the_ends():
    made = Plates(hole_diameter_mm=0.4, hole_pitch_mm=1.0)
    places = [hole.w for hole in holes_of(made, 0.3, 5.0)]
    assert places == pytest.approx([-1.2, -0.2, 0.8, 1.8])
    assert {hole.radius for hole in holes_of(made, 0.3, 5.0)} == {0.2}
    # The outermost may end a diameter before the span does, and not later.
    assert len(holes_of(made, 0.0, 4.2)) == 4
    assert len(holes_of(made, 0.0, 4.19)) == 2
    assert holes_of(Plates(), 0.3, 5.0) == ()


def test_a_row_across_a_dome_is_level_with_its_crest_wherever_its_span_lies():
    body = {"shape": "dome", "dome_radius_mm": 20.0}
    rows = [
        plate_frames(Design(design={"name": "a"}, body=body, plates={"span_mm": 2.0, **more}))
        for more in ({}, {"span_offset_mm": 1.5, "stagger_mm": 0.5})
    ]
    for frame, shifted in zip(*rows, strict=True):
        crest = float(surface_height(Body(**body), frame.x, 0.0))
        assert frame.y == shifted.y == pytest.approx(crest - 2.0, abs=1e-12)


def test_frames_follow_the_surface_and_mirror():
    design = Design.model_validate({"design": {"name": "a"}})
    frames = plate_frames(design)
    assert len(frames) == 15
    xs = np.array([plate.x for plate in frames])
    ys = np.array([plate.y for plate in frames])
    assert np.allclose(xs, -xs[::-1])
    assert np.allclose(ys, ys[::-1])
    assert np.allclose(ys, surface_height(design.body, xs) - 2.0)
    assert np.isclose(ys[7], crest_height(design.body) - 2.0)
    assert (frames[0].low, frames[0].high) == (-5.0, 5.0)
    assert np.allclose(frames[3].normal, [-np.sqrt(0.5), np.sqrt(0.5)])
