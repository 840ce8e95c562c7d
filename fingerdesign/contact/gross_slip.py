"""Complete slip under a level plane: the forces that friction then carries (numpy only).

Dragged far in one increment, every node in contact slides toward +x, so forces follow from the
approach alone. Coulomb's law makes F_t = mu F_n of them; under another law their ratio depends on
the load, and an object of weight w a finger is held by F_n where F_t(F_n) = w.
"""

from __future__ import annotations

from fingerdesign.contact.balance import ForceSlope, rising_root
from fingerdesign.contact.increment import Increment, Workspace, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.tangent import stiffness
from fingerdesign.errors import SolverError

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


def forces_of_slip(problem: ContactProblem, approach: float) -> tuple[float, float]:
    """(F_n, F_t) N of the whole finger; errors as of :func:`sliding`."""
    force = problem.model.total_force(sliding(problem, approach).force)
    return -float(force[1]), float(force[0])


def coefficient_under(problem: ContactProblem, tangential: float) -> float:
    """Ratio of F_t = ``tangential`` (N, over 0) to the least F_n that carries it.

    Coulomb's coefficient is the same at every load; of another law this is the one that a lift of
    that load meets. Raises ZoneExhausted where no contact within the candidates carries the force,
    else as :func:`sliding`.
    """
    if problem.law.is_coulomb:
        return problem.law.coefficient

    def carried(approach: float) -> ForceSlope:
        found = sliding(problem, approach)
        force = problem.model.total_force(found.force)
        return ForceSlope(float(force[0]), float(stiffness(problem, found)[1, 0]), -float(force[1]))

    touch = max(0.0, float(problem.gap0.min()))
    softest = float(problem.self_compliance.max()) / problem.model.symmetry_factor
    start = touch + 0.1 * softest * tangential
    held = rising_root(carried, tangential, start, touch, softest)
    return tangential / forces_of_slip(problem, held)[0]
