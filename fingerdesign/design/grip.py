"""The ``[grip]`` table: the lifts that are simulated beside the fundamental case."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from fingerdesign.design.base import Many, Table

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
        default=200.0, gt=0, le=1e5, description="two fingers carry half the weight each"
    )
    controller: Literal["paper"] = Field(
        default="paper", description="paper: the flow chart of Maeno et al. 2000, Fig. 9"
    )
    preload_mm: float = Field(
        default=0.1, gt=0, le=50, description="approach before the first tangential move"
    )
    approach_step_mm: float = Field(
        default=0.02, gt=0, le=5, description="normal move of one control step"
    )
    shear_step_mm: float = Field(
        default=0.02, gt=0, le=5, description="largest tangential move of one control step"
    )
    max_steps: int = Field(default=200, ge=1, le=100_000, description="give up after so many")
    seed: int = Field(default=0, ge=0, le=2**32 - 1, description="seeds whatever noise is asked")
