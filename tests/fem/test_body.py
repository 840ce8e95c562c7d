"""Bodies of any origin: loads of their own, what is no body, zones in x and z."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp

from fingerdesign import parse_design
from fingerdesign.errors import SolverError
from fingerdesign.fem.body import condense_body
from fingerdesign.fem.model import build_model, free_ends
from fingerdesign.fem.reduction import body_model
from fingerdesign.layout.surface import ContactSurface
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import boundary_facets
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from tests.support.boxes import block

SHAPES = {2: ((6, 4), (3.0, 2.0)), 3: ((4, 3, 2), (3.0, 2.0, 1.0))}


@pytest.mark.parametrize("dim", [2, 3])
def test_a_readout_of_loads_is_the_displacement_under_them(dim):
    body = block(*SHAPES[dim], SHAPES[dim][1][1])
    loads = np.random.default_rng(0).normal(size=(body.fixed.size, 1))
    condensed = condense_body(body, [sp.csr_matrix(loads.T)])
    none = np.zeros((1, len(condensed.trace.nodes), dim))
    wanted = condensed.trace.operator @ condensed.displacement_fields(none, loads)[0].ravel()
    assert np.abs(condensed.readouts[0][0] - wanted).max() < 1e-11 * np.abs(wanted).max()


@pytest.mark.parametrize("dim", [2, 3])
def test_contact_facets_that_are_none_are_refused(dim):
    body = block(*SHAPES[dim], SHAPES[dim][1][1])
    mesh, own = body.mesh, body.contact
    first = [0, 1, 3] if dim == 2 else [0, 1, 2, 4, 5, 6]
    inside = mesh.cells[:, first]
    inside = inside[~np.isin(inside[:, -1], boundary_facets(mesh.cells))]
    for contact, words in (
        (own[:, :dim], "mid-edge nodes"),
        (own + 10**6, "name nodes"),
        (own - 10**6, "name nodes"),
        (own[:, ::-1], "no face of a cell"),
        (own[:0], "no contact facet"),
        (inside[:1], "inside the body"),
        (np.vstack([own, own[:1]]), "more than once"),
        (own[:, [0, 1, 2, 4, 3, 5][: len(own[0])]], "between its corners"),
    ):
        if dim == 3 or "between" not in words:
            with pytest.raises(SolverError, match=words):
                condense_body(replace(body, contact=contact))


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_held_too_little_or_too_much_is_refused(dim):
    counts, size = SHAPES[dim]
    body = block(counts, size, size[1])
    with pytest.raises(SolverError, match="fixed has the shape"):
        condense_body(replace(body, fixed=body.fixed[:-1]))
    one = np.arange(len(body.fixed)) < dim
    along_x = body.fixed & (np.arange(len(body.fixed)) % dim == 0)
    contact = np.zeros(body.mesh.points.shape, dtype=bool)
    contact[np.unique(body.contact)] = True
    for fixed, words in (
        (np.zeros_like(one), "not fixed|move as a whole"),
        (one, "not fixed|move as a whole"),
        (along_x, "not fixed|move as a whole"),
        (np.ones_like(one), "every displacement of the body is fixed"),
        (contact.ravel(), "every contact node is fixed"),
    ):
        with pytest.raises(SolverError, match=words):
            body_model(replace(body, fixed=fixed))


@pytest.mark.parametrize("element", ["P1", "P2", "mixed"])
def test_unsound_materials_are_refused_by_name(element):
    body = block((2, 2), (1.0, 1.0), 1.0, element=element)
    one = np.ones(len(body.mesh.cells))
    for value in (0.5, 0.6, -1.0, np.nan):
        with pytest.raises(SolverError, match="Poisson's ratio"):
            condense_body(replace(body, poissons_ratio=value * one))
    for value in (0.0, -5.0, np.inf, np.nan):
        with pytest.raises(SolverError, match="Young's modulus"):
            condense_body(replace(body, youngs_modulus=value * one))
        with pytest.raises(SolverError, match="thickness"):
            condense_body(replace(body, thickness=value))
    points = np.where(body.mesh.points == 1.0, np.nan, body.mesh.points)
    with pytest.raises(SolverError, match="NaN"):
        condense_body(replace(body, mesh=replace(body.mesh, points=points)))
    with pytest.raises(SolverError, match="one for each"):
        condense_body(replace(body, youngs_modulus=one[1:]))
    if element == "P2":
        loose = replace(body.mesh, points=np.vstack([body.mesh.points, [[9.0, 9.0]]]))
        fixed = np.append(body.fixed, [False, False])
        with pytest.raises(SolverError, match="belong to no cell"):
            condense_body(replace(body, mesh=loose, fixed=fixed))


SMALL = """
design.name = "small"
body.width_mm = 8.0
body.base_height_mm = 3.0
body.arc_radius_mm = 8.0
body.depth_mm = 6.0
plates.count = 0
[mesh]
contact_size_mm = 0.4
far_size_mm = 1.2
layers = 5
[mesh.section]
contact_size_mm = 0.2
far_size_mm = 0.8
"""


def test_a_zone_limited_in_z_ends_in_a_rim():
    design = parse_design(SMALL)
    mesh = extrude(design, Zone(1.5))
    whole = build_model(design, mesh, 1.5).reduced
    short = build_model(design, mesh, 1.5, zone_half_depth=2.0).reduced
    assert short.points[:, 2].max() <= 2.0 + 1e-9 < whole.points[:, 2].max()
    far = short.points[:, 2] > short.points[:, 2].max() - 1e-9
    assert short.rim[far].all()
    inner = (np.abs(short.points[:, 0]) < 0.5) & ~far
    assert inner.any()
    assert not short.rim[inner].any()


def test_gaps_are_measured_from_the_exact_surface():
    design = parse_design(SMALL)
    surface = ContactSurface.of(design.body)
    for mesh in (mesh_section(design, 1.5), extrude(design, Zone(1.5))):
        points = build_model(design, mesh, 1.5).reduced.surface.points
        assert np.abs(surface.distance(points)).max() < 1e-12


def test_fields_of_forces_and_loads_of_a_bodys_own_add_up(own_cache):
    body = block(*SHAPES[2], SHAPES[2][1][1])
    loads = np.random.default_rng(0).normal(size=(body.fixed.size, 1))
    for _ in "ab":  # the second time with stored fields
        condensed = condense_body(body, store=True)
        forces = np.ones((1, len(condensed.trace.nodes), 2))
        given = ((forces, 0.0), (0.0 * forces, loads), (forces, loads))
        alone, own, both = (condensed.displacement_fields(*each) for each in given)
        assert both == pytest.approx(alone + own, abs=1e-9 * np.abs(own).max())


def test_a_step_bodys_free_ends_are_where_its_ends_meet_the_contact():
    """Nodes 0 and 1 are of the contact alone, those of z = 9 of an end alone."""
    body = SimpleNamespace(kind=SimpleNamespace(turned=False), depth_mm=30.0, shape="step")
    both, inf = (-2.5, 3.5), np.inf
    known = {(-3.0, 4.0): both, (4.0,): (-inf, 3.5), (-3.0,): (-2.5, inf), (): None}
    for ends, between in known.items():
        points = np.array([[0.0, 0.0, z] for z in (1.0, 2.0, 9.0, 9.0, *ends)])
        shared = range(4, len(points))
        facets = {"end": np.array([2, 3, *shared]), "contact": np.array([0, 1, *shared])}
        mesh = SimpleNamespace(dimension=3, points=points, facets=facets)
        assert free_ends(body, mesh) == between
    body.shape = "arc"
    assert free_ends(body, mesh) == (-14.5, 14.5)
