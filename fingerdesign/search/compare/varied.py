"""Values of the keys in which compared fingers differ, from the designs themselves."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

from fingerdesign.design.keys import leaves
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.study.values import is_number, value_in

_FINGER = ("body.", "plates.", "gages.", "materials.")
_NO_VALUES = (".content", ".source")  # of a file, of a material: in words elsewhere


def with_varied(outcomes: Sequence[Outcome]) -> tuple[Outcome, ...]:
    """The outcomes; where some are of no study, all with the values of every key that a study
    varies or in which their fingers differ, from the designs themselves. Where the fingers are
    alike, of every other key too: of the controller, the mesh."""
    if all(outcome.values or not outcome.design for outcome in outcomes):
        return tuple(outcomes)
    keys = dict.fromkeys(chain.from_iterable(outcome.values for outcome in outcomes))
    keys |= _varied([outcome.design for outcome in outcomes if outcome.design])

    def completed(outcome: Outcome) -> Outcome:
        found = {key: _value_at(outcome.design, key) for key in keys}
        return replace(outcome, values=found | outcome.values)

    return tuple(completed(each) if each.design else each for each in outcomes)


def _varied(designs: Sequence[dict[str, Any]]) -> dict[str, None]:
    """Keys of the finger in which designs differ; of any other where the fingers are alike."""
    flat = [_leaves(each) for each in designs]
    every = dict.fromkeys(chain.from_iterable(flat))
    varied = [key for key in every if len({each.get(key) for each in flat}) > 1]
    return dict.fromkeys([key for key in varied if key.startswith(_FINGER)] or varied)


def _leaves(design: dict[str, Any]) -> dict[str, bool | float | str]:
    """A design's dotted keys with one value each; files by their names, without their places."""
    found = {
        key: Path(str(value)).name if key.endswith(".file") else value
        for key, value in leaves(design)
        if isinstance(value, bool | int | float | str) and not key.endswith(_NO_VALUES)
    }
    return {key: value for key, value in found.items() if not key.startswith("design.")}


def _value_at(design: dict[str, Any], key: str) -> Any:
    """The value of a dotted key, of "a / b" the share of two keys; None where there is none."""
    above, *whole = (value_in(design, piece.strip()) for piece in key.split("/"))
    if not whole:
        return above if isinstance(above, bool | int | float | str) else None
    below = whole[0]
    return above / below if is_number(above) and is_number(below) and below else None
