"""The controllers by name, and the tables of those that the paper's rule is judged against."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from fingerdesign.design.base import Table

ControllerName = Literal[
    "paper",
    "fixed_force",
    "fixed_ratio",
    "reactive",
    "oracle_1.2",
    "oracle_1.5",
    "regulator",
]


class Rival(Table):
    """What every rival's table says."""

    pull_share: float = Field(
        default=0.02,
        gt=0,
        le=1,
        description="F_t rises by about this share of F_n in one control step, no more",
    )


class FixedForce(Rival):
    """``[grip.fixed_force]``: one normal force for every object."""

    force_N: float = Field(
        default=14.7,
        gt=0,
        le=1e5,
        description="normal force of one finger; the default is 1.2 times what holds 500 g at a "
        "friction of 0.2, taken for the worst",
    )


class FixedRatio(Rival):
    """``[grip.fixed_ratio]``: both forces grow in one ratio."""

    ratio: float = Field(
        default=0.17,
        gt=0,
        lt=5,
        description="F_t / F_n; the default is a friction of 0.2, taken for the worst, over 1.2",
    )


class Reactive(Rival):
    """``[grip.reactive]``: pull lightly gripped, grip harder once it slips.

    The defaults lift most objects with `sensitive` and `maeno2000`. A hand that pulls faster, or
    waits for F_t to fall further, feels the slip when the whole contact slips.
    """

    pull_share: float = Field(
        default=0.007,
        gt=0,
        le=1,
        description="F_t rises by about this share of F_n in one control step, no more",
    )
    first_force_N: float = Field(
        default=3.0, gt=0, le=1e5, description="normal force before anything has slipped"
    )
    slip_share: float = Field(
        default=0.75,
        gt=0,
        lt=1,
        description="it slips where F_t rises by less than this share of what the stiffest pull at "
        "this normal force gave",
    )
    force_floor_N: float = Field(
        default=0.1, gt=0, le=1e3, description="rise of F_t over which that is judged"
    )
    step_up: float = Field(
        default=1.9, gt=1, le=10, description="the normal force grows by this factor at a slip"
    )


class Oracle(Rival):
    """``[grip.oracle]``: told friction and mass; its margin is in its name."""
