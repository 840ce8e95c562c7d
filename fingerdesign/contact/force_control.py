"""Force control: the motion at which the object presses and pulls with given forces (numpy only).

Unknown are approach and shear, or the approach alone where the shear is prescribed. The equations

    F_n(approach, shear) = normal,   F_t(approach, shear) = tangential       (whole finger)

are solved by Newton with the increments' own tangent; a step is shortened where the residual does
not fall. Every trial starts from the same frozen state: the friction history moves once, with the
accepted increment.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import Increment, Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.tangent import stiffness
from fingerdesign.errors import SolverError

TOLERANCE = 1e-9  # Relative to the target normal force.
_ITERATIONS = 60
_SHORTEST = 1e-3  # The shortest piece of a Newton step.
_DOUBLINGS, _BISECTIONS = 12, 60
_SHARES = 8
# After so many trials that outgrow the candidates the answer lies outside them too.
_OUTSIDE = 3
# Stiffness against shear over that of the stiffest trial: below it friction carries no more.
_SLACK = 1e-7


class NoEquilibrium(SolverError):
    """No motion gives the target forces: friction cannot carry them, or there is no contact."""


@dataclass(frozen=True)
class Forces:
    """Forces on the whole finger, N: normal > 0 in compression, tangential > 0 toward +x.

    tangential None: the shear is prescribed instead. ``held`` gives the amplitudes that are not
    unknown (shear where it is prescribed, shear_z, twist, load).
    """

    normal: float
    tangential: float | None = None
    held: Motion = field(default_factory=lambda: Motion(0.0, 0.0))

    def toward(self, target: Forces, share: float) -> Forces:
        """The forces ``share`` of the way to ``target``."""
        normal = self.normal + share * (target.normal - self.normal)
        sideways, start = target.tangential, self.tangential or 0.0
        if sideways is not None:
            sideways = start + share * (sideways - start)
        return Forces(normal, sideways, self.held.toward(target.held, share))

    def __str__(self) -> str:
        sideways = "" if self.tangential is None else f", {self.tangential:g} N tangential"
        return f"{self.normal:g} N normal{sideways}"


def solve_forces(
    problem: ContactProblem,
    state: ContactState,
    forces: Forces,
    workspace: Workspace | None = None,
    tolerance: float = TOLERANCE,
) -> Increment:
    """The increment from ``state`` whose contact forces are ``forces``; its motion is the answer.

    tolerance: of the forces, relative to the normal one.
    Raises NoEquilibrium where none exists (complete slip under a tangential force that friction
    cannot carry), ZoneExhausted where the contact outgrows the candidates, SolverError where no
    motion was found although nothing shows that none exists.
    """
    if not (np.isfinite(forces.normal) and forces.normal > 0.0):
        raise NoEquilibrium(f"{forces}: a contact can only press; the normal force must be over 0")
    held = forces.held.amplitudes
    if not (np.isfinite(forces.tangential or 0.0) and np.isfinite(held).all()):
        raise SolverError(f"{forces}: tangential force and prescribed motion must be finite")
    _refuse_beyond_friction(problem, forces)
    workspace = workspace or Workspace()
    try:
        found = _Search(problem, state, forces, workspace, False, tolerance).run()
    except (NoEquilibrium, ZoneExhausted):
        raise
    except SolverError:  # near a jump between answers the fast methods may all fail
        found = _Search(problem, state, forces, workspace, True, tolerance).run()
    workspace.record(state, found.state)
    return found


def _refuse_beyond_friction(problem: ContactProblem, forces: Forces) -> None:
    """A flat object turns every node's force limit into one for the sum: no search is needed."""
    normals = problem.frames[:, 0]
    across, down = float(normals[0, 0]), float(normals[0, 1])
    flat = np.abs(normals - normals[0]).max() < 1e-12 and abs(np.hypot(across, down) - 1.0) < 1e-12
    if forces.tangential is None or not flat or not problem.law.is_coulomb:
        return  # sloping along z, its force may have a part there that is not prescribed
    pressed = across * forces.tangential - down * forces.normal
    pulled = -down * forces.tangential - across * forces.normal
    if abs(pulled) > problem.friction_coefficient * pressed * (1.0 + TOLERANCE):
        slope, angle = np.arctan2(across, -down), np.arctan(problem.friction_coefficient)
        low, high = (forces.normal * float(np.tan(slope + sign * angle)) for sign in (-1.0, 1.0))
        carried = f"{high:.4g}" if across == 0.0 else f"from {low:.4g} to {high:.4g}"
        raise _beyond_friction(problem, forces, carried)


