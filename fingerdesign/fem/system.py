"""The equations of a body: stiffness on the free dofs, and how displacements follow from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.fem.assembly import assemble_stiffness
from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class System:
    """K q = L^T load for the free dofs q, of which the nodal displacements are u = L q.

    stiffness (d, d): upper triangle in CSR, sorted; lift (n dim, d): L; support (dim, d): sum of
    the supports' forces on the body per component; negative: how many eigenvalues of K are below
    zero (the pressures of a mixed element).
    """

    stiffness: sp.csr_matrix
    lift: sp.csr_matrix
    support: sp.csr_matrix
    negative: int = 0

    @property
    def dofs(self) -> int:
        """How many equations there are."""
        return int(self.stiffness.shape[0])


def assemble_system(
    mesh: Mesh,
    youngs_modulus: Array,
    poissons_ratio: Array,
    fixed: BoolArray,
    thickness: float = 1.0,
    attached: sp.csr_matrix | None = None,
) -> System:
    """The system of quadratic displacement elements with ``fixed`` (n dim,) dofs held at zero.

    ``attached``: upper triangle of a stiffness of all dofs to be added, N/mm.
    """
    whole = assemble_stiffness(mesh.points, mesh.cells, youngs_modulus, poissons_ratio, thickness)
    if attached is not None:
        whole = (whole + attached).tocsr()
    free = np.flatnonzero(~fixed)
    stiffness = whole[free][:, free].tocsr()
    stiffness.sort_indices()
    ones = np.ones(len(free))
    lift = sp.csr_matrix((ones, (free, np.arange(len(free)))), shape=(len(fixed), len(free)))
    support = _support_rows(whole, fixed, mesh.dimension)[:, free]
    return System(stiffness, lift, support)


def _support_rows(stiffness: sp.csr_matrix, fixed: BoolArray, dimension: int) -> sp.csr_matrix:
    """Rows (dim, dofs): sum over held dofs of K u, component by component."""
    indicator = np.zeros((stiffness.shape[0], dimension))
    held = np.flatnonzero(fixed)
    indicator[held, held % dimension] = 1.0
    total = stiffness @ indicator + stiffness.T @ indicator
    total -= stiffness.diagonal()[:, None] * indicator
    return sp.csr_matrix(total.T)
