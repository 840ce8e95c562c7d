"""Bodies of any origin: loads of their own, two bodies facing each other, zones in x and z."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.errors import SolverError
from fingerdesign.fem.body import body_model, condense_body
from fingerdesign.fem.elements import EDGES
from fingerdesign.fem.facing import facing_compliance
from fingerdesign.fem.model import build_model
from fingerdesign.layout.surface import ContactSurface
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from tests.support.boxes import block


def raised(body, height):
    mesh = body.mesh
    points = mesh.points + height * np.eye(mesh.dimension)[1]
    return replace(body, mesh=replace(mesh, points=points))


WIDE = ((4, 3, 2), (3.0, 2.0, 1.0))
SHAPES = {2: ((6, 4), (3.0, 2.0)), 3: ((4, 3, 2), (3.0, 2.0, 1.0))}


@pytest.mark.parametrize("dim", [2, 3])
def test_loads_are_those_of_a_full_solve(dim):
    counts, size = SHAPES[dim]
    plain = block(counts, size, size[1])
    loads = np.random.default_rng(0).normal(size=plain.fixed.shape)
    condensed = condense_body(block(counts, size, size[1], loads=loads))
    none = np.zeros((1, len(condensed.trace.nodes), dim))
    field = condensed.displacement_fields(none, load=1.0)[0]
    wanted = condensed.trace.operator @ field.ravel()
    assert np.abs(condensed.load_displacement - wanted).max() < 1e-11 * np.abs(wanted).max()
    total = loads.reshape(-1, dim).sum(axis=0)
    assert np.allclose(condensed.load_reaction, -total, rtol=0, atol=1e-9)
    assert body_model(plain).load_displacement is None


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_facing_its_mirror_image(dim):
    """On the same contact mesh the object's compliance is that of the body itself, mirrored."""
    counts, size = SHAPES[dim]
    lower, upper = block(counts, size, size[1]), block(counts, size, 0.0)
    finger = body_model(lower)
    upper = raised(upper, size[1] + 0.3)
    got, own = facing_compliance(upper, finger), body_model(upper)
    order = [
        int(np.flatnonzero(np.abs(own.points[:, ::2] - p[::2]).max(axis=1) < 1e-9)[0])
        for p in finger.points
    ]
    pick = (np.array(order)[:, None] * dim + np.arange(dim)).ravel()
    wanted = own.compliance[np.ix_(pick, pick)]
    assert np.abs(got - wanted).max() < 1e-10 * np.abs(wanted).max()


def test_uniform_pressure_between_meshes_that_do_not_match():
    """At nu = 0 both shorten uniformly, but for quadrature over the other mesh's kinks."""
    finger = body_model(block((6, 4), (3.0, 2.0), 2.0, poisson=0.0))
    upper = raised(block((7, 3), (3.0, 2.0), 0.0, poisson=0.0), 2.0)
    compliance = facing_compliance(upper, finger)
    force = np.zeros(finger.points.shape)
    force[:, 1] = -0.1 * finger.areas
    moved = (compliance @ force.ravel()).reshape(force.shape)
    assert np.allclose(moved[:, 1], -0.1 * 2.0 / 5.0, rtol=1e-3)


def test_a_zone_wider_than_the_object_is_refused():
    finger = body_model(block((6, 4), (3.0, 2.0), 2.0))
    with pytest.raises(SolverError, match="face no contact facet"):
        facing_compliance(raised(block((4, 4), (2.0, 2.0), 0.0), 2.0), finger)


