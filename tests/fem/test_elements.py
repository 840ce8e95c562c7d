"""P1, P2 and mixed elements: fitted orders, rigid motions, patch tests, locking, interfaces."""

import numpy as np
import pytest
import scipy.sparse as sp

from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import physical_gradients, quadrature, tabulate
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, assemble_system
from fingerdesign.fem.trace import contact_trace
from fingerdesign.mesh.cells import kind_of, outer_facets
from tests.support.boxes import box, mesh_of

SIZES = {2: (4, 8, 16), 3: (2, 4, 8), "prisms": (2, 4, 8)}
WAVES, SLOPES = np.array([2.0, 1.5, 1.0]), np.array([1.0, 2.0, 1.5])


def full(upper):
    return (upper + sp.triu(upper, k=1).T).tocsr()


def isochoric(x):
    """curl of (0, 0, sin ax sin by cos cz): no volume change, so no stress grows with nu."""
    a, b, c = WAVES
    u = np.zeros(x.shape)
    along = np.cos(c * x[..., 2]) if x.shape[-1] == 3 else 1.0
    u[..., 0] = b * np.sin(a * x[..., 0]) * np.cos(b * x[..., 1]) * along
    u[..., 1] = -a * np.cos(a * x[..., 0]) * np.sin(b * x[..., 1]) * along
    return u


def volumetric(x):
    """grad cos(k . x): divided by lame it gives a pressure that does not grow with nu."""
    slopes = SLOPES[: x.shape[-1]]
    return -np.sin(x @ slopes)[..., None] * slopes


def exact(x, lame, share):
    return isochoric(x) + share / lame * volumetric(x)


def body_force(x, lame, shear, share):
    dim = x.shape[-1]
    force = shear * (WAVES[:dim] ** 2).sum() * isochoric(x)
    stiff = (lame + 2 * shear) / lame
    return force + share * stiff * (SLOPES[:dim] ** 2).sum() * volumetric(x)


def system_of(points, cells, young, poisson, element="P2"):
    """The system of a body that is not held, and the places of its own nodes."""
    mesh, none = mesh_of(points, cells), np.zeros(points.size, dtype=bool)
    moduli = (np.broadcast_to(value, len(cells)) for value in (young, poisson))
    system = assemble_system(Body(mesh, *moduli, none, cells[:0], element=element))
    nodes = np.unique(mesh.corners) if element == "P1" else np.arange(len(points))
    return system, points[nodes]


def solve(points, system, places, values, load):
    """Nodal displacements with ``values`` prescribed at the element's boundary nodes."""
    dim = points.shape[1]
    boundary = ((places < 1e-9) | (places > 1 - 1e-9)).any(axis=1)
    moves = np.diff(system.lift.tocsc().indptr) > 0  # the others are pressures
    fixed, found = np.zeros(system.dofs, dtype=bool), np.zeros(system.dofs)
    fixed[moves] = np.repeat(boundary, dim)
    found[moves] = values.ravel()
    found[~fixed] = 0.0
    whole = full(system.stiffness)
    right = system.lift.T @ load.ravel() - whole @ found
    inner = sp.triu(whole[~fixed][:, ~fixed], format="csr")
    inner.sort_indices()
    first = int(np.argmax(moves[~fixed]))
    one = sp.csr_matrix(([1.0], ([0], [first])), shape=(1, inner.shape[0]))
    condensation = Condensation(inner, one, system.pressures)
    found[~fixed] = condensation.solve(right[~fixed][:, None])[:, 0]
    return (system.lift @ found).reshape(points.shape)


def error(shape, n, poisson, element, share=1.0):
    """L2 error of the manufactured solution on a box of n cells a side."""
    points, cells = box(shape, n)
    kind = kind_of(cells)
    lame, shear = (float(v) for v in lame_parameters(np.array(1.0), np.array(poisson)))
    system, places = system_of(points, cells, 1.0, poisson, element)
    table = tabulate(kind, *quadrature(kind, 6))
    _, weights = physical_gradients(points, cells, 6)
    where = np.einsum("nq,cna->cqa", table.value, points[cells])
    load = np.zeros_like(points)
    force = body_force(where, lame, shear, share)
    np.add.at(load, cells, np.einsum("nq,cqa,cq->cna", table.value, force, weights))
    got = solve(points, system, places, exact(places, lame, share), load)
    miss = np.einsum("nq,cna->cqa", table.value, got[cells]) - exact(where, lame, share)
    return float(np.sqrt(np.einsum("cqa,cq->", miss**2, weights)))


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize(
    ("element", "poisson", "least"),
    [("P1", 0.3, 1.8), ("P2", 0.3, 2.8), ("mixed", 0.3, 2.8), ("mixed", 0.4999, 2.8)],
)
def test_orders(shape, element, poisson, least):
    errors = [error(shape, n, poisson, element) for n in SIZES[shape]]
    order = -np.polyfit(np.log(SIZES[shape]), np.log(errors), 1)[0]
    assert least < order < least + 0.8


