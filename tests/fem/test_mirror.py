"""A whole finger condensed by halves: the answers of the whole, on what mirrors alone."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from fingerdesign.checks.load import with_values
from fingerdesign.fem.body import condense_body
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.mirror import MirroredCondensation, _folded, factored, mirror_of
from fingerdesign.fem.model import body_of
from fingerdesign.fem.readout import gage_rows
from fingerdesign.fem.system import assemble_system
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from tests.fem.test_condensation import DESIGN

MIXED = with_values(DESIGN, {"mesh.element": "mixed", "materials.silicone.poissons_ratio": 0.49})


def whole(design):
    """A design's whole body, and its gage rows."""
    mesh = extrude(design, Zone(1.5), symmetric=False)
    frames = plate_frames(design)
    return body_of(design, mesh, mesh.facets["contact"]), gage_rows(
        mesh, frames, design.gages, design.gage_weights
    )


def both(body, readout):
    """The system, its bordering rows, and factors by halves and of the whole."""
    system = assemble_system(body)
    contact = condense_body(body).trace.operator
    rows = sp.vstack([contact @ system.lift, readout @ system.lift, system.support]).tocsr()
    rows.sort_indices()
    halves = factored(system, rows, body.mesh.points)
    return system, rows, halves, Condensation(system.stiffness, rows, system.pressures)


@pytest.mark.parametrize(
    "values",
    [
        {"mesh.element": "P2"},
        {"gages.z_mm": 0.7, "gages.face": "upper"},  # a gage without a mirror image
        {"plates.model": "sheet", "plates.thickness_mm": 0.05},
        {"plates.material": "silicone", "plates.span_mm": 2.0},
    ],
    ids=["P2", "gages off the middle", "sheets", "short plates"],
)
def test_the_halves_of_a_finger_answer_as_the_whole(values):
    body, readout = whole(with_values(MIXED, values))
    system, rows, halves, whole_one = both(body, readout)
    assert isinstance(halves, MirroredCondensation)
    assert halves.operations < 0.6 * whole_one.operations
    largest = np.sqrt(np.outer(*2 * [np.maximum(np.diag(whole_one.matrix), 1e-300)]))
    assert (np.abs(halves.matrix - whole_one.matrix) <= 1e-9 * largest + 1e-13).all()
    load = np.random.default_rng(0).normal(size=(system.dofs, 2))
    expected = whole_one.solve(load)
    assert np.abs(halves.solve(load) - expected).max() < 1e-9 * np.abs(expected).max()
    some = np.array([3, 0, rows.shape[0] - 1, rows.shape[0] - 4])
    fields = whole_one.fields(some)
    assert np.abs(halves.fields(some) - fields).max() < 1e-9 * np.abs(fields).max()


def test_what_does_not_mirror_is_factored_whole():
    body, _ = whole(MIXED)
    assert mirror_of(assemble_system(body), body.mesh.points) is not None
    points = body.mesh.points.copy()
    inner = np.flatnonzero((points[:, 2] > 0.0) & (points[:, 1] > points[:, 1].min() + 0.1))[0]
    points[inner] += 1e-4
    moved = replace(body, mesh=replace(body.mesh, points=points))
    young = body.youngs_modulus * np.linspace(1.0, 1.01, len(body.youngs_modulus))
    # Soft rubber that differs beside plates so stiff that in the whole it does not show.
    soft = np.where(body.mesh.regions == 0, body.youngs_modulus, 1e9)
    back = body.mesh.points[body.mesh.corners][:, :, 2].mean(axis=1) < 0.0
    soft[(body.mesh.regions == 0) & back] *= 1.0 + 1e-6
    bodies = (moved, *(replace(body, youngs_modulus=each) for each in (young, soft)))
    for other in (*bodies, replace(body, element="P1")):
        system = assemble_system(other)
        assert mirror_of(system, other.mesh.points) is None
        found = factored(system, system.support.tocsr(), other.mesh.points)
        assert isinstance(found, Condensation)
    half = extrude(MIXED, Zone(1.5))
    system = assemble_system(body_of(MIXED, half, half.facets["contact"]))
    assert mirror_of(system, half.points) is None


def test_what_gains_nothing_or_has_one_kind_of_functionals_is_factored_whole():
    body, _ = whole(MIXED)
    system = assemble_system(body)
    odd = system.support.tocsr()[2:]
    assert isinstance(factored(system, odd, body.mesh.points), Condensation)
    body, _ = whole(with_values(MIXED, {"plates.model": "none", "mesh.layers": 1}))
    system = assemble_system(body)
    found = factored(system, system.support.tocsr(), body.mesh.points)
    assert isinstance(found, Condensation)


def test_orders_of_elimination_hold_stored_zeros():
    """The places of a half's matrix are those of its mesh's topology, whatever its numbers."""
    body, _ = whole(MIXED)
    system = assemble_system(body)
    zeros = replace(system, stiffness=system.stiffness.copy())
    zeros.stiffness.data[::7] = np.where(np.abs(zeros.stiffness.data[::7]) < 1e-3, 0.0, 1.0)
    mirror = mirror_of(system, body.mesh.points)
    for half in mirror.halves():
        one, two = (_folded(each.stiffness, half, half, upper=True) for each in (system, zeros))
        np.testing.assert_array_equal(one.indptr, two.indptr)
        np.testing.assert_array_equal(one.indices, two.indices)
