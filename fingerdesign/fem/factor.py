"""The one seam to sparse direct solvers.

``Condensation(stiffness, rows)`` holds R K^-1 R^T for sparse functionals R, found without a
right-hand side per row: the functionals border the stiffness,

    [ K  R^T ]        Schur complement of K:  -D - R K^-1 R^T,
    [ R  -D  ]

which MKL PARDISO delivers with the factorisation, at a tenth more than K's factorisation alone. D,
a constant diagonal, keeps that complement regular where functionals repeat each other; it is taken
off afterwards. The factors stay for displacement fields. The order of elimination, over half of
the time in 3-D, stays for the next model of the same pattern: with other materials, or on a mesh
whose nodes have moved. Where MKL has no wheel (not x86-64), SciPy's SuperLU does the same: with the
border eliminated last, the last block of its factors is that complement. How long that takes hangs
on the order of elimination: nested dissection where pymetis is installed, else minimum degree,
which fills a 3-D model many times as much.
"""

import hashlib
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from ctypes import POINTER, byref, c_double, c_int32, c_int64
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.sparse import merged

# mm/N. It has the size of a soft finger's compliance, so that it costs the diagonal one rounding.
_SHIFT = 1.0
_TINY = 1e-13  # Relative to a diagonal entry: a smaller pivot is the rounding of zero.
_ONE_THREAD = 1_000_000  # With fewer entries a second thread gains next to nothing.
# Orders of models that are gone, the last one at the end, by their patterns: PARDISO, with 190 MB
# at 111k dofs, and its count of operations. They go before a model of another pattern takes memory,
# but for those of so many equations, the new model's among them.
_ORDERS: dict[bytes, tuple[Any, float]] = {}
_held = ContextVar("equations whose orders are held", default=0)

_BLOCK = 48  # Fields solved for at a time: of 64, 5 % less time and 30 MB more at 120k dofs.

_NOT_DEFINITE = (
    "the stiffness is not positive definite: the body is not fixed, or a material is unsound"
)
_PARDISO_ERRORS = {
    -2: "not enough memory for the factorisation; coarsen the mesh",
    -4: _NOT_DEFINITE,
}


