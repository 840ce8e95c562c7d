"""The curve that a row along z follows."""

import numpy as np
import pytest

from fingerdesign import parse_design


@pytest.mark.parametrize("x", [0.0, 3.0, -6.0])
def test_a_dome_is_a_circle_in_each_plane_across_its_arc(x):
    """About the axis that the dome's outline turns about: smaller where the outline is lower."""
    keys = 'shape = "dome", arc_radius_mm = 20.0, dome_radius_mm = 25.0'
    body = parse_design(f'design.name = "a"\nplates.count = 0\nbody = {{{keys}}}').body
    radius, z = body.kind.row_radius(body, "z", x), np.array([0.0, 1.0, 3.0])
    heights = body.kind.height(body, np.full(3, x), z)
    assert heights[0] - heights == pytest.approx(radius - np.sqrt(radius**2 - z**2))
