"""The study of grids drawn: the gage area beside the length that sticks, a panel each row."""

from collections.abc import Sequence
from pathlib import Path

from fingerdesign.report import style
from fingerdesign_bench.studies.grids import FRICTIONS, GridRow

_COLUMNS = 2


def draw_grids(rows: Sequence[GridRow], path: Path) -> Path:
    """One point an increment that gave a response, one look a friction coefficient."""
    with style.house_style():
        figure = style.canvas(7.6, 0.8 + 2.4 * -(-len(rows) // _COLUMNS))
        labels = {"across": "length that sticks at z = 0 (mm)", "up": "gage area A (mm)"}
        panels = style.small_multiples(
            figure, len(rows), _COLUMNS, **labels, sharex=True, sharey=True
        )
        for axes, row in zip(panels, rows, strict=True):
            for look, mu in enumerate(FRICTIONS):
                stick, area = row.stick_length_mm[look], row.gage_area_mm[look]
                style.series(axes, stick, area, look, f"friction {mu:g}", ms=3.2, lw=0.7)
            known = [value for value in row.correlations if value is not None]
            rank = f"{min(known):.2f} to {max(known):.2f}" if known else "none"
            kind = {"axial": "single gages", "tee": "tee rosettes"}.get(row.grid, row.grid)
            axes.set_title(f"{row.finger}, {kind}\nrank correlation {rank}", fontsize=9)
        style.shared_legend(panels[:1], len(FRICTIONS))
        path.write_bytes(style.to_png(figure))
    return path
