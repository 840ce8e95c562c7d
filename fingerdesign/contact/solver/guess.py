"""First guess of an increment: the nodes in contact, from the normal forces alone (numpy only).

With the tangential forces fixed, contact is a linear complementarity problem in the normal forces:
a third of the unknowns (half in the plane) and a small part of the work. An active set, started
from the nodes that were in contact before, mostly ends in three or four steps.
"""

import numpy as np
from scipy.linalg.lapack import dposv

from fingerdesign.arrays import Array
from fingerdesign.contact.friction import Friction
from fingerdesign.contact.laws import project

_STEPS = 12  # Newton corrects what is still wrong after so many steps.


def active_set_guess(compliance: Array, offset: Array, guess: Array, friction: Friction) -> Array:
    """Guess admissible forces (m, dim): normal ones that close the gap under ``guess``'s pull.

    compliance (m dim, m dim), offset (m, dim) as in newton.newton. Never fails: a guess.
    """
    m, dim = offset.shape
    pull = guess.copy()
    pull[:, 0] = 0.0
    gap = offset[:, 0] + (compliance @ pull.reshape(-1))[::dim]
    closed = guess[:, 0] > 0.0
    if not closed.any():
        closed = gap < 0.0
    normal, pressing = np.zeros(m), np.ascontiguousarray(compliance[::dim, ::dim])
    for _ in range(_STEPS):
        index = np.flatnonzero(closed)
        normal[:] = 0.0
        if len(index):
            rows = pressing[index]  # by symmetry the gaps that they cause
            *_, force, info = dposv(rows[:, index].T, -gap[index], overwrite_a=1)
            if info:
                return guess
            normal[index] = force
        now = np.where(closed, normal > 0.0, gap + normal @ pressing < 0.0)
        if (now == closed).all():
            break
        closed = now
    pull[:, 0] = np.maximum(normal, 0.0)
    return project(pull, friction)
