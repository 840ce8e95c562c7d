"""How the object is moved, in words, and what of that the figures' words may rest on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fingerdesign.report.numbers import NOISE, cleaned, under_load
from fingerdesign.results import IncrementResult, Result

PATH = "scene.path."
MOST_PHASES = 6  # in one sentence; a longer path is told by its ranges
_MOTIONS = (("approach", "mm"), ("shear", "mm"), ("shear along z", "mm"), ("twist", "degrees"))
_FORCES = (("normal force", "N"), ("tangential force", "N"))
_ASIDE = 0.01  # of the normal force, and of it times the contact's width: less is the mesh's


def force_controlled(result: Result) -> bool:
    """Whether the path's rows are forces."""
    return bool(result.parameters.get(f"{PATH}control") == "force")


def motion_text(result: Result) -> str:
    """The path in a sentence or two; empty where the result does not hold it."""
    keys = result.parameters
    rows = keys.get(f"{PATH}increments_N") or keys.get(f"{PATH}increments_mm") or []
    if not rows:
        return ""
    forced = force_controlled(result)
    names = _FORCES if forced else _MOTIONS
    table = np.array([[*row, *[0.0] * (len(names) - len(row))] for row in rows], dtype=float)
    phases = _phases(table)
    if len(phases) <= MOST_PHASES:
        told = ", ".join(_phase(columns, table[last], names) for columns, last in phases)
    else:
        told = ", ".join(
            f"{name} from {low:g} to {high:g} {unit}"
            for (name, unit), low, high in zip(names, table.min(0), table.max(0), strict=True)
            if low or high
        )
    words = "Its forces are prescribed" if forced else "Its motion is prescribed"
    words += f": {told or 'none'}"
    substeps = keys.get(f"{PATH}substeps") or 1
    if substeps != 1:
        words += f", each row in {substeps} equal increments"
    return f"{words}; the motions were found." if forced else f"{words}."


def model_text(result: Result) -> str:
    """How much of the finger the model holds, in a sentence; empty without a model."""
    if result.model is None:
        return ""
    if result.model.dimension == 2:
        return "The model is one section of the finger; forces are those over its whole depth."
    if result.model.symmetry:
        return "The model is the half z ≥ 0 of the finger, mirrored; forces are the whole finger's."
    return "The model is the whole finger."


def leaves_section(found: Sequence[IncrementResult]) -> bool:
    """Whether anything is moved, or pushed, out of the plane of the section."""
    if any(row.shear_z_mm or row.twist_deg for row in found):
        return True
    most = max((abs(row.normal_force_N) for row in found), default=0.0)
    width = max((row.contact_width_mm for row in found), default=0.0)
    force = max((abs(row.force_z_N) for row in found), default=0.0)
    moment = max((abs(row.twist_moment_Nmm) for row in found), default=0.0)
    return force > _ASIDE * max(most, NOISE) or moment > _ASIDE * max(most * width, NOISE)


def slip_grows_with_shear(found: Sequence[IncrementResult]) -> bool:
    """Whether the stick ratio falls from its largest to its last as the tangential force grows."""
    loaded = under_load(found)
    if len(loaded) < 2 or loaded != list(range(loaded[0], len(found))) or leaves_section(found):
        return False
    rows = [found[place] for place in loaded]
    ratio = np.array([row.stick_ratio or 0.0 for row in rows])
    force = np.abs(cleaned(row.tangential_force_N for row in rows))
    start = len(ratio) - 1 - int(ratio[::-1].argmax())  # the last of the largest
    falls = bool((np.diff(ratio[start:]) <= 0).all()) and ratio[-1] < ratio[start]
    return falls and bool((np.diff(force[start:]) >= -1e-6 * force.max()).all())


def _phases(table: np.ndarray) -> list[tuple[tuple[int, ...], int]]:
    """Stretches in which the same columns move the same way: the columns, the last row."""
    steps = np.diff(table, axis=0, prepend=np.zeros((1, table.shape[1])))
    phases: list[tuple[tuple[int, ...], int]] = []
    before: Any = None
    for number, step in enumerate(steps):
        way = tuple(np.sign(step).tolist())
        columns = tuple(np.flatnonzero(step).tolist())
        if not columns:
            continue
        if way == before:
            phases[-1] = (columns, number)
        else:
            phases.append((columns, number))
        before = way
    return phases


def _phase(columns: tuple[int, ...], row: np.ndarray, names: Sequence[tuple[str, str]]) -> str:
    return " with ".join(f"{names[c][0]} to {row[c]:g} {names[c][1]}" for c in columns)
