"""What plane strain gets wrong, from the records of plane_strain.py (numpy only).

All errors are plane strain against 3-D at the mid-plane: forces and contact width relative (signed:
> 0 where plane strain says more), stick ratio absolute, gage strains relative to the largest 3-D
reading of the increment (the worst plate, pressed or sheared). Those at equal force begin with
``force_``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fingerdesign.arrays import Array

Record = dict[str, Any]

PRESSED, SHEARED = 1, 3  # rows of a path: see plane_strain.scene_of
MOTION = (
    "normal_force",
    "tangential_force",
    "contact_width",
    "stick_ratio",
    "gage_both",
    "gage_face",
)
FORCE = ("force_contact_width", "force_stick_ratio", "force_gage_both", "force_gage_face")
QUANTITIES = MOTION + FORCE


def row_errors(row: Record) -> dict[str, float | None]:
    """Errors of one approach by QUANTITIES; None: no gages, or no answer at equal force.

    ``gage_both``: the mean of both faces (membrane); ``gage_face``: each face alone.
    """
    truth, moved, forced = row["space"], row["motion"], row["force"]
    found: dict[str, float | None] = {
        "normal_force": _relative(moved, truth, "normal_force", PRESSED),
        "tangential_force": _relative(moved, truth, "tangential_force", SHEARED),
    }
    for prefix, other in (("", moved), ("force_", forced)):
        if other is None:
            names = ("contact_width", "stick_ratio", "gage_both", "gage_face")
            found |= {f"{prefix}{name}": None for name in names}
            continue
        here, there = _gages(other), _gages(truth)
        found |= {
            f"{prefix}contact_width": _relative(other, truth, "contact_width", PRESSED),
            f"{prefix}stick_ratio": float(
                other["stick_ratio"][SHEARED] - truth["stick_ratio"][SHEARED]
            ),
            f"{prefix}gage_both": worst_reading(here.mean(axis=-1), there.mean(axis=-1)),
            f"{prefix}gage_face": worst_reading(here, there),
        }
    return {name: found[name] for name in QUANTITIES}


def half_width(row: Record) -> float:
    """The contact's half-width at the mid-plane, pressed, in 3-D; mm."""
    return 0.5 * float(row["space"]["contact_width"][PRESSED])


def worst_reading(found: Array, truth: Array) -> float | None:
    """Greatest difference of readings (rows, plates[, faces]) over the largest of its row."""
    if not truth.size:
        return None
    worst = 0.0
    for row in (PRESSED, SHEARED):
        largest = float(np.abs(truth[row]).max())
        worst = max(worst, float(np.abs(found[row] - truth[row]).max()) / largest)
    return worst


def _gages(readings: Record) -> Array:
    return np.asarray(readings["gages"], dtype=float).reshape(len(readings["gages"]), -1, 2)


def _relative(found: Record, truth: Record, name: str, row: int) -> float:
    return float(found[name][row] / truth[name][row] - 1.0)
