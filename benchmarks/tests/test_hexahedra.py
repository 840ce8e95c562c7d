"""Triquadratic hexahedra against scikit-fem's own and against tetrahedra; the bench of cells."""

import numpy as np
import pytest
import scipy.sparse as sp
from fingerdesign_bench.accuracy import hexahedra
from fingerdesign_bench.accuracy.hexahedra import (
    FINGER,
    LINES,
    Hexahedra,
    HexPoint,
    write_hexahedra,
)
from fingerdesign_bench.accuracy.hexahedral_model import (
    extruded_hexahedra,
    gauss,
    hex_system,
    hex_trace,
    shapes,
)
from fingerdesign_bench.machine import machine
from scipy.sparse.linalg import spsolve

from fingerdesign.checks.load import parse_design
from fingerdesign.design.schema import Design
from fingerdesign.layout.surface import surface_of
from fingerdesign.layout.volume import outline_volume
from fingerdesign.mesh.section.extrude import layer_heights
from fingerdesign.mesh.section.section import mesh_section

SIZES = {"contact_size_mm": 0.8, "plate_size_mm": 0.6, "plate_end_size_mm": 0.2}
TABLES = {
    "design": {"name": "hexes"},
    "body": {"width_mm": 6.0, "base_height_mm": 3.0, "depth_mm": 4.0},
    "plates": {"count": 1, "length_mm": 1.2, "cover_mm": 1.0, "thickness_mm": 0.2},
    "gages": {"length_mm": 0.6},
    "mesh": {"section": SIZES | {"far_size_mm": 2.0, "gradation": 1.0}},
}


def mesh_of(**body):
    design = Design.model_validate(TABLES | {"body": TABLES["body"] | body})
    section = mesh_section(design, 1.5)
    project = surface_of(design.body).project
    return design, extruded_hexahedra(section, layer_heights(2.0, 2, 1.15), project)


@pytest.fixture(scope="module")
def arched():
    return mesh_of(arc_radius_mm=6.0)


def materials(mesh):
    soft = mesh.regions == 0
    return np.where(soft, 5.0, 1e5), np.where(soft, 0.49, 0.3)


def full(system):
    return system.stiffness + sp.triu(system.stiffness, k=1).T


@pytest.mark.slow
def test_the_energy_is_scikit_fems():
    """Of a quadratic displacement on straight cells, where both spaces hold it exactly."""
    import skfem
    from skfem.helpers import ddot, sym_grad, trace
    from skfem.models.elasticity import lame_parameters

    _, mesh = mesh_of(shape="block")
    young, poisson = materials(mesh)
    first, shear = lame_parameters(young, poisson)
    corner = [0, 18, 6, 2, 24, 20, 8, 26]  # in scikit-fem's order of a cell's corners
    used, cells = np.unique(mesh.cells[:, corner], return_inverse=True)
    grid = skfem.MeshHex(mesh.points[used].T.copy(), cells.reshape(-1, 8).T.copy())
    basis = skfem.Basis(grid, skfem.ElementVector(skfem.ElementHex2()), intorder=5)
    flat = skfem.Basis(grid, skfem.ElementHex0(), intorder=5)

    @skfem.Functional
    def energy(w):
        strain = sym_grad(w.u)
        return 2.0 * w.shear * ddot(strain, strain) + w.first * trace(strain) ** 2

    def field(x):
        return np.array([x[0] * x[1], 0.3 * x[1] ** 2 + x[2], x[2] * x[0] - x[1]])

    dofs = basis.zeros()
    for k in range(3):
        chosen = basis.get_dofs(elements=True).all(f"u^{k + 1}")
        dofs[chosen] = field(basis.doflocs[:, chosen])[k]
    moduli = {"first": flat.interpolate(first), "shear": flat.interpolate(shear)}
    theirs = energy.assemble(basis, u=basis.interpolate(dofs), **moduli)
    system = hex_system(mesh, young, poisson, np.zeros(mesh.points.size, dtype=bool))
    ours = field(mesh.points.T).T.reshape(-1)
    assert ours @ full(system) @ ours == pytest.approx(theirs, rel=1e-10)


def test_rigid_motions_cost_nothing(arched):
    _, mesh = arched
    system = hex_system(mesh, *materials(mesh), np.zeros(mesh.points.size, dtype=bool))
    stiffness, x = full(system), mesh.points
    for motion in (np.ones_like(x), np.cross([0.3, 0.2, 0.5], x)):
        force = stiffness @ motion.reshape(-1)
        assert np.abs(force).max() < 1e-9 * abs(stiffness).max() * np.abs(motion).max()


