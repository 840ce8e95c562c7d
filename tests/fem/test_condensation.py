"""The condensed model against the full one: compliance, readouts, balance, uniform pressure."""

import gc
import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp

from fingerdesign import parse_design
from fingerdesign.checks.load import with_values
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.fem import body, factor
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.model import (
    MIXED_FROM,
    body_of,
    build_model,
    candidate_facets,
    element_of,
    fixed_dofs,
)
from fingerdesign.fem.readout import gage_rows, locate, strain_rows
from fingerdesign.fem.system import assemble_system
from fingerdesign.fem.trace import contact_trace, on_another
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import facet_kind
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.runtime.isolate import call
from tests.support.session import never_called

DESIGN = parse_design(
    """
    design.name = "coarse"
    body.width_mm = 8.0
    body.base_height_mm = 3.0
    body.arc_radius_mm = 8.0
    body.depth_mm = 4.0
    plates.count = 3
    plates.pitch_mm = 1.5
    plates.length_mm = 1.2
    plates.cover_mm = 1.0
    gages.length_mm = 0.6
    [mesh]
    element = "P2"
    contact_size_mm = 0.8
    plate_size_mm = 0.8
    far_size_mm = 2.0
    layers = 2
    [mesh.section]
    contact_size_mm = 0.3
    plate_size_mm = 0.2
    far_size_mm = 1.0
    """
)
POINT = np.array([[0.5, 3.2, 0.0]])

CASES = [(kind, "P2") for kind in ("section", "half", "whole")]
CASES += [(kind, element) for kind in ("section", "half") for element in ("P1", "mixed")]


@cache
def condensed(kind, element="P2"):
    """Design, mesh and model of a section, of a half in space or of the whole."""
    design = DESIGN
    if element != "P2":
        keys = {"mesh.element": element, "materials.silicone.poissons_ratio": 0.4999}
        design = with_values(design, keys)
    flat = kind == "section"
    mesh = mesh_section(design, 1.5) if flat else extrude(design, Zone(1.5), kind == "half")
    return design, mesh, build_model(design, mesh, 1.5, POINT)


def test_auto_goes_by_the_poisson_ratio():
    """The shipped silicone (0.49) is mixed; below the threshold, and when asked, P2."""
    for poisson, requested, used in (
        (0.49, "auto", "mixed"),
        (MIXED_FROM - 0.01, "auto", "P2"),
        (0.49, "P2", "P2"),
        (0.3, "mixed", "mixed"),
    ):
        values = {"materials.silicone.poissons_ratio": poisson, "mesh.element": requested}
        assert element_of(with_values(DESIGN, values)) == used
    mesh, mixed = mesh_section(DESIGN, 1.5), with_values(DESIGN, {"mesh.element": "mixed"})
    pressed = body_of(mixed, mesh, mesh.facets["contact"]).pressed
    np.testing.assert_array_equal(pressed, mesh.regions == 0)  # plates are P2


def random_force(model, seed=0):
    force = np.random.default_rng(seed).normal(size=model.points.shape)
    force[model.locked] = 0.0
    return force


def stiffness_of(design, mesh):
    """Upper triangle of the stiffness of all dofs (whole depth in plane strain)."""
    free = np.zeros(mesh.points.size, dtype=bool)
    whole = replace(body_of(design, mesh, mesh.facets["contact"]), fixed=free, element="P2")
    return assemble_system(whole).stiffness


