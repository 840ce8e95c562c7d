"""Molds drawn: seconds and volume error of each, by the kind of its body."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

BODIES = ("arc", "block", "dome", "revolved", "step")
MARKS = {"made": ("o", "#4c78a8"), "failed": ("X", "#c8321e"), "refused": ("v", "#8a8a8a")}
_FLOOR = 1e-9  # a mold record keeps nine decimals: below it an error is 0 there


def draw_molds(records: Sequence[dict[str, Any]], path: Path) -> None:
    """Two panels, a column a body: seconds of each mold; how far its cavity is from the finger."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for status, (mark, colour) in MARKS.items():
        mine = [each for each in records if each["status"] == status and _body(each) is not None]
        if not mine:
            continue
        places = [_place(each, number) for number, each in enumerate(mine)]
        style = {"marker": mark, "color": colour, "s": 24, "alpha": 0.75}
        left.scatter(
            places, [each["seconds"] for each in mine], label=f"{status} ({len(mine)})", **style
        )
        known = [k for k, each in enumerate(mine) if each.get("volume_error") is not None]
        errors = [max(mine[k]["volume_error"], _FLOOR) for k in known]
        right.scatter([places[k] for k in known], errors, **style)
    made = sum(each["status"] == "made" for each in records)
    left.set(ylabel="seconds, design to files", ylim=(0.0, None))
    left.axhline(20.0, color="#c8321e", linewidth=1.0)
    left.set_title(
        f"{made} of {len(records)} designs have molds; asked: 20 s", loc="left", fontsize=10
    )
    left.legend(fontsize=8)
    right.set(yscale="log", ylabel="cavity less plates and core against the body, share")
    right.axhline(1e-3, color="#c8321e", linewidth=1.0)
    right.set_title("asked: 0.001", loc="left", fontsize=10)
    for axes in (left, right):
        axes.set_xticks(range(len(BODIES)), BODIES)
        axes.set_xlim(-0.5, len(BODIES) - 0.5)
        axes.grid(alpha=0.25)
    figure.savefig(path, dpi=130)


def _body(record: dict[str, Any]) -> str | None:
    return next((kind for kind in record["kinds"] if kind in BODIES), None)


def _place(record: dict[str, Any], number: int) -> float:
    """Column of a record, set off a little so that its marks do not cover each other."""
    golden = 0.618034
    return BODIES.index(str(_body(record))) + 0.6 * float(np.modf(number * golden)[0]) - 0.3
