"""Points of a study: every combination of a grid, a Latin hypercube or a Sobol sequence; seeded."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from fingerdesign.design.faults import dotted
from fingerdesign.errors import DesignError, Fault
from fingerdesign.search.study.values import Choice, Range

if TYPE_CHECKING:
    from fingerdesign.search.study.file import Study
    from fingerdesign.search.study.values import Choice


MOST_GRID = 100_000  # variants


Values = dict[str, Choice]


def points(study: Study) -> Iterator[Values]:
    """The values of each variant, in order. DesignError for a grid that has no end."""
    if study.study.sampling == "grid":
        return _grid(study)
    return _drawn(study)


def number_of_points(study: Study) -> int:
    """How many variants the study has."""
    if study.study.count is not None:
        return study.study.count
    return math.prod(len(values) for values in _levels(study).values())


def at_shares(study: Study, shares: tuple[float, ...]) -> Values:
    """The values at shares in [0, 1) of each parameter."""
    return {
        key: _at(parameter, share)
        for (key, parameter), share in zip(study.parameters.items(), shares, strict=True)
    }


def _at(parameter: Range | tuple[Choice, ...], share: float) -> Choice:
    if isinstance(parameter, Range):
        return parameter.at(share)
    return parameter[min(int(share * len(parameter)), len(parameter) - 1)]


def _levels(study: Study) -> dict[str, list[Choice]]:
    """Each parameter's values on the grid."""
    found: dict[str, list[Choice]] = {}
    faults = []
    for key, parameter in study.parameters.items():
        if not isinstance(parameter, Range):
            found[key] = list(parameter)
            continue
        levels = parameter.levels
        if levels is None or levels > MOST_GRID:
            bound = "a list, or a range with a step, where study.sampling = 'grid'"
            remedy = "give a list or a step without log, or set study.sampling = 'sobol'"
            where = dotted(("parameters", key))
            faults.append(Fault(where, f"{parameter.low} to {parameter.high}", bound, remedy))
        else:
            found[key] = [parameter.at((level + 0.5) / levels) for level in range(levels)]
    count = math.prod(len(values) for values in found.values())
    if not faults and count > MOST_GRID:
        remedy = "give fewer values, or set study.sampling = 'sobol'"
        faults.append(Fault("parameters", f"{count} variants", f"at most {MOST_GRID}", remedy))
    if faults:
        raise DesignError(faults)
    return found


def _grid(study: Study) -> Iterator[Values]:
    levels = _levels(study)
    return (dict(zip(levels, each, strict=True)) for each in itertools.product(*levels.values()))


def _drawn(study: Study) -> Iterator[Values]:
    import numpy as np
    from scipy.stats import qmc

    count, dimension = number_of_points(study), len(study.parameters)
    chance = np.random.default_rng(study.study.seed)
    if study.study.sampling == "sobol":
        engine: Any = qmc.Sobol(dimension, scramble=True, rng=chance)
        # A power of 2 is balanced; the first of it are taken.
        shares = engine.random_base2(max(0, math.ceil(math.log2(count))))[:count]
    else:
        shares = qmc.LatinHypercube(dimension, rng=chance).random(count)
    return (at_shares(study, tuple(float(share) for share in row)) for row in shares)