class Condensation:
    """R K^-1 R^T for K by its upper triangle (n, n) and R (r, n), both CSR with sorted indices.

    ``matrix`` (r, r) is symmetric, zero where a row is empty; ``operations``: floating-point ones
    of the factorisation with its border. ``negative``: how many eigenvalues of
    K are below zero, the pressures of a mixed element. Raises SolverError where K has others (a
    body that can move as a whole, a negative modulus) or memory runs out.
    """

    def __init__(self, stiffness: sp.csr_matrix, rows: sp.csr_matrix, negative: int = 0) -> None:
        self.matrix: Array
        self.operations = float("nan")
        self._size = stiffness.shape[0]
        self._some = np.flatnonzero(np.diff(rows.indptr))
        self._count = rows.shape[0]
        self._rows, self._negative = rows[self._some].tocsr(), negative
        self._order: IntArray | None = None
        self._pardiso: Any = None
        self._pattern = b""  # of what PARDISO has factored; empty where it failed
        self._superlu: Any = None
        self.renew(stiffness)

    def renew(self, stiffness: sp.csr_matrix) -> None:
        """Factor another stiffness with the same pattern; the order of elimination is used again.

        That order takes half of the time in 3-D. The old factors are lost, also where this raises.
        """
        self._bordered = _border(stiffness, self._rows)
        if has_pardiso():  # numbers from 1; from 0, it holds places of its own, 60 MB at 120k dofs
            self._bordered.indptr += 1
            self._bordered.indices += 1
        border = self._rows.shape[0]
        work = self._by_pardiso if has_pardiso() else self._by_superlu
        schur = work(stiffness, border, self._negative)
        schur = -0.5 * (schur + schur.T)
        schur[np.diag_indices(border)] -= _SHIFT
        self.matrix = np.zeros((self._count, self._count))
        self.matrix[np.ix_(self._some, self._some)] = schur

    def _by_pardiso(self, stiffness: sp.csr_matrix, border: int, negative: int) -> Array:
        phase, pattern = 22, self._pattern
        self._pattern = b""
        if self._pardiso is None:
            pattern = _pattern(self._bordered, border)
            self._pardiso, self.operations = _ORDERS.pop(pattern, (None, float("nan")))
        if self._pardiso is None:
            phase = 12
            _forget_orders(self._size + border)
            self._pardiso = _solver()
            self._pardiso.set_iparm(36, 2)  # the Schur complement, and factors that solve later
            self._pardiso.iparm[18] = -1  # asks for the count of operations, which is in millions
            self._pardiso.perm = np.zeros(self._size + border, dtype=np.int32)
            self._pardiso.perm[self._size :] = 1
        schur = self._phase(phase, np.zeros((border, border)))
        if phase == 12:
            self.operations = 1e6 * float(self._pardiso.iparm[18])
        positive = int(self._pardiso.iparm[21])  # eigenvalues > 0 of the bordered matrix: K's own
        perturbed = int(self._pardiso.iparm[13])
        if positive != self._size - negative or perturbed:
            raise SolverError(_NOT_DEFINITE)
        self._pattern = pattern
        return schur

    def _by_superlu(self, stiffness: sp.csr_matrix, border: int, negative: int) -> Array:
        slow = "pypardiso is not installed: using SuperLU, 3 to 5 times slower in 3-D"
        lacking = "" if find_spec("pymetis") else ", and without pymetis far slower still"
        warnings.warn(slow + lacking, stacklevel=3)
        size = self._size
        if self._order is None:
            self._order = np.append(_elimination_order(stiffness), np.arange(size, size + border))
        self._superlu = _superlu(_full(self._bordered)[self._order][:, self._order])
        lower, upper = self._superlu.L, self._superlu.U
        pivots = upper.diagonal()[:size]  # their signs are those of K's eigenvalues
        tiny = np.abs(pivots) < _TINY * np.abs(stiffness.diagonal()[self._order[:size]])
        swapped = self._superlu.perm_r != np.arange(size + border)
        if tiny.any() or swapped.any() or int((pivots < 0.0).sum()) != negative:
            raise SolverError(_NOT_DEFINITE)
        self.operations = float((np.diff(lower.indptr).astype(float) ** 2).sum())
        schur: Array = (lower[size:, size:] @ upper[size:, size:]).toarray()
        self._schur = schur
        return schur

    def solve(self, loads: Array) -> Array:
        """K^-1 loads for loads (n, k)."""
        if self._superlu is not None:
            # Twice: with the rows' values of K^-1 loads on the border, the border carries no load.
            border = self._swept(loads, np.zeros((len(self._schur), loads.shape[1])))[self._size :]
            return self._swept(loads, -self._schur @ border)[: self._size]
        bordered = np.zeros((loads.shape[1], self._bordered.shape[0]))
        bordered[:, : self._size] = loads.T
        forward = self._phase(331, bordered)
        forward[:, self._size :] = 0.0  # the border carries no load: K alone is solved
        return np.ascontiguousarray(self._phase(333, forward)[:, : self._size].T)

    def fields(self, rows: IntArray) -> Array:
        """K^-1 R^T of a unit force on each of some rows (k,): half of a solve each. One field a
        column (n + 1, k), unknown by unknown in memory; the last row is zero."""
        found = np.zeros((self._size + 1, len(rows)))
        loads = np.zeros((min(_BLOCK, len(rows)), self._bordered.shape[0]))
        answers = np.zeros_like(loads)
        for start in range(0, len(rows), _BLOCK):
            some = slice(start, start + _BLOCK)
            border = np.equal.outer(rows[some], self._some).astype(float)
            if self._superlu is not None:
                found[:-1, some] = self.solve(self._rows.T @ border.T)
                continue
            loads = loads[: len(border)]  # PARDISO leaves them as they are.
            loads[:, self._size :] = -border
            found[:-1, some] = self._phase(333, loads, answers[: len(border)])[:, : self._size].T
        return found

    def _swept(self, loads: Array, border: Array) -> Array:
        """Solve the bordered system with SuperLU."""
        assert self._order is not None
        found = np.empty((len(self._order), loads.shape[1]))
        found[self._order] = self._superlu.solve(np.vstack([loads, border])[self._order])
        return found

    def _phase(self, phase: int, loads: Array, found: Array | None = None) -> Array:
        """A phase of PARDISO with right-hand sides (k, n + r), and its answers, in ``found``."""
        self._pardiso.set_phase(phase)
        found = np.zeros_like(loads) if found is None else found
        _call(self._pardiso, self._bordered, loads, found)
        return found

    def __del__(self) -> None:
        # At the interpreter's end its memory goes anyway, and pypardiso can import no more.
        solver = getattr(self, "_pardiso", None)
        if solver is None or sys.is_finalizing():
            return
        if self._pattern:
            self._phase(0, np.zeros((1, 1)))  # The factors go, the order stays.
            _forget_order(self._pattern)
            _forget_orders(len(solver.perm))
            _ORDERS[self._pattern] = solver, self.operations
        else:
            solver.free_memory(everything=True)


@contextmanager
def orders_held(equations: int) -> Iterator[None]:
    """Meanwhile hold orders of elimination of so many equations, for meshes that take turns."""
    token = _held.set(equations)
    try:
        yield
    finally:
        _held.reset(token)


def has_pardiso() -> bool:
    """True where MKL PARDISO can be used."""
    return find_spec("pypardiso") is not None


def load_solver() -> None:
    """Load PARDISO ahead of need: its libraries take as long as a small factorisation."""
    if has_pardiso():
        _solver()


def _forget_orders(coming: int) -> None:
    """Free the first orders until there is room for one of so many equations."""
    for pattern in list(_ORDERS):
        held = sum(len(kept[0].perm) for kept in list(_ORDERS.values()))
        if held + coming <= _held.get():
            break
        _forget_order(pattern)


def _forget_order(pattern: bytes) -> None:
    if kept := _ORDERS.pop(pattern, None):  # Another thread may have it by now.
        kept[0].free_memory(everything=True)


