"""A mesh whose plates lie a little elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.load import load_design
from fingerdesign.fem.stiffness import STRAIGHT
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.measures import curved_cells
from fingerdesign.mesh.moved import with_plates_moved
from fingerdesign.mesh.section.extrude import extrude

DESIGN = load_design("sensitive")
MESH = extrude(DESIGN, Zone(1.5))


def moved(angle=0.0, y=0.0):
    frames = plate_frames(DESIGN)
    own = frames[3]
    after = replace(own, angle_deg=own.angle_deg + angle, y=own.y + y)
    return with_plates_moved(MESH, frames, (*frames[:3], after, *frames[4:]))


def test_a_moved_plate_is_rigid_and_its_rubber_follows_in_straight_cells():
    """Straight cells are integrated faster, and derivatives move them so."""
    mesh = moved(angle=1.0, y=0.05)
    assert mesh.moved
    assert not MESH.moved
    curved = [curved_cells(each.points, each.cells, STRAIGHT) for each in (MESH, mesh)]
    assert np.array_equal(*curved)
    still = np.unique(np.concatenate([mesh.facets[name].ravel() for name in ("base", "contact")]))
    assert np.array_equal(mesh.points[still], MESH.points[still])
    plate = np.unique(MESH.cells[MESH.regions == 4])
    apart = [each.points[plate] - each.points[plate[0]] for each in (MESH, mesh)]
    assert np.linalg.norm(apart[1], axis=1) == pytest.approx(np.linalg.norm(apart[0], axis=1))
    before = plate_frames(DESIGN)[3]
    after = replace(before, angle_deg=before.angle_deg + 1.0, y=before.y + 0.05)
    np.testing.assert_allclose(
        after.local(mesh.points[plate]), before.local(MESH.points[plate]), atol=1e-12
    )
    others = np.unique(MESH.cells[(MESH.regions > 0) & (MESH.regions != 4)])
    assert np.array_equal(mesh.points[others], MESH.points[others])


def test_a_plate_moved_beyond_its_rubber_is_none():
    assert moved(y=2.0) is None
