"""The controllers by the names that ``[grip] controller`` and ``--controller`` take.

    controller("oracle_1.2", design.grip, friction=0.3, mass_g=500.0)

Who knows what: the oracles are told friction and mass, the regulator has an estimator that was
taught on its design; all others have the design's ``[grip]`` table alone, one for every object.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.control.controllers.flow_chart import Controller, PaperController, PaperSettings
from fingerdesign.control.controllers.regulator import Regulator, RegulatorSettings
from fingerdesign.control.controllers.rivals import FixedForce, FixedRatio, Oracle, Reactive, Steps
from fingerdesign.errors import DesignError, Fault

if TYPE_CHECKING:
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.grip import Grip, Rival

MARGINS = {"oracle_1.2": 1.2, "oracle_1.5": 1.5}
NAMES = ("paper", "fixed_force", "fixed_ratio", "reactive", *MARGINS, "regulator")


def controller(
    name: str,
    grip: Grip,
    *,
    estimator: GripEstimator | None = None,
    friction: float | None = None,
    mass_g: float | None = None,
) -> Controller:
    """A fresh controller with the parameters of a design's ``[grip]`` table.

    friction and mass_g are the object's; only the oracles look at them, and ValueError is raised
    where they lack. Raises DesignError for an unknown name and for a regulator without estimator.
    """
    if name == "paper":
        return PaperController(paper_settings(grip))
    if name == "fixed_force":
        return FixedForce(hand_steps(grip, grip.fixed_force), grip.fixed_force.force_N)
    if name == "fixed_ratio":
        return FixedRatio(hand_steps(grip, grip.fixed_ratio), grip.fixed_ratio.ratio)
    if name == "reactive":
        own = grip.reactive
        return Reactive(
            hand_steps(grip, own),
            own.first_force_N,
            own.slip_share,
            own.step_up,
            own.force_floor_N,
        )
    if name in MARGINS:
        if friction is None or mass_g is None:
            raise ValueError(f"{name} must be told the object's friction and mass")
        return Oracle(hand_steps(grip, grip.oracle), MARGINS[name], friction, mass_g)
    if name == "regulator":
        if estimator is None:
            raise DesignError([regulator_fault()])
        return Regulator(regulator_settings(grip), estimator)
    raise DesignError(
        [Fault("grip.controller", name, f"one of {', '.join(NAMES)}", "choose one of them")]
    )


def regulator_settings(grip: Grip) -> RegulatorSettings:
    """The regulator's parameters from a design's ``[grip]`` table."""
    own = grip.regulator
    return RegulatorSettings(
        approach_step=grip.approach_step_mm,
        press_step=own.press_share,
        pull_step=own.pull_share,
        shear_step=grip.shear_step_mm,
        target=own.target,
        memory=own.memory,
        least_stick=own.least_stick,
        most_used=own.most_used,
        most_held=own.most_held,
    )


def regulator_fault() -> Fault:
    """Why there is no regulator without an estimator."""
    return Fault(
        "grip.controller",
        "regulator",
        "a controller that needs no training, where no estimator taught on this design is given",
        "teach one first, or choose another controller",
    )


def paper_settings(grip: Grip) -> PaperSettings:
    """The paper's rule's parameters from a design's ``[grip]`` table."""
    return PaperSettings(
        approach_step=grip.approach_step_mm,
        shear_step=grip.shear_step_mm,
        curve=grip.curve_per_N,
        threshold_share=grip.threshold_share,
        force_floor=grip.force_floor_N,
        dead_band=grip.dead_band_mm,
        hold_force=grip.hold_force_N,
    )


def hand_steps(grip: Grip, own: Rival) -> Steps:
    """What a hand may do in one control step, from a design's ``[grip]`` table and a rival's own.

    The calibration must have been made with the table's ``max_approach_mm``.
    """
    return Steps(
        approach_step=grip.approach_step_mm,
        shear_step=grip.shear_step_mm,
        pull_share=own.pull_share,
        bench_travel=grip.max_approach_mm,
        preload=grip.preload_mm,
    )