@pytest.mark.parametrize("shape", SIZES)
def test_what_locking_costs(shape):
    """A field without volume change is the same at every nu: only the mixed element keeps it."""
    n = SIZES[shape][1]

    def growth(element):
        return error(shape, n, 0.4999, element, 0.0) / error(shape, n, 0.3, element, 0.0)

    assert growth("mixed") < 1.1
    assert growth("P2") > 3.0


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("element", ["P1", "P2", "mixed"])
def test_patch_of_uniform_strain(shape, element):
    """A linear field is reproduced exactly, volume change and all, on a distorted mesh."""
    points, cells = box(shape, 3, jitter=0.2)
    dim = points.shape[1]
    system, places = system_of(points, cells, 1.0, 0.4999, element)
    slope = np.random.default_rng(0).normal(size=(dim, dim))
    got = solve(points, system, places, places @ slope, np.zeros_like(points))
    assert np.abs(got - points @ slope).max() < 1e-9


@pytest.mark.parametrize("shape", SIZES)
def test_rigid_motions_cost_nothing(shape):
    points, cells = box(shape, 3, jitter=0.2)
    dim = points.shape[1]
    stiffness = full(system_of(points, cells, 2.0, 0.3)[0].stiffness)
    slopes = np.random.default_rng(2).normal(size=(2, dim, dim))
    for slope in slopes:
        motion = points @ (slope - slope.T) + slope[0]
        assert np.abs(stiffness @ motion.ravel()).max() < 1e-11 * abs(stiffness).max()


@pytest.mark.parametrize("shape", SIZES)
def test_patch_across_an_interface(shape):
    """A stress that both materials carry at uniform strain each is reproduced exactly.

    Layers stacked along y under u_x = gamma(y): the shear stress is the same in both.
    """
    points, cells = box(shape, 4)
    young = np.where(points[cells].mean(axis=1)[:, 1] < 0.5, 1.0, 1e4)
    low, high = lame_parameters(np.array([1.0, 1e4]), np.array(0.3))[1]
    system, places = system_of(points, cells, young, 0.3)
    wanted, y = np.zeros_like(points), points[:, 1]
    wanted[:, 0] = np.where(y <= 0.5, y / low, 0.5 / low + (y - 0.5) / high)
    got = solve(points, system, places, wanted, np.zeros_like(points))
    assert np.abs(got - wanted).max() < 1e-10 * np.abs(wanted).max()


@pytest.mark.parametrize("shape", SIZES)
def test_pressure_jumps_between_materials(shape):
    """Two nearly incompressible layers stretched alike, and a compressible one: exact strains."""
    points, cells = box(shape, 4)
    dim = points.shape[1]
    height = points[cells].mean(axis=1)[:, 1]
    young = np.where(height < 0.5, 1.0, 40.0)
    poisson = np.where(height < 0.5, 0.4999, 0.499)
    mesh = mesh_of(points, cells)
    held = np.zeros(points.shape, dtype=bool)
    held[points[:, 1] < 1e-9, 1] = True
    for k in [0, *range(2, dim)]:
        held[:, k] = True  # stretched along y alone: oedometric, layer by layer
    body = Body(mesh, young, poisson, held.ravel(), cells[:0], element="mixed")
    system = assemble_system(body)
    assert system.pressures > len(np.unique(mesh.corners))
    *_, facets = outer_facets(cells)  # of prisms the squares
    trace = contact_trace(points, facets[(points[facets, 1] > 1 - 1e-9).all(axis=1)])
    pull = np.outer(trace.areas, np.eye(dim)[1])
    row = sp.csr_matrix((trace.operator.T @ pull.ravel())[None] @ system.lift)
    field = Condensation(system.stiffness, row, system.pressures).solve(row.toarray().T)
    moved = (system.lift @ field).reshape(points.shape)[points[:, 1] > 1 - 1e-9, 1]
    lame, shear = lame_parameters(np.array([1.0, 40.0]), np.array([0.4999, 0.499]))
    assert np.allclose(moved, (0.5 / (lame + 2 * shear)).sum(), rtol=1e-7)


def test_a_negative_stiffness_is_refused():
    points, cells = box(2, 2)
    stiffness = system_of(points, cells, 1.0, 0.3)[0].stiffness
    rows = sp.csr_matrix(([1.0], ([0], [3])), shape=(1, points.size))
    with pytest.raises(SolverError, match="not positive definite"):
        Condensation(-stiffness, rows)
