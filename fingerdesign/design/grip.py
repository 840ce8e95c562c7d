"""The ``[grip]`` table: the lifts that are simulated beside the fundamental case."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from fingerdesign.design.base import Many, Table
from fingerdesign.design.grip_plant import (
    HardwareTable,
    OppositeName,
    PlantName,
    Tug,
    WeightChange,
)
from fingerdesign.design.grip_regulator import RegulatorTable
from fingerdesign.design.grip_rivals import ControllerName, FixedForce, FixedRatio, Oracle, Reactive

Friction = Annotated[float, Field(gt=0, le=5)]


class Grip(Table):
    """How two like fingers lift an object; the object moves relative to each finger's base.

    One set of controller parameters serves every friction coefficient: the controller is told
    neither the friction nor the mass.
    """

    friction_coefficients: Many[Friction] = Field(
        default=(0.3, 0.5, 0.8),
        min_length=1,
        max_length=100,
        description="one lift each; the controller is not told",
    )
    object_mass_g: float = Field(
        default=500.0, gt=0, le=1e5, description="two fingers carry half the weight each"
    )
    plant: PlantName = Field(
        default="finger",
        description="finger: one finger on a stage, lifted where 2 F_t exceeds the weight, as in "
        "the paper; lift: two fingers and the object on its support, which then hangs from them",
    )
    opposite: OppositeName = Field(
        default="mirror",
        description="lift: the other finger; mirror: a mirror image, half of all forces each; "
        "bare: the same body without plates, a second model",
    )
    hold_steps: int = Field(
        default=0,
        ge=0,
        le=100_000,
        description="lift: control steps for which the lifted object is held on",
    )
    tugs: Many[Tug] = Field(
        default=(), max_length=1000, description="lift: what pulls at the object while it hangs"
    )
    weight_changes: Many[WeightChange] = Field(
        default=(), max_length=1000, description="lift: when the hanging object's mass changes"
    )
    hardware: HardwareTable = Field(default_factory=HardwareTable)
    controller: ControllerName = Field(
        default="paper",
        description="paper: the flow chart of Maeno et al. 2000, Fig. 9; oracles are told friction "
        "and mass and hold 1.2 or 1.5 times the least force",
    )
    regulator: RegulatorTable = Field(default_factory=RegulatorTable)
    preload_mm: float = Field(
        default=0.03, gt=0, le=50, description="approach before the first tangential move"
    )
    approach_step_mm: float = Field(
        default=0.004, gt=0, le=5, description="normal move of one control step"
    )
    shear_step_mm: float = Field(
        default=0.03, gt=0, le=5, description="largest tangential move of one control step"
    )
    max_steps: int = Field(default=200, ge=1, le=100_000, description="give up after so many")
    max_approach_mm: float = Field(
        default=0.4, gt=0, le=50, description="stage travel; the contact zone must hold it"
    )
    curve_per_N: float = Field(
        default=0.1,
        gt=0,
        le=1e3,
        description="F_t rises by this times the square of F_n's rise since the last hold",
    )
    threshold_share: float = Field(
        default=0.4,
        gt=0,
        lt=1,
        description="a gage counts as over stick where its response to F_t exceeds this share of "
        "the strongest gage's at full stick (the rig measures that itself)",
    )
    force_floor_N: float = Field(
        default=0.1, gt=0, le=1e3, description="change of F_t that a response is made from"
    )
    dead_band_mm: float = Field(
        default=0.05,
        ge=0,
        le=50,
        description="the stick region shrinks once the gage area is this far below its largest "
        "value since the last hold",
    )
    hold_force_N: float = Field(
        default=0.5,
        gt=0,
        le=1e3,
        description="a hold (dx = 0) lasts until F_n has risen by this; at least one step",
    )
    bench_friction_coefficient: float = Field(
        default=0.5,
        gt=0,
        le=5,
        description="of the surface that the rig is calibrated on, not of the object",
    )
    fixed_force: FixedForce = Field(default_factory=FixedForce)
    fixed_ratio: FixedRatio = Field(default_factory=FixedRatio)
    reactive: Reactive = Field(default_factory=Reactive)
    oracle: Oracle = Field(default_factory=Oracle)
    seed: int = Field(default=0, ge=0, le=2**32 - 1, description="seeds whatever noise is asked")
