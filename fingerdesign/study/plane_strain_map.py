"""The map of where plane strain holds: errors over four ratios, looked up between the models.

The ratios are depth over height D/H (of the crest), contact half-width over height a/H, Poisson's
ratio and the plates' span over the depth (0: no plates). Numpy only: the table is made once, by
``fingerdesign bench plane-strain``, and ships with the program.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.study.plane_strain_errors import QUANTITIES, Record, half_width, row_errors

Table = dict[str, Any]

SHIPPED = "plane_strain.json"
_WITHIN = 1e-9


@dataclass(frozen=True)
class PlaneStrainMap:
    """Errors on a grid.

    poisson (p,), span (s,), depth (d,): D/H, ascending; width (p, s, d, k): log(a/H) of each
    approach, ascending; errors: by quantity (p, s, d, k), NaN where there is none; table: what was
    fixed, the one-off models, the rules, as the file holds them.
    """

    poisson: Array
    span: Array
    depth: Array
    width: Array
    errors: dict[str, Array]
    table: Table

    def error(
        self, quantity: str, poisson: float, span: float, depth: float, width: float
    ) -> float:
        """The error at one point: linear in Poisson's ratio and span, in log D/H and log a/H.

        Beyond the grid its border's value holds (see :meth:`inside`). NaN where there is none.
        """
        at = [
            _place(self.poisson, poisson),
            _place(self.span, span),
            _place(np.log(self.depth), np.log(depth)),
        ]
        total = 0.0
        for i, share_i in at[0]:
            for j, share_j in at[1]:
                for k, share_k in at[2]:
                    share = share_i * share_j * share_k
                    if share > _WITHIN:
                        values = self.errors[quantity][i, j, k]
                        total += share * float(
                            np.interp(np.log(width), self.width[i, j, k], values)
                        )
        return total

    def inside(self, poisson: float, span: float, depth: float, width: float) -> bool:
        """Whether a point lies within the ratios that were computed."""
        ranges = ((self.poisson, poisson), (self.span, span), (self.depth, depth))
        within = all(axis[0] - _WITHIN <= value <= axis[-1] + _WITHIN for axis, value in ranges)
        wide = np.exp([self.width[..., 0].max(), self.width[..., -1].min()])
        return bool(within and wide[0] <= width <= wide[1])


def _place(axis: Array, value: float) -> list[tuple[int, float]]:
    """Neighbours of a value on an ascending axis, and their shares."""
    value = float(np.clip(value, axis[0], axis[-1]))
    low = int(np.clip(np.searchsorted(axis, value, side="right") - 1, 0, max(len(axis) - 2, 0)))
    if len(axis) == 1:
        return [(0, 1.0)]
    share = (value - float(axis[low])) / float(axis[low + 1] - axis[low])
    return [(low, 1.0 - share), (low + 1, share)]


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


def map_of(table: Table) -> PlaneStrainMap:
    """The map that a table holds. ValueError where its points are no full grid."""
    points = table["points"]
    axes = [
        np.unique([each[name] for each in points])
        for name in ("poissons_ratio", "span_over_depth", "depth_over_height")
    ]
    approaches = {len(each["rows"]) for each in points}
    shape = tuple(len(axis) for axis in axes)
    if len(points) != np.prod(shape) or len(approaches) != 1:
        raise ValueError(f"{len(points)} models are no full grid of {shape}")
    size = (*shape, approaches.pop())
    width = np.full(size, np.nan)
    errors = {name: np.full(size, np.nan) for name in QUANTITIES}
    for each in points:
        place = tuple(
            int(np.searchsorted(axis, each[name]))
            for axis, name in zip(
                axes, ("poissons_ratio", "span_over_depth", "depth_over_height"), strict=True
            )
        )
        width[place] = np.log([row["half_width_over_height"] for row in each["rows"]])
        for name in QUANTITIES:
            values = [row[name] for row in each["rows"]]
            errors[name][place] = [np.nan if value is None else value for value in values]
    return PlaneStrainMap(axes[0], axes[1], axes[2], width, errors, table)


@cache
def shipped_map() -> PlaneStrainMap:
    """The map that comes with the program."""
    file = resources.files("fingerdesign") / "data" / SHIPPED
    return map_of(json.loads(file.read_text("utf-8")))


def write_table(table: Table, path: Path) -> Path:
    """Write a table as JSON, a model a line."""
    parts = []
    for name, value in table.items():
        if isinstance(value, list):
            rows = ",\n".join(json.dumps(each, allow_nan=False) for each in value)
            parts.append(f"{json.dumps(name)}: [\n{rows}\n]")
        else:
            parts.append(f"{json.dumps(name)}: {json.dumps(value, allow_nan=False)}")
    path.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")
    return path
