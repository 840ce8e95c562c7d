"""Closed-form distances against brute force, and the layout that they rest on."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fingerdesign.design.schema import Body, Design
from fingerdesign.layout.clearance import cover_clearances, least_dome_radius
from fingerdesign.layout.frames import PlateFrame, crest_height, plate_frames, surface_height

QUICK = settings(max_examples=50, derandomize=True, deadline=None)


def frame(x, y, angle, length=2.0, thickness=0.3):
    return PlateFrame(0, x, y, angle, length, thickness, -1.0, 1.0)


@QUICK
@given(st.floats(-6, 6), st.floats(9, 11), st.floats(-90, 90), st.floats(0.5, 6), st.booleans())
def test_cover_is_the_distance_to_the_surface(x, y, angle, half_span, dome):
    body = Body(shape="dome", dome_radius_mm=25.0, depth_mm=14.0) if dome else Body(depth_mm=14.0)
    plate = replace(frame(x, y, angle), low=-half_span, high=half_span)
    clearance = cover_clearances(body, (plate,))[0]
    u = np.linspace(-10, 10, 401)
    w = np.linspace(-7, 7, 281)
    grid = np.meshgrid(u, w, indexing="ij")
    surface = np.stack([grid[0], surface_height(body, *grid), grid[1]], axis=-1).reshape(-1, 3)
    ends = [np.append(corner, half_span) for corner in plate.corners()]
    below = all(end[1] < surface_height(body, end[0], end[2]) for end in ends)
    if below:
        sampled = min(np.linalg.norm(surface - end, axis=1).min() for end in ends)
        assert clearance <= sampled + 1e-9
        assert sampled - clearance < 0.03 or abs(x) > 4  # near the sides the arc is cut off
    else:
        assert clearance < 1e-9


@QUICK
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
