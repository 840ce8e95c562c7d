"""The estimator that a design is gripped with: the one given, one shipped with it, or one trained.

A shipped design may have a file next to it, NAME.estimator.json: a copy of what `fingerdesign train
NAME --fidelity 3d` wrote in some version; of GripBench's `sensitive` without the option. It is used
for the finger and stage that it was trained on, also where other values of the design or its name
differ.
"""

import json
from dataclasses import replace

from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.roster import needs_training
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import ESTIMATOR_SUFFIX, estimator_texts
from fingerdesign.errors import DesignError
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.model import FIDELITIES
from fingerdesign.sensing.train.result import (
    estimator_faults,
    finger_key,
    finger_keys,
    training_result_for,
)


def shipped_estimator(design: Design, fidelity: str | None = None) -> GripEstimator | None:
    """The estimator that ships for a design's finger and stage, None without one.

    fidelity: None takes the best one, of 3-D before plane strain.
    """
    found = _shipped(design, fidelity)
    return None if found is None else GripEstimator.from_json(found[1])


def _shipped(design: Design, fidelity: str | None) -> tuple[str, str] | None:
    """Name and text of the file that ships for a design's finger and stage."""
    wanted = reversed(FIDELITIES) if fidelity is None else [fidelity]
    texts = {json.loads(each[1])["design"]: each for each in estimator_texts().items()}
    for each in wanted if texts else ():
        for key in finger_keys(design, each) if each in FIDELITIES else ():
            if key in texts:
                return texts[key]
    return None


def adopted_estimator(design: Design, name: str) -> GripEstimator | None:
    """The estimator that ships with the design ``name``, for a finger that it was not trained on;
    None where none ships.

    A rig measures its own finger, so the estimator serves fingers near to its own: that of
    film_tees lifted 48 of 48 objects with a finger that a search found from it (half of the
    travel, another pitch, 43 degrees) at a margin of 1.31. With several faults it lifts less.
    """
    if (text := estimator_texts().get(name)) is None:
        return None
    shipped, found = load_design(name), GripEstimator.from_json(text)
    trained = next(each for each in FIDELITIES if found.design in finger_keys(shipped, each))
    if found.design in finger_keys(design, trained):
        return found
    return replace(found, design=finger_key(design, trained), adopted_from=name)


def unused_estimator(design: Design, fidelity: str | None = None) -> str | None:
    """A sentence where an estimator ships for the finger, and not for the fidelity (None: any), or
    under the design's name, and not for this finger."""
    name = design.design.name
    if _shipped(design, fidelity) is not None:
        return None
    if (other := _shipped(design, None)) is not None:
        reason = f"it was not trained for --fidelity {fidelity}"
        return f"{other[0]}{ESTIMATOR_SUFFIX} is not used: {reason}"
    if name not in estimator_texts():
        return None
    return (
        f"{name}{ESTIMATOR_SUFFIX} is not used: finger, gages or stage are not those of the "
        f"shipped {name}"
    )


def estimator_of(
    design: Design,
    report: Report = lambda message: None,
    workers: int = 1,
    fidelity: str = "plane-strain",
) -> GripEstimator:
    """The estimator that ships for a design; without one it is trained or comes from the cache.

    Raises as :func:`training_result_for`, which has these arguments too.
    """
    if (shipped := shipped_estimator(design, fidelity)) is not None:
        return shipped
    ready = (each for each in FIDELITIES if shipped_estimator(design, each) is not None)
    hints = (f"; --fidelity {each} needs no training" for each in ready)  # in the first message
    found = training_result_for(
        design, lambda each: report(f"{each}{next(hints, '')}"), workers, fidelity
    )
    return found.estimator


def grip_fidelity(fidelity: str) -> str:
    """The fidelity of the estimator that an analysis of one fidelity grips with."""
    return "3d" if fidelity == "3d" else "plane-strain"


def with_estimator(case: Case, report: Report) -> Case:
    """The case with the estimator of its regulator. Without one it ships with the design, or is
    trained: in 3-D where the case is, for one of plane strain drops every second object there.

    Raises DesignError for an estimator of another finger or another fidelity.
    """
    if not case.runs_grips or not needs_training(case.design.grip.controller):
        return case
    if case.estimator is None:
        fidelity = grip_fidelity(case.fidelity)
        return replace(case, estimator=estimator_of(case.design, report, fidelity=fidelity))
    if faults := estimator_faults(case.design, case.estimator, case.fidelity):
        raise DesignError(faults)
    return case
