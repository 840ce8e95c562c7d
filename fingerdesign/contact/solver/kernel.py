"""Following increments, compiled: kernel.c behind tracking.py's Tracker.

In the plane nearly all of a step's time is the overhead of numpy's calls, in 3-D a third. Where a C
compiler is at hand kernel.c does the same work; where none is, tracking.py does it, and either way
the answers agree to rounding.
"""

import ctypes
import weakref
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cython_blas, cython_lapack

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.contact.friction import ByPressure, Coulomb, Friction
from fingerdesign.contact.laws import Certificate, coded, lengths
from fingerdesign.contact.outcome import Answer, Outcome
from fingerdesign.contact.problem import ContactProblem, ContactState
from fingerdesign.contact.solver.active_inverse import ActiveInverse
from fingerdesign.contact.solver.tracking import LastIncrement, Start, Tracker, WorkingSet
from fingerdesign.runtime.native import compiled

_ROUTINES = {
    cython_blas: ("dsymv", "dgemv", "dgemm", "dtrmm"),
    cython_lapack: ("dpotrf", "dtrtri", "dgetrf", "sgetrf", "dgetrs", "sgetrs"),
}
_NONE, _FOUND, _NEEDS_A_BASE = range(3)  # The results of following.
_AT, _REAL, _INT = ctypes.c_void_p, ctypes.c_double, ctypes.c_int
_AT_ONCE = 3  # Open nodes that join the working set at a time.
_SIGNATURES = {
    "bind_blas": (None, _AT),
    "follower_new": (_AT, _INT, _INT, _AT, _REAL, _AT, _AT),
    "follower_free": (None, _AT),
    "follower_meet": (None, _AT, _AT),
    "follower_base": (None, _AT, _INT, _AT, _AT),
    "follower_begin": (_INT, *6 * [_AT], _REAL, _INT, _INT, _REAL, *3 * [_AT]),
    "follower_go": (_INT, _AT, _INT),
    "follower_border": (_INT, _AT, _AT, _INT, _AT),
    "follower_runs_short": (_INT, _AT),
    "follower_needed": (_AT, _AT),
    "follower_gap": (_AT, _AT),
    "follower_residual": (_REAL, _AT),
    "follower_iterations": (_INT, _AT),
    "account_for": (_INT, *10 * [_AT]),
}


