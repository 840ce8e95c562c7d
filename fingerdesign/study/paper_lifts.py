"""Figures 2 and 10: lifts by the paper's rule.

Fig. 10  the rule at several friction coefficients, unknown to it, and the same path without it
Fig. 2   one of these lifts, its target point (mg/2mu, mg/2), and two other routes to the weight:
         the path that never holds, and a squeeze that needs no feeling, SQUEEZE times the least
         force and then shear alone
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.measures import completely_slips
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.control.calibration import Calibration, calibrate
from fingerdesign.control.controller import PaperController
from fingerdesign.control.episode import Bounds, Episode, run_episode
from fingerdesign.control.judge import weight_per_finger
from fingerdesign.control.plant import CondensedPlant, Plant
from fingerdesign.control.roster import paper_settings

if TYPE_CHECKING:
    from fingerdesign.study.paper_case import PaperCase

RigMaker = Callable[[Plant], Plant]

LIFTED_FRICTIONS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
ROUTE_FRICTION = 0.3
SQUEEZE = 4.0
_SHEAR_PART = 0.25  # of the controller's largest shear step: a step of the squeeze
_MOST_SHEARS = 400


@dataclass(frozen=True)
class Lift:
    """One grip by the rule, and the same path without it."""

    friction: float
    ruled: Episode
    free: Episode


@dataclass(frozen=True)
class Route:
    """A way to the weight that feels nothing: forces (k,) N; slips: it ended in complete slip."""

    normal_force: Array
    tangential_force: Array
    slips: bool


def lifts(case: PaperCase, frictions: tuple[float, ...] = LIFTED_FRICTIONS) -> list[Lift]:
    """Fig. 10: one calibration, one set of parameters, a lift at each friction coefficient."""
    learnt = calibration(case)
    return [
        Lift(friction, *(grip(case, learnt, friction, rule=rule) for rule in (True, False)))
        for friction in frictions
    ]


def squeeze(case: PaperCase, friction: float = ROUTE_FRICTION) -> Route:
    """Press to SQUEEZE times the least force, or as far as the stage goes, then shear alone."""
    hand = case.design.grip
    weight = weight_per_finger(hand.object_mass_g)
    moves = max(1, round(hand.max_approach_mm / hand.approach_step_mm))
    forces: list[tuple[float, float]] = [(0.0, 0.0)]
    slips = False

    def path() -> Iterator[Motion]:
        approach = 0.0
        for k in range(1, moves + 1):
            approach = hand.max_approach_mm * k / moves
            yield Motion(approach, 0.0)
            if forces[-1][0] >= SQUEEZE * weight / friction:
                break
        for k in range(1, _MOST_SHEARS + 1):
            yield Motion(approach, _SHEAR_PART * hand.shear_step_mm * k)

    for step in follow(case.finger.with_friction(friction), path()):
        measures = step.measures
        forces.append((measures.normal_force, measures.tangential_force))
        slips = completely_slips(measures, 2)
        if slips or measures.tangential_force > weight:
            break
    both = np.array(forces)
    return Route(both[:, 0], both[:, 1], slips)


def _as_it_is(plant: Plant) -> Plant:
    return plant


def _bounds(case: PaperCase) -> Bounds:
    hand = case.design.grip
    return Bounds(hand.preload_mm, hand.approach_step_mm, hand.max_approach_mm, hand.max_steps)


def calibration(case: PaperCase, rig: RigMaker = _as_it_is) -> Calibration:
    """What a rig learns of the finger; ``rig`` is the hardware around the plant."""
    bounds = _bounds(case)
    bench = case.finger.with_friction(case.design.grip.bench_friction_coefficient)
    return calibrate(
        lambda: rig(CondensedPlant(bench, case.face)),
        case.gage_x,
        bounds.preload,
        bounds.approach_step,
        bounds.max_approach,
    )


def grip(
    case: PaperCase,
    learnt: Calibration,
    friction: float,
    rig: RigMaker = _as_it_is,
    rule: bool = True,
) -> Episode:
    """One grip by the design's ``[grip]`` table."""
    problem = case.finger.with_friction(friction)
    return run_episode(
        rig(CondensedPlant(problem, case.face)),
        PaperController(paper_settings(case.design.grip), rule),
        learnt,
        _bounds(case),
        friction,
        case.design.grip.object_mass_g,
    )
