"""``[grip.regulator]``: how the stick-ratio regulator grips, and how much it is taught."""

from __future__ import annotations

from pydantic import Field

from fingerdesign.design.base import Table


class RegulatorTable(Table):
    """Parameters of control/regulator.py, one set for all objects, and of its teaching."""

    target: float = Field(
        default=0.74,
        gt=0,
        lt=1,
        description="share of the friction in use, F_t / (mu F_n), that is held; its inverse is "
        "the safety margin",
    )
    pull_share: float = Field(
        default=0.03, gt=0, le=1, description="F_t of a step of the first pull, as part of F_n"
    )
    press_share: float = Field(
        default=0.1, gt=0, le=1, description="of F_n, the most that it rises in a step of the climb"
    )
    memory: float = Field(
        default=0.9, ge=0, lt=1, description="of what earlier steps said of the friction"
    )
    least_stick: float = Field(
        default=0.3, ge=0, lt=1, description="stick ratio below which it closes without pulling"
    )
    most_used: float = Field(
        default=0.88, gt=0, le=1, description="share in use above which it does the same"
    )
    most_held: float = Field(
        default=0.82,
        gt=0,
        le=1,
        description="share in use over which a hanging object is pressed harder",
    )
    taught_grips: int = Field(
        default=3000,
        ge=50,
        le=100_000,
        description="simulated grips that its estimator learns from",
    )
