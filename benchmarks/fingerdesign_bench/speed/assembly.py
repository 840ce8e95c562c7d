"""The stiffness of about 100,000 dofs by scikit-fem's own assembly and by ours, from one mesh."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem
from scipy.spatial import cKDTree
from skfem.models.elasticity import lame_parameters, linear_elasticity

from fingerdesign.fem.system import Body, assemble_system
from fingerdesign.mesh.types import TETRA_EDGES, TRIANGLE_EDGES, Mesh
from fingerdesign_bench.check import Check

YOUNGS_MODULUS, POISSONS_RATIO = 4.96, 0.45
SAME = 1e-12  # relative difference of the two matrices
WORTH = 1.5  # of our time: below it, scikit-fem's assembly would be the one to use
DIVISIONS = {2: 112, 3: 16}  # of a unit square, a unit cube: 101,250 and 107,811 dofs
_RUNS = 3


def assembly_checks(divisions: dict[int, int] = DIVISIONS) -> list[Check]:
    """The same matrix, and our seconds over scikit-fem's times WORTH, plane and space."""
    checks = []
    for dimension, count in divisions.items():
        ours, theirs, difference, dofs = compared(dimension, count)
        where = f"{dimension}-D, {dofs} dofs"
        checks.append(Check(f"{where}: difference of the matrices", SAME, difference))
        factor = theirs / ours
        name = f"{where}: {WORTH:g} over scikit-fem's time as a multiple of ours ({factor:.1f})"
        checks.append(Check(name, 1.0, WORTH / factor))
    return checks


def compared(dimension: int, count: int) -> tuple[float, float, float, int]:
    """Seconds of our assembly and of scikit-fem's, relative difference of the matrices, dofs."""
    line = [np.linspace(0.0, 1.0, count + 1)] * dimension
    mesh = skfem.MeshTet.init_tensor(*line) if dimension == 3 else skfem.MeshTri.init_tensor(*line)
    element = skfem.ElementTetP2() if dimension == 3 else skfem.ElementTriP2()
    vector = skfem.ElementVector(element)
    form = linear_elasticity(*lame_parameters(YOUNGS_MODULUS, POISSONS_RATIO))
    points, cells = quadratic_cells(skfem.Basis(mesh, element))
    moduli = np.full(len(cells), YOUNGS_MODULUS), np.full(len(cells), POISSONS_RATIO)
    own_mesh = Mesh(points, cells, np.zeros(len(cells), dtype=np.int64), {}, "scikit-fem")
    nothing = np.zeros(points.size, dtype=bool)
    body = Body(own_mesh, *moduli, nothing, np.zeros((0, 3), dtype=np.int64))
    ours, own = _timed(lambda: assemble_system(body).stiffness)
    theirs, other = _timed(lambda: form.assemble(skfem.Basis(mesh, vector, intorder=2)))
    # Their dofs stand node by node as well, in another order of the nodes.
    places = skfem.Basis(mesh, vector, intorder=2).doflocs.T
    node = cKDTree(points).query(places)[1]
    component = np.empty(len(places), dtype=np.int64)
    component[np.lexsort((np.arange(len(places)), node))] = np.tile(
        np.arange(dimension), len(points)
    )
    order = node * dimension + component
    whole = sp.csr_matrix(own + sp.triu(own, 1).T)[order][:, order]
    return ours, theirs, float(abs(whole - other).max() / abs(other).max()), len(places)


def quadratic_cells(basis: Any) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, dim) and cells (c, 6 or 10) in our order, positively oriented, of a P2 basis."""
    points, dofs = basis.doflocs.T.copy(), basis.element_dofs.T.astype(np.int64)
    corners = points.shape[1] + 1
    edges = TRIANGLE_EDGES if corners == 3 else TETRA_EDGES
    theirs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)][: len(edges)]
    middle = {pair: dofs[:, corners + k] for k, pair in enumerate(theirs)}
    sides = points[dofs[:, 1:corners]] - points[dofs[:, :1]]
    turned = np.linalg.det(sides) < 0.0
    cells = np.empty_like(dofs)
    for flip in (False, True):
        vertex = [1, 0, *range(2, corners)] if flip else list(range(corners))
        columns = [dofs[:, k] for k in vertex]
        columns += [middle[tuple(sorted((vertex[i], vertex[j])))] for i, j in edges]  # type: ignore[index]
        cells[turned == flip] = np.column_stack(columns)[turned == flip]
    return points, cells


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """The least seconds of this process in some runs, and what came of the last."""
    least, found = np.inf, None
    for _ in range(_RUNS):
        start = time.process_time()
        found = work()
        least = min(least, time.process_time() - start)
    return float(least), found