@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_condensed_equals_full(case):
    """Contact displacement, gage and point strain of the reduced and of the full solution.

    The compliance is symmetric positive definite, every force comes out at the supports, and
    K u = f on the free dofs of the full stiffness.
    """
    design, mesh, built = condensed(*case)
    model = built.reduced
    assert built.element == design.mesh.element
    compliance = model.compliance
    assert np.abs(compliance - compliance.T).max() <= 1e-10 * np.abs(compliance).max()
    assert np.linalg.eigvalsh(compliance).min() > 0.0
    force = random_force(model)
    field = built.displacement_fields(force[None])[0].ravel()
    u = (built.condensed.trace.operator @ field).reshape(force.shape)
    free = ~model.locked
    assert np.abs(model.displacement(force) - u)[free].max() < 1e-9 * np.abs(u).max()
    frames = plate_frames(design)
    gages = gage_rows(mesh, frames, design.gages, design.gage_weights) @ field
    assert np.abs(model.gage_strain(force).ravel() - gages).max() < 1e-9 * np.abs(gages).max()
    strain = strain_rows(mesh, POINT[0, : mesh.dimension]) @ field
    assert np.abs(model.point_strain(force)[0] - strain).max() < 1e-9 * np.abs(strain).max()
    bearing = 2 if model.locked.any() else model.dimension
    reaction = model.reaction_readout @ force.ravel()
    least = 1e-7  # N, of ten: plates are 27,000 times stiffer than the body
    assert np.allclose(reaction[:bearing], -force.sum(axis=0)[:bearing], rtol=0, atol=least)
    if built.element == "P2":  # others' stiffness has fewer dofs, or pressures among them
        upper = stiffness_of(design, mesh)
        residual = upper @ field + sp.triu(upper, k=1).T @ field
        residual -= built.condensed.trace.operator.T @ force.ravel()
        internal = abs(upper) @ np.abs(field)  # what cancels in each row
        assert np.abs(residual[~fixed_dofs(mesh)]).max() < 1e-12 * internal.max()


def test_half_model_equals_whole():
    """Mirror symmetry: the half model under half the load moves as the whole one does."""
    half, whole = (condensed(kind)[2].reduced for kind in ("half", "whole"))
    load = np.array([1.0, -3.0, 0.0])
    u_half = half.displacement(half.areas[:, None] * load)
    u_whole = whole.displacement(whole.areas[:, None] * load)
    keep = whole.points[:, 2] > -1e-9
    order_half = np.lexsort(np.round(half.points, 9).T)
    order_whole = np.flatnonzero(keep)[np.lexsort(np.round(whole.points[keep], 9).T)]
    free = ~half.locked[order_half]
    error = np.abs(u_half[order_half] - u_whole[order_whole])[free].max()
    assert error < 1e-9 * np.abs(u_whole).max()
    assert np.allclose(2 * (half.areas @ np.ones(half.nodes)), whole.areas.sum(), rtol=1e-9)


def test_uniform_pressure_is_reproduced():
    """Nodal forces p a_i load the quadratic surface exactly as the uniform pressure p does."""
    for mesh in (mesh_section(DESIGN, 1.5), extrude(DESIGN, Zone(1.5))):
        facets, dim = mesh.facets["contact"], mesh.dimension
        trace = contact_trace(mesh.points, facets)
        load = trace.operator.T @ np.outer(trace.areas, np.eye(dim)[1]).ravel()
        where, weights = quadrature(facet_kind(facets), 6)
        table = tabulate(facet_kind(facets), where)
        tangents = np.einsum("fna,nbq->fqba", mesh.points[facets], table.gradient)
        normal = tangents[..., 0, :] if dim == 2 else np.cross(*np.moveaxis(tangents, 2, 0))
        measure = np.linalg.norm(normal, axis=2) * weights
        wanted = np.zeros(mesh.points.shape)
        np.add.at(wanted[:, 1], facets, np.einsum("nq,fq->fn", table.value, measure))
        assert trace.areas.min() > 0.0
        assert np.isclose(trace.areas.sum(), measure.sum(), rtol=1e-12)
        assert np.isclose(load.sum(), measure.sum(), rtol=1e-12)
        moments = [each.reshape(mesh.points.shape)[:, 1] @ mesh.points for each in (load, wanted)]
        assert np.allclose(*moments, rtol=0, atol=1e-10)


def test_a_trace_reads_another_meshs_displacements():
    """Exactly, where they are quadratic along x and z."""
    own = extrude(DESIGN, Zone(1.5))
    other = extrude(with_values(DESIGN, {"mesh.contact_size_mm": 0.5, "mesh.layers": 3}), Zone(1.5))
    trace = contact_trace(own.points, own.facets["contact"])
    known, found = (
        each.operator @ np.stack([1.0 + x, x * z, z**2 - x**2], axis=1).ravel()
        for each, (x, _, z) in (
            (trace, own.points.T),
            (on_another(trace, own, other), other.points.T),
        )
    )
    assert len(own.points) != len(other.points)
    assert found == pytest.approx(known, abs=1e-6 * np.abs(known).max())
    facets = other.facets["contact"]
    corner = (other.points[:, 0] + other.points[:, 2])[facets].max(axis=1).argmax()
    holed = replace(other, facets=other.facets | {"contact": np.delete(facets, corner, axis=0)})
    with pytest.raises(SolverError, match="not in rows"):
        on_another(trace, own, holed)


