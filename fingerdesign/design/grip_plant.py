"""``[grip]`` tables of what is gripped with: hardware, and what happens to a lifted object."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from fingerdesign.design.base import Many, Table

PlantName = Literal["finger", "lift"]
OppositeName = Literal["mirror", "bare"]
_PlateNumber = Annotated[int, Field(ge=0, le=100_000)]


class Tug(Table):
    """``[[grip.tugs]]``: something pulls at the lifted object."""

    step_after_lift: int = Field(
        ge=1, le=100_000, description="first control step of it; 1 is the next after the lift"
    )
    extra_force_N: float = Field(
        ge=-1e5, le=1e5, description="down where positive, on top of the weight"
    )
    duration_steps: int = Field(default=1, ge=1, le=100_000, description="control steps it lasts")


class WeightChange(Table):
    """``[[grip.weight_changes]]``: the lifted object has another mass from a step on."""

    step_after_lift: int = Field(ge=1, le=100_000, description="1 is the next after the lift")
    object_mass_g: float = Field(gt=0, le=1e5, description="its mass from then on")


class HardwareTable(Table):
    """``[grip.hardware]``: what is imperfect of sensors and stage; the defaults are perfect."""

    gage_noise_microstrain: float = Field(
        default=0.0,
        ge=0,
        le=1e5,
        description="standard deviation of one sample; 0.5 is a good strain amplifier at 100 Hz",
    )
    drift_microstrain_per_s: float = Field(
        default=0.0,
        ge=0,
        le=1e5,
        description="each gage drifts steadily, at a rate of this standard deviation",
    )
    gain_spread: float = Field(
        default=0.0, ge=0, le=1, description="standard deviation of the gages' relative gain errors"
    )
    dead_gages: Many[_PlateNumber] = Field(
        default=(), max_length=1000, description="plates (from 0) whose gages answer to nothing"
    )
    quantisation_microstrain: float = Field(
        default=0.0, ge=0, le=1e5, description="step of the converter; 0: none"
    )
    force_noise_N: float = Field(
        default=0.0, ge=0, le=1e5, description="standard deviation of one sample of either force"
    )
    sample_rate_Hz: float = Field(
        default=100.0, gt=0, le=1e6, description="samples, and control steps, a second"
    )
    delay_samples: int = Field(
        default=0, ge=0, le=1000, description="the controller hears everything so late"
    )
    backlash_mm: float = Field(
        default=0.0, ge=0, le=5, description="what each axis of the stage loses at a turn"
    )
    stage_step_mm: float = Field(
        default=0.0, ge=0, le=5, description="the stage moves in whole steps of this; 0: any way"
    )
    specimen: int = Field(
        default=0,
        ge=0,
        le=2**32 - 1,
        description="which of many such rigs: its gains are drawn from this number",
    )