def _pattern(bordered: sp.csr_matrix, border: int) -> bytes:
    """Digest of the places of a bordered matrix's entries, and of its border's rows."""
    digest = hashlib.blake2b(f"{border}".encode(), digest_size=16)
    digest.update(bordered.indptr.tobytes())
    digest.update(bordered.indices.tobytes())
    return digest.digest()


def _full(upper: sp.csr_matrix) -> sp.csr_matrix:
    return sp.csr_matrix(upper + sp.triu(upper, k=1).T)


def _superlu(matrix: sp.csr_matrix) -> Any:
    """Factors in the order given, without pivoting."""
    from scipy.sparse.linalg import splu

    how = {"permc_spec": "NATURAL", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    try:
        return splu(matrix.tocsc(), **how)
    except RuntimeError as error:  # "Factor is exactly singular"
        raise SolverError(f"factorisation failed: {_NOT_DEFINITE}") from error
    except MemoryError as error:
        raise SolverError(f"factorisation failed: {_PARDISO_ERRORS[-2]}") from error


def _elimination_order(stiffness: sp.csr_matrix) -> IntArray:
    """Which unknown is eliminated first, second, ... (n,), so that factors stay sparse."""
    full = _full(stiffness)
    if find_spec("pymetis"):
        import pymetis

        full = sp.csr_matrix(full - sp.diags_array(full.diagonal()))
        full.eliminate_zeros()
        graph = pymetis.CSRAdjacency(full.indptr, full.indices)
        return np.asarray(pymetis.nested_dissection(graph)[0], dtype=np.int64)
    from scipy.sparse.linalg import spilu

    # An incomplete factorisation that drops all, of the same places: SuperLU's order alone.
    full.data[:] = 1.0
    places = (full + sp.diags_array(np.full(len(full.indptr) - 1, 1e6))).tocsc()
    ordered = spilu(places, drop_tol=1e300, fill_factor=1.0, permc_spec="MMD_AT_PLUS_A")
    return np.argsort(ordered.perm_c)


def _solver() -> Any:
    _point_to_mkl()
    from pypardiso import PyPardisoSolver

    # Symmetric indefinite, as the bordered matrix is; as fast as Cholesky on the same matrix.
    solver = PyPardisoSolver(mtype=-2)
    solver.set_iparm(1, 1)  # our own settings from here on
    solver.set_iparm(2, 2)  # nested dissection (METIS)
    return solver


def _call(solver: Any, matrix: sp.csr_matrix, loads: Array, found: Array) -> None:
    """Call PARDISO by itself: pypardiso's call copies the matrix's places and turns the answers."""
    error, numbers = c_int32(0), (1, 1, solver.mtype, solver.phase, matrix.shape[0])
    places = [each.astype(np.int32, copy=False) for each in (matrix.indptr, matrix.indices)]
    arrays = [_start(each, c_int32) for each in (*places, solver.perm, solver.iparm)]
    # MKL's threads wait by spinning. Measured on a section of 34k dofs: with one thread 0.4 s of
    # processor time for 0.55 with two, and at a load of 9 on two cores 1.2 s of waiting for 1.75.
    limit = solver.libmkl.MKL_Set_Num_Threads_Local
    before = limit(1) if len(matrix.data) < _ONE_THREAD else None
    try:
        solver.libmkl.pardiso(
            _start(solver.pt, c_int64),
            *(byref(c_int32(number)) for number in numbers),
            _start(matrix.data, c_double),
            *arrays[:3],
            byref(c_int32(len(loads))),
            arrays[3],
            byref(c_int32(solver.msglvl)),
            _start(loads, c_double),
            _start(found, c_double),
            byref(error),
        )
    finally:
        if before is not None:
            limit(before)
    if error.value:
        reason = _PARDISO_ERRORS.get(error.value, f"PARDISO error {error.value}")
        raise SolverError(f"factorisation failed: {reason}")


def _start(values: Any, kind: Any) -> Any:
    return values.ctypes.data_as(POINTER(kind))


def _border(stiffness: sp.csr_matrix, rows: sp.csr_matrix) -> sp.csr_matrix:
    """Upper triangle of [[K, R^T], [R, -D]] in CSR, sorted."""
    size, border = stiffness.shape[0], rows.shape[0]
    turned, own = rows.T.tocoo(), size + np.arange(border)
    values = np.append(turned.data, np.full(border, -_SHIFT))
    where = np.append(turned.row, own), np.append(size + turned.col, own)
    added = sp.coo_matrix((values, where), shape=(size + border, size + border))
    return merged(stiffness, added.tocsr())


def _point_to_mkl() -> None:
    """Tell pypardiso where MKL is: its own search walks the whole environment."""
    if "PYPARDISO_MKL_RT" in os.environ:
        return
    for folder in ("lib", "Library/bin"):
        found = sorted(Path(sys.prefix, folder).glob("*mkl_rt*"))
        if found:
            os.environ["PYPARDISO_MKL_RT"] = str(found[0])
            return
