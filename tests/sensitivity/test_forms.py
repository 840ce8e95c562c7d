"""The stiffness' derivative against differences of assembled ones, on a swept and a tetrahedral
body and in plane strain."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from fingerdesign import load_design, with_values
from fingerdesign.fem.model import body_of, candidate_facets
from fingerdesign.fem.system import assemble_system
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.make import mesh_finger
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import in_tetrahedra
from fingerdesign.sensitivity.change import Change
from fingerdesign.sensitivity.forms import products

COARSE = {
    "mesh.mesher": "sweep",
    "mesh.layers": 3,
    "mesh.contact_size_mm": 1.5,
    "mesh.plate_size_mm": 2.0,
    "mesh.section.contact_size_mm": 1.0,
    "mesh.section.plate_size_mm": 2.0,
    "mesh.section.plate_end_size_mm": 1.0,
    "mesh.section.far_size_mm": 4.0,
    "plates.count": 2,
    "plates.pitch_mm": 2.5,
    "plates.thickness_mm": 0.2,
    "materials.phosphor_bronze.youngs_modulus_MPa": 50.0,
}


def mesh_of(kind):
    design = with_values(load_design("maeno2000"), COARSE)
    if kind == "plain":  # without pressures of its own
        design = with_values(design, {"materials.silicone.poissons_ratio": 0.3})
    if kind in ("section", "plain"):
        return design, mesh_section(design, 1.5)
    mesh = mesh_finger(design, Zone(1.5))
    return design, mesh if kind == "swept" else in_tetrahedra(mesh)


def energies_of(body, first, second):
    """w^T K u (r, k) of displacements (n dim, .) and pressures of the body as they are."""
    system = assemble_system(body)
    full = system.stiffness + sp.triu(system.stiffness, k=1).T
    free = [_unknowns(system, *each) for each in (first, second)]
    return free[0].T @ (full @ free[1])


def _unknowns(system, moved, pressure):
    if system.pressure_lift is None:
        return system.lift.T @ moved
    unit = system.pressure_lift.data[0]
    return system.lift.T @ moved + system.pressure_lift.T @ pressure / unit**2


@pytest.mark.parametrize(
    ("kind", "uneven"),
    [
        ("plain", False),
        ("section", False),
        ("swept", False),
        ("tetrahedra", True),
        pytest.param("swept", True, marks=pytest.mark.slow),
    ],
)
def test_products_are_differences_of_the_stiffness(kind, uneven):
    """Of places (in a swept body alike from layer to layer, or not) and of a modulus."""
    design, mesh = mesh_of(kind)
    body = body_of(design, mesh, candidate_facets(mesh, 1.5))
    system, chance = assemble_system(body), np.random.default_rng(1)
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    velocity = np.zeros_like(mesh.points)
    velocity[:, 0], velocity[:, 1] = np.sin(0.7 * x + 0.2 * y), 0.3 * x * y
    part = velocity * (x > 0.0)[:, None]
    if uneven:
        part[:, 2] = 0.1 * mesh.points[:, 2] ** 2
    rubber = mesh.regions == 0
    own, nu = np.where(rubber, 1.0, 0.0), body.poissons_ratio
    moduli = own * np.array([nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)])
    changes = [
        Change("all", velocity=sp.csr_matrix(velocity)),
        Change("some", velocity=sp.csr_matrix(part)),
        Change("rubber", moduli=moduli),
    ]
    bodies = [
        lambda t: replace(body, mesh=replace(mesh, points=mesh.points + t * velocity)),
        lambda t: replace(body, mesh=replace(mesh, points=mesh.points + t * part)),
        lambda t: replace(body, youngs_modulus=body.youngs_modulus + t * own),
    ]
    moved = chance.standard_normal((mesh.points.size, 3)) * ~body.fixed[:, None]
    pressure = chance.standard_normal((system.pressures, 3))
    fields = np.vstack([_unknowns(system, moved, pressure), np.zeros(3)])
    loads, pairs = chance.standard_normal((2, 1)), chance.standard_normal((2, 2, 4))
    found, between = products(body, system, changes, fields, loads, tuple(pairs))
    none = np.zeros((2, 0))
    empty = products(body, system, changes, fields, none, (none, none))
    assert [each.shape for each in empty] == [(3, 3, 0), (3, 0)]
    step, (left, right) = 1e-4, pairs
    for each, made in enumerate(bodies):
        low, high = (
            energies_of(made(side * step), (moved, pressure), (moved, pressure))
            for side in (-1.0, 1.0)
        )
        whole = (high - low) / (2.0 * step)
        most = 1e-6 * np.abs(whole).max()
        assert found[each] == pytest.approx(whole[:, :2] @ loads, abs=most)
        assert between[each] == pytest.approx(
            np.einsum("aj,ab,bj->j", left, whole[:2, :2], right), abs=10.0 * most
        )