def test_constant_strain_is_read_exactly_and_a_point_outside_is_refused():
    """A linear displacement gives its own strain at points and gages, in 2-D and 3-D."""
    for mesh in (mesh_section(DESIGN, 1.5), extrude(DESIGN, Zone(1.5), symmetric=False)):
        d = mesh.dimension
        slope = np.array([[0.3, 0.2, 0.1], [0.05, -0.4, 0.07], [0.02, 0.03, 0.6]])[:d, :d]
        field = (mesh.points @ slope.T).ravel()
        strain = np.zeros((3, 3))
        strain[:d, :d] = slope + slope.T
        wanted = [*np.diag(strain) / 2.0, strain[0, 1], strain[0, 2], strain[1, 2]]
        got = strain_rows(mesh, np.array([0.5, 3.2, 0.4])[:d]) @ field
        assert np.allclose(got, wanted, atol=1e-9)
        frames = plate_frames(DESIGN)
        gages = gage_rows(mesh, frames, DESIGN.gages, DESIGN.gage_weights) @ field
        axis = frames[0].axis
        assert np.allclose(gages, axis @ slope[:2, :2] @ axis, atol=1e-9)
        with pytest.raises(DesignError, match=r"readout\.points_mm"):
            strain_rows(mesh, np.array([0.0, 30.0, 0.0])[:d])
        just_in, just_out = (np.array([0.5, y, 0.4])[:d] for y in (1e-4, -1e-4))
        assert locate(mesh, just_out) == locate(mesh, just_in)  # a place on a surface that bends


def test_slow_fallback_gives_the_same(monkeypatch):
    """SuperLU, used where MKL has no wheel, agrees and says that it is slow."""
    pytest.importorskip("pypardiso")
    mesh = mesh_section(DESIGN, 1.5)
    free = ~fixed_dofs(mesh)
    stiffness = stiffness_of(DESIGN, mesh)[free][:, free].tocsr()
    stiffness.sort_indices()
    rows = gage_rows(mesh, plate_frames(DESIGN), DESIGN.gages, DESIGN.gage_weights)[:, free].tocsr()
    fast = Condensation(stiffness, rows)
    silent = sp.csr_matrix(sp.vstack([sp.csr_matrix((1, rows.shape[1])), rows]))
    assert not Condensation(stiffness, silent).matrix[0].any()
    load = np.random.default_rng(0).normal(size=(stiffness.shape[0], 2))
    found = [False]
    monkeypatch.setattr(factor, "has_pardiso", lambda: found[0])
    with pytest.warns(UserWarning, match="slower"):
        slow = Condensation(stiffness, rows)
    assert np.abs(fast.matrix - slow.matrix).max() < 1e-9 * np.abs(fast.matrix).max()
    difference = slow.solve(load) - fast.solve(load)
    assert np.abs(difference).max() < 1e-8 * np.abs(fast.solve(load)).max()
    # Half of a solve gives the fields of unit forces on some rows.
    whole = fast.solve(rows[[3, 0]].T.toarray())
    for each in (fast, slow):
        *own, beyond = each.fields(np.array([3, 0]))
        assert np.abs(own - whole).max() < 1e-8 * np.abs(whole).max()
        assert not beyond.any()
    unsound = (stiffness - sp.diags_array(0.5 * stiffness.diagonal())).tocsr()
    for found[0] in (True, False):
        with (
            warnings.catch_warnings(action="ignore"),
            pytest.raises(SolverError, match="not positive definite"),
        ):
            Condensation(unsound, rows)


