"""The parameters of a study as Optuna's distributions, and back; what a trial is told."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fingerdesign.sweep.study_file import Choice, Range, Study

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from fingerdesign.sweep.outcome import Outcome

ABSENT = 1e9  # the loss told where there is none: finite, as Optuna wants it; never a result
_FAILED, _MOST_EXCESS = "failed", 1e6


def distributions(study: Study) -> dict[str, Any]:
    """By key, what Optuna draws from: a list is a choice, a range its numbers."""
    return {key: _distribution(parameter) for key, parameter in study.parameters.items()}


def values_of(study: Study, drawn: Mapping[str, Any]) -> dict[str, Choice]:
    """The studied keys' values: what was drawn, to six digits where it is a fraction."""
    return {key: _value(parameter, drawn[key]) for key, parameter in study.parameters.items()}


def directions(study: Study) -> list[str]:
    """minimize or maximize, of each objective."""
    return [f"{each.direction}imize" for each in study.objectives]


def told(study: Study, outcomes: Sequence[Outcome]) -> tuple[list[float], dict[str, float]]:
    """Objectives, and constraints (above 0: broken), of a trial's outcomes: the worst scene's.

    What failed or misses an objective is infeasible; its objectives are the worst there are.
    """
    values = []
    for wanted in study.objectives:
        found = [outcome.metrics.get(wanted.metric) for outcome in outcomes]
        known = [value for value in found if value is not None]
        if len(known) < len(found) or any(each.status != "ok" for each in outcomes):
            return _infeasible(study)
        values.append(max(known) if wanted.direction == "min" else min(known))
    broken = {
        name: min(max(bound.excess(each.metrics.get(name)) for each in outcomes), _MOST_EXCESS)
        for name, bound in study.constraints.items()
    }
    return values, {_FAILED: 0.0} | broken


def _infeasible(study: Study) -> tuple[list[float], dict[str, float]]:
    worst = [ABSENT if each.direction == "min" else -ABSENT for each in study.objectives]
    return worst, {_FAILED: 1.0} | dict.fromkeys(study.constraints, _MOST_EXCESS)


def _distribution(parameter: Range | tuple[Choice, ...]) -> Any:
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if not isinstance(parameter, Range):
        return CategoricalDistribution(parameter)
    low, step, log = parameter.low, parameter.step, parameter.log
    levels = parameter.levels
    high = parameter.high if levels is None else low + (step or 1) * (levels - 1)
    if parameter.whole:
        return IntDistribution(int(low), int(high), log=log, step=int(step or 1))
    return FloatDistribution(float(low), float(high), log=log, step=step)


def _value(parameter: Range | tuple[Choice, ...], drawn: Any) -> Choice:
    if not isinstance(parameter, Range):
        choice: Choice = drawn
        return choice
    if parameter.whole:
        return int(drawn)
    digits = 6 if parameter.levels is None else 10
    value = float(f"{drawn:.{digits}g}")
    return min(max(value, float(parameter.low)), float(parameter.high))
