"""The one seam to sparse direct solvers.

``flexibility(stiffness, rows)`` returns R K^-1 R^T for sparse functionals R without a right-hand
side per row: the functionals border the stiffness,

    [ K  R^T ]        Schur complement of K:  0 - R K^-1 R^T,
    [ R   0  ]

which MKL PARDISO delivers with the factorisation. Only K is eliminated, and K is positive definite,
so Cholesky needs no pivoting. Where MKL has no wheel (not x86-64), SuperLU does the same work with
one solve per row, many times slower, and says so.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.errors import SolverError

Array = NDArray[np.float64]


def flexibility(stiffness: sp.csr_matrix, rows: sp.csr_matrix) -> Array:
    """R K^-1 R^T, symmetric (r, r), for K by its upper triangle (n, n) and R (r, n), both CSR.

    Raises SolverError where K is not positive definite (a body that is not held, a negative
    modulus) or memory runs out.
    """
    if has_pardiso():
        return _pardiso_flexibility(stiffness, rows)
    _warn_slow()
    factors = _superlu(stiffness)
    matrix = np.zeros((rows.shape[0], rows.shape[0]))
    for start in range(0, rows.shape[0], 64):
        part = slice(start, start + 64)
        matrix[:, part] = rows @ factors.solve(rows[part].T.toarray())
    return 0.5 * (matrix + matrix.T)


def solve(stiffness: sp.csr_matrix, loads: Array) -> Array:
    """K^-1 loads for loads (n, k), K by its upper triangle in CSR: one factorisation."""
    if not has_pardiso():
        _warn_slow()
        return np.asarray(_superlu(stiffness).solve(loads))
    solver = _solver()
    solver.set_phase(13)
    try:
        return _call(solver, stiffness, np.asfortranarray(loads))
    finally:
        solver.free_memory(everything=True)


def factorise(stiffness: sp.csr_matrix) -> None:
    """Factor K and drop the factors: what condensing is compared with."""
    if not has_pardiso():
        _warn_slow()
        _superlu(stiffness)
        return
    solver = _solver()
    solver.set_phase(12)
    try:
        _call(solver, stiffness, np.zeros((stiffness.shape[0], 1), order="F"))
    finally:
        solver.free_memory(everything=True)


def has_pardiso() -> bool:
    """True where MKL PARDISO can be used."""
    return importlib.util.find_spec("pypardiso") is not None


def _warn_slow() -> None:
    warnings.warn(
        "pypardiso is not installed: using SuperLU, about ten times slower in 3-D", stacklevel=3
    )


def _superlu(stiffness: sp.csr_matrix) -> Any:
    from scipy.sparse.linalg import splu

    full = stiffness + sp.triu(stiffness, k=1).T
    return splu(full.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0)


def _pardiso_flexibility(stiffness: sp.csr_matrix, rows: sp.csr_matrix) -> Array:
    size, kept = stiffness.shape[0], rows.shape[0]
    solver = _solver()
    solver.set_iparm(36, 1)  # Schur complement of the dofs marked in perm
    solver.perm = np.zeros(size + kept, dtype=np.int32)
    solver.perm[size:] = 1
    solver.set_phase(12)
    try:
        schur = _call(solver, _border(stiffness, rows), np.zeros((kept, kept), order="F"))
    finally:
        solver.free_memory(everything=True)
    return -0.5 * (schur + schur.T)


def _solver() -> Any:
    _point_to_mkl()
    from pypardiso import PyPardisoSolver

    solver = PyPardisoSolver(mtype=2)
    solver.set_iparm(1, 1)  # our own settings from here on
    solver.set_iparm(2, 2)  # nested dissection (METIS)
    return solver


def _call(solver: Any, matrix: sp.csr_matrix, right_hand_side: Array) -> Array:
    from pypardiso.pardiso_wrapper import PyPardisoError

    try:
        return np.asarray(solver._call_pardiso(matrix, right_hand_side))
    except PyPardisoError as error:
        reason = _PARDISO_ERRORS.get(int(error.value), f"PARDISO error {error.value}")
        raise SolverError(f"factorisation failed: {reason}") from None


def _border(stiffness: sp.csr_matrix, rows: sp.csr_matrix) -> sp.csr_matrix:
    """Upper triangle of [[K, R^T], [R, 0]] with its zero diagonal stored, sorted."""
    unit = sp.identity(rows.shape[0], format="csr")
    bordered = sp.bmat([[stiffness, rows.T.tocsr()], [None, unit]], format="csr")
    bordered.sort_indices()
    bordered.data[bordered.indptr[stiffness.shape[0] : -1]] = 0.0
    return bordered


def _point_to_mkl() -> None:
    """Tell pypardiso where MKL is: its own search walks the whole environment."""
    if "PYPARDISO_MKL_RT" in os.environ:
        return
    for folder in ("lib", "Library/bin"):
        found = sorted(Path(sys.prefix, folder).glob("*mkl_rt*"))
        if found:
            os.environ["PYPARDISO_MKL_RT"] = str(found[0])
            return


_PARDISO_ERRORS = {
    -2: "not enough memory for the factorisation; coarsen the mesh",
    -4: "the stiffness is not positive definite: the body is not held, or a material is unsound",
}