def test_the_cells_fill_the_body(arched):
    design, mesh = arched
    weights, slope = gauss(3)[1], shapes(gauss(3)[0], 3)[1]
    jacobian = np.einsum("cna,nbq->cqab", mesh.points[mesh.cells], slope)
    volume = np.linalg.det(jacobian) @ weights
    assert volume.min() > 0.0
    assert volume.sum() == pytest.approx(outline_volume(design.body, half=True), rel=1e-5)
    assert volume[mesh.regions == 1].sum() == pytest.approx(1.2 * 0.2 * 2.0, rel=1e-9)


def test_traces_take_constants_as_they_are(arched):
    _, mesh = arched
    trace = hex_trace(mesh.points, mesh.contact)
    moved = trace.operator @ np.tile([0.1, -0.2, 0.3], len(mesh.points))
    assert np.allclose(moved.reshape(-1, 3), [0.1, -0.2, 0.3])
    arc = 2.0 * 6.0 * np.arcsin(0.5)
    assert trace.areas.sum() == pytest.approx(arc * 2.0, rel=1e-4)
    assert trace.facet_areas.sum() == pytest.approx(trace.areas.sum())
    assert len(trace.areas) == len(trace.nodes)
    own = (trace.operator @ mesh.points.reshape(-1)).reshape(-1, 3)
    assert np.allclose(trace.surface.mean(trace.surface.points, len(own)), own)


@pytest.mark.slow
def test_pressures_change_little_where_nothing_locks(arched):
    """At nu = 0.3 mixed and plain hexahedra are alike; mixed ones have the pressures extra."""
    _, mesh = arched
    fixed = (mesh.points[:, 1] < 1e-9).repeat(3)
    young, poisson = materials(mesh)
    trace = hex_trace(mesh.points, mesh.contact)
    force = (trace.areas[:, None] * [0.0, -1.0, 0.0]).reshape(-1)
    found = []
    for pressures in (None, mesh.regions == 0):
        system = hex_system(mesh, young, np.full_like(poisson, 0.3), fixed, pressures)
        load = system.lift.T @ (trace.operator.T @ force)
        q = spsolve(full(system).tocsc(), load, permc_spec="MMD_AT_PLUS_A")
        found.append(float(force @ (trace.operator @ (system.lift @ q))))
        assert (system.pressures > 0) == (pressures is not None)
    assert found[1] == pytest.approx(found[0], rel=0.02)


@pytest.mark.slow
def test_both_cells_give_nearly_the_same_answer():
    """Very coarse ones, both mixed: within a few percent, though little but the body is shared."""
    design = parse_design(FINGER)
    tets = hexahedra._tetrahedra(design, 1.6, True)
    hexes = hexahedra._hexahedra(design, 3.0, True)
    assert (tets.line, hexes.line) == (LINES[1], LINES[3])
    assert hexes.forces[-1] == pytest.approx(tets.forces[-1], rel=0.03)
    assert hexes.stick == pytest.approx(tets.stick, abs=0.2)
    most = max(abs(value) for value in tets.gages[1])
    assert hexes.gages[1] == pytest.approx(tets.gages[1], abs=0.3 * most)


def point(line, dofs, error):
    forces = ((1.0 + error, 0.0), (2.0, 0.5))
    gages = ((3.0, -1.0), (2.0, 1.0 + error))
    return HexPoint(
        line, 1.0, dofs, 9, 1e-3 * dofs, 0.1, 0.2, forces, (0.5, 0.7 - 0.1 * error), gages
    )


@pytest.fixture
def measured():
    """Errors that fall with the square of the equations; both references exact."""
    points = [point(line, n, 1e6 / n**2) for line in LINES for n in (1000, 2000, 4000)]
    points += [point(LINES[1], 9000, 0.0), point(LINES[3], 9000, 0.0)]
    return Hexahedra(points, {})


@pytest.mark.slow
def test_errors_are_against_the_other_cell(measured):
    first = measured.points[0]
    assert measured.reference(LINES[0]).line == LINES[3]
    assert measured.reference(LINES[2]).line == LINES[1]
    assert measured.errors(first) == pytest.approx((1.0, 0.1, 0.5))
    assert measured.band() == (0.0, 0.0, 0.0)


@pytest.mark.slow
def test_numbers_and_chart_are_written(measured, tmp_path):
    measured.machine = machine()
    paths = write_hexahedra(measured, tmp_path / "new" / "folder")
    assert [path.name for path in paths] == ["hexahedra.json", "hexahedra.png"]
    assert all(path.stat().st_size > 500 for path in paths)
