"""The friction history of a contact, and friction that is larger at rest than in motion (numpy).

A node that slipped in the last accepted increment meets the kinetic coefficient in the next one,
mu_k = share mu; one that stuck, or was open, meets the static one, mu. So within an increment every
node has one coefficient, and laws, certificate and solvers stay Coulomb's; friction changes
between increments alone, by the shares of :meth:`ContactProblem.patchy`, with which it multiplies.

The rule knows no rate and lags by one increment: a node that begins to slip carries the static
limit to the end of that increment and falls to the kinetic one in the next, where its neighbours
take over the load that it loses. That is right for a quasi-static path whose increments are small
against the slip of the zone that slides: slip then lasts many increments, and a lag of one is
negligible. In one large increment the whole contact would slide at the static limit. A node that
came to rest, also for a single increment, has the static limit again: rubber heals at once.
"""

from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.contact.increment import Increment, Workspace
from fingerdesign.contact.laws import SLIP, lengths
from fingerdesign.contact.problem import ContactProblem, ContactState

_STILL = 1e-9  # Relative to a node's displacement under its own force: a shorter slip is rounding.


class FrictionHistory:
    """The state after a path of increments: ``problem`` and ``state`` to solve the next one from.

    last: the last accepted increment, in the problem's components; workspace: to solve with.
    settled: whether the same motion once more would leave all forces as they are.
    """

    def __init__(self, problem: ContactProblem, kinetic_share: float = 1.0) -> None:
        """kinetic_share: the kinetic coefficient over the static one, which is the problem's; 1:
        one friction. Raises ValueError unless it is over 0 and at most 1."""
        if not 0.0 < kinetic_share <= 1.0:
            raise ValueError(f"a kinetic share of {kinetic_share} must be over 0 and at most 1")
        self.problem = self._at_rest = problem
        self.state = ContactState.untouched(problem)
        self.last: Increment | None = None
        self.workspace = Workspace()
        self.settled = True
        self._share, self._law = kinetic_share, problem.law
        self._slid = np.zeros(problem.shape[0], dtype=bool)

    def accept(self, increment: Increment) -> None:
        """Go on from an increment that was solved from ``problem`` and ``state``."""
        self.workspace.record(self.state, increment.state)
        before, self.state, self.last = self.state, increment.state, increment
        if self._share == 1.0:
            return
        # Nodes that stay on their limit unmoved did not slide.
        least = _STILL * self.problem.self_compliance * increment.multiplier[:, 0]
        slid = (increment.status == SLIP) & (lengths(increment.slip_increment) > least)
        self.settled = not (slid & ~self._slid).any()
        if (slid == self._slid).all():
            return
        scale = self._shares(slid) / self._shares(self._slid)
        self._slid = slid
        self.problem = self._at_rest
        if slid.any():
            self.problem = self._at_rest.patchy(self._shares(slid))
        self.state = _rescaled_state(increment.state, scale)
        self.last = replace(
            increment,
            multiplier=self.state.multiplier,
            slip_increment=scale[:, None] * increment.slip_increment,
            state=self.state,
        )
        self.workspace = Workspace(self.workspace.follows)
        self.workspace.record(_rescaled_state(before, scale), self.state)

    def displace(self, lag: Array) -> None:
        """Solve the next increments on a surface displaced by ``lag`` (m, dim) mm, in the first
        problem's components, instead of the body's own loads (contact/memory.py)."""
        alike = self.problem is self._at_rest
        self._at_rest = _displaced(self._at_rest, lag)
        if alike:
            self.problem = self._at_rest
        else:
            scale = np.ones(lag.shape)
            scale[:, 1:] = self._shares(self._slid)[:, None]
            self.problem = _displaced(self.problem, scale * lag)
        if self.state.motion.load != 1.0:
            self.state = replace(self.state, motion=replace(self.state.motion, load=1.0))

    def strengthen(self, factor: float) -> None:
        """Solve the next increments with ``factor`` > 0 times the friction of the first problem."""
        law = self._law if factor == 1.0 else self._law.scaled(factor)
        if law != self.problem.law:
            self._at_rest = replace(self._at_rest, law=law)
            self.problem = replace(self.problem, law=law)

    def at_rest(self, multiplier: Array) -> Array:
        """Forces (m, dim) in the problem's components, in those of the first problem."""
        own = multiplier.copy()
        own[:, 1:] *= self._shares(self._slid)[:, None]
        return own

    def _shares(self, slid: BoolArray) -> Array:
        return np.where(slid, self._share, 1.0)


def _displaced(problem: ContactProblem, lag: Array) -> ContactProblem:
    modes = problem.modes.copy()
    modes[4] = lag
    return replace(problem, modes=modes)


def _rescaled_state(state: ContactState, scale: Array) -> ContactState:
    """A state where nodes' shares of the friction coefficient are ``scale`` (m,) times as large."""
    multiplier = state.multiplier.copy()
    multiplier[:, 1:] /= scale[:, None]
    return ContactState(
        scale[:, None] * state.slip,
        multiplier,
        state.motion,
        scale * state.travelled,
        scale * state.sliding,
    )
