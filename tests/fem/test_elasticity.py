"""Assembly against scikit-fem's own form, rigid motions, patch tests, and fitted orders."""

import numpy as np
import pytest
import scipy.sparse as sp
import skfem
from skfem.models.elasticity import linear_elasticity

from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import assemble_stiffness, lame_parameters, physical_gradients
from fingerdesign.fem.factor import Condensation
from fingerdesign.mesh.types import quadratic


def box(dimension, n, jitter=0.0, seed=1):
    """Quadratic simplices of the unit square or cube; inner nodes moved by ``jitter`` of h."""
    axis = np.linspace(0, 1, n + 1)
    mesh = (skfem.MeshTri if dimension == 2 else skfem.MeshTet).init_tensor(*[axis] * dimension)
    points, cells = mesh.p.T.copy(), mesh.t.T.copy()
    inside = ((points > 1e-9) & (points < 1 - 1e-9)).all(axis=1)
    move = np.random.default_rng(seed).uniform(-1, 1, points.shape)
    points[inside] += jitter / n * move[inside]
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    flipped = np.linalg.det(edges) < 0
    cells[flipped] = cells[flipped][:, [1, 0, *range(2, dimension + 1)]]
    return quadratic(points, cells)


def full(upper):
    return (upper + sp.triu(upper, k=1).T).tocsr()


@pytest.mark.parametrize("dimension", [2, 3])
def test_assembly_equals_scikit_fem(dimension):
    """The same matrix as scikit-fem's linear elasticity, to rounding."""
    points, cells = box(dimension, 3, jitter=0.2)
    young, poisson = 4.96, 0.49
    ours = full(
        assemble_stiffness(points, cells, np.full(len(cells), young), np.full(len(cells), poisson))
    )
    corners = cells[:, : dimension + 1]
    count = corners.max() + 1
    kind, element = (
        (skfem.MeshTri, skfem.ElementTriP2())
        if dimension == 2
        else (skfem.MeshTet, skfem.ElementTetP2())
    )
    mesh = kind(points[:count].T, corners.T, sort_t=False)
    basis = skfem.Basis(mesh, skfem.ElementVector(element), intorder=2)
    first, shear = lame_parameters(np.array(young), np.array(poisson))
    theirs = linear_elasticity(float(first), float(shear)).assemble(basis)
    # Match their dofs to our nodes by place and component.
    place = basis.doflocs.T
    component = np.empty(len(place), dtype=int)
    for k in range(dimension):
        component[basis.get_dofs(elements=True).all(f"u^{k + 1}")] = k
    order = np.lexsort((component, *np.round(place.T, 9)))
    own_place = np.repeat(points, dimension, axis=0)
    own_component = np.tile(np.arange(dimension), len(points))
    own_order = np.lexsort((own_component, *np.round(own_place.T, 9)))
    difference = ours[own_order][:, own_order] - theirs[order][:, order]
    assert abs(difference).max() < 1e-12 * abs(theirs).max()


@pytest.mark.parametrize("dimension", [2, 3])
def test_rigid_motions_cost_nothing(dimension):
    points, cells = box(dimension, 3, jitter=0.2)
    stiffness = full(
        assemble_stiffness(points, cells, np.full(len(cells), 2.0), np.full(len(cells), 0.3))
    )
    motions = [np.tile(row, (len(points), 1)) for row in np.eye(dimension)]
    turns = [(0, 1)] if dimension == 2 else [(0, 1), (0, 2), (1, 2)]
    for a, b in turns:
        turn = np.zeros_like(points)
        turn[:, a], turn[:, b] = -points[:, b], points[:, a]
        motions.append(turn)
    for motion in motions:
        assert np.abs(stiffness @ motion.ravel()).max() < 1e-12 * abs(stiffness).max()


@pytest.mark.parametrize("dimension", [2, 3])
def test_patch_across_an_interface(dimension):
    """A stress that both materials carry at uniform strain each is reproduced exactly.

    Layers stacked along y under u_x = gamma(y): the shear stress is the same in both.
    """
    points, cells = box(dimension, 4)
    centre = points[cells].mean(axis=1)
    soft = centre[:, 1] < 0.5
    young, poisson = np.where(soft, 1.0, 1e4), np.full(len(cells), 0.3)
    _, shear = lame_parameters(young, poisson)
    stiffness = assemble_stiffness(points, cells, young, poisson)
    exact = np.zeros_like(points)
    low, high = shear[soft][0], shear[~soft][0]
    y = points[:, 1]
    exact[:, 0] = np.where(y <= 0.5, y / low, 0.5 / low + (y - 0.5) / high)
    boundary = ((points < 1e-9) | (points > 1 - 1e-9)).any(axis=1)
    got = solve_dirichlet(stiffness, boundary, exact)
    assert np.abs(got - exact).max() < 1e-10 * np.abs(exact).max()


