"""Force control: the motion at which the object presses and pulls with given forces (numpy only).

Unknown are approach and shear (or the approach alone, the shear being held); equations are

    F_n(approach, shear) = normal,   F_t(approach, shear) = tangential       (whole finger)

solved by Newton with the increments' own tangent, shortened where the residual does not fall. Every
trial starts from the same frozen state: friction history moves once, with the accepted increment.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fingerdesign.contact.increment import (
    ContactState,
    Increment,
    Workspace,
    ZoneExhausted,
    solve_increment,
)
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.contact.tangent import force_response
from fingerdesign.errors import SolverError

Array = NDArray[np.float64]

_TOLERANCE = 1e-9  # of the normal force asked for
_ITERATIONS = 60
_SHORTEST = 1e-6  # of a Newton step
# Stiffness against shear over that of the first trial: below it friction carries no more.
_SLACK = 1e-7


class NoEquilibrium(SolverError):
    """No motion gives the forces asked for: friction can't carry them, or nothing is touched."""


@dataclass(frozen=True)
class Forces:
    """Forces on the whole finger, N: normal > 0 in compression, tangential > 0 toward +x.

    tangential None: the shear is held instead. ``held`` gives the amplitudes that are not found
    (shear where it is held, shear_z, twist, load).
    """

    normal: float
    tangential: float | None = None
    held: Motion = field(default_factory=lambda: Motion(0.0, 0.0))

    def toward(self, target: Forces, share: float) -> Forces:
        """The forces ``share`` of the way to ``target``."""

        def between(first: float, last: float) -> float:
            return first + share * (last - first)

        sideways = target.tangential
        if sideways is not None:
            sideways = between(self.tangential or 0.0, sideways)
        held = self.held.toward(target.held, share)
        return Forces(between(self.normal, target.normal), sideways, held)

    def __str__(self) -> str:
        sideways = "" if self.tangential is None else f", {self.tangential:g} N tangential"
        return f"{self.normal:g} N normal{sideways}"


def solve_forces(
    problem: ContactProblem,
    state: ContactState,
    forces: Forces,
    workspace: Workspace | None = None,
) -> Increment:
    """The increment from ``state`` whose contact forces are ``forces``; its motion is the answer.

    Raises NoEquilibrium where none exists (complete slip under a tangential force that friction
    cannot carry), ZoneExhausted where the contact outgrows the candidates, SolverError where no
    motion was found although nothing shows that none exists.
    """
    if not (np.isfinite(forces.normal) and forces.normal > 0.0):
        raise NoEquilibrium(f"{forces}: a contact can only press; the normal force must be over 0")
    search = _Search(problem, state, forces, workspace or Workspace())
    return search.run()


class _Search:
    def __init__(
        self, problem: ContactProblem, state: ContactState, forces: Forces, workspace: Workspace
    ) -> None:
        self.problem, self.state, self.forces = problem, state, forces
        self.workspace = workspace
        self.free = [0] if forces.tangential is None else [0, 1]
        wanted = [forces.normal, forces.tangential or 0.0]
        self.wanted = np.array(wanted)[self.free]
        self.exhausted: ZoneExhausted | None = None

    def run(self) -> Increment:
        unknown = self._start()
        trial = self._solve(unknown)
        if trial is None:
            raise self._failure(None)
        stiffest = 0.0
        for _ in range(_ITERATIONS):
            missing = self.wanted - self._resultant(trial)
            if np.abs(missing).max() <= _TOLERANCE * self.forces.normal:
                return trial
            tangent = self._tangent(trial)
            if len(self.free) == 2:
                slack = self._shear_stiffness(tangent)
                stiffest = max(stiffest, slack)
                if slack <= _SLACK * stiffest or not np.isfinite(slack):
                    raise self._failure(trial)
            try:
                step: Array = np.linalg.solve(tangent, missing).astype(float)
            except np.linalg.LinAlgError:
                raise self._failure(trial) from None
            better = self._line_search(unknown, step, float(np.abs(missing).max()))
            if better is None:
                raise self._failure(trial)
            unknown, trial = better
        raise self._failure(trial)

    def _start(self) -> Array:
        """The last motion, brought just into contact where it is not."""
        last = self.state.motion
        unknown = np.array([last.approach, last.shear])[self.free]
        gap = self.problem.offset(self._motion(unknown), self.state.slip)[:, 0].min()
        if not (self.state.multiplier[:, 0] > 0.0).any():
            share = self.forces.normal / self.problem.model.symmetry_factor
            overlap = 0.1 * share * float(self.problem.self_compliance.min())
            unknown[0] += gap + overlap
        return unknown

    def _motion(self, unknown: Array) -> Motion:
        held = self.forces.held
        shear = float(unknown[1]) if len(unknown) == 2 else held.shear
        return replace(held, approach=float(unknown[0]), shear=shear)

    def _solve(self, unknown: Array) -> Increment | None:
        try:
            return solve_increment(self.problem, self.state, self._motion(unknown), self.workspace)
        except ZoneExhausted as exhausted:
            self.exhausted = exhausted
        except SolverError:
            pass
        self.workspace.inverse = None
        return None

    def _resultant(self, increment: Increment) -> Array:
        force = self.problem.model.total_force(increment.force)
        return np.array([-force[1], force[0]])[self.free]

    def _tangent(self, increment: Increment) -> Array:
        """d(F_n, F_t) / d(approach, shear) of the free ones, N/mm."""
        changes = force_response(
            self.problem, increment, self.problem.modes[self.free], self.workspace
        )
        columns = [
            self.problem.model.total_force(self.problem.to_global(change)) for change in changes
        ]
        rows = np.array([[-column[1], column[0]] for column in columns]).T
        return np.asarray(rows[self.free])

    @staticmethod
    def _shear_stiffness(tangent: Array) -> float:
        """dF_t / d(shear) at constant normal force."""
        if tangent[0, 0] == 0.0:
            return 0.0
        return float(tangent[1, 1] - tangent[1, 0] * tangent[0, 1] / tangent[0, 0])

    def _line_search(
        self, unknown: Array, step: Array, missing: float
    ) -> tuple[Array, Increment] | None:
        length = 1.0
        while length >= _SHORTEST:
            trial = self._solve(unknown + length * step)
            if trial is not None:
                left = float(np.abs(self.wanted - self._resultant(trial)).max())
                if left <= (1.0 - 1e-3 * length) * missing:
                    return unknown + length * step, trial
            length *= 0.5
        return None

    def _failure(self, trial: Increment | None) -> SolverError:
        friction = self.problem.friction_coefficient
        if trial is not None and len(self.free) == 2:
            force = self.problem.model.total_force(trial.force)
            sliding = trial.multiplier[:, 0] > 0.0
            slips = trial.state.sliding[sliding] > 0.0
            if slips.mean() > 0.95:
                normal = self.forces.normal
                return NoEquilibrium(
                    f"no motion gives {self.forces}: complete slip. At friction {friction:g} the "
                    f"contact carries {-force[0] / force[1] * normal:.4g} N tangential with "
                    f"{normal:g} N normal; ask for less, press harder, or prescribe the motion"
                )
        if self.exhausted is not None:
            return self.exhausted
        return SolverError(f"no motion was found that gives {self.forces}: use smaller increments")
