"""The plane-strain map drawn: where plane strain holds within 1, 2, 5, 10, 20, 40 and 80 %."""

from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.report.style import INK, MUTED, PAPER, Axes, canvas, house_style
from fingerdesign.validate.plane_strain import PlaneStrainMap
from fingerdesign_bench.chart import fixed_ticks, save

LEVELS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
# One hue from light (small errors) to dark: readable without colour, and in print.
SHADES = (
    *("#f4f8fb", "#dce9f3", "#bcd6e8", "#93bdd9"),
    *("#5f9cc4", "#2f78a8", "#0b4a75", "#06263f"),
)
_RATIOS = (0.3, 0.45, 0.49)
_SAMPLES = 60
# The rows of the chart: a quantity at one span share, and its title.
PANELS = (
    ("normal_force", 0.0, "F_n at equal approach, no plates"),
    ("normal_force", 1.0, "F_n at equal approach, plates of full span"),
    ("gage_face", 0.0, "strain of the rubber where the gages would be, no plates"),
    ("gage_face", 1.0, "gage on one face, plates of full span"),
    ("gage_both", 1.0, "gage on both faces (mean), plates of full span"),
)


def draw_map(chart: PlaneStrainMap, path: Path) -> Path:
    """Contours of the errors over D/a and D/H; a row a quantity, a column a Poisson's ratio."""
    panels = [panel for panel in PANELS if panel[1] in chart.span]
    ratios = sorted({_nearest(chart.poisson, ratio) for ratio in _RATIOS})
    with house_style():
        figure = canvas(7.6, 0.9 + 1.85 * len(panels))
        grid = figure.subplots(len(panels), len(ratios), sharex=True, sharey=True, squeeze=False)
        for row, (quantity, span, title) in zip(grid, panels, strict=True):
            for axes, poisson in zip(row, ratios, strict=True):
                _draw(axes, chart, (quantity, span, poisson))
            row[0].set_title(f"{title}\nPoisson's ratio {ratios[0]:g}")
            row[0].set_ylabel("depth / height, D / H")
            _radius_axis(row[-1], chart)
        for axes in grid[-1]:
            axes.set_xlabel("depth / contact half-width, D / a")
        figure.suptitle(
            "What plane strain gets wrong, per cent of 3-D at the mid-plane", color=INK, fontsize=11
        )
        return save(figure, path, 150)


def sampled(
    chart: PlaneStrainMap, quantity: str, span: float, poisson: float
) -> tuple[Array, Array, Array]:
    """D/a, D/H and the sizes of the errors, (m, n) each, over all that was computed."""
    low, high = chart.width[..., 0].max(), chart.width[..., -1].min()
    width = np.exp(np.linspace(low, high, _SAMPLES))
    depth = np.geomspace(chart.depth[0], chart.depth[-1], _SAMPLES)
    values = [
        [abs(chart.error(quantity, poisson, span, float(d), float(w))) for w in width]
        for d in depth
    ]
    return depth[:, None] / width, np.tile(depth[:, None], (1, _SAMPLES)), np.array(values)


def _draw(axes: Axes, chart: PlaneStrainMap, place: tuple[str, float, float]) -> None:
    quantity, span, poisson = place
    across, depth, values = sampled(chart, quantity, span, poisson)
    axes.contourf(across, depth, values, levels=[0.0, *LEVELS, 10.0], colors=SHADES)
    lines = axes.contour(across, depth, values, levels=LEVELS, colors=[INK], linewidths=0.8)
    labels = axes.clabel(lines, fmt=lambda level: f"{100 * level:g} %", fontsize=7.5)
    for label in labels:
        label.set_bbox({"facecolor": PAPER, "edgecolor": "none", "pad": 0.6, "alpha": 0.85})
    axes.set(xscale="log", yscale="log", title=f"Poisson's ratio {poisson:g}")
    fixed_ticks(axes.xaxis, (2, 5, 10, 20, 50))
    fixed_ticks(axes.yaxis, (0.5, 1, 2, 3))
    at = np.exp(_models(chart, span, poisson))
    axes.plot(at[0], at[1], color=MUTED, linestyle="none", marker=".", markersize=2.5)


def _models(chart: PlaneStrainMap, span: float, poisson: float) -> tuple[Array, Array]:
    """log D/a and log D/H of the models that were computed."""
    i = int(np.argmin(np.abs(chart.poisson - poisson)))
    j = int(np.argmin(np.abs(chart.span - span)))
    high = np.broadcast_to(np.log(chart.depth)[:, None], chart.width[i, j].shape)
    return (high - chart.width[i, j]).ravel(), high.ravel()


def _radius_axis(axes: Axes, chart: PlaneStrainMap) -> None:
    """R/D at the right: of these fingers R/H is one number."""
    ratio = float(chart.table["points"][0]["radius_over_height"])

    def turned(value: Any) -> Any:
        return ratio / np.maximum(np.asarray(value, dtype=float), 1e-9)

    right = axes.secondary_yaxis("right", functions=(turned, turned))
    right.set_ylabel("radius / depth, R / D", color=INK)
    fixed_ticks(right.yaxis, (0.25, 0.5, 1.0, 2.0, 4.0))


def _nearest(axis: Array, ratio: float) -> float:
    return float(axis[int(np.argmin(np.abs(axis - ratio)))])