def solve(stiffness, load):
    rows = sp.csr_matrix(([1.0], ([0], [0])), shape=(1, stiffness.shape[0]))
    return Condensation(stiffness, rows).solve(load)


def solve_dirichlet(stiffness, boundary, values, load=None):
    fixed = np.repeat(boundary, values.shape[1])
    whole = full(stiffness)
    right = np.zeros(values.size) if load is None else load.ravel().copy()
    right -= whole[:, fixed] @ values.ravel()[fixed]
    inner = stiffness[~fixed][:, ~fixed].tocsr()
    inner.sort_indices()
    solution = values.ravel().copy()
    solution[~fixed] = solve(inner, right[~fixed][:, None])[:, 0]
    return solution.reshape(values.shape)


@pytest.mark.parametrize(("dimension", "sizes"), [(2, (4, 8, 16)), (3, (2, 4, 8))])
def test_displacement_converges_at_third_order(dimension, sizes):
    """Manufactured u_i = sin(pi x) cos(pi y)...: the L2 error falls as h^3 (quadratic elements)."""
    errors = []
    young, poisson = 1.0, 0.3
    first, shear = (float(v) for v in lame_parameters(np.array(young), np.array(poisson)))
    for n in sizes:
        points, cells = box(dimension, n)
        exact = manufactured(points)
        stiffness = assemble_stiffness(
            points, cells, np.full(len(cells), young), np.full(len(cells), poisson), order=4
        )
        load = np.zeros_like(points)
        value, weights, where = shapes(points, cells, 6)
        force = body_force(where, first, shear)
        np.add.at(load, cells, np.einsum("nq,cqa,cq->cna", value, force, weights))
        boundary = ((points < 1e-9) | (points > 1 - 1e-9)).any(axis=1)
        got = solve_dirichlet(stiffness, boundary, exact, load)
        field = np.einsum("nq,cna->cqa", value, got[cells])
        errors.append(np.sqrt(np.einsum("cqa,cq->", (field - manufactured(where)) ** 2, weights)))
    order = np.polyfit(np.log(1.0 / np.array(sizes)), np.log(errors), 1)[0]
    assert 2.7 < order < 3.5


def shapes(points, cells, order):
    from fingerdesign.fem.elements import quadrature, tabulate

    dimension = points.shape[1]
    table = tabulate(dimension, *quadrature(dimension, order))
    _, weights = physical_gradients(points, cells, order)
    where = np.einsum("nq,cna->cqa", table.value, points[cells])
    return table.value, weights, where


def manufactured(x):
    """u = (s, 0.5 s, ...) with s = sin(pi x) sin(2 y): smooth, no symmetry to hide behind."""
    s = np.sin(np.pi * x[..., 0]) * np.sin(2.0 * x[..., 1])
    return np.stack([s, 0.5 * s, 0.25 * s][: x.shape[-1]], axis=-1)


def body_force(x, first, shear):
    """f = -div sigma for u = c s(x, y): -(lame + mu) grad(c . grad s) - mu c laplacian s."""
    c = np.array([1.0, 0.5, 0.25])[: x.shape[-1]]
    a, b = np.pi, 2.0
    sx, cx = np.sin(a * x[..., 0]), np.cos(a * x[..., 0])
    sy, cy = np.sin(b * x[..., 1]), np.cos(b * x[..., 1])
    s_xx, s_yy, s_xy = -a * a * sx * sy, -b * b * sx * sy, a * b * cx * cy
    gradient = np.zeros(x.shape)
    gradient[..., 0] = c[0] * s_xx + c[1] * s_xy
    gradient[..., 1] = c[0] * s_xy + c[1] * s_yy
    return -(first + shear) * gradient - shear * (s_xx + s_yy)[..., None] * c


def test_an_unheld_body_is_refused():
    points, cells = box(2, 2)
    stiffness = assemble_stiffness(
        points, cells, np.full(len(cells), -1.0), np.full(len(cells), 0.3)
    )
    rows = sp.csr_matrix(([1.0], ([0], [3])), shape=(1, points.size))
    with pytest.raises(SolverError, match="not positive definite"):
        Condensation(stiffness, rows)
