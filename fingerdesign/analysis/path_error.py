"""The share of the path in the errors of an analysis: its rows are cut into increments."""

from collections.abc import Sequence

import numpy as np

from fingerdesign.analysis.fidelity.readings import NOT_PULLED, Readings, readings_of
from fingerdesign.analysis.path import targets
from fingerdesign.arrays import Array
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.scene import ScenePath
from fingerdesign.errors import SolverError
from fingerdesign.records.result import ErrorEstimate

# The error goes with this power of the increments' length. That of the stick ratio was measured on
# seventeen fingers and scenes: a quarter of the increments is 2.9 times as far off as half of them.
_ORDERS = {"normal_force": 1.0, "tangential_force": 1.0, "stick_ratio": 1.5, "gages": 1.0}


def path_error(
    problem: ContactProblem, path: ScenePath, face: str, steps: Sequence[Step]
) -> ErrorEstimate | None:
    """Estimate how far steps are from those of ever shorter increments.

    A second path has half as many increments a row, or two where the first has one. None where it
    has no answer.
    """
    substeps = path.substeps
    other = 2 if substeps == 1 else substeps and substeps // 2
    times = substeps / other if substeps and other else 2.0
    try:
        second = list(follow(problem, targets(path), other, coarser=1 if other else 2))
    except SolverError:
        return None
    apart = distances(readings_of(second, face), readings_of(steps, face))
    return richardson(apart, times, _ORDERS)


def richardson(apart: dict[str, float], times: float, orders: dict[str, float]) -> ErrorEstimate:
    """Errors from the distances D to an answer on elements or increments ``times`` as long.

    An answer of size h is taken to be off by c h^p: D / |times^p - 1|, p = ``orders``.
    """
    errors = {name: each / abs(times ** orders[name] - 1.0) for name, each in apart.items()}
    return ErrorEstimate(**errors)


def distances(found: Readings, truth: Readings) -> dict[str, float]:
    """Largest distance over the rows: forces and gages over the row's own largest value (at least
    a hundredth of the path's), stick ratios absolute."""
    reading = np.abs(truth.reading).max(axis=1, initial=0.0)
    normal, pull = np.abs(truth.normal_force), np.abs(truth.tangential_force)
    off = np.abs(found.reading - truth.reading).max(axis=1, initial=0.0)
    least = NOT_PULLED**2 * normal.max(initial=0.0)  # F_t below it is the mesh's own
    return {
        "normal_force": _largest(found.normal_force - truth.normal_force, normal),
        "tangential_force": _largest(found.tangential_force - truth.tangential_force, pull, least),
        "stick_ratio": float(np.abs(found.stick_ratio - truth.stick_ratio).max(initial=0.0)),
        "gages": _largest(off, reading),
    }


def _largest(apart: Array, values: Array, least: float = 0.0) -> float:
    least = max(least, NOT_PULLED * float(values.max(initial=0.0)), np.finfo(float).tiny)
    return float((np.abs(apart) / np.maximum(values, least)).max(initial=0.0))
