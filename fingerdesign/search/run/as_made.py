"""Metrics of fingers as they come out of the mold: a study has them where it names them.

Only then is this module imported: it loads the molds and the tolerances, a fifth of what the start
of a worker takes.
"""

from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError
from fingerdesign.mold.placement import placement_effect
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.notes import placement_worst
from fingerdesign.search.study.metrics import SPREAD
from fingerdesign.tolerance.spread import tolerance


def placement_of(design: Design) -> tuple[float | None, tuple[str, ...]]:
    """Greatest change of a reading by the tolerances of the planned mold, a share of the largest
    reading, as `mold` judges it; and why there is none."""
    try:
        found = placement_effect(design, plan_mold(design))
    except FingerDesignError as error:
        return None, (f"no placement effect: {error}",)
    if found["reason"] is not None:
        return None, (f"no placement effect: {found['reason']}",)
    return placement_worst(found), ()


def spread_of(
    design: Design, scene: Scene | None
) -> tuple[dict[str, float | None], tuple[str, ...]]:
    """The spread of fingers that are cast after a design, by derivatives in plane strain; and why
    there is none."""
    try:
        found = tolerance(design, scene)
    except FingerDesignError as error:
        return dict.fromkeys(SPREAD), (f"no spread of fingers as made: {error}",)
    made, calibrated = found.reading_std
    response = None if found.gage_response is None else found.gage_response[1]
    values = (made or None, calibrated if made else None, found.yield_by_motion[0], response)
    return dict(zip(SPREAD, values, strict=True)), ()
