"""Figures 2 and 10: lifts by the paper's rule.

Fig. 10  the rule at several friction coefficients, unknown to it, and the same path without it
Fig. 2   one of these lifts, its target point (mg/2mu, mg/2), and two other routes to the weight:
         the path that never holds, and a squeeze without sensors, SQUEEZE times the least force
         and then shear alone
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.measures import completely_slips
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.controllers.flow_chart import PaperController
from fingerdesign.control.episode import Episode, run_episode
from fingerdesign.control.plants.hardware import Hardware, ImperfectPlant
from fingerdesign.control.plants.plant import CondensedPlant, Plant
from fingerdesign.control.signals import Calibration
from fingerdesign.design.grip import weight_per_finger
from fingerdesign_bench.paper.case import PaperCase

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
    """A route to the weight without sensors: forces (2, k), normal and tangential, N; slips: it
    ended in complete slip."""

    forces: Array
    slips: bool


def lifts(case: PaperCase) -> list[Lift]:
    """Fig. 10: one calibration, one set of parameters, a lift at each friction coefficient."""
    learnt = calibration(case)
    return [
        Lift(friction, *(grip(case, learnt, friction, rule=rule) for rule in (True, False)))
        for friction in LIFTED_FRICTIONS
    ]


def squeeze(case: PaperCase) -> Route:
    """Press to SQUEEZE times the least force, or as far as the stage goes, then shear alone."""
    hand = case.design.grip
    weight = weight_per_finger(hand.heaviest_g)
    moves = max(1, round(hand.max_approach_mm / hand.approach_step_mm))
    forces: list[tuple[float, float]] = [(0.0, 0.0)]
    slips = False

    def path() -> Iterator[Motion]:
        approach = 0.0
        for k in range(1, moves + 1):
            approach = hand.max_approach_mm * k / moves
            yield Motion(approach, 0.0)
            if forces[-1][0] >= SQUEEZE * weight / ROUTE_FRICTION:
                break
        for k in range(1, _MOST_SHEARS + 1):
            yield Motion(approach, _SHEAR_PART * hand.shear_step_mm * k)

    for step in follow(case.finger.with_friction(ROUTE_FRICTION), path()):
        measures = step.measures
        forces.append((measures.normal_force, measures.tangential_force))
        slips = completely_slips(measures, 2)
        if slips or measures.tangential_force > weight:
            break
    return Route(np.array(forces).T, slips)


Around = tuple[Hardware, np.random.Generator]  # a plant, and what its noise is drawn from


def _plant(case: PaperCase, friction: float, around: Around | None) -> Plant:
    plant = CondensedPlant(case.finger.with_friction(friction), case.face)
    return plant if around is None else ImperfectPlant(plant, *around)


def calibration(case: PaperCase, around: Around | None = None) -> Calibration:
    """The calibration of a rig; around: its hardware, None: a perfect one."""
    hand = case.design.grip
    plant = lambda: _plant(case, hand.bench_friction_coefficient, around)  # noqa: E731
    return calibrate(plant, case.gage_x, Bounds.of(hand))


def grip(
    case: PaperCase,
    learnt: Calibration,
    friction: float,
    around: Around | None = None,
    rule: bool = True,
) -> Episode:
    """One grip by the design's ``[grip]`` table."""
    hand = case.design.grip
    plant, controller = _plant(case, friction, around), PaperController(hand, rule=rule)
    return run_episode(plant, controller, learnt, Bounds.of(hand), friction, hand.heaviest_g)
