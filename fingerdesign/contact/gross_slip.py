"""Complete slip: the forces that friction then carries (numpy only).

Dragged far in one increment under a level plane, every node in contact slides toward +x, so forces
follow from the approach alone. Coulomb's law makes F_t = mu F_n of them; under another law, and of
an object that turns about a centre off the middle, their ratio depends on the load, and an object
of weight w a finger is held by F_n where F_t(F_n) = w.

Where friction falls with the pressure, a coefficient alone says nothing: :func:`meeting` makes the
law whose coefficient holds at a given F_n.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.balance import Attempts, ForceSlope, rising_root
from fingerdesign.contact.increment import Increment, Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.tangent import stiffness
from fingerdesign.contact.turning import carried_turning
from fingerdesign.errors import SolverError
from fingerdesign.shapes.friction import FrictionLaw

# An object that turns is dragged by growing steps, the first one in approaches times the bound.
_FIRST, _GROWTH, _MOST_DRAGS = 0.1, 1.35, 18
_FAR = 10.0  # Shear, in approaches times the steepest bound (at least 1): every node slides.


def sliding(problem: ContactProblem, approach: float) -> Increment:
    """The increment to an approach in which all of the contact slides toward +x.

    problem: under a level plane. Raises SolverError where a node sticks, and what solve_increment
    raises.
    """
    far = _FAR * max(1.0, problem.law.steepest) * approach
    start = ContactState.untouched(problem)
    found = solve_increment(problem, start, Motion(approach, far), Workspace())
    touching = found.multiplier[:, 0] > 0.0
    if not (found.state.sliding[touching] > 0.0).all():
        raise SolverError(f"the contact does not slide as a whole at approach {approach:g} mm")
    return found


def coefficient_under(problem: ContactProblem, tangential: float) -> float:
    """Ratio of F_t = ``tangential`` (N, over 0) to the least F_n that carries it.

    Coulomb's coefficient is the same at every load; under another law, and of an object that turns,
    this is the one that a lift of that load meets. Where no contact within the candidates holds the
    load, it is the ratio at the deepest one. Raises as :func:`sliding`.
    """
    if problem.law.is_coulomb and problem.softness is None:
        return problem.law.coefficient
    if problem.softness is not None or not problem.is_level:
        return _coefficient_by_presses(problem, tangential)

    def carried(approach: float) -> ForceSlope:
        found = sliding(problem, approach)
        normal, pulled = problem.resultant(found.force).tolist()
        return ForceSlope(pulled, float(stiffness(problem, found)[1, 0]), normal)

    last = _reach(problem, carried, tangential)
    return last.value / last.scale


def meeting(problem: ContactProblem, friction: float, normal: float) -> ContactProblem:
    """The problem at a friction coefficient; its law's exponent n stays, and mu holds at
    F_n = ``normal`` (N).

    Friction then carries sum A_i mu p0^n p_i^(1 - n) = mu F_n under a press to that force, which
    gives the law's reference pressure p0. A force beyond the candidates counts as the largest one
    that they reach. Raises SolverError where no press is found.
    """
    exponent = problem.law.exponent
    if exponent == 0.0:
        return problem.with_friction(friction)
    smooth = problem.with_friction(0.0)
    trials = Attempts(smooth, ContactState.untouched(smooth))

    def pressed(approach: float) -> ForceSlope | None:
        if trials.at(approach, 0.0) is None:
            return None
        force = float(trials.forces()[0])
        return ForceSlope(force, float(trials.stiffness()[0, 0]), force)

    _reach(smooth, pressed, normal)
    forces = np.maximum(trials.last.multiplier[:, 0], 0.0)
    falls = forces ** (1.0 - exponent) @ problem.model.areas**exponent / forces.sum()
    return problem.with_friction(
        FrictionLaw(friction, exponent=exponent, reference=float(falls ** (-1.0 / exponent)))
    )


def _turning_until_sliding(
    problem: ContactProblem, pressed: Increment, workspace: Workspace
) -> Increment:
    """Drag on from a press, ever farther, until every node slides or at least turns as it will."""
    state, found, shear = pressed.state, pressed, 0.0
    friction = problem.mean_friction(pressed.multiplier[:, 0])
    step = _FIRST * max(friction, _FIRST) * pressed.motion.approach
    for _ in range(_MOST_DRAGS):
        shear, step = shear + step, _GROWTH * step
        motion = replace(state.motion, shear=shear)
        try:
            found = solve_increment(problem, state, motion, workspace)
        except ZoneExhausted:  # The drag leaves the candidates: the last state inside them counts.
            break
        state, touching = found.state, found.multiplier[:, 0] > 0.0
        if (state.sliding[touching] > 0.0).all():
            break
    return found


def _coefficient_by_presses(problem: ContactProblem, tangential: float) -> float:
    """The force that holds is found by presses, and so is the ratio on a surface that leans or is
    round, for a drag would leave it. Of an object that turns the ratio is found by a slide: it
    shifts the normal forces, and lowers the ratio by some hundredths, which hardly changes with the
    force."""
    turns = problem.softness is not None
    presses = problem if turns else problem.with_friction(0.0)  # Each has one answer.
    trials = Attempts(presses, ContactState.untouched(presses))

    def sliding_force(normal: Array) -> tuple[float, float]:
        return carried_turning(problem, normal) if turns else problem.carried_sliding(normal)

    def carried(approach: float) -> ForceSlope | None:
        found = trials.at(approach, 0.0)
        if found is None:
            return None
        normal, pulled = sliding_force(found.multiplier[:, 0])
        rise = float(trials.stiffness()[0, 0])
        return ForceSlope(pulled, rise * pulled / max(normal, 1e-300), normal)

    last = _reach(presses, carried, tangential)
    if not turns:
        return last.value / last.scale
    slid = _turning_until_sliding(problem, trials.last, trials.workspace)
    normal, pulled = sliding_force(slid.multiplier[:, 0])
    return pulled / normal


def _reach(
    problem: ContactProblem, evaluate: Callable[[float], ForceSlope | None], target: float
) -> ForceSlope:
    """The last trial of the approach at which a rising force reaches ``target`` (N), or, where that
    is beyond the candidates, of the deepest one inside them. Raises SolverError for neither."""
    found: ForceSlope | None = None
    outside = False

    def inside(approach: float) -> ForceSlope | None:
        nonlocal found, outside
        try:
            trial = evaluate(approach)
        except ZoneExhausted:  # of one trial: the answer may be nearer
            outside = True
            return None
        found = trial or found
        return trial

    try:
        rising_root(inside, target, *_start(problem, target))
    except SolverError:
        if not outside or found is None:
            raise
    assert found is not None  # A root was evaluated.
    return found


def _start(problem: ContactProblem, tangential: float) -> tuple[float, float, float]:
    """For rising_root: an approach to begin at, that of the touch (mm), and the softest (mm/N)."""
    touch = max(0.0, float(problem.gap0.min()))
    softest = float(problem.self_compliance.max()) / problem.model.symmetry_factor
    return touch + 0.1 * softest * tangential, touch, softest
