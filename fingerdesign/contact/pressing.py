"""Which nodes touch, from the normal forces alone: a cheap first guess for Newton (numpy only).

Tangential forces being held, contact is a linear complementarity problem in the normal forces, a
third of the unknowns (half in the plane) and a small part of the work. An active set, from the
nodes that touched before, mostly ends in three or four steps.
"""

from __future__ import annotations

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.laws import project

_STEPS = 12  # what is wrong after them Newton mends


def pressed(compliance: Array, offset: Array, guess: Array, friction_coefficient: float) -> Array:
    """Admissible forces (m, dim): normal ones that close ``offset``'s gap under ``guess``'s pull.

    compliance (m dim, m dim), offset (m, dim) as in newton.newton. Never fails: a guess.
    """
    m, dim = offset.shape
    pull = guess.copy()
    pull[:, 0] = 0.0
    gap = offset[:, 0] + (compliance @ pull.reshape(-1))[::dim]
    closed = guess[:, 0] > 0.0
    if not closed.any():
        closed = gap < 0.0
    normal = np.zeros(m)
    for _ in range(_STEPS):
        index = np.flatnonzero(closed)
        rows = compliance[dim * index][:, ::dim]  # by symmetry the gaps that they cause
        try:
            force = np.linalg.solve(rows[:, index], -gap[index]) if len(index) else np.empty(0)
        except np.linalg.LinAlgError:
            return guess
        normal[:] = 0.0
        normal[index] = force
        now = np.where(closed, normal > 0.0, gap + force @ rows < 0.0)
        if (now == closed).all():
            break
        closed = now
    pull[:, 0] = np.maximum(normal, 0.0)
    return project(pull, friction_coefficient)