@pytest.mark.slow
def test_the_order_of_a_model_serves_the_next_on_a_moved_mesh(calls_of):
    """While the model before lives it keeps its order; where nodes lie decides nothing."""
    pytest.importorskip("pypardiso")
    design = with_values(DESIGN, {"mesh.element": "mixed"})
    mesh = extrude(design, Zone(1.5))
    solvers = calls_of(factor, "_solver")
    factor._forget_orders(1)

    def condensed_when_sheared(by, zone=1.5):
        points = mesh.points + by * mesh.points[:, [1]] * [1.0, 0.0, 0.0]
        facets = candidate_facets(mesh, zone)
        moved = replace(mesh, points=points, moved=True)
        return body.condense_body(body_of(design, moved, facets))

    answers = {}
    for by in (0.03, 0.07, 0.05):
        model = condensed_when_sheared(by)
        answers[by] = model.compliance
        del model
        gc.collect()
    assert len(solvers) == 1
    first, second = condensed_when_sheared(0.03), condensed_when_sheared(0.07)
    assert len(solvers) == 2
    for by, fresh in ((0.03, first), (0.07, second)):
        np.testing.assert_allclose(answers[by], fresh.compliance, atol=1e-11)
    assert np.abs(answers[0.03] - answers[0.05]).max() > 1e-3 * np.abs(answers[0.03]).max()
    del first, second

    for equations, made in ((400_000, 3), (0, 6)):
        # The narrower zone's is new; then all but the first are, whose order is still there.
        with factor.orders_held(equations):
            for zone in (1.5, 1.0, 1.5, 1.0):
                condensed_when_sheared(0.03, zone)
                gc.collect()
        assert len(solvers) == made


@pytest.mark.slow
def test_an_analysis_without_mkl_gives_the_same(cache_in, tmp_path):
    """In a process where pypardiso cannot be found: as on a machine that MKL has no wheel for."""
    pytest.importorskip("pypardiso")
    sizes = {"contact_size_mm": 0.3, "plate_size_mm": 0.4, "plate_end_size_mm": 0.2}
    changes = {f"mesh.section.{key}": size for key, size in sizes.items()}
    changes |= {"mesh.mesher": "sweep", "mesh.plate_size_mm": 2.0, "plates.count": 3}
    changes |= {"mesh.contact_size_mm": 1.2, "mesh.layers": 2}
    found = []
    for mkl in (True, False):
        cache_in(tmp_path / str(mkl))  # none is kept
        found.append(call("tests.support.calls:forces", changes, mkl, time_s=500.0))
    for with_mkl, without in zip(*found, strict=True):
        assert np.abs(with_mkl).max() > 0.1
        assert without == pytest.approx(with_mkl, rel=1e-7, abs=1e-9)


def test_repeated_functionals_are_answered():
    """The same point twice, and more points than their patch has coefficients: no singularity."""
    mesh = mesh_section(DESIGN, 1.5)
    heights = np.linspace(0.3, 2.2, 120)
    points = np.column_stack([np.full_like(heights, 0.4), heights, np.zeros_like(heights)])
    points = np.vstack([points, points[:3]])
    model = build_model(DESIGN, mesh, 1.5, points).reduced
    force = random_force(model)
    strain = model.point_strain(force)
    assert np.allclose(strain[-3:], strain[:3], rtol=0, atol=1e-12 * np.abs(strain).max())
    plain = build_model(DESIGN, mesh, 1.5).reduced
    difference = np.abs(plain.compliance - model.compliance).max()
    assert difference < 1e-10 * np.abs(plain.compliance).max()


def test_points_mirror_with_their_signs():
    """In a half model strains at z < 0 are those at z > 0 with xz and yz turned round."""
    mesh = extrude(DESIGN, Zone(1.5))
    points = np.array([[0.5, 3.2, 0.9], [0.5, 3.2, -0.9], [0.5, 3.2, 0.0]])
    model = build_model(DESIGN, mesh, 1.5, points).reduced
    strain = model.point_strain(random_force(model))
    assert np.allclose(strain[1], strain[0] * [1, 1, 1, 1, -1, -1], atol=1e-12)
    assert np.abs(strain[0, 4:]).max() > 1e-6
    assert np.abs(strain[2, 4:]).max() < 1e-9 * np.abs(strain[2]).max()


def test_strains_on_the_mirror_plane_are_those_of_a_linear_field():
    mesh = extrude(DESIGN, Zone(1.5))
    slopes = np.array([[1.0, 2.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 5.0]])  # it mirrors in z
    found = strain_rows(mesh, np.array([0.5, 3.2, 0.0])) @ (mesh.points @ slopes.T).ravel()
    assert found == pytest.approx(np.array([1.0, 4.0, 5.0, 5.0, 0.0, 0.0]), abs=1e-9)