@pytest.mark.parametrize("dim", [2, 3])
def test_an_object_that_does_not_face_the_finger_is_refused(dim):
    counts, size = SHAPES[dim]
    finger, upper = body_model(block(counts, size, size[1])), block(counts, size, 0.0)
    facing_compliance(raised(upper, 0.6 * size[1]), finger)  # overlapping is no fault
    above = raised(upper, size[1])
    away = replace(above, contact=above.mesh.facets["base"], fixed=np.roll(above.fixed, dim))
    whole = replace(above, contact=np.vstack([above.contact, away.contact]))
    for made, words in (
        (raised(upper, -50.0), "behind the finger"),
        (upper, "behind the finger"),
        (away, "look away"),
        (whole, "look away"),
        (replace(above, contact=above.contact[:, :dim]), "mid-edge nodes"),
        (replace(above, contact=above.contact + 10**6), "name nodes"),
        (replace(above, contact=above.contact - 10**6), "name nodes"),
        (replace(above, contact=above.contact[:, ::-1]), "no face of a cell"),
        (replace(above, contact=above.contact[:0]), "no contact facet"),
        (replace(above, contact=above.mesh.cells[:3, : above.contact.shape[1]]), "contact facets"),
        (raised(block(*(part[: 5 - dim] for part in WIDE), 0.0), size[1]), "dimensions"),
    ):
        with pytest.raises(SolverError, match=words):
            facing_compliance(made, finger)
    if dim == 3:
        turned = above.contact[:, [0, 1, 2, 4, 3, 5]]
        with pytest.raises(SolverError, match="between its corners"):
            facing_compliance(replace(above, contact=turned), finger)


def test_facets_inside_a_body_are_refused():
    body = block((2, 2), (1.0, 1.0), 1.0)
    mesh = body.mesh
    edges = np.concatenate([mesh.cells[:, [a, b, 3 + k]] for k, (a, b) in enumerate(EDGES[2])])
    first = np.unique(edges[:, 2], return_index=True)[1]
    with pytest.raises(SolverError, match="inside the body"):
        condense_body(replace(body, contact=edges[first]))
    with pytest.raises(SolverError, match="more than once"):
        condense_body(replace(body, contact=np.vstack([body.contact, body.contact[:1]])))


def test_loads_that_are_no_forces_are_refused():
    body = block((2, 2), (1.0, 1.0), 1.0)
    for value in (np.nan, np.inf):
        loads = np.zeros(body.fixed.shape)
        loads[5] = value
        with pytest.raises(SolverError, match="loads must be finite"):
            condense_body(replace(body, loads=loads))
    for shape in ((3,), body.mesh.points.shape):
        with pytest.raises(SolverError, match="loads have the shape"):
            condense_body(replace(body, loads=np.zeros(shape)))
    with pytest.raises(SolverError, match="fixed has the shape"):
        condense_body(replace(body, fixed=body.fixed[:-1]))


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_held_too_little_or_too_much_is_refused(dim):
    counts, size = SHAPES[dim]
    body = block(counts, size, size[1])
    one = np.arange(len(body.fixed)) < dim
    along_x = body.fixed & (np.arange(len(body.fixed)) % dim == 0)
    contact = np.zeros(body.mesh.points.shape, dtype=bool)
    contact[np.unique(body.contact)] = True
    for fixed, words in (
        (np.zeros_like(one), "not held"),
        (one, "not held"),
        (along_x, "not held"),
        (np.ones_like(one), "every displacement of the body is held"),
        (contact.ravel(), "every contact node is held"),
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


def test_nodes_of_no_cell_are_refused():
    body = block((2, 2), (1.0, 1.0), 1.0)
    loose = replace(body.mesh, points=np.vstack([body.mesh.points, [[9.0, 9.0]]]))
    fixed = np.append(body.fixed, [False, False])
    with pytest.raises(SolverError, match="belong to no cell"):
        condense_body(replace(body, mesh=loose, fixed=fixed))


def test_linear_elements_lock():
    """A bonded layer pressed flat: P1 gives way at nu = 0.3 but not at 0.4999; mixed does both."""

    def settlement(element, poisson, factor=1):
        counts = (16 * factor, 4 * factor)
        model = body_model(block(counts, (4.0, 1.0), 1.0, poisson=poisson, element=element))
        force = np.zeros(model.points.shape)
        force[:, 1] = -model.areas
        return float(-model.areas @ model.displacement(force)[:, 1])

    for poisson, locks in ((0.3, False), (0.4999, True)):
        right = settlement("mixed", poisson, 4)
        assert settlement("mixed", poisson) == pytest.approx(right, rel=0.03)
        assert (settlement("P1", poisson) < 0.6 * right) == locks
        assert settlement("P2", poisson) == pytest.approx(right, rel=0.1 if locks else 0.01)


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
