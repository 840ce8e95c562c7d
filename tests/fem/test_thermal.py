"""Thermal expansion against what is known of it: free bodies, a bimetal strip, a finger's gages."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.load import with_values
from fingerdesign.fem.body import condense_body
from fingerdesign.fem.model import build_model, expansions_of
from fingerdesign.fem.readout import gage_rows
from fingerdesign.fem.thermal import thermal_loads
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from tests.fem.test_condensation import DESIGN
from tests.support.boxes import block_mesh, body_of

ALPHA = 3e-4


def free_displacement(body, expansion):
    condensed = condense_body(body)
    nothing = np.zeros((1, len(condensed.trace.nodes), body.mesh.dimension))
    return condensed.displacement_fields(nothing, thermal_loads(body, expansion))[0]


@pytest.mark.parametrize("element", ["P1", "P2", "mixed"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_free_body_expands_without_stress(dim, element):
    """Held so that it can slide: u = alpha x, in plane strain (1 + nu) alpha x."""
    mesh = block_mesh((3, 2, 2)[:dim], (3.0, 2.0, 1.0)[:dim], 2.0)
    points, poisson = mesh.points, 0.45
    fixed = np.zeros(points.shape, dtype=bool)
    fixed[np.abs(points[:, 1]) < 1e-9, 1] = True
    left = np.abs(points[:, 0] + 1.5) < 1e-9
    fixed[left, 0] = True
    if dim == 3:
        fixed[np.abs(points[:, 2]) < 1e-9, 2] = True
    body = body_of(mesh, 5.0, poisson, fixed.ravel(), element=element)
    moved = free_displacement(body, np.full(len(mesh.cells), ALPHA))
    stretch = ALPHA * (1.0 + poisson) if dim == 2 else ALPHA
    assert np.allclose(moved, stretch * (points - [-1.5, 0.0, 0.0][:dim]), rtol=0, atol=1e-10)


def test_a_bimetal_strip_bends_as_timoshenko_says():
    """Two layers of one thickness in plane strain: curvature of J. Opt. Soc. Am. 11 (1925) 233."""
    long, thick, young, poisson = 20.0, 1.0, np.array([2.0, 5.0]), 0.3
    mesh = block_mesh((80, 4), (long, thick), thick)
    upper = mesh.points[mesh.corners].mean(axis=1)[:, 1] > 0.5 * thick
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    fixed[np.abs(mesh.points[:, 0] + 0.5 * long) < 1e-9] = True
    body = replace(
        body_of(mesh, 1.0, poisson, fixed.ravel()),
        youngs_modulus=np.where(upper, young[1], young[0]),
    )
    expansion = np.where(upper, 2.0 * ALPHA, ALPHA)
    moved = free_displacement(body, expansion)
    n = young[1] / young[0]  # (1 - nu^2) is the same in both
    curvature = 24.0 * (1.0 + poisson) * ALPHA / (thick * (14.0 + n + 1.0 / n))
    line = np.abs(mesh.points[:, 1]) < 1e-9
    x, bent = mesh.points[line, 0], moved[line, 1]
    inside = np.abs(x) < 0.3 * long  # away from the ends
    fit = np.polyfit(x[inside], bent[inside], 2)
    assert -2.0 * fit[0] == pytest.approx(curvature, rel=2e-3)


@pytest.mark.parametrize("element", ["P2", "mixed"])
@pytest.mark.parametrize("kind", ["section", pytest.param("half", marks=pytest.mark.slow)])
def test_a_warming_finger_is_condensed_with_what_it_does_untouched(kind, element):
    """Surface and gages as of the whole field; plates and rubber each by their own material; the
    same from kept answers and at another modulus."""
    values = {"grip.plant": "lift", "grip.warming_K": 10.0, "mesh.element": element}
    design = with_values(DESIGN, values | {"materials.silicone.expansion_per_K": 3e-4})
    mesh = mesh_section(design, 1.5) if kind == "section" else extrude(design, Zone(1.5))
    model = build_model(design, mesh, 1.5)
    expansion = expansions_of(design, mesh)
    assert set(expansion) == {3e-4, design.expansion_of("plates")}
    nothing = np.zeros((1, *model.reduced.points.shape))
    loads = thermal_loads(model.condensed.body, expansion)
    field = model.condensed.displacement_fields(nothing, loads)[0]
    surface = (model.condensed.trace.operator @ field.ravel()).reshape(nothing.shape[1:])
    assert model.reduced.load_displacement == pytest.approx(surface, abs=1e-12)
    rows = gage_rows(mesh, plate_frames(design), design.gages, design.gage_weights)
    read = rows @ (field - design.expansion_of("plates") * mesh.points).ravel()
    assert model.reduced.load_gage_strain.ravel() == pytest.approx(read, abs=1e-9 * abs(read).max())
    part = model.reduced.with_gages([2, 0])
    assert part.load_gage_strain.tolist() == model.reduced.load_gage_strain[[2, 0]].tolist()
    for values in ({}, {"materials.silicone.youngs_modulus_MPa": 5.0}):
        again = build_model(with_values(design, values), mesh, 1.5, store=True).reduced
        assert again.load_displacement == pytest.approx(surface, rel=0.02, abs=1e-7)
    assert build_model(DESIGN, mesh, 1.5).reduced.load_displacement is None