MODULI = ("materials.silicone.youngs_modulus_MPa", "materials.phosphor_bronze.youngs_modulus_MPa")
PARTS = tuple(zip(MODULI, ("body", "plates"), strict=True))


def test_a_body_is_condensed_once_whatever_its_moduli_are_multiplied_by(
    calls_of, own_cache, tmp_path
):
    mesh = mesh_section(DESIGN, 1.5)

    def built(factors=(1.0, 1.0), store=True):
        parts = [DESIGN.material_of(part).youngs_modulus_MPa for part in ("body", "plates")]
        values = {key: f * e for key, f, e in zip(MODULI, factors, parts, strict=True)}
        return build_model(with_values(DESIGN, values), mesh, 1.5, POINT, store=store)

    built()
    calls = calls_of(body, "assemble_system")
    kept, fresh = built((2.3, 2.3)), built((2.3, 2.3), store=False)
    assert len(calls) == 1  # the fresh one
    parts = [{**vars(each.reduced), "between": each.condensed.between} for each in (kept, fresh)]
    for name in ("compliance", "gage_readout", "point_readout", "reaction_readout", "between"):
        one, other = (each[name] for each in parts)
        np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(other).max())
    assert kept.dofs == fresh.dofs
    force = np.random.default_rng(0).normal(size=(1, *kept.reduced.points.shape))
    fields = [model.displacement_fields(force) for model in (kept, kept, fresh)]
    assert len(calls) == 2  # once for both fields of the kept one
    np.testing.assert_allclose(fields[0], fields[2], atol=1e-8 * np.abs(fields[2]).max())
    built((1.0, 1.1))  # another contrast is another body
    assert len(calls) == 3
    for path in (tmp_path / "models").iterdir():
        path.write_bytes(b"garbled")
    built()
    assert len(calls) == 4


def test_fields_of_stored_loads_and_of_their_combinations_need_no_factors(
    calls_of, own_cache, tmp_path
):
    """A field is linear in its load; one of another load is computed."""
    mesh = mesh_section(DESIGN, 1.5)

    def built(factor=1.0, store=True):
        values = {key: factor * DESIGN.material_of(part).youngs_modulus_MPa for key, part in PARTS}
        return build_model(with_values(DESIGN, values), mesh, 1.5, store=store)

    fresh = built(3.0, store=False)
    forces = np.random.default_rng(1).normal(size=(3, *fresh.reduced.points.shape))
    known = fresh.displacement_fields(forces)
    scale = 1e-9 * np.abs(known).max()
    built().displacement_fields(forces[:2])
    again = built(3.0)
    with never_called(body, "assemble_system"):
        again.condensed.prepare_fields(needed=True)
        np.testing.assert_allclose(again.displacement_fields(forces[:2]), known[:2], atol=scale)
        mixed = again.displacement_fields(forces[:1] - 2.0 * forces[1:2])
        np.testing.assert_allclose(mixed, known[:1] - 2.0 * known[1:2], atol=3.0 * scale)
    near = forces[:1] + 1e-9 * forces[2:]  # not made up of the stored ones
    calls = calls_of(Condensation, "solve")
    for _ in range(2):
        found = again.displacement_fields(near)
        np.testing.assert_allclose(found, known[:1] + 1e-9 * known[2:], atol=scale)
        assert len(calls) == 1
    for path in (tmp_path / "fields").iterdir():
        path.write_bytes(b"garbled")
    np.testing.assert_allclose(built(3.0).displacement_fields(forces), known, atol=scale)
    assert len(calls) == 2


def test_elements_agree_where_nothing_locks():
    """At nu = 0.3 mixed and P2 give the same compliance and gages as the mesh gets fine."""
    fine = {"mesh.section.gradation": 0.2, "mesh.section.plate_end_size_mm": 0.02}
    values = {"materials.silicone.poissons_ratio": 0.3} | fine
    found = {}
    for element in ("P2", "mixed"):
        design = with_values(DESIGN, values | {"mesh.element": element})
        found[element] = build_model(design, mesh_section(design, 1.5), 1.5).reduced
    load = found["P2"].areas[:, None] * np.array([0.3, -1.0])
    for read in ("displacement", "gage_strain"):
        a, b = (getattr(found[element], read)(load) for element in ("P2", "mixed"))
        assert np.abs(a - b).max() < 2e-3 * np.abs(a).max()
