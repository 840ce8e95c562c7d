"""Cases of the stability map under laws of friction that depend on the pressure.

Each ``every``-th case is solved by the production solver under three laws, made from its
coefficient mu and from the body's mean pressure p when it is pressed without friction. There
Coulomb's bound, tau0 alone and the power law are equal; the capped one may be larger by a fifth.
Forces beyond friction are left out: they are beyond Coulomb's law alone.
"""

from collections.abc import Iterator
from dataclasses import replace

from fingerdesign.contact.increment import solve_increment
from fingerdesign.contact.problem import ContactState, Motion, contact_problem
from fingerdesign.reduced import ReducedModel
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import Plane
from fingerdesign_bench.stability.bodies import HardBody, hard_bodies
from fingerdesign_bench.stability.cases import BEYOND, WITHIN, cases_of
from fingerdesign_bench.stability.run import CaseResult, run_production

_POWER = 1.0 / 3.0  # a sphere at constant shear strength; silicone on wood: 0.31


def laws_of(coefficient: float, pressure: float) -> dict[str, FrictionLaw]:
    """The three laws of a coefficient mu and a mean pressure p, MPa."""
    bound = coefficient * pressure
    return {
        "capped": FrictionLaw(coefficient, 0.2 * bound, cap=1.2 * bound),
        "shear strength": FrictionLaw(0.0, bound),
        "power": FrictionLaw(coefficient, exponent=_POWER, reference=pressure),
    }


def mean_pressure(body: HardBody, model: ReducedModel, crest: float) -> float:
    """Force over area of the contact pressed by an ordinary grip without friction, MPa."""
    problem = contact_problem(model, Plane(crest), 0.0)
    start = ContactState.untouched(problem)
    force = solve_increment(problem, start, Motion(body.press, 0.0)).multiplier[:, 0]
    return float(force.sum() / model.areas[force > 0.0].sum())


def sampled(every: int) -> Iterator[tuple[str, CaseResult]]:
    """Each ``every``-th result of all bodies' cases under the laws, with the law's name."""
    number = 0
    for body in hard_bodies():
        model, crest = body.build()
        pressure = mean_pressure(body, model, crest)
        for case in cases_of(body, model, crest):
            if case.family == BEYOND or not case.friction:
                continue
            if case.family == WITHIN:  # What another law carries is not known.
                case = replace(case, solvable=0)
            for name, law in laws_of(case.friction, pressure).items():
                number += 1
                if number % every == 0:
                    yield name, run_production(case, model, law)
