"""One increment of the path: a frozen state and a motion in, an accepted increment out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.contact.laws import Certificate, certify, status_of
from fingerdesign.contact.newton import NewtonResult, newton
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.contact.sweeps import gauss_seidel
from fingerdesign.errors import SolverError

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


class ZoneExhausted(SolverError):
    """The contact reaches the rim of the candidate zone: a wider zone is needed."""


ACCEPT = 1e-8  # the laws; Newton ends near 1e-13, so a pass is never a close call
ACCEPT_BALANCE = 1e-6  # the model's own rounding, not the solver's (fem.model)
_CUTS = (2, 8, 32)  # pieces that carry the iterate, not the friction history, to the motion


@dataclass(frozen=True)
class ContactState:
    """What the past leaves: slip so far (m, dim - 1) mm, and the last forces as a first guess."""

    slip: Array
    multiplier: Array
    motion: Motion
    travelled: Array  # (m,) accumulated slip while in contact, mm

    @staticmethod
    def untouched(problem: ContactProblem) -> ContactState:
        m, dim = problem.shape
        return ContactState(
            np.zeros((m, dim - 1)), np.zeros((m, dim)), Motion(0.0, 0.0), np.zeros(m)
        )


@dataclass(frozen=True)
class Increment:
    """An accepted increment. Local components; forces N of the modelled part, motions mm."""

    motion: Motion
    multiplier: Array  # (m, dim)
    gap: Array  # (m,)
    slip_increment: Array  # (m, dim - 1)
    status: IntArray  # (m,) OPEN, STICK, SLIP
    force: Array  # (m, dim) nodal forces in x, y(, z)
    state: ContactState  # to start the next increment from
    iterations: int
    residual: float
    certificate: Certificate
    method: str


def solve_increment(problem: ContactProblem, state: ContactState, motion: Motion) -> Increment:
    """Forces and slips after ``motion`` (total, from touch), the friction history being ``state``.

    Evaluating twice gives the same answer: nothing is stored. Raises SolverError, with the reason,
    where no iterate passes the certificate or the candidate zone is exhausted.
    """
    offset = problem.offset(motion, state.slip)
    if not np.isfinite(offset).all():
        raise SolverError(f"the motion {motion} is not finite")
    result, method = _solve(problem, state, motion, offset)
    m, dim = problem.shape
    multiplier = result.multiplier
    local = (problem.compliance @ multiplier.reshape(-1)).reshape(m, dim) + offset
    force = problem.to_global(multiplier)
    free = ~problem.model.locked.any(axis=0)
    reaction = problem.model.reaction_readout @ force.reshape(-1)
    certificate = certify(
        multiplier,
        local,
        problem.self_compliance,
        problem.friction_coefficient,
        reaction[free],
        force.sum(axis=0)[free],
    )
    if not (certificate.laws <= ACCEPT and certificate.balance <= ACCEPT_BALANCE):
        raise SolverError(
            f"no accepted answer at approach {motion.approach:g}, shear {motion.shear:g} mm "
            f"(friction {problem.friction_coefficient:g}): {certificate} after "
            f"{result.iterations} iterations; use smaller increments"
        )
    _check_zone(problem, multiplier, local[:, 0], motion)
    status = status_of(multiplier, local, problem.self_compliance, problem.friction_coefficient)
    slip = local[:, 1:] + state.slip
    moved = np.linalg.norm(local[:, 1:], axis=1)
    travelled = np.where(multiplier[:, 0] > 0.0, state.travelled + moved, 0.0)
    return Increment(
        motion=motion,
        multiplier=multiplier,
        gap=local[:, 0],
        slip_increment=local[:, 1:],
        status=status,
        force=force,
        state=ContactState(slip, multiplier, motion, travelled),
        iterations=result.iterations,
        residual=result.residual,
        certificate=certificate,
        method=method,
    )


def _solve(
    problem: ContactProblem, state: ContactState, motion: Motion, offset: Array
) -> tuple[NewtonResult, str]:
    """Newton from the last forces; then by a walk of the motion; then from Gauss-Seidel."""
    friction, compliance = problem.friction_coefficient, problem.compliance
    result = newton(compliance, offset, friction, state.multiplier)
    if result.converged:
        return result, "newton"
    spent, best = result.iterations, result
    start_offset = problem.offset(state.motion, state.slip)
    for pieces in _CUTS:
        guess, failed = state.multiplier, False
        for piece in range(1, pieces + 1):
            part = start_offset + (offset - start_offset) * (piece / pieces)
            walked = newton(compliance, part, friction, guess)
            spent += walked.iterations
            guess = walked.multiplier
            failed = not walked.converged
        if not failed:
            return _counted(walked, spent), "newton, walked"
    for factor in (0.01, 0.5):
        result = newton(compliance, offset, friction, best.multiplier, factor=factor)
        spent += result.iterations
        if result.converged:
            return _counted(result, spent), "newton, other augmentation"
    for sweeps in (100, 1000):
        swept = gauss_seidel(compliance, offset, friction, best.multiplier, sweeps)
        spent += swept.iterations
        result = newton(compliance, offset, friction, swept.multiplier)
        spent += result.iterations
        if result.converged:
            return _counted(result, spent), "gauss-seidel, newton"
        best = min((swept, result, best), key=lambda each: each.residual)
    return _counted(best, spent), "none"


def _counted(result: NewtonResult, iterations: int) -> NewtonResult:
    return NewtonResult(result.multiplier, result.residual, iterations, result.converged)


def _check_zone(problem: ContactProblem, multiplier: Array, gap: Array, motion: Motion) -> None:
    rim = problem.model.rim
    if (multiplier[rim, 0] > 0.0).any():
        where = problem.model.points[rim & (multiplier[:, 0] > 0.0), 0]
        raise ZoneExhausted(
            f"the contact reaches the end of the candidate zone (x = {where[0]:.2f} mm) at "
            f"approach {motion.approach:g}, shear {motion.shear:g} mm; widen the zone"
        )
