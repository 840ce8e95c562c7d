"""Errors of plane strain, from the records of run.py: the table that ships."""

from collections.abc import Sequence

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.validate.plane_strain import QUANTITIES, Table
from fingerdesign_bench.files import Record

PRESSED, SHEARED = 1, 3  # rows of a path: see plane_strain.scene_of


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
        own = dict.fromkeys(("contact_width", "stick_ratio", "gage_both", "gage_face"))
        if other is not None:
            here, there = _gages(other), _gages(truth)
            own |= {
                "contact_width": _relative(other, truth, "contact_width", PRESSED),
                "stick_ratio": float(other["stick_ratio"][SHEARED] - truth["stick_ratio"][SHEARED]),
                "gage_both": worst_reading(here.mean(axis=-1), there.mean(axis=-1)),
                "gage_face": worst_reading(here, there),
            }
        found |= {f"{prefix}{name}": value for name, value in own.items()}
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


def table_of(records: Sequence[Record]) -> Table:
    """Ratios and errors of the records, to four digits: what the program ships.

    "points": the grid's models; "also": the one-off ones by name.
    """
    made = [_model(record) for record in records]
    return {
        "points": [each for each in made if not each["name"]],
        "also": [each for each in made if each["name"]],
    }


def _model(record: Record) -> Table:
    height = record["height_mm"]
    rows = []
    for row in record["rows"]:
        errors = {name: _digits(value) for name, value in row_errors(row).items()}
        rows.append({"half_width_over_height": _digits(half_width(row) / height)} | errors)
    return {
        "name": record["name"],
        "poissons_ratio": record["poissons_ratio"],
        "span_over_depth": _digits(record["span_share"]),
        "depth_over_height": _digits(record["depth_mm"] / height),
        "radius_over_height": _digits(record["radius_mm"] / height),
        "width_over_height": _digits(record["width_mm"] / height),
        "dofs": record["dofs"],
        "rows": rows,
    }


def _digits(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.4g}")