def _beyond_friction(problem: ContactProblem, forces: Forces, carried: str) -> NoEquilibrium:
    return NoEquilibrium(
        f"no motion gives {forces}: complete slip. At friction "
        f"{problem.law} the contact carries {carried} N tangential "
        f"with {forces.normal:g} N normal; ask for less, press harder, or prescribe the motion"
    )


@dataclass
class _Search:
    """A search for the motion; it starts again and again from one frozen state."""

    problem: ContactProblem
    state: ContactState
    forces: Forces
    workspace: Workspace
    try_slow_methods: bool
    tolerance: float

    def __post_init__(self) -> None:
        self.free = [0] if self.forces.tangential is None else [0, 1]
        target = [self.forces.normal, self.forces.tangential or 0.0]
        self.target = np.array(target)[self.free]
        self.exhausted: ZoneExhausted | None = None
        self.guess = self.state  # forces and motion to start from; its history is the state's
        self.outside = 0  # trials of this Newton search
        self._last: Increment

    def run(self) -> Increment:
        if len(self.free) == 1:
            return self._by_approach()
        found = self._newton()
        if found is None:
            self.guess = self.state
            found = self._in_shares()
        return self._by_shear() if found is None else found

    def _in_shares(self) -> Increment | None:
        """Newton by steps of the forces: each answer is the next one's guess, the history stays.
        Where friction is large the motion alone may have several answers, an open one among them;
        this leads along the one that carries the forces."""
        goal = self.target
        start = self.problem.resultant(self.problem.to_global(self.state.multiplier))
        found = None
        for part in range(1, _SHARES + 1):
            self.target = start + (goal - start) * (part / _SHARES)
            found = self._newton()
            if found is None:
                break
            self._start_from(found)
        self.target, self.guess = goal, self.state
        return found

    def _start_from(self, trial: Increment) -> None:
        """The next trial's forces and motion to start from are this one's: it is nearer."""
        self.guess = replace(self.state, multiplier=trial.multiplier, motion=trial.motion)

    def _by_approach(self) -> Increment:
        """Newton between an approach that presses too little and one that presses too much."""
        low = self._touch(self.forces.held.shear)
        near, high = low + self._overlap(), np.inf
        approach = max(near, self.state.motion.approach)
        for _ in range(_ITERATIONS):
            trial = self._solve(np.array([approach]))
            pressed = np.inf if trial is None else float(self._resultant(trial)[0])
            if trial is not None and self._reached(pressed, 0):
                return trial
            low, high = (approach, high) if pressed < self.target[0] else (low, approach)
            slope = 0.0 if trial is None else float(self._tangent(trial)[0, 0])
            step = (self.target[0] - pressed) / slope if slope > 0.0 else np.inf
            approach += step
            if not low < approach < high:
                approach = 0.5 * (low + high) if np.isfinite(high) else low + 2.0 * (near - low)
                near = approach
        raise self._failure()

    def _touch(self, shear: float) -> float:
        """Approach at which the first node would touch, the finger being undeformed."""
        held = replace(self.forces.held, approach=0.0, shear=shear)
        gap = self.problem.offset(held, self.state.slip)[:, 0]
        closing = -self.problem.modes[0, :, 0]
        return float((gap[closing > 0.0] / closing[closing > 0.0]).min())

    def _overlap(self) -> float:
        """A little of the approach that the normal force will take, mm."""
        share = self.forces.normal / self.problem.model.symmetry_factor
        return 0.1 * share * float(self.problem.self_compliance.min())

    def _newton(self) -> Increment | None:
        self.outside = 0
        unknown = self._start()
        trial = self._solve(unknown)
        stiffest = 0.0
        for _ in range(_ITERATIONS):
            if trial is None:
                return None
            missing = self.target - self._resultant(trial)
            if np.abs(missing).max() <= self.tolerance * self.forces.normal:
                return trial
            tangent = self._tangent(trial)
            stiffness = 0.0  # against shear, at a constant normal force
            if tangent[0, 0] != 0.0:
                stiffness = tangent[1, 1] - tangent[1, 0] * tangent[0, 1] / tangent[0, 0]
            stiffest = max(stiffest, stiffness)
            if not stiffness > _SLACK * stiffest:
                # All slides: more shear changes nothing, but less of it makes nodes stick.
                tangent = self._tangent(trial, turning_back=True)
            try:
                step: Array = np.linalg.solve(tangent, missing).astype(float)
            except np.linalg.LinAlgError:
                return None
            unknown, trial = self._line_search(unknown, step, float(np.abs(missing).max()))
        return None

    def _by_shear(self) -> Increment:
        """The shear by bisection, at each the approach that gives the normal force: slow, and safe.
        At a constant normal force the tangential one grows with the shear until all slides."""
        reach = self.forces.normal / self.problem.model.symmetry_factor
        reach *= float(self.problem.self_compliance.max())
        start = self.state.motion.shear
        here, carried = start, self._pulled(start)
        if self._reached(carried, 1):
            return self._last
        onward = 1.0 if self.target[1] > carried else -1.0
        for doubling in range(_DOUBLINGS):
            there = start + onward * reach * 2.0 ** (doubling - 2)
            pulled = self._pulled(there)
            if self._reached(pulled, 1):
                return self._last
            if onward * (pulled - self.target[1]) > 0.0:
                return self._bisect(here, there)
            here = there
        touching = self._last.multiplier[:, 0] > 0.0
        if (self._last.state.sliding[touching] > 0.0).all():
            raise _beyond_friction(self.problem, self.forces, f"{pulled:.4g}")
        raise self._failure()

    def _bisect(self, low: float, high: float) -> Increment:
        onward = 1.0 if high > low else -1.0
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            pulled = self._pulled(middle)
            if self._reached(pulled, 1):
                return self._last
            if onward * (pulled - self.target[1]) > 0.0:
                high = middle
            else:
                low = middle
        raise self._failure()

    def _pulled(self, shear: float) -> float:
        """Tangential force at ``shear`` under the target normal force; the increment is stored."""
        held = replace(self.forces.held, shear=shear)
        pressed = Forces(self.forces.normal, None, held)
        try:
            self._last = replace(self, forces=pressed).run()
        except ZoneExhausted:
            raise
        except SolverError:
            raise self._failure() from None  # it names the target forces, not the inner ones
        return float(self.problem.resultant(self._last.force)[1])

    def _reached(self, force: float, which: int) -> bool:
        return abs(force - float(self.target[which])) <= self.tolerance * self.forces.normal

    def _start(self) -> Array:
        """The last motion, brought just into contact where it is not."""
        last = self.guess.motion
        approach = last.approach
        if not (self.guess.multiplier[:, 0] > 0.0).any():
            approach = self._touch(last.shear) + self._overlap()
        return np.array([approach, last.shear])[self.free]

    def _solve(self, unknown: Array) -> Increment | None:
        motion, slowly = self.forces.held, self.try_slow_methods
        approach, *shear = unknown.tolist()
        motion = replace(motion, approach=approach, shear=shear[0] if shear else motion.shear)
        try:
            return solve_increment(self.problem, self.guess, motion, self.workspace, slowly)
        except ZoneExhausted as exhausted:
            self.exhausted = exhausted
            self.outside += 1
            if self.outside >= _OUTSIDE:
                raise
        except SolverError:
            pass
        self.workspace.inverse = None
        return None

    def _resultant(self, increment: Increment) -> Array:
        return np.asarray(self.problem.resultant(increment.force)[self.free])

    def _tangent(self, increment: Increment, turning_back: bool = False) -> Array:
        """d(F_n, F_t) / d(approach, shear) of the free ones, N/mm."""
        whole = stiffness(self.problem, increment, self.workspace, turning_back)
        return whole[np.ix_(self.free, self.free)]

    def _line_search(
        self, unknown: Array, step: Array, missing: float
    ) -> tuple[Array, Increment | None]:
        """The longest of the step's halves that brings the forces nearer, and its increment."""
        length = 1.0
        while length >= _SHORTEST:
            trial = self._solve(unknown + length * step)
            if trial is not None:
                left = float(np.abs(self.target - self._resultant(trial)).max())
                if left <= (1.0 - 1e-3 * length) * missing:
                    self._start_from(trial)
                    return unknown + length * step, trial
            length *= 0.5
        return unknown, None

    def _failure(self) -> SolverError:
        if self.exhausted is not None:
            return self.exhausted
        return SolverError(f"no motion was found that gives {self.forces}: use smaller increments")
