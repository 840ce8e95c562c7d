"""The pressure along the middle of the contact, and its ripple."""

import numpy as np
import pytest
from fingerdesign_bench.accuracy.smoothness import WITHIN, along_middle, ripple

from fingerdesign import parse_design
from fingerdesign.fem.model import build_model
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude

DESIGN = parse_design(
    'design.name = "s"\nplates.count = 0\n[mesh]\ncontact_size_mm = 0.8\nlayers = 2\n'
)


def test_a_linear_traction_is_read_as_it_is_along_the_middle():
    model = build_model(DESIGN, extrude(DESIGN, Zone(2.0)), 2.0).reduced
    x = np.linspace(-1.2, 1.2, 7)
    given = 3.0 + 0.5 * model.points[:, 0] - 0.7 * model.points[:, 2]
    np.testing.assert_allclose(along_middle(model, x) @ given, 3.0 + 0.5 * x, atol=1e-12)


def test_ripple_is_peak_to_peak_where_the_contact_does_not_end():
    x = np.linspace(-1.0, 1.0, 401)
    fine = np.where(np.abs(x) < 0.5, 2.0, 0.0)
    waves = np.where(np.abs(x) < 0.5 * WITHIN, 0.1 * np.sin(40.0 * x), 5.0 * x)
    assert ripple(fine + waves, fine) == pytest.approx(0.1, rel=0.01)
