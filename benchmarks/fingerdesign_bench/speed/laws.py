"""Time of increments under each law of friction, over Coulomb's, in one run.

    python -m fingerdesign_bench.speed.laws

Small increments of a lift: press, then to and fro along x, deeper and back. Laws are followed in
turn, several times, and the least time of each counts. In the plane and in 3-D, by the compiled
kernel where there is one.
"""

import time

import numpy as np
from threadpoolctl import threadpool_limits

from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion, contact_problem
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import Plane
from fingerdesign_bench.stability.bodies import hard_bodies
from fingerdesign_bench.stability.laws import laws_of, mean_pressure

_BODIES = ("15 plates, nu 0.4999", "3-D, nu 0.49")
_FRICTION, _ROUNDS, _STEPS = 0.4, 7, 60


def walk(press: float) -> list[Motion]:
    """Increments of 1/40 of an approach, ten of pressing and sixty sheared to and fro."""
    way = np.arange(_STEPS)
    sheared = press * 0.25 * np.sin(2.0 * np.pi * way / 40.0)
    deeper = press * (1.0 + 0.1 * np.sin(2.0 * np.pi * way / 23.0))
    start = [Motion(press * share, 0.0) for share in np.linspace(0.1, 1.0, 10)]
    return start + [Motion(float(a), float(s)) for a, s in zip(deeper, sheared, strict=True)]


def seconds(problem: ContactProblem, rows: list[Motion]) -> tuple[float, int]:
    """Seconds of the increments after the press, and their iterations."""
    state, workspace, spent, iterations = ContactState.untouched(problem), Workspace(), 0.0, 0
    for number, row in enumerate(rows):
        start = time.perf_counter()
        increment = solve_increment(problem, state, row, workspace)
        if number >= len(rows) - _STEPS:
            spent += time.perf_counter() - start
            iterations += increment.iterations
        state = increment.state
    return spent, iterations


def main() -> None:
    """Print the table."""
    print(f"{'body':22} {'law':15} {'ms':>8} {'ratio':>6} {'iterations':>11}")
    with threadpool_limits(limits=1, user_api="blas"):
        for body in (each for each in hard_bodies() if each.name in _BODIES):
            model, crest = body.build()
            rows, pressure = walk(body.press), mean_pressure(body, model, crest)
            laws = {"coulomb": FrictionLaw(_FRICTION), **laws_of(_FRICTION, pressure)}
            base = contact_problem(model, Plane(crest), _FRICTION)
            found: dict[str, tuple[float, int]] = dict.fromkeys(laws, (np.inf, 0))
            for _ in range(_ROUNDS):
                for name, law in laws.items():
                    found[name] = min(found[name], seconds(base.with_friction(law), rows))
            for name, (spent, iterations) in found.items():
                ratio = spent / found["coulomb"][0]
                each = 1e3 * spent / _STEPS
                print(
                    f"{body.name:22} {name:15} {each:8.3f} {ratio:6.2f} {iterations / _STEPS:11.2f}"
                )


if __name__ == "__main__":
    main()
