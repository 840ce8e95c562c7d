"""Search for other answers of an increment, and count them (numpy only).

With the motion given there always is an answer (pivots.py proves it). For a small friction
coefficient it is the only one; for a large one there may be several, jammed and free ones among
them, and nothing in the laws prefers one. Each that is found here passed the certificate; that none
was found proves nothing.

The count: deforming friction into sticking keeps the answers bounded, so the signs of the
linearised system's determinant at all answers add up to 1, as at the one answer that sticks
(Brouwer's degree; Cottle, Pang, Stone, The Linear Complementarity Problem, 1992, ch. 6). Answers
come in odd numbers, and one whose sign is -1 is not alone: it has at least two companions.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, product

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.friction import Coulomb
from fingerdesign.contact.increment import Increment, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.solver.newton import newton
from fingerdesign.contact.solver.pivots import friction_pivots
from fingerdesign.errors import SolverError

_DISTINCT = 1e-5  # Two answers differ by more than this part of the largest force.
_SHARES = (0.25, 0.5, 0.75)  # Starts between two answers, where a third one mostly lies.
_FACTORS = (0.5, 2.0, 10.0)  # Large augmentations stay at answers that the ordinary one leaves.


def other_solutions(
    problem: ContactProblem,
    state: ContactState,
    motion: Motion,
    known: Increment | None = None,
    starts: int = 8,
) -> list[Increment]:
    """Certified increments from ``state`` to ``motion`` that differ from ``known`` and each other.

    known: the answer in hand, that of solve_increment where None (whose SolverError is passed on).
    Searched from nothing, from all-sticking and frictionless answers, from complete slip in
    ``starts`` directions or random mixtures, in the plane along as many paths of pivots, and
    between the answers found; several times ``starts`` times the cost of an increment. An empty
    list does not prove uniqueness.
    """
    known = solve_increment(problem, state, motion) if known is None else known
    found = [known]

    def look(guess: Array) -> None:
        # Standing at the goal with the guess in hand, Newton stays if the guess is an answer.
        there = replace(state, multiplier=guess, motion=motion)
        try:
            increment = solve_increment(problem, there, motion)
        except SolverError:
            return
        if all(_differ(increment, other) for other in found):
            found.append(increment)

    for guess in _guesses(problem, state, motion, starts):
        look(guess)
    if len(found) > 1:
        offset = problem.offset(motion, state.slip)
        for one, other in list(combinations(found, 2))[:starts]:
            for share, factor in product(_SHARES, _FACTORS):
                between = share * one.multiplier + (1.0 - share) * other.multiplier
                result = newton(problem.compliance, offset, problem.friction, between, factor)
                if result.converged:
                    look(result.multiplier)
    return found[1:]


def _differ(one: Increment, other: Increment) -> bool:
    scale = max(float(np.abs(one.multiplier).max()), float(np.abs(other.multiplier).max()))
    return bool(np.abs(one.multiplier - other.multiplier).max() > _DISTINCT * max(scale, 1e-300))


def _guesses(
    problem: ContactProblem, state: ContactState, motion: Motion, starts: int
) -> Iterator[Array]:
    m, dim = problem.shape
    offset = problem.offset(motion, state.slip)
    compliance, friction = problem.compliance, problem.friction
    rng = np.random.default_rng(0)
    # A bound that is never reached: everything sticks.
    stuck = newton(compliance, offset, Coulomb(1e6), np.zeros((m, dim))).multiplier
    if dim == 2:
        # Of another law by Coulomb's, with the coefficients of the forces that stick.
        near = friction
        if not isinstance(near, Coulomb):
            near = Coulomb(np.array(near.secant(stuck[:, 0])))
        for path in range(starts):
            result = friction_pivots(compliance, offset, near, path)
            if result.converged:
                yield result.multiplier
    yield np.zeros((m, dim))
    yield stuck
    free = newton(compliance, offset, Coulomb(0.0), np.zeros((m, dim))).multiplier
    yield free
    press = np.maximum(free[:, :1], 0.0)
    bound = friction.bound(press[:, 0])[:, None]
    for start in range(starts):
        angle = 2.0 * np.pi * start / starts
        direction = np.array([np.cos(angle), np.sin(angle)])[: dim - 1]
        yield np.hstack([press, bound * direction])
        share = rng.uniform(0.0, 1.0, (m, 1))
        mixed = share * stuck + (1.0 - share) * free
        yield np.where(mixed[:, :1] > 0.0, mixed, 0.0)