@cache
def kernel() -> ctypes.CDLL | None:
    """The compiled file with SciPy's BLAS bound to it; None where it cannot be had."""
    library = compiled(Path(__file__).with_name("kernel.c"))
    if library is None:
        return None
    for name, (result, *arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    pointers = [_routine(module, name) for module, names in _ROUTINES.items() for name in names]
    library.bind_blas((_AT * len(pointers))(*pointers))
    return library if all(pointers) else None


def _routine(module: Any, name: str) -> int | None:
    """Address of one of SciPy's Fortran routines; None where its integers are not C's."""
    capsule = module.__pyx_capi__[name]
    named, pointer = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
    named.restype, named.argtypes = ctypes.c_char_p, [ctypes.py_object]
    pointer.restype, pointer.argtypes = _AT, [ctypes.py_object, ctypes.c_char_p]
    types = named(capsule)
    return pointer(capsule, types) if b"int *" in types.replace(b"_int *", b"") else None


class _Law(ctypes.Structure):
    """Friction in the layout of kernel.c; no areas: Coulomb's law."""

    _fields_ = [
        *((name, _REAL) for name in ("coefficient", "strength", "cap", "exponent", "reference")),
        ("steepest", _REAL),
        ("areas", _AT),
        ("shares", _AT),
    ]


def _law_of(friction: Friction) -> tuple[_Law, tuple[Array | None, Array | None]]:
    """The law, and the areas and shares that must outlive it."""
    areas: Array | None = None
    if isinstance(friction, Coulomb):
        own, factor = (1.0, 0.0, np.inf, 0.0, 1.0, np.inf), friction.coefficient
        if not isinstance(factor, np.ndarray):
            own, factor = (factor, *own[1:]), 1.0
    else:
        assert isinstance(friction, ByPressure)
        law, factor = friction.law, friction.shares
        own = law.coefficient, law.strength, law.cap, law.exponent, law.reference, law.steepest
        areas = np.ascontiguousarray(friction.areas, dtype=np.float64)
    shares: Array | None = None
    if isinstance(factor, np.ndarray):
        shares = np.ascontiguousarray(factor, dtype=np.float64)
    places = [None if each is None else address(each) for each in (areas, shares)]
    return _Law(*own, *places), (areas, shares)


class _Judged(ctypes.Structure):
    """The problem's data in the layout of kernel.c."""

    _fields_ = [
        *((name, _INT) for name in ("m", "dim")),
        ("typical", _REAL),
        ("law", _Law),
        *((name, _AT) for name in ("self_compliance", "frames", "readout", "balanced", "rim")),
    ]


class CompiledTracker(Tracker):
    """A Tracker whose increments the kernel follows."""

    starts = True

    def __init__(
        self, library: ctypes.CDLL, compliance: Array, self_compliance: Array, friction: Friction
    ) -> None:
        super().__init__(compliance, self_compliance, friction)
        self._library = library
        m = len(self_compliance)
        law, self._fields = _law_of(friction)
        self._follower = library.follower_new(
            *(m, len(compliance) // m, ctypes.addressof(law), self._length),
            *(address(compliance), address(self._rho)),
        )
        if not self._follower:
            raise MemoryError(f"no memory to follow {m} contact nodes")
        self._end = weakref.finalize(self, library.follower_free, self._follower)
        self._bound: WorkingSet | None = None
        self._problem: ContactProblem | None = None
        self._about: tuple[_Judged, tuple[Array | None, ...]]

    def meet(self, friction: Friction) -> None:
        super().meet(friction)
        law, self._fields = _law_of(friction)
        self._library.follower_meet(self._follower, ctypes.addressof(law))

    def start(self, offset: Array, guess: Array) -> Answer | None:
        largest = float(guess[:, 0].max(initial=0.0))
        if not largest > 0.0:
            return None
        yielded = (self.compliance @ guess.reshape(-1)).reshape(guess.shape)
        limit = self.friction.bound(guess[:, 0], 1.0 - 1e-9)
        status = coded(lengths(guess[:, 1:]) >= limit, guess[:, 0] > 0.0)
        none = np.zeros(0)
        ahead = np.zeros_like(guess)
        known = LastIncrement(guess, yielded, status, ahead, none, none, none, yielded, largest)
        try:
            return self._follow(known, offset, Start(1.0))
        except np.linalg.LinAlgError:
            self.base = None
            return None

    def _follow(self, known: LastIncrement, offset: Array, start: Start) -> Answer | None:
        library, follower = self._library, self._follower
        self._bind(self.base)
        out = np.empty((3, *offset.shape))
        given = offset, known.multiplier, known.yielded, known.status, known.ahead
        how = known.largest, start.turned, start.trial, start.share
        came = library.follower_begin(follower, *map(address, given), *how, *map(address, out))
        while came == _NEEDS_A_BASE:
            self._bind(self._bring_base(*self._required(), _AT_ONCE))
            came = library.follower_go(follower, True)
        if came != _FOUND:
            return None
        residual = library.follower_residual(follower)
        iterations = library.follower_iterations(follower)
        if library.follower_runs_short(follower):
            self._bring_base(*self._required(), widen=True)
        return Answer(out[0], out[1], out[2], residual, iterations)

    def _required(self) -> tuple[BoolArray, Array]:
        """Nodes that the working set must hold, and all nodes' gaps (m,)."""
        m, library = len(self._rho), self._library
        needed = ctypes.string_at(library.follower_needed(self._follower), m)
        gap = ctypes.string_at(library.follower_gap(self._follower), 8 * m)
        return np.frombuffer(needed, dtype=np.bool_).copy(), np.frombuffer(gap)

    def _inverse_on(self, base: WorkingSet, nodes: IntArray, dim: int) -> ActiveInverse:
        """Bordered by the kernel where nodes only join."""
        joins = nodes[~base.inside[nodes]]
        k = len(base.nodes) + len(joins)
        if k == len(nodes) and len(joins):
            self._bind(base)
            inverse = self._inverses((k * dim, k * dim))
            if self._library.follower_border(
                self._follower, address(joins), len(joins), address(inverse)
            ):
                return ActiveInverse(np.concatenate([base.nodes, joins]), inverse)
        return super()._inverse_on(base, nodes, dim)

    def outcome(self, problem: ContactProblem, past: ContactState, found: Answer) -> Outcome:
        m, dim = found.motion.shape
        n = m * dim
        reals, codes = np.empty(5 + 3 * n + m), np.empty((2, m), dtype=np.int64)
        given = [found.multiplier, found.yielded, found.motion, self._before(past.slip, found)]
        given += [past.slip, past.travelled, past.sliding]
        whole = [np.ascontiguousarray(array, dtype=np.float64) for array in given]
        at_rim = self._library.account_for(
            self._judged(problem), *map(address, whole), address(reals), address(codes)
        )
        *laws, largest = reals[:5].tolist()
        slip = reals[5 + 2 * n : 5 + 3 * n - m]
        return Outcome(
            Certificate(*laws),
            reals[5 : 5 + n].reshape(m, dim),
            codes[0],
            codes[1],
            reals[5 + n : 5 + 2 * n].reshape(m, dim),
            largest,
            bool(at_rim),
            slip.reshape(m, dim - 1),
            reals[5 + 3 * n - m : 5 + 3 * n],
            reals[5 + 3 * n :],
        )

    def _judged(self, problem: ContactProblem) -> int:
        """Address of what outcomes of a problem are made with."""
        last, model = self._problem, problem.model
        # A rubber's memory makes a problem a step, on the same finger in the same frames.
        if (
            last is None
            or last.model is not model
            or last.frames is not problem.frames
            or last.law != problem.law
            or last.friction_share is not problem.friction_share
        ):
            own = problem.self_compliance
            sources = [own, problem.frames, model.reaction_readout, model.balanced, model.rim]
            kinds = [np.float64, np.float64, np.float64, np.bool_, np.bool_]
            arrays = [np.ascontiguousarray(*each) for each in zip(sources, kinds, strict=True)]
            law, fields = _law_of(problem.friction)
            judged = _Judged(*problem.shape, problem.typical_compliance, law, *map(address, arrays))
            self._problem, self._about = problem, (judged, (*arrays, *fields))
        return ctypes.addressof(self._about[0])

    def _bind(self, base: WorkingSet | None) -> None:
        if base is not self._bound:
            self._bound = base
            given: tuple[int, int | None, int | None] = 0, None, None
            if base is not None:
                given = len(base.nodes), address(base.nodes), address(base.inverse)
            self._library.follower_base(self._follower, *given)


def address(array: NDArray[Any]) -> int:
    """Address of a contiguous array's first element."""
    try:
        # A third of the other's time.
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    except (TypeError, ValueError):  # read-only, or empty
        return int(array.ctypes.data)


def tracker_of(compliance: Array, self_compliance: Array, friction: Friction) -> Tracker:
    """Build the compiled tracker, or the numpy one where there is no compiler."""
    library = kernel()
    if library is None:
        return Tracker(compliance, self_compliance, friction)
    return CompiledTracker(library, compliance, self_compliance, friction)
