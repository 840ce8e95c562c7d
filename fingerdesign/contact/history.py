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

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import Increment, Workspace
from fingerdesign.contact.laws import SLIP, lengths
from fingerdesign.contact.problem import ContactProblem, ContactState

_STILL = 1e-9  # Relative to a node's displacement under its own force: a shorter slip is rounding.


class FrictionHistory:
    """The state after a path of increments: ``problem`` and ``state`` to solve the next one from.

    last: the last accepted increment; workspace: to solve with. settled: whether the same motion
    once more would leave all forces as they are.
    """

    def __init__(self, problem: ContactProblem, kinetic_share: float = 1.0) -> None:
        """kinetic_share: the kinetic coefficient over the static one, which is the problem's; 1:
        one friction. Raises ValueError unless it is over 0 and at most 1."""
        if not 0.0 < kinetic_share <= 1.0:
            raise ValueError(f"a kinetic share of {kinetic_share} must be over 0 and at most 1")
        self.problem = problem
        self.state = ContactState.untouched(problem)
        self.last: Increment | None = None
        self.workspace = Workspace()
        self.settled = True
        self._kinetic = kinetic_share
        self._law, self._own_shares = problem.law, problem.friction_share  # at rest
        self._slid = np.zeros(problem.shape[0], dtype=bool)

    def accept(self, increment: Increment) -> None:
        """Go on from an increment that was solved from ``problem`` and ``state``."""
        self.workspace.record(self.state, increment.state)
        self.state, self.last = increment.state, increment
        if self._kinetic == 1.0:
            return
        # Nodes that stay on their limit unmoved did not slide.
        least = _STILL * self.problem.self_compliance * increment.multiplier[:, 0]
        slid = (increment.status == SLIP) & (lengths(increment.slip_increment) > least)
        self.settled = not (slid & ~self._slid).any()
        if (slid == self._slid).all():
            return
        self._slid = slid
        at_rest = replace(self.problem, friction_share=self._own_shares)
        self.problem = at_rest.patchy(np.where(slid, self._kinetic, 1.0)) if slid.any() else at_rest

    def displace(self, lag: Array) -> None:
        """Solve the next increments on a surface displaced by ``lag`` (m, dim) mm, instead of the
        body's own loads (contact/memory.py)."""
        modes = self.problem.modes.copy()
        modes[4] = lag
        self.problem = replace(self.problem, modes=modes)
        if self.state.motion.load != 1.0:
            self.state = replace(self.state, motion=replace(self.state.motion, load=1.0))

    def strengthen(self, factor: float) -> None:
        """Solve the next increments with ``factor`` > 0 times the friction of the first problem."""
        law = self._law if factor == 1.0 else self._law.scaled(factor)
        if law != self.problem.law:
            self.problem = replace(self.problem, law=law)
